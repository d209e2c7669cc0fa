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
expect "a pose becomes a joint target" sh -c "'$MUKCA' compensate $arm --from rapid --poses path.mod -q |
    sed -n 4p | grep -qE 'MoveL \[\[[-0-9.]+(,[-0-9.]+){5}\],\[[-0-9.]+(,9E9){5}\]\], v100'"
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
accept "far.mod:1: the arm does not get there" compensate $arm --from rapid --poses far.mod
accept 'path.mod: poses not corrected: 1; correct these next, in the result, with --poses' compensate $arm --from rapid path.mod
accept 'path.mod: joint targets not corrected: 2; correct these first, without --poses' \
    compensate $arm --from rapid --poses path.mod
accept 'path.mod: the poses are joint targets now; move to them by MoveAbsJ' compensate $arm --from rapid --poses path.mod
