#!/bin/bash
# recalibrate, compensate and the example of the core library from the command line:
# the paper's arm with its Table 3 built in, bad logs, and the published controllers' poses.
set -u
cd "$(dirname "$0")/.." || exit 1
example=${BUILD:-$PWD/build}/examples/example_controller
urdf=$PWD/data/gen3.urdf
real=${MUKCA_REAL_DATA:-$PWD/../shared/real}
tracker=${MUKCA_TRACKER_DATA:-$PWD/../shared/tracker}

# shellcheck source=tests/ok.bash
. tests/ok.bash

refuses() { # NAME CODE PATTERN COMMAND...
    local name=$1 want=$2 pattern=$3 code
    shift 3
    "$@" >"$dir/out" 2>"$dir/err"
    code=$?
    if [ $code = "$want" ] && cat "$dir/out" "$dir/err" | grep -q -- "$pattern"; then
        echo "ok $name"
    else
        echo "not ok $name: exit $code, wanted $want and '$pattern'"
        tail -n 3 "$dir/err"
        failed=1
    fi
}

less() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a + 0 < b + 0) }'; }

# number FILE KEYS...: the value in JSON that is printed one key a line, behind those keys in turn
number() {
    local file=$1
    shift
    awk -v keys="$*" 'BEGIN { n = split(keys, key, " "); k = 1 }
        index($0, "\"" key[k] "\"") { if (k++ == n) { gsub(/[^-0-9.e+]*:/, ""); gsub(/[ ,]/, ""); print; exit } }' "$file"
}

# Table 3 of the paper as an offsets table: lengths as they are, angles as origins.
sha=$(sha256sum "$urdf" | cut -d' ' -f1)
awk -v sha="$sha" '
function atan3(y, x) { return atan2(y, x) }
function row(joint, p, unit, nominal, offset) {
    printf "%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t0\t1\t-\n", joint, p, unit, nominal, nominal + offset, offset
}
BEGIN {
    pi = atan2(0, -1)
    print "# urdf_sha256: " sha
    print "joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm"
    split("1 0.5 -0.5 0.5 -0.5 0.5 -0.5", turn, " ")
    split("0.0044 0.0088 -0.0035 -0.0043 0.0068 0.0026 -0.0084", dq, " ")
    split("0 0 0.1564 0 0.0054 -0.1284 0 -0.2104 -0.0064 0 0.0064 -0.2104 0 -0.2084 -0.0064 0 0 -0.1059 0 -0.1059 0 0 0 -0.0615", p, " ")
    split("0.0085 0.0003 -0.0083 -0.0068 0 0 -0.0001 -0.0041 0.0028 -0.0003 0.0015 0 0.0001 0 0 -0.0003 -0.0001 -0.0024 0.0009 0 0 0.0009 -0.0003 0", dp, " ")
    split("x y z", axis, " ")
    for (k = 1; k <= 8; k++) {
        joint = k < 8 ? "joint_" k : "tool_joint"
        for (i = 1; i <= 3; i++) row(joint, axis[i], "m", p[3 * k - 3 + i], dp[3 * k - 3 + i])
        if (k == 8) break
        a = turn[k] * pi; c = cos(dq[k]); s = sin(dq[k]) # Rx(a) Rz(dq) as roll, pitch, yaw
        r31 = sin(a) * s; r32 = sin(a) * c; r33 = cos(a)
        roll = atan3(r32, r33); pitch = atan3(-r31, sqrt(r32 * r32 + r33 * r33)); yaw = atan3(cos(a) * s, c)
        if (roll - a < -pi) roll += 2 * pi
        row(joint, "roll", "rad", a, roll - a); row(joint, "pitch", "rad", 0, pitch); row(joint, "yaw", "rad", 0, yaw)
    }
}' >"$dir/truth.tsv"

arm=(--urdf "$urdf")
for recipe in sweeps raster; do
    "${BUILD:-$PWD/build}/bench/bench_recipes" "$urdf" $recipe >"$dir/$recipe.angles"
    ok "simulate $recipe" "$mukca" simulate "${arm[@]}" --offsets "$dir/truth.tsv" --at "$dir/$recipe.angles" -o "$dir/$recipe.tsv" -q
done
ok "recalibrate, iterated" "$mukca" recalibrate "${arm[@]}" "$dir/sweeps.tsv" --test "$dir/raster.tsv" --iterate \
    --json "$dir/r.json" -o "$dir/offsets.tsv"
ok "poses that were not seen, to 2 um" less "$(number "$dir/r.json" test position both max_m)" 2e-6
ok "and to 2 urad" less "$(number "$dir/r.json" test orientation both max_rad)" 2e-6
ok "rank 17 of 24 lengths" test "$(number "$dir/r.json" models rank)" = 24
ok "one pass under 1 um" "$mukca" recalibrate "${arm[@]}" "$dir/sweeps.tsv" --json "$dir/one.json"
ok "one pass under 1 um" less "$(number "$dir/one.json" train position both mean_m)" 1e-6
ok "the table predicts for others" sh -c "cut -f2-8 '$dir/raster.tsv' | grep -v '^#' >'$dir/q.tsv' &&
    '$mukca' fk --urdf '$urdf' --offsets '$dir/offsets.tsv' '$dir/q.tsv' -o '$dir/p.tsv' &&
    grep -v '^#' '$dir/raster.tsv' | cut -f9-11 | paste - '$dir/p.tsv' |
    awk 'NR > 1 { for (i = 1; i <= 3; i++) { d = \$i - \$(i + 3); if (d > 2e-6 || d < -2e-6) exit 1 } }'"

# Faults of logs
grep -v '^#' "$dir/sweeps.tsv" >"$dir/plain.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 { $4 = 0.3 } 1' "$dir/plain.tsv" >"$dir/x.tsv" # not what was measured
awk 'BEGIN { FS = OFS = "\t" } NR == 1 { for (i = 9; i <= 11; i++) sub("_m", "_m", $i) } NR > 1 { for (i = 9; i <= 11; i++) $i *= 30 } 1' "$dir/plain.tsv" >"$dir/far.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 { for (i = 9; i <= 11; i++) $i *= 1000 } 1' "$dir/plain.tsv" >"$dir/mm.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 { for (i = 2; i <= 8; i++) $i *= 57.29577951308232 } 1' "$dir/plain.tsv" >"$dir/deg.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 { w = $12; for (i = 12; i < 15; i++) $i = $(i + 1); $15 = w } 1' "$dir/plain.tsv" >"$dir/last.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR > 1 && NR % 3 == 0 { for (i = 12; i <= 15; i++) $i = -$i } 1' "$dir/plain.tsv" >"$dir/sign.tsv"
head -n 6 "$dir/plain.tsv" >"$dir/few.tsv"
head -c 20000 "$dir/plain.tsv" >"$dir/cut.tsv"
cut -f1-8 "$dir/plain.tsv" >"$dir/joints.tsv"
refuses "millimetres" 3 "positions are in m" "$mukca" recalibrate "${arm[@]}" "$dir/mm.tsv"
refuses "degrees" 3 "angles are in rad" "$mukca" recalibrate "${arm[@]}" "$dir/deg.tsv"
refuses "another frame" 3 "free-base" "$mukca" recalibrate "${arm[@]}" "$dir/far.tsv"
refuses "too few rows" 5 "5 poses" "$mukca" recalibrate "${arm[@]}" "$dir/few.tsv"
refuses "a cut-off last line" 3 "cut.tsv:" "$mukca" recalibrate "${arm[@]}" "$dir/cut.tsv"
refuses "no poses at all" 3 "x_m" "$mukca" recalibrate "${arm[@]}" "$dir/joints.tsv"
refuses "w last is told, and read" 0 "x y z w" "$mukca" recalibrate "${arm[@]}" "$dir/last.tsv"
refuses "flipped signs do no harm" 0 "both  *0.000  *0.000" "$mukca" recalibrate "${arm[@]}" "$dir/sign.tsv"
awk 'BEGIN { FS = OFS = "\t" } NR == 1 || $4 == 0' "$dir/plain.tsv" >"$dir/still.tsv"
refuses "a joint that never moved" 0 "'joint_3' never moved" "$mukca" recalibrate "${arm[@]}" "$dir/still.tsv"
"$mukca" simulate "${arm[@]}" --at "$dir/sweeps.angles" --noise 1e-5 --rotation-noise 1e-5 -o "$dir/nominal.tsv" -q
refuses "poses that repeat the nominal model" 5 "no calibration in these poses" "$mukca" recalibrate "${arm[@]}" \
    "$dir/nominal.tsv" -o "$dir/none.tsv"
ok "nothing written then" test ! -e "$dir/none.tsv"

# A mounted tool: its offset goes to the tool, not to the joint before it; and one story is told
{
    grep '^#' "$dir/truth.tsv"
    printf 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n'
    printf 'tool_joint\tz\tm\t-0.0615\t-0.12326\t-0.06176\t0\t1\t-\n'
    printf 'joint_1\tx\tm\t0\t0.002\t0.002\t0\t1\t-\n'
} >"$dir/mounted.tsv"
"$mukca" simulate "${arm[@]}" --offsets "$dir/mounted.tsv" --at "$dir/sweeps.angles" -o "$dir/mounted_log.tsv" -q
ok "a mounted tool" "$mukca" recalibrate "${arm[@]}" "$dir/mounted_log.tsv" --iterate -o "$dir/found.tsv"
cat "$dir/out" "$dir/err" >"$dir/said"
ok "one story: what was found, what was written" sh -c "
    grep -q '^Result' '$dir/said' && grep -q '^Written' '$dir/said' &&
    ! grep -q 'saves the result\|nothing was written\|joint_3 y' '$dir/said'"
ok "the tool's offset is the tool's alone" awk -F '\t' '
    $1 == "joint_7" && $2 == "y" { arm = $6 } $1 == "tool_joint" && $2 == "z" { tool = $6 }
    END { exit !(arm * arm < 1e-12 && (tool + 0.06176) ^ 2 < 1e-10) }' "$dir/found.tsv"
refuses "a verdict alone where the poses are nominal" 5 "no offsets table is written" \
    "$mukca" recalibrate "${arm[@]}" "$dir/nominal.tsv" -o "$dir/none.tsv"
test ! -s "$dir/out"
nothing=$?
ok "and no figures" test $nothing = 0
ok "-v lists all offsets" sh -c "'$mukca' recalibrate --urdf '$urdf' '$dir/mounted_log.tsv' -v | grep -q 'joint_3 y'"

# Compensation of what was found
ok "compensate" "$mukca" compensate "${arm[@]}" --offsets "$dir/offsets.tsv" "$dir/q.tsv" -o "$dir/sent.tsv" --json "$dir/c.json"
ok "all reached" test "$(number "$dir/c.json" status ok)" = 165
ok "the corrected arm is where the nominal one was meant to be" sh -c "
    '$mukca' fk --urdf '$urdf' '$dir/q.tsv' -o '$dir/meant.tsv' &&
    cut -f1-7 '$dir/sent.tsv' | '$mukca' fk --urdf '$urdf' --offsets '$dir/offsets.tsv' - -o '$dir/got.tsv' &&
    paste '$dir/meant.tsv' '$dir/got.tsv' |
    awk 'NR > 1 { for (i = 1; i <= 3; i++) { d = \$i - \$(i + 3); if (d > 1e-7 || d < -1e-7) exit 1 } }'"
ok "poses in" sh -c "'$mukca' fk --pose --urdf '$urdf' '$dir/q.tsv' |
    '$mukca' compensate --poses --urdf '$urdf' --offsets '$dir/offsets.tsv' | grep -c 'ok$' | grep -qx 165"
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
    ok "0.105 mm on its random poses" less "$(number "$dir/ur5.json" test position both mean_m)" 0.105e-3
else
    echo "skip the tracker's log: $tracker is not here (MUKCA_TRACKER_DATA)"
fi
exit $failed
