#!/bin/bash
# Pose logs in the forms that people have: several targets, several logs, a tracker somewhere; and what is said of them.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/ok.bash

urdf=data/demo/arm.urdf
"$mukca" simulate --urdf $urdf --poses 100 --perturb 1,2 --seed 3 -q -o "$dir/all.csv" || exit 1
# A tracker 2 m away; targets A, B and C in training, D in the test; noise of 0.1 mm.  The true places of A, B, C differ by
# (-50, 30, 0) and (-30, -40, 30) mm from A's.
awk -F, -v OFS=, -v dir="$dir" '
BEGIN { srand(1) }
function noise(  i, s) { if (shared) return common[axis++ % 3]; for (i = s = 0; i < 12; i++) s += rand(); return 1e-4 * (s - 6) }
function place(t,  w, x, y, z, a, b, c, p, q, r) {
    w = $12; x = $13; y = $14; z = $15; a = at[t, 1]; b = at[t, 2]; c = at[t, 3]
    p = $9 + (1-2*(y*y+z*z))*a + 2*(x*y-z*w)*b + 2*(x*z+y*w)*c
    q = $10 + 2*(x*y+z*w)*a + (1-2*(x*x+z*z))*b + 2*(y*z-x*w)*c
    r = $11 + 2*(x*z-y*w)*a + 2*(y*z+x*w)*b + (1-2*(x*x+y*y))*c
    return sprintf("%.9f,%.9f,%.9f", cos(1)*p - sin(1)*q + 2 + noise(), sin(1)*p + cos(1)*q - 1 + noise(), r + 0.5 + noise()) }
BEGIN { split("A .03 0 .02 B -.02 .03 .02 C 0 -.04 .05 D .05 .05 0", s, " ")
    for (i = 1; i < 16; i += 4) for (k = 1; k < 4; k++) at[s[i], k] = s[i + k] }
/^#/ { next }
!joints { joints = $2 OFS $3 OFS $4 OFS $5 OFS $6 OFS $7 OFS $8
    print joints, "x_m.A,y_m.A,z_m.A,x_m.B,y_m.B,z_m.B,x_m.C,y_m.C,z_m.C" >dir "/columns.csv"
    print joints, "x_m.A,y_m.A,z_m.A,x_m.B,y_m.B,z_m.B,x_m.C,y_m.C,z_m.C" >dir "/shared.csv"
    print "target", joints, "x_m,y_m,z_m" >dir "/rows.csv"
    print "target", joints, "x_m,y_m,z_m" >dir "/test.csv"
    print joints, "x_m,y_m,z_m" >dir "/one.csv"
    print joints, "x_m,y_m,z_m" >dir "/two.csv"
    next }
{ q = $2 OFS $3 OFS $4 OFS $5 OFS $6 OFS $7 OFS $8; n++
    if (n > 60) { print "D", q, place("D") >dir "/test.csv"; print q, place("A") >dir "/two.csv"; next }
    a = place("A"); b = place("B"); c = place("C")
    print q, a, b, c >dir "/columns.csv"
    for (k = 0; k < 3; k++) common[k] = noise()
    shared = 1; print q, place("A"), place("B"), place("C") >dir "/shared.csv"; shared = 0
    print q, a >dir "/one.csv"
    print "A", q, a RS "B", q, b RS "C", q, c >dir "/rows.csv" }' "$dir/all.csv"
run() { "$mukca" "$1" --urdf $urdf "${@:2}"; }

# ---- a tracker on its side: gravity and the base's tilt are of the arm's base
"$mukca" simulate --urdf $urdf --poses 100 --seed 3 --effect base_compliance=4e-5 --noise 5e-5 -q -o "$dir/tilts.csv" --force
awk -F, -v OFS=, '/^#/ { next } !n++ { print $2, $3, $4, $5, $6, $7, $8, "x_m", "y_m", "z_m"; next }
    { print $2, $3, $4, $5, $6, $7, $8, $11 + 2, $9 - 1, $10 + 0.5 }' "$dir/tilts.csv" >"$dir/side.csv"
run diagnose "$dir/side.csv" --free-base -o "$dir/side.tsv" >"$dir/side.txt" 2>"$dir/said"
run evaluate "$dir/side.csv" --offsets "$dir/side.tsv" --json "$dir/side.json" >"$dir/scores" 2>"$dir/said"
ok "evaluate has base compliance in the arm's base" less "$(sed -n 's/^  "mae_m": \([0-9.e-]*\),.*/\1/p' "$dir/side.json")" 1e-4
ok "and so has the largest change of the tip" less "$(sed -n 's/^# tip_change_m: //p' "$dir/side.tsv")" 0.03

run fk "$dir/side.csv" --offsets "$dir/side.tsv" --accept-failed >"$dir/tips" 2>"$dir/said"
ok "the tracker's frame in a table is not that of another base" sh -c "test -s '$dir/tips' && ! grep 'another base' '$dir/said'"

# ---- angles from 0 to a turn of limited joints are the same postures
run simulate --poses 60 --seed 3 --effect joint_scale:joint_2=2e-3 --noise 5e-5 -q -o "$dir/signed.csv" --force
awk -F, -v OFS=, '/^#/ { next } !n++ { print; next }
    { for (j = 2; j <= 8; j++) if ($j < 0) $j = sprintf("%.12f", $j + 6.283185307179586); print }' "$dir/signed.csv" >"$dir/turns.csv"
run evaluate "$dir/turns.csv" >"$dir/got" 2>"$dir/said"
ok "angles of 0 to 360 degrees: noted once a joint" grep -q "turns.csv:[0-9]*: joint '.*' is .* rad; read as -.* rad, the same posture" "$dir/said"
ok "angles of 0 to 360 degrees: none is beyond the limits" sh -c "! grep -q 'beyond its limits' '$dir/said'"
run diagnose "$dir/signed.csv" -q --json - 2>/dev/null | grep -A3 '"causes"' | sed 's/[0-9.]*$//' >"$dir/want"
run diagnose "$dir/turns.csv" -q --json - 2>/dev/null | grep -A3 '"causes"' | sed 's/[0-9.]*$//' >"$dir/got"
ok "angles of 0 to 360 degrees: the same causes" sh -c "test -s '$dir/want' && cmp '$dir/want' '$dir/got'"

# ---- noise of the joints, 0.3 mrad: samples far out are the least exact; the expected error of the tip is the true one, on average
for seed in 1 2 3 4 5 6 7 8 9 10; do
    run simulate --poses 25 --perturb 1,2 --noise 2e-5 --seed $seed -q -o "$dir/exact.csv" --truth "$dir/truth.tsv" --force
    awk -F, -v OFS=, -v seed=$seed 'BEGIN { srand(seed) } /^#/ { next }
        n++ { for (j = 2; j <= 8; j++) { for (i = s = 0; i < 12; i++) s += rand(); $j += 3e-4 * (s - 6) } }
        { print $2, $3, $4, $5, $6, $7, $8, $9, $10, $11 }' "$dir/exact.csv" >"$dir/joints.csv"
    run calibrate "$dir/joints.csv" --free-base --free-tool -o "$dir/joints.tsv" --json "$dir/joints.json" -q --force >/dev/null 2>&1
    run compare "$dir/joints.tsv" "$dir/truth.tsv" --json - -q 2>/dev/null | sed -n '/"aligned"/,/}/s/.*"mean_m": \([^,]*\).*/true \1/p'
    sed -n 's/.*"error_workspace_m": \([^,]*\).*/stated \1/p' "$dir/joints.json"
done >"$dir/errors"
ok "noise of the joints: the stated error is the true one" \
    awk '{ sum[$1] += $2; n++ } END { r = sum["true"] / sum["stated"]; print r; exit !(n == 20 && r > 0.85 && r < 1.05) }' "$dir/errors"

# ---- few poses: nothing is found by chance, and the number that is missing is stated
for n in 5 8 9; do
    run simulate --poses $n --perturb 1,2 --noise 1e-4 --rotation-noise 1e-4 --seed 1 -q -o "$dir/few.csv" --force
    run diagnose "$dir/few.csv" --free-base --free-tool >"$dir/few.txt" 2>"$dir/said"
    ok "$n poses are too few" grep -q "too few different samples: record $((12 - n)) more" "$dir/few.txt"
    run calibrate "$dir/few.csv" --free-base --free-tool >"$dir/few.txt" 2>"$dir/said"
    ok "$n poses: no infinite error" sh -c "! grep -qw inf '$dir/few.txt'"
done

# ---- several targets
for form in columns rows; do
    run diagnose -v "$dir/$form.csv" --free-base --test "$dir/test.csv" -o "$dir/$form.tsv" --json "$dir/$form.json" \
        >"$dir/$form.txt" 2>"$dir/said"
    ok "$form: three targets" grep -q 'each of the 3 targets has its own position on the tool' "$dir/$form.txt"
    ok "$form: nothing is found in noise" grep -q '"verdict": "none"' "$dir/$form.json"
    ok "$form: an untrained target is placed by the test data" less \
        "$(awk '/^  calibrated geometry/ { print $4 }' "$dir/$form.txt")" 0.25
done
run evaluate "$dir/rows.csv" "$dir/test.csv" --offsets "$dir/rows.tsv" >"$dir/scores" 2>"$dir/said"
"$mukca" diagnose -q --urdf $urdf --free-base --free-tool --json "$dir/shared.json" "$dir/shared.csv" >/dev/null 2>&1
ok "noise that the targets of a posture share makes no cause" grep -q '"verdict": "none"' "$dir/shared.json"
# Readings of the joints with noise of 0.3 mrad turn the targets of a posture together: they are one posture.
awk -F, -v OFS=, 'BEGIN { srand(2) } NR > 1 { for (j = 1; j <= 7; j++) { for (i = s = 0; i < 12; i++) s += rand(); $j += 3e-4 * (s - 6) } }
    { print }' "$dir/shared.csv" >"$dir/turned.csv"
"$mukca" diagnose -q --urdf $urdf --free-base --free-tool --json "$dir/turned.json" "$dir/turned.csv" >/dev/null 2>&1
ok "nor does noise that turns them together" grep -q '"verdict": "none"' "$dir/turned.json"
ok "a row per log and target" test "$(cut -f 2 "$dir/scores" | tr '\n' ' ')" = "placement rows.csv:A rows.csv:B rows.csv:C test.csv:D "
ok "each below 0.25 mm" awk -F'\t' 'NR > 1 && !($5 < 2.5e-4) { exit 1 }' "$dir/scores"
run report "$dir/columns.csv" --free-base --test "$dir/test.csv" -o "$dir/targets.html" >"$dir/said" 2>&1
for row in 'nominal model=10' 'calibrated geometry=0.25'; do
    ok "report of several targets: ${row%=*}" less \
        "$(sed -n "s/^<tr>.*<td>${row%=*}<.*>\([0-9.]*\)<\/td>$/\1/p; s/.*<td>${row%=*}<.*>\([0-9.]*\)<\/td><\/tr>$/\1/p" "$dir/targets.html" | head -n 1)" "${row#*=}"
done
refuses "calibrate names the command for several" 3 'the pose logs have 3 targets; mukca diagnose -o' run calibrate "$dir/rows.csv" --free-base
refuses "and so does recalibrate" 3 'the pose logs have 3 targets; mukca diagnose -o' run recalibrate "$dir/rows.csv" --free-base

# ---- several logs, one table
run evaluate "$dir/one.csv" "$dir/two.csv" >"$dir/scores" 2>"$dir/said"
ok "evaluate: a row per log" test "$(cut -f 2,3 "$dir/scores" | tr '\t\n' ': ')" = "placement:rows one.csv:60 two.csv:40 "
for tip in link_7 ball_link; do # the link of the last moving joint has no fixed joint for the target
    run diagnose "$dir/one.csv" --tip $tip --free-base --free-tool -o "$dir/one.tsv" --force >"$dir/one.txt" 2>"$dir/said"
    run evaluate "$dir/two.csv" --tip $tip --offsets "$dir/one.tsv" >"$dir/scores" 2>"$dir/said"
    ok "$tip: the table of a diagnosis predicts as the diagnosis does" awk -F'\t' 'NR > 1 && !($5 < 2.5e-4) { bad = 1 } END { exit bad || NR < 2 }' "$dir/scores"
done

# ---- what is said of pose logs
run calibrate "$dir/one.csv" --free-base --free-tool --test "$dir/two.csv" >"$dir/calibrate.txt" 2>"$dir/said"
ok "calibrate with a free base" grep -q '^Use     yes: held-out' "$dir/calibrate.txt"
ok "the nominal model is judged with the frames aligned" grep -Eq 'position mm, train +[0-9]\.' "$dir/calibrate.txt"
ok "and no warning says that it is metres off" sh -c "! grep -q 'mm off' '$dir/calibrate.txt' '$dir/said'"
run report "$dir/one.csv" --free-base --free-tool -o "$dir/page.html" >"$dir/out" 2>"$dir/said" || echo "not ok report: $(cat "$dir/said")"
sed 's/<style.*//; s/<[^>]*>/ /g' "$dir/page.html" 2>/dev/null | tr -d '\0' >"$dir/page.txt"
for text in calibrate.txt one.txt page.txt; do
    ok "$text: no ball, socket or placement" sh -c "! sed 's/ball_[a-z]*//g' '$dir/$text' | grep -nwE 'balls?|sockets?|placements?' >&2"
done

# ---- no header: the quaternion's order is asked for, and judged by the arm
grep -v '^#' "$dir/all.csv" | cut -d, -f2- >"$dir/named.csv"
tail -n +2 "$dir/named.csv" >"$dir/first.csv"
awk -F, -v OFS=, '{ w = $11; $11 = $12; $12 = $13; $13 = $14; $14 = w } { print }' "$dir/first.csv" >"$dir/last.csv"
run evaluate "$dir/named.csv" -q >"$dir/wanted"
refuses "both orders are offered" 3 'with --map order, or --map order-w-last for qx qy qz qw$' run evaluate "$dir/last.csv"
for form in first:order last:order-w-last; do
    run evaluate "$dir/${form%:*}.csv" --map "${form#*:}" >"$dir/scores" 2>"$dir/said"
    ok "--map ${form#*:} reads the poses" sh -c "grep -v '^heron7' '$dir/scores' | cut -f 3- | head -n 2 >'$dir/a'
        cut -f 3- '$dir/wanted' | head -n 2 | cmp - '$dir/a'"
    ok "--map ${form#*:} says what was taken, once" test "$(grep -c "${form%:*}.csv: read as 7 joints, x y z, q" "$dir/said")" = 1
done
refuses "the other order is noticed: w last" 3 'last.csv:[0-9]*: column 11: the orientations contradict the positions by [0-9]* mrad; the quaternions fit as xyzw: --rotation xyzw$' run evaluate "$dir/last.csv" --map order
refuses "the other order is noticed: w first" 3 'first.csv:[0-9]*: column 14: .* the quaternions fit as wxyz: --rotation wxyz$' run evaluate "$dir/first.csv" --map order-w-last
refuses "poses the other way round are noticed" 3 "the poses fit as those of the target in the fixed frame: omit --inverse-poses$" run evaluate "$dir/named.csv" --inverse-poses

# ---- orientations that contradict the positions in every convention: a note, and no table is accepted
awk -F, -v OFS=, 'NR > 1 { $12 *= 1.6; n = sqrt($11^2 + $12^2 + $13^2 + $14^2); for (i = 11; i < 15; i++) $i = sprintf("%.12f", $i / n) } 1' \
    "$dir/named.csv" >"$dir/bent.csv"
for command in calibrate diagnose recalibrate; do
    run $command "$dir/bent.csv" --free-base --free-tool >"$dir/said" 2>&1
    ok "$command refuses orientations that contradict the positions" grep -qE '^Use +no: |no offsets table is written' "$dir/said"
    ok "$command: and says so" grep -q 'note: .*bent.csv: the orientations contradict the positions by [0-9]* mrad in every common convention; --rotation none' "$dir/said"
done
run evaluate "$dir/bent.csv" --rotation none -q >"$dir/scores"
ok "--rotation none reads the positions alone" awk -F'\t' 'NR == FNR { wanted = $5; next } FNR == 2 { found = ($5 - wanted) ^ 2 < 1e-18 && $10 == "" && $11 == "" } END { exit !found }' \
    "$dir/wanted" "$dir/scores"
refuses "an unknown convention is an error" 2 '^mukca evaluate: --rotation XXZ: give angles as XYZ (intrinsic)' run evaluate "$dir/named.csv" --rotation XXZ

# ---- columns and frames that explain poses far off are named by recalibrate, too
awk -F, -v OFS=, 'NR > 1 { $4 *= -1 } 1' "$dir/named.csv" >"$dir/sign.csv"
awk -F, -v OFS=, 'NR > 1 { w = $11; x = $12; y = $13; $8 *= -1; $9 *= -1; $11 = -$14; $12 = -y; $13 = x; $14 = w } 1' "$dir/named.csv" >"$dir/base.csv"
run recalibrate "$dir/sign.csv" --free-base --free-tool 2>&1 | tr '\n' ' ' >"$dir/said"
ok "a joint of the opposite sign" grep -q 'with the opposite sign of joint_4' "$dir/said"
run recalibrate "$dir/base.csv" 2>&1 | tr '\n' ' ' >"$dir/said"
ok "a base frame turned by half a turn" grep -q 'with the base turned by 1[78][0-9.]* degrees' "$dir/said"
run recalibrate "$dir/named.csv" 2>&1 | tr '\n' ' ' >"$dir/said"
ok "nothing of a log that fits" sh -c "grep -q 'Result' '$dir/said' && ! grep -q 'would agree' '$dir/said'"
exit $failed
