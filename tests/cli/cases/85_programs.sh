# Targets of robot programs: read, corrected, and written where they stood.
arm="--urdf $root/data/gen3.urdf"
cat >path.mod <<'MOD'
MODULE Path ! a comment
  CONST jointtarget home:=[[10, 20,-30,40,50,60],[70,9E9,9E9,9E9,9E9,9E9]];
  MoveAbsJ [[0,20,30,40,50,60],[70,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
  MoveL [[400,100,500],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
ENDMODULE
MOD
{
    echo "# urdf_sha256: $(sha256sum "$root/data/gen3.urdf" | cut -d ' ' -f 1)"
    printf 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n'
    printf 'joint_1\tyaw\trad\t0\t0.01\t0.01\t1e-5\t1\t-\n'
} >offsets.tsv
turned="compensate $arm --offsets offsets.tsv"
"$MUKCA" $turned --from rapid path.mod -q >corrected.mod
expect "all text but the joints stays" sh -c "sed '2,3s/:=\[\[.*/J/; 2,3s/\[\[.*, v/J/' path.mod >a &&
    sed '2,3s/:=\[\[.*/J/; 2,3s/\[\[.*, v/J/' corrected.mod | cmp - a &&
    grep -qE 'home:=\[\[[-0-9.]+, [-0-9.]+,(-?[0-9.]+,){3}[-0-9.]+\],\[[-0-9.]+,9E9,9E9,9E9,9E9,9E9\]\];' corrected.mod"
joints() { # FROM FILE: the targets of a program as a table
    "$MUKCA" compensate $arm --from "$1" --format table "$2" -q | cut -f 1-7
}
close_to() { # A B: tables of three numbers agree within 0.1 um
    paste "$1" "$2" | awk 'NR > 1 { n++; for (i = 1; i <= 3; i++) if (!(($i - $(i + 3)) ^ 2 < 1e-14)) exit 1 }
        END { if (n != 2) exit 1 }'
}
joints rapid path.mod | "$MUKCA" fk $arm >meant.tsv
for language in rapid krl urscript; do
    "$MUKCA" $turned --from rapid path.mod -q --format $language -o "path.$language"
    joints $language "path.$language" | "$MUKCA" fk $arm --offsets offsets.tsv -q >reached.tsv
    expect "the arm reaches what was meant, by targets in $language" close_to meant.tsv reached.tsv
done
expect "without a table a pose stays what it is" sh -c "'$MUKCA' compensate $arm --from rapid --poses path.mod -q |
    sed -n 4p | grep -qE 'MoveL \[\[400.000000,100.000000,500.000000\],\[0.5000*(,0.5000*){3}\],\[0,0,0,0\],\[9E9(,9E9){5}\]\], v100'"
printf 'x\ty\tz\trx\try\trz\n400\t100\t500\t69.28203230\t69.28203230\t69.28203230\n' >degrees.tsv
printf 'x_m\ty_m\tz_m\tqw\tqx\tqy\tqz\n0.4\t0.1\t0.5\t0.5\t0.5\t0.5\t0.5\n' >metres.tsv
"$MUKCA" compensate $arm --poses --units deg,mm degrees.tsv -q >from_degrees.tsv
"$MUKCA" compensate $arm --poses metres.tsv -q >from_metres.tsv
expect "poses in degrees and millimetres are those in rad and m" awk -F '\t' '
    NR == FNR { q[FNR] = $1 + 0; next } FNR > 1 && !(($1 - q[FNR]) ^ 2 < 1e-14) { exit 1 }
    END { exit FNR != 2 }' from_degrees.tsv from_metres.tsv
refuse 3 "path.mod: no list of 7 axes is a target in krl; check --from" compensate $arm --from krl path.mod -o new.src
echo 'movej([10,20,30,40,50,60,70])' >degrees.script
refuse 3 "degrees.script:1: joint 'joint_2' is 20 rad, more than two turns; check --from" \
    compensate $arm --from urscript degrees.script -o new.script
echo '[[4000,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]' >far.mod
accept "far.mod:1: the arm does not get there.*; the pose is unchanged" compensate $arm --from rapid --poses far.mod
expect "and nothing goes elsewhere" cmp "$scratch/out" far.mod
{
    echo '<robot name="long"><link name="l0"/>'
    for i in $(seq 14); do
        echo "<link name=\"l$i\"/><joint name=\"j$i\" type=\"revolute\"><parent link=\"l$((i - 1))\"/><child link=\"l$i\"/>
<origin xyz=\"0.1 0 0\"/><axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\" effort=\"9\" velocity=\"2\"/></joint>"
    done
    echo '</robot>'
} >long.urdf
echo 'MoveAbsJ [[1,2,3,4,5,6],[7,8,9,10,11,12]], v100, fine, tool0;' >long.mod
refuse 3 'a target in rapid has at most 12 axes, and the chain has 14; check --tip' compensate --urdf long.urdf --from rapid long.mod
refuse 3 'a target in krl has at most 12 axes' compensate --urdf long.urdf --format krl long.mod
accept 'path.mod: poses not corrected: 1; correct these next, in the result, with --poses' compensate $arm --from rapid path.mod
accept 'path.mod: joint targets not corrected: 2; correct these as well, without --poses' \
    compensate $arm --from rapid --poses path.mod
accept 'far.mod: no joint target in the program determines the posture at the poses' \
    compensate $arm --from rapid --poses far.mod

# Linear moves stay linear moves: the nominal controller is sent to a pose from where the real arm is where it was meant to be.
. "$here/ur5e.sh"
{
    echo "# urdf_sha256: $(sha256sum ur5e.urdf | cut -d ' ' -f 1)"
    printf 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n'
    printf 'shoulder_pan_joint\tyaw\trad\t0\t0.002\t0.002\t1e-5\t1\t-\nelbow_joint\tx\tm\t-0.425\t-0.423\t0.002\t1e-5\t1\t-\n'
    printf 'wrist_2_joint\tyaw\trad\t0\t-0.003\t-0.003\t1e-5\t1\t-\n'
} >ur.tsv
ur='--urdf ur5e.urdf --tip wrist_3_link'
cat >line.mod <<'MOD'
  MoveAbsJ [[10,-60,80,20,50,30],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
  MoveL [[-400,100,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
  MoveL [[-400,200,300],[0,0.8,0.6,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
MOD
cat >line.src <<'SRC'
$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}
PTP {A1 10,A2 -60,A3 80,A4 20,A5 50,A6 30}
LIN {X -400,Y 100,Z 300,A 0,B 0,C 180,S 2,T 10} C_DIS
LIN {Y 200,A 73.7397952917}
SRC
cat >line.script <<'SCRIPT'
movej([0.174532925,-1.047197551,1.396263402,0.349065850,0.872664626,0.523598776], a=1)
movel(p[-0.4,0.1,0.3,3.14159265359,0,0], a=1)
movel(p[-0.4,0.2,0.3,2.51327412287,1.88495559215,0], a=1)
SCRIPT
joints() { # FROM FILE: where the nominal controller goes, as a table
    "$MUKCA" compensate $ur --from "$1" --poses --format table "$2" -q | cut -f 1-6
}
for each in rapid:mod:MoveL krl:src:LIN urscript:script:movel; do
    language=${each%%:*} move=${each##*:}
    file=line.$(echo "$each" | cut -d : -f 2)
    "$MUKCA" compensate $ur --offsets ur.tsv --from "$language" --poses -q "$file" >corrected
    joints "$language" "$file" | "$MUKCA" fk $ur --pose >meant.tsv
    joints "$language" corrected | "$MUKCA" fk $ur --offsets ur.tsv --pose -q >reached.tsv
    expect "$language: linear moves stay linear moves" test "$(grep -c "^ *$move" corrected)" = 2
    expect "$language: the real arm reaches the poses that were meant" sh -c "paste meant.tsv reached.tsv | awk '
        NR > 1 { n++; for (i = 1; i <= 7; i++) if (!((\$i - \$(i + 7)) ^ 2 < 1e-14)) exit 1 } END { exit n != 2 }'"
    joints "$language" "$file" | "$MUKCA" fk $ur --offsets ur.tsv --pose -q >reached.tsv
    expect "$language: without the correction it does not" sh -c "paste meant.tsv reached.tsv | awk '
        NR > 1 && !((\$1 - \$8) ^ 2 + (\$2 - \$9) ^ 2 > 1e-8) { exit 1 }'"
done
poses() { grep -o 'p\[[^]]*\]' "$1"; }
sed '2s/l(/c(/; 2s/\(.*\), a=1)/\1,/; 3s/movel(//' line.script | sed '2{N;s/\n/ /;}' >arc.script
"$MUKCA" compensate $ur --offsets ur.tsv --from urscript --poses -q line.script >corrected
"$MUKCA" compensate $ur --offsets ur.tsv --from urscript --poses -q arc.script >arc
expect "both poses of movec" test "$(grep -c movec arc) $(poses arc)" = "1 $(poses corrected)"
"$MUKCA" compensate $ur --offsets ur.tsv --from krl --poses -q line.src >corrected
expect "the base's frame is no target" grep -qxF '$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}' corrected
expect "what a KRL move leaves out is written" grep -qE '^LIN \{Y [0-9.]+,A [0-9.]+,X -[0-9.]+,Z [0-9.]+,B -?[0-9.]+,C -?[0-9.]+\}$' corrected
printf 'PTP XHOME\nLIN {X 100}\nLIN {X 400,Y 100,Z 300,A 0,B 0,C 180}\n' >named.src
accept 'named.src: targets with omitted components, after a move to a target outside the program: 1' \
    compensate $ur --from krl --poses named.src
