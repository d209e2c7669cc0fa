#!/bin/bash
# recalibrate, compensate and the example of the core library from the command line:
# the paper's arm with its Table 3 built in, bad logs, and the published controllers' poses.
set -u
cd "$(dirname "$0")/.." || exit 1
example=${BUILD:-$PWD/build}/examples/example_controller
urdf=$PWD/data/gen3.urdf
real=${MUKCA_REAL_DATA:-$PWD/../shared/real}
tracker=${MUKCA_TRACKER_DATA:-$PWD/../shared/tracker}

. tests/ok.bash

# number FILE KEYS...: the value in JSON that is printed one key a line, behind those keys in turn
number() {
    local file=$1
    shift
    awk -v keys="$*" 'BEGIN { n = split(keys, key, " "); k = 1 }
        index($0, "\"" key[k] "\"") { if (k++ == n) { sub(/^[^:]*:/, ""); gsub(/[ ,]/, ""); print; exit } }' "$file"
}

arm=(--urdf "$urdf")
# An arm with errors in its lengths and in the zeros of its joints, which turn the origins about their z axes.
"$mukca" simulate "${arm[@]}" --poses 1 --seed 3 --perturb 4,5 --truth "$dir/all.tsv" -q >"$dir/one.log"
awk -F '\t' '/^#/ ? !/digest/ : $2 ~ /^[xyz]$|^parameter/ || $1 != "tool_joint" && $2 == ($1 == "joint_1" ? "yaw" : "pitch")' \
    "$dir/all.tsv" >"$dir/truth.tsv"
for recipe in sweeps raster; do
    "${BUILD:-$PWD/build}/bench/bench_recipes" "$urdf" $recipe >"$dir/$recipe.angles"
    ok "simulate $recipe" "$mukca" simulate "${arm[@]}" --offsets "$dir/truth.tsv" --at "$dir/$recipe.angles" -o "$dir/$recipe.tsv" -q
done
ok "recalibrate, beside a test" "$mukca" recalibrate "${arm[@]}" "$dir/sweeps.tsv" --test "$dir/raster.tsv" \
    --json "$dir/r.json" -o "$dir/offsets.tsv"
ok "poses that were not seen, to 2 um" less "$(number "$dir/r.json" test position both max_m)" 2e-6
ok "and to 2 urad" less "$(number "$dir/r.json" test orientation both max_rad)" 2e-6
ok "rank 24 of 31 unknowns" test "$(number "$dir/r.json" models rank)" = 24
ok "under 1 um on the log" less "$(number "$dir/r.json" train position both mean_m)" 1e-6
ok "the table predicts for others" sh -c "cut -f2-8 '$dir/raster.tsv' | grep -v '^#' >'$dir/q.tsv' &&
    '$mukca' fk --urdf '$urdf' --offsets '$dir/offsets.tsv' '$dir/q.tsv' -o '$dir/p.tsv' &&
    grep -v '^#' '$dir/raster.tsv' | cut -f9-11 | paste - '$dir/p.tsv' |
    awk 'NR > 1 { for (i = 1; i <= 3; i++) { d = \$i - \$(i + 3); if (d > 2e-6 || d < -2e-6) exit 1 } }'"

# Positions of one link, orientations of another that is turned against it, of an arm with errors in all origins
"$mukca" simulate "${arm[@]}" --poses 250 --seed 2 --perturb 1,2 --noise 5e-5 --rotation-noise 1e-4 -o "$dir/axes.tsv" -q
tip=$(awk -F '"' '/<child link/ { last = $2 } END { print last }' "$urdf")
sed "s|</robot>|<link name=\"probe\"/><joint name=\"probe_joint\" type=\"fixed\"><parent link=\"$tip\"/><child link=\"probe\"/>&|
     s|<child link=\"probe\"/>|&<origin xyz=\"0.1 0 0.05\" rpy=\"0.3 -0.5 0.7\"/></joint>|" "$urdf" >"$dir/probe.urdf"
awk 'BEGIN { FS = OFS = "\t"; a = cos(.15); A = sin(.15); b = cos(-.25); B = sin(-.25); c = cos(.35); C = sin(.35)
        w = a * b * c + A * B * C; x = A * b * c - a * B * C; y = a * B * c + A * b * C; z = a * b * C - A * B * c }
    /^#/ || !n++ { print; next }
    { p = $12; q = $13; r = $14; s = $15
      $12 = p * w - q * x - r * y - s * z; $13 = p * x + q * w + r * z - s * y
      $14 = p * y - q * z + r * w + s * x; $15 = p * z + q * y - r * x + s * w; print }' "$dir/axes.tsv" >"$dir/probe.tsv"
refuses "two links" 0 "positions are those of '$tip', orientations those of 'probe'" \
    "$mukca" recalibrate --urdf "$dir/probe.urdf" "$dir/probe.tsv" --json "$dir/probe.json"
"$mukca" recalibrate "${arm[@]}" "$dir/axes.tsv" --json "$dir/plain.json" -q
ok "are as good as one" less "$(number "$dir/probe.json" train orientation all mean_rad)" \
    "$(number "$dir/plain.json" train orientation all mean_rad | awk '{ print 1.001 * $1 }')"

# Faults of logs
grep -v '^#' "$dir/sweeps.tsv" >"$dir/plain.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 { for (i = 9; i <= 11; i++) $i *= 30 } 1' "$dir/plain.tsv" >"$dir/far.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 && NR % 3 == 0 { for (i = 12; i <= 15; i++) $i = -$i } 1' "$dir/plain.tsv" >"$dir/sign.tsv"
head -n 6 "$dir/plain.tsv" >"$dir/few.tsv"
cut -f1-8 "$dir/plain.tsv" >"$dir/joints.tsv"
refuses "another frame" 3 "free-base" "$mukca" recalibrate "${arm[@]}" "$dir/far.tsv"
refuses "too few rows" 5 "5 poses" "$mukca" recalibrate "${arm[@]}" "$dir/few.tsv"
refuses "no poses at all" 3 "x_m" "$mukca" recalibrate "${arm[@]}" "$dir/joints.tsv"
refuses "flipped signs do no harm" 0 "both  *0.000  *0.000" "$mukca" recalibrate "${arm[@]}" "$dir/sign.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR == 1 || $4 == 0' "$dir/plain.tsv" >"$dir/still.tsv"
refuses "a joint that never moved" 0 "'joint_3' never moved" "$mukca" recalibrate "${arm[@]}" "$dir/still.tsv"
"$mukca" simulate "${arm[@]}" --at "$dir/sweeps.angles" --noise 1e-5 --rotation-noise 1e-5 -o "$dir/nominal.tsv" -q
refuses "poses that repeat the nominal model" 5 "no calibration in these poses" "$mukca" recalibrate "${arm[@]}" \
    "$dir/nominal.tsv" -o "$dir/none.tsv"
mv "$dir/out" "$dir/figures"
mv "$dir/err" "$dir/said"
ok "a verdict alone" grep -q "no offsets table is written" "$dir/said"
ok "no figures" test ! -s "$dir/figures"
ok "and nothing written" test ! -e "$dir/none.tsv"

# A mounted tool: its offset goes to the tool, not to the joint before it; and one story is told
{
    grep '^#' "$dir/truth.tsv"
    printf 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n'
    printf 'tool_joint\tz\tm\t-0.0615\t-0.12326\t-0.06176\t0\t1\t-\n'
    printf 'joint_1\tx\tm\t0\t0.002\t0.002\t0\t1\t-\n'
} >"$dir/mounted.tsv"
"$mukca" simulate "${arm[@]}" --offsets "$dir/mounted.tsv" --at "$dir/sweeps.angles" -o "$dir/mounted_log.tsv" -q
ok "a mounted tool" "$mukca" recalibrate "${arm[@]}" "$dir/mounted_log.tsv" -o "$dir/found.tsv"
cat "$dir/out" "$dir/err" >"$dir/said"
ok "one story: what was found, what was written" sh -c "
    grep -q '^Result' '$dir/said' && grep -q '^Tip ' '$dir/said' && grep -q '^Use ' '$dir/said' && grep -q '^Written' '$dir/said' &&
    ! grep -q 'saves the result\|nothing was written\|joint_3 y' '$dir/said'"
ok "the tool's offset is the tool's alone" awk -F '\t' '
    $1 == "joint_7" && $2 == "y" { arm = $6 } $1 == "tool_joint" && $2 == "z" { tool = $6 }
    END { exit !(arm * arm < 1e-12 && (tool + 0.06176) ^ 2 < 1e-10) }' "$dir/found.tsv"
ok "--json lists all offsets" sh -c "'$mukca' recalibrate --urdf '$urdf' '$dir/mounted_log.tsv' --json - | grep -q 'joint_3 y'"

# Compensation of what was found
ok "compensate" "$mukca" compensate "${arm[@]}" --offsets "$dir/offsets.tsv" "$dir/q.tsv" -o "$dir/sent.tsv" --json "$dir/c.json"
ok "all reached" test "$(number "$dir/c.json" status ok)" = 165
ok "the corrected arm is where the nominal one was meant to be" sh -c "
    '$mukca' fk --urdf '$urdf' '$dir/q.tsv' -o '$dir/meant.tsv' &&
    cut -f1-7 '$dir/sent.tsv' | '$mukca' fk --urdf '$urdf' --offsets '$dir/offsets.tsv' - -o '$dir/got.tsv' &&
    paste '$dir/meant.tsv' '$dir/got.tsv' |
    awk 'NR > 1 { for (i = 1; i <= 3; i++) { d = \$i - \$(i + 3); if (d > 1e-7 || d < -1e-7) exit 1 } }'"
if [ -x "$example" ]; then
    printf '0.1,0.2,0.3,-1.5,0.2,1.1,0.4\n' | "$mukca" fk "${arm[@]}" --offsets "$dir/offsets.tsv" -o "$dir/fk.tsv"
    "$example" "$dir/offsets.tsv" 0.1 0.2 0.3 -1.5 0.2 1.1 0.4 >"$dir/example"
    ok "the core library agrees with mukca fk" awk 'NR == FNR { if (FNR == 2) split($0, p, "\t"); next }
        /^position_m/ { seen = 1; for (i = 1; i <= 3; i++) { d = $(i + 1) - p[i]; if (d > 2e-9 || d < -2e-9) exit 1 } }
        END { if (!seen) exit 1 }' "$dir/fk.tsv" "$dir/example"
fi

if [ -d "$real" ]; then
    for robot in panda_1 panda_2 panda_3; do
        refuses "$robot: no factory calibration" 5 "no calibration in these poses" \
            "$mukca" recalibrate --urdf "$real/panda.urdf" "$real/$robot"/*/
    done
    ok "panda_4 holds one" "$mukca" recalibrate --urdf "$real/panda.urdf" "$real/panda_4"/*/
else
    echo "skip published controllers' poses: $real is not here (MUKCA_REAL_DATA)"
fi
if [ -d "$tracker" ]; then
    ok "a tracker's log" "$mukca" recalibrate --urdf "$tracker/ur5.urdf" "$tracker/ur5_grid.tsv" \
        --test "$tracker/ur5_random.tsv" --json "$dir/ur5.json"
    ok "0.105 mm on its random poses" less "$(number "$dir/ur5.json" test position all mean_m)" 0.105e-3
else
    echo "skip the tracker's log: $tracker is not here (MUKCA_TRACKER_DATA)"
fi
exit $failed
