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
table_of "$root/data/gen3.urdf" 'joint_1\tyaw\trad\t0\t0.01\t0.01\t1e-5\t1\t-' >offsets.tsv
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
for language in rapid krl urscript; do
    joints "path.$language" | "$MUKCA" fk $arm >meant.tsv
    "$MUKCA" $turned --from $language "path.$language" -q -o "new.$language"
    joints "new.$language" | "$MUKCA" fk $arm --offsets offsets.tsv -q >reached.tsv
    expect "the arm reaches what was meant, by a program in $language" near 1e-7 3 meant.tsv reached.tsv
done
{ tail -n 1 path.urscript; printf 'movej([10,20,30,40,50,60,70])\nmovel(pick)\n'; } >degrees.script
run compensate $arm --from urscript degrees.script -o new.script
expect "angles in degrees and a pose: both lines are listed, nothing is written" test "$code,$(grep -cE "degrees.script:(2: joint 'joint_2' is 20 rad, more than two turns; check --from|3: not understood)" "$scratch/err")" = 3,2 -a ! -e new.script
run compensate $arm --from urscript degrees.script -q
expect "... nor to standard output" test ! -s "$scratch/out"
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
