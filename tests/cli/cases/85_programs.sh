# Programs with joint targets: corrected as a whole, or refused with all lines named.
arm="--urdf $root/data/gen3.urdf"
cat >path.mod <<'MOD'
MODULE Path ! a comment
 PROC main()
  MoveAbsJ [[10, 20,-30,40,50,60],[70,9E9,9E9,9E9,9E9,9E9]]\NoEOffs, v100, fine, tool0;
  MoveAbsJ [[0,20,30,40,50,60],[70,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;
 ENDPROC
ENDMODULE
MOD
{
    echo "# urdf_sha256: $(sha256sum "$root/data/gen3.urdf" | cut -d ' ' -f 1)"
    printf 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n'
    printf 'joint_1\tyaw\trad\t0\t0.01\t0.01\t1e-5\t1\t-\n'
} >offsets.tsv
turned="compensate $arm --offsets offsets.tsv"
"$MUKCA" $turned --from rapid path.mod -q >corrected.mod
expect "all text but the joints stays" sh -c "sed '3,4s/\[\[.*\]\]/J/' path.mod >a &&
    sed '3,4s/\[\[.*\]\]/J/' corrected.mod | cmp - a &&
    grep -qE ' MoveAbsJ \[\[[-0-9.]+, [-0-9.]+,(-?[0-9.]+,){3}[-0-9.]+\],\[[-0-9.]+,9E9,9E9,9E9,9E9,9E9\]\]' corrected.mod"
# the same path in the other languages
printf 'PTP {A1 10,A2 20,A3 -30,A4 40,A5 50,A6 60,E1 70} C_PTP\nPTP {A1 0,A2 20,A3 30,A4 40,A5 50,A6 60,E1 70}\n' >path.krl
printf 'movej([0.17453293,0.34906585,-0.52359878,0.6981317,0.87266463,1.04719755,1.22173048], a=1)\n
movej([0,0.34906585,0.52359878,0.6981317,0.87266463,1.04719755,1.22173048])\n' >path.urscript
cp path.mod path.rapid
joints() { # PROGRAM: its targets as a table, rad
    awk -v unit="$(case $1 in *urscript) echo 1 ;; *) echo 0.017453292519943295 ;; esac)" '/MoveAbsJ|PTP|movej/ {
        sub(/^[^[{]*/, ""); gsub(/[AE][1-6] /, ""); gsub(/[][{}]/, ""); split($0, q, ",")
        for (i = 1; i <= 7; i++) printf "%.12f%s", q[i] * unit, i < 7 ? "\t" : "\n" }' "$1"
}
close_to() { # A B: tables of three numbers agree within 0.1 um
    paste "$1" "$2" | awk 'NR > 1 { n++; for (i = 1; i <= 3; i++) if (!(($i - $(i + 3)) ^ 2 < 1e-14)) exit 1 }
        END { if (n != 2) exit 1 }'
}
for language in rapid krl urscript; do
    joints "path.$language" | "$MUKCA" fk $arm >meant.tsv
    "$MUKCA" $turned --from $language "path.$language" -q -o "new.$language"
    joints "new.$language" | "$MUKCA" fk $arm --offsets offsets.tsv -q >reached.tsv
    expect "the arm reaches what was meant, by a program in $language" close_to meant.tsv reached.tsv
done
echo 'movej([10,20,30,40,50,60,70])' >degrees.script
echo 'movel(pick)' >>degrees.script
run compensate $arm --from urscript degrees.script -o new.script
expect "angles in degrees and a pose: both lines are listed, nothing is written" test "$code,$(grep -cE "degrees.script:(1: joint 'joint_2' is 20 rad, more than two turns; check --from|2: not understood)" "$scratch/err")" = 3,2 -a ! -e new.script
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
refuse 3 'a target in krl has at most 12 axes' compensate --urdf long.urdf --from krl long.mod

. "$here/ur5e.sh"
ur='--urdf ur5e.urdf --tip wrist_3_link'

# Each line that could move the arm elsewhere is named, and nothing is written.
cat >named.mod <<'MOD'
PROC main()
  CONST jointtarget jHome:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  MoveAbsJ jHome\NoEOffs,v200,fine,tBall;
  MoveAbsJ [[10,-5.5,20,0,40,90],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,z10,tBall;
  MoveL Offs(pPick,0,0,50),v100,fine,tBall\WObj:=wobjFixture;
  MoveL [[350,0,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
  Subroutine;
ENDPROC
MOD
cat >named.src <<'SRC'
DEF prog()
PTP {A1 0,A2 -20,A3 30,A4 0,A5 40,A6 0}
LIN {X 350,Y 0,Z 300,A 0,B 150,C 0} C_DIS
PTP HOME
PTP {A1 5}
LIN_REL {Z 50}
XHOME={AXIS: A1 5,A2 -10,A3 20,A4 0,A5 30,A6 0}
END
SRC
cat >named.script <<'SCRIPT'
def pick_place():
  home = [0, -1.57, 1.57, -1.57, -1.57, 0]
  movej([d2r(10),d2r(-80),d2r(95),d2r(-105),d2r(-90),0], a=1.4)
  movej([0.1,-1.5,1.5,-1.57,-1.57,0])
  movel(pose_add(pick,p[0,0,0.1,0,0,0]))
  movel(p[-0.4, -0.2, 0.3, 0, 3.14, 0], a=1.2)
end
SCRIPT
for each in rapid:mod:2,3,5,6,7 krl:src:3,4,5,6,7 urscript:script:2,3,5,6; do
    lines=${each##*:} file=named.$(echo "$each" | cut -d : -f 2)
    run compensate $ur --from "${each%%:*}" "$file" -q
    expect "$file: refused, all lines named, nothing written" test "$code,$(sed -n \
        "s/^mukca: $file:\([0-9]*\): not understood: .*/\1/p" "$scratch/err" | paste -sd ,)" = "3,$lines" -a ! -s "$scratch/out"
    run compensate $ur --from "${each%%:*}" "$file" -o new
    expect "$file: no new file" test "$code" = 3 -a ! -e new
done
