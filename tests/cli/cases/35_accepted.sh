# A table that did not pass its gates reaches no controller.
. "$here/fixture.sh"
a="--urdf arm.urdf"
run simulate $a --seed 3 --placements 3 --rows 20 --perturb 2,4 --noise 1e-4 -o sim.tsv
answer '^Use     yes: held-out error' calibrate $a sim.tsv -o ok.tsv
doubt '^Use     no: the arm would be 2.8 % larger than the model; check --distance' calibrate $a sim.tsv --distance 0.052
awk -F'\t' '$1 != "p1" || $2 != "1" || n++ < 10' sim.tsv >cut.tsv
accept 'note: placement p1: 20 samples of socket 0, 10 of socket 1; was a file cut?' calibrate $a cut.tsv
run simulate $a --seed 3 --placements 4 --rows 20 --perturb 2,4 --noise 1e-4 --held-out 1 -o four.tsv --test fifth.tsv
answer '^Save    -o' calibrate $a four.tsv --test fifth.tsv
run simulate $a --seed 3 --placements 3 --rows 1500 --perturb 2,4 --noise 1e-4 -o long.tsv
answer 'expected error 0.[0-9]* mm .0.0[0-9]' calibrate $a long.tsv --distance-sd 1e-5 # the noise of many samples does not shrink the arm
answer "it the sockets' distance" calibrate $a sim.tsv
expect "without effects no advice to diagnose" sh -c "! grep -q 'mukca diagnose' '$scratch/out'"
answer 'expected error 0.[0-3]' calibrate $a sim.tsv --distance-sd 1e-5
for command in calibrate diagnose; do
    answer 'smaller than the model: check --distance first' $command $a sim.tsv --distance 0.0495
done
# the better table leaves: where the diagnosis expects a gain, it is calibrate's next step
answer '^Next    mukca diagnose -o FILE with these data: its table has the effects that' \
    calibrate --urdf "$root/data/demo/arm.urdf" "$root/data/demo/train.tsv"
refuse 2 'sd' evaluate $a sim.tsv --distance-sd 1e-5
for key in accepted converged error_of error_m error_nominal_m tip_change_m \
    identified postures error_here_m error_here_low_m error_workspace_m; do
    expect "the table tells $key" grep -q "^# $key: " ok.tsv
done
run fk $a --offsets ok.tsv good/hole_0.csv
expect "an accepted table is used without a word" test "$code" = 0 -a ! -s "$scratch/err"

# every command that carries the table on refuses it, and says how to use it nevertheless
sed -e '/^# digest/d' -e 's/^# accepted: yes/# accepted: no; moves the tip by 551 mm/' ok.tsv >failed.tsv
refused() {
    refuse 3 'failed.tsv: this calibration did not pass: moves the tip by 551 mm (--accept-failed' "$@"
}
for command in "fk good/hole_0.csv" "compensate good/hole_0.csv" "export -o new.urdf" \
    "plan sim.tsv -o new.tsv" "capture --still --lcm-url file://nix -o new.tsv"; do
    refused ${command%% *} $a --offsets failed.tsv ${command#* }
done
accept 'note: failed.tsv: this calibration did not pass' fk $a --offsets failed.tsv --accept-failed good/hole_0.csv
accept 'note: failed.tsv: this calibration did not pass' export $a --offsets failed.tsv --accept-failed
expect 'the export says so' grep -q '^<!-- The offsets table was not accepted: moves the tip by 551 mm -->$' "$scratch/out"
answer 'Use     no: moves the tip by 551 mm' evaluate $a --offsets failed.tsv sim.tsv -o scores.tsv
answer '; accepted; expected error of the tip' compare ok.tsv ok.tsv
answer '^Use     yes: held-out error' evaluate $a --offsets ok.tsv sim.tsv -o scores.tsv --force
sed '/^# digest/d' ok.tsv >old.tsv
accept 'note: old.tsv: has no digest' fk $a --offsets old.tsv good/hole_0.csv
sed -e '/^# accepted/d' -e '/^# digest/d' ok.tsv >old.tsv
accept 'note: old.tsv: has no verdict' fk $a --offsets old.tsv good/hole_0.csv
sed 's/^# accepted: yes/&\n# accepted: no; twice/' ok.tsv >failed.tsv
refuse 3 'did not pass: twice' fk $a --offsets failed.tsv good/hole_0.csv
sed 's/^# accepted: yes/# NOT CONVERGED/' ok.tsv >failed.tsv
refuse 3 'did not pass: NOT CONVERGED' fk $a --offsets failed.tsv good/hole_0.csv

# a table that was edited or cut says so, and so does what is made from it
awk -F '\t' -v OFS='\t' '$1 == "j2" && $2 == "x" { $5 += 0.1; $6 += 0.1 } 1' ok.tsv >edited.tsv
head -c -1 ok.tsv >cut.tsv
for table in edited cut; do
    refuse 3 "$table.tsv: was edited or cut after it was written: the digest differs" export $a --offsets $table.tsv -o new.urdf
    accept "note: $table.tsv: this calibration did not pass: the table was edited or cut" fk $a --offsets $table.tsv \
        --accept-edited good/hole_0.csv
    expect 'the output says so' grep -q '^# the offsets table was not accepted: the table was edited' "$scratch/out"
    answer 'Use     no: the table was edited or cut' evaluate $a --offsets $table.tsv sim.tsv -o scores.tsv --force
done
sed '/^# digest/d' edited.tsv >old.tsv
accept 'old.tsv: has no digest (older, or edited); check it' fk $a --offsets old.tsv good/hole_0.csv

# samples that are nearly alike: whichever solver, the ball stays where it is
for solver in slsqp lbfgs gauss-newton; do
    awk 'BEGIN { print "placement\tsocket\tj1\tj2\tj3"; for (i = 0; i < 12; i++)
        printf "p\t%d\t%.9f\t%.9f\t%.9f\n", i % 2, 0.1 + 1e-5 * i, 0.4 + 1e-5 * i, 0.9 - 1e-5 * i }' >still.tsv
    doubt 'the samples are of 1 different posture' calibrate $a still.tsv --solver $solver -o still_$solver.tsv
    expect "$solver keeps the ball" awk -F '\t' '$1 == "tool" && !($6 * $6 < 0.01) { exit 1 }' still_$solver.tsv
    refuse 3 'did not pass: the samples are of 1 different' export $a --offsets still_$solver.tsv
done
awk 'BEGIN { srand(2); print "placement\tsocket\tj1\tj2\tj3"; for (i = 0; i < 40; i++) { p = int(i / 10) % 4; s = i % 2
    printf "p%d\t%d\t%.9f\t%.9f\t%.9f\n", p, s, 0.3 * p + 1e-4 * rand(), 0.4 + 0.1 * s + 1e-4 * rand(), 0.9 - 0.2 * p } }' >held.tsv
doubt 'the samples are of 8 different postures in all sockets together' calibrate $a held.tsv

# labels that mean nothing
awk -F '\t' -v OFS='\t' 'NR > 1 && $1 !~ /^#/ && $1 != "placement" { $1 = "p" (NR * 7 % 3 > 1); $2 = NR * 5 % 7 > 3 } 1' \
    sim.tsv >mislabelled.tsv
doubt '^Use     no: ' calibrate $a mislabelled.tsv -o wrong.tsv
refuse 3 'did not pass: ' compensate $a --offsets wrong.tsv good/hole_0.csv
run diagnose $a mislabelled.tsv -o wrong.tsv --force
refuse 3 'did not pass: ' fk $a --offsets wrong.tsv good/hole_0.csv

# an arm that is as its model says: a calibration cannot improve it
run simulate $a --seed 3 --placements 3 --rows 8 --noise 1e-3 -o nominal.tsv
doubt 'no sure improvement' calibrate $a nominal.tsv -o wrong.tsv --force
