# The answer of each command is on standard output; standard error has notes alone.  Where a machine
# reads standard output, the text for people is on standard error or left out.
demo=$root/data/demo
a="--urdf $demo/arm.urdf" d="$demo/train.tsv"
answer "^Converged after" calibrate $a "$d" -o offsets.tsv
expect "the next step is the diagnosis, which explains a part of the error" grep -q "^Next    mukca diagnose -o FILE" "$scratch/out"
answer "^  consistency mm, data" evaluate $a "$d" -o scores.tsv
answer "^report: page.html" report $a "$d" -o page.html
"$MUKCA" simulate $a --poses 500 --seed 1 --perturb 1,2 -o log.tsv
answer "^Result  the poses contain a calibration" recalibrate $a log.tsv
printf '0.1\t0.2\t0.3\t-1.5\t0.2\t1.1\t0.4\n' >row.tsv
answer "^x_m" fk $a row.tsv
answer "^1 row" compensate $a --offsets offsets.tsv row.tsv -o targets.tsv
answer "^joint_1	" compensate $a --offsets offsets.tsv row.tsv -q
answer "^robot: " export $a --offsets offsets.tsv --format yaml

apart() { # PATTERN ARGS...: standard output has no text that matches, standard error has, or none
    pattern=$1
    shift
    run "$@"
    expect "text for people stays out of the data: mukca $*" \
        sh -c "test $code -eq 0 && ! grep -q -- '$pattern' '$scratch/out' && test -s '$scratch/out'"
}
apart "^Converged" calibrate $a "$d" --json -
apart "^Converged" calibrate $a "$d" -o -
apart "^Found" diagnose $a "$d" --json -
apart "consistency mm" evaluate $a "$d"
apart "consistency mm" evaluate $a "$d" --json -
apart "^Result" recalibrate $a log.tsv --json -
apart "postures" plan $a --place front=0.45,0,0.05 --rows 12 --json -
apart "^1 row" compensate $a --offsets offsets.tsv row.tsv
apart "^1 row" compensate $a --offsets offsets.tsv row.tsv --json -
apart "^report: " report $a "$d"
run diagnose $a "$d" -q
expect "-q prints nothing" test "$code $(cat "$scratch/out" "$scratch/err")" = "0 "

script -qec "'$MUKCA' evaluate $a $d" /dev/null >terminal.txt </dev/null
expect "evaluate on a terminal prints the placements in mm and no table of all digits" \
    sh -c "grep -q '^    left *7\.030' terminal.txt && ! grep -q mae_nominal_m terminal.txt"

# columns that are not the URDF's
mixed() { # NAME PROGRAM: the demo's session, changed by awk; columns 4 to 10 are the joints
    awk -F '\t' -v OFS='\t' "/^#/ || /^placement/ {print; next} {$2; print}" "$d" >"$1.tsv"
}
mixed sign '$7 = -$7; $9 = -$9'
mixed exchange 'x = $5; $5 = $6; $6 = x'
mixed zero '$5 += 1.5707963267948966'
mixed parallel '$6 -= $5'
mixed cycle 'x = $4; $4 = $5; $5 = $6; $6 = x'
doubt "sign of joint_4, joint_6" calibrate $a sign.tsv
doubt "joint_2 and joint_3 exchanged" diagnose $a exchange.tsv
# by any angle, beside reversed joints; the frame of measured poses
"$MUKCA" simulate $a --poses 60 --seed 4 --perturb 1,2 --noise 5e-5 | grep -v '^#' >poses.tsv
changed() { # NAME PROGRAM: columns 2 to 8 are the joints, 9 to 11 the position
    awk -F '\t' -v OFS='\t' "NR > 1 {$2} {print}" poses.tsv >"$1.tsv"
}
changed angle '$7 += 2'
changed lower '$7 -= 2.05'
changed half '$7 -= 0.5'
changed three '$3 = -$3; $6 = -$6; $4 -= 1.5707963267948966'
changed turned '$9 = -$9; $10 = -$10'
changed small '$3 += 0.8'
sed '1s/x_m\ty_m\tz_m/x_m.a\ty_m.a\tz_m.a/' poses.tsv | cut -f 1-11 |
    awk -F '\t' -v OFS='\t' '{ print $0, NR == 1 ? "x_m.b\ty_m.b\tz_m.b" : $9 OFS $10 OFS $11
        }' | awk -F '\t' -v OFS='\t' 'NR > 1 { $4 -= $3 } { print }' >targets.tsv
hints() { # COMMAND FILE PATTERN
    run $1 $a $2
    expect "$1 $2: $3" sh -c 'cat "$@" | tr "\n" " " | tr -s " " | grep -q -e "$0"' "$3" "$scratch/out" "$scratch/err"
}
# poses that are the controller's own; one posture
"$MUKCA" simulate $a --poses 60 --seed 5 -o own.tsv 2>/dev/null
awk -F '\t' -v OFS='\t' 'NR == 2 { split($0, q) } NR > 1 { for (i = 2; i < 9; i++) $i = q[i] } { print }' poses.tsv >same.tsv
# a tracker that was moved between the recordings; columns that repeat, and a joint that did not move
changed moved '$9 += 0.05; $10 += 0.02'
changed shifted '$9 += 0.002'
mixed angle_sockets '$7 -= 2'
mixed follows '$6 = 0.3 - $5; $8 = 0.5'
for command in calibrate diagnose; do
    hints $command own.tsv "the controller's own, not measured"
    hints "$command --free-base --free-tool" own.tsv "the controller's own, not measured"
    hints "$command" "poses.tsv --test moved.tsv" 'test error 53.* mm, .*in a base frame of their own the test data agree to 0.0'
    hints "$command" "poses.tsv --test shifted.tsv" 'held-out error [12][.0-9]* mm (test data, 60 samples, 0.0[0-9]* mm in their own frame)'
    hints $command angle.tsv 'with -11[345][.0-9]* degrees added to joint_6: check'
    hints $command lower.tsv '^[^U]*Use no.* with +11[67][.0-9]* degrees added to joint_6: check'
    hints $command half.tsv 'with +2[89][.0-9]* degrees added to joint_6: check'
    hints $command three.tsv 'with the opposite sign of joint_2, joint_5, and +90 degrees added to joint_3: check'
    hints $command turned.tsv 'with the base turned by 1[78][.0-9]* degrees about (0 0 -*1) .* (or [-+]1[.0-9]* degrees added to joint_1): check --base'
    hints $command angle_sockets.tsv 'with +11[456][.0-9]* degrees added to joint_4: check'
    hints $command small.tsv 'with -4[56][.0-9]* degrees added to joint_2: check'
    hints "$command --free-base --free-tool" targets.tsv 'with joint_2 added to joint_3 (as where'
    hints $command parallel.tsv 'Use no.* joint_2 added to joint_3' # it counts joint_3 from the horizontal
    doubt 'joint_2 and joint_3 have a constant sum' $command $a follows.tsv
    doubt 'did not move in any sample: joint_5' $command $a follows.tsv
done
answer "the controller's own" evaluate $a own.tsv -o own.out
refuse 5 'no calibration in these poses' recalibrate $a own.tsv -o new.tsv
doubt 'measured poses: all 60 samples have the same joint angles' diagnose $a same.tsv
for command in calibrate evaluate; do
    refuse 5 'measured poses: all 60 samples have the same joint angles' $command $a same.tsv
done
refuse 3 'all samples have the same joint angles' recalibrate $a same.tsv -o new.tsv
answer '^Use     yes, frames only; the arm stays nominal: held-out error' calibrate $a poses.tsv --free-base --free-tool \
    --free base_frame,ball_joint
expect "frames alone change no tip" sh -c "! grep -q '^Tip' '$scratch/out'"
mixed stops 'if (NR > 30 && NR < 45) $9 = 0.123456'
doubt 'joint_6 reads 0.123456 in rows .* while other joints move' diagnose $a stops.tsv
accept "-90 degrees added to joint_2" evaluate $a zero.tsv
run diagnose $a cycle.tsv
expect "no hint where no single mix-up explains the data" \
    sh -c "grep -q 'do not fit this arm' '$scratch/out' && ! grep -q 'would agree' '$scratch/out'"

# ---- of two placements only the difference is known: neither is blamed
run simulate $a --seed 7 --rows 30 --placements 2 --noise 5e-5 --effect zero_jump:joint_3/p2=-4e-3 -o jump.tsv
run diagnose $a jump.tsv --json jump.json
expect "two placements: a jump of a zero is in neither" sh -c "tr -d ' \n' <jump.json | grep -q '\"causes\":\[{\"effect\":\"zero_jump\",\"joint\":\"joint_3\",\"placement\":null'"
expect "... and the screen states the difference" grep -q "zero jump at joint_3, p[12] against p[12] " "$scratch/out"
