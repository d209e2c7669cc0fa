#!/bin/bash
# calibrate and evaluate from the command line, on a planar arm whose postures are worked out here in
# awk: three turning joints, links of 0.401, 0.3 and 0.199 m where the URDF says 0.4, 0.3 and 0.2.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/ok.bash

{
    echo '<robot name="planar"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="ball"/>'
    i=0
    for step in 'base a 0' 'a b 0.4' 'b c 0.3'; do
        read -r parent child x <<<"$step"
        i=$((i + 1))
        echo "<joint name=\"j$i\" type=\"revolute\"><parent link=\"$parent\"/><child link=\"$child\"/>"
        echo "<origin xyz=\"$x 0 0\"/><axis xyz=\"0 0 1\"/><limit lower=\"-6\" upper=\"6\" effort=\"1\" velocity=\"1\"/></joint>"
    done
    echo '<joint name="tool" type="fixed"><parent link="c"/><child link="ball"/><origin xyz="0.2 0 0"/></joint></robot>'
} >"$dir/planar.urdf"

# 14 postures in each socket, elbow up and down by turns
awk -v OFS='\t' '
function acos(x) { return atan2(sqrt(1 - x * x), x) }
function seat(placement, socket, x, y,    i, phi, wx, wy, r2, elbow, q1, q2) {
    for (i = 0; i < 14; i++) {
        phi = atan2(y, x) - 1 + 0.15 * i
        wx = x - 0.199 * cos(phi); wy = y - 0.199 * sin(phi)
        r2 = wx * wx + wy * wy
        elbow = acos((r2 - 0.401 ^ 2 - 0.3 ^ 2) / (2 * 0.401 * 0.3)) * (i % 2 ? 1 : -1)
        q1 = atan2(wy, wx) - atan2(0.3 * sin(elbow), 0.401 + 0.3 * cos(elbow))
        printf "%s\t%s\t%.15g\t%.15g\t%.15g\n", placement, socket, q1, elbow, phi - q1 - elbow
    }
}
BEGIN {
    print "placement", "socket", "j1", "j2", "j3"
    seat("front", "s0", 0.6, 0); seat("front", "s1", 0.6, 0.05)
    seat("side", "s0", 0.35, 0.45); seat("side", "s1", 0.4, 0.45)
    seat("near", "s0", 0.45, -0.2); seat("near", "s1", 0.45, -0.15); seat("near", "s2", 0.48, -0.15)
}' >"$dir/all.tsv"
for p in front side near; do grep -E "^(placement|$p)" "$dir/all.tsv" >"$dir/$p.tsv"; done
printf 'socket_a\tsocket_b\tdistance_m\ns0\ts1\t0.05\ns1\ts2\t0.03\ns0\ts2\t%.15g\n' 0.058309518948453 >"$dir/distances.tsv"

calibrate=("$mukca" calibrate --urdf "$dir/planar.urdf" --distances "$dir/distances.tsv")
evaluate=("$mukca" evaluate --urdf "$dir/planar.urdf" --distances "$dir/distances.tsv")

finds_the_links() {
    "${calibrate[@]}" "$dir/front.tsv" "$dir/near.tsv" --lambda 1e-9 -o "$dir/offsets.tsv" \
        --json "$dir/result.json" --test "$dir/side.tsv" >"$dir/out" || return 1
    grep -q 'Converged' "$dir/out" || return 1
    awk -F'\t' '$1 == "j2" && $2 == "x" { exit !($6 > 0.000995 && $6 < 0.001005) }' "$dir/offsets.tsv" || return 1
    awk -F'\t' '$1 == "tool" && $2 == "x" { exit !($6 < -0.000995 && $6 > -0.001005) }' "$dir/offsets.tsv"
}
ok calibrate_finds_the_links finds_the_links

json_is_complete() {
    local key
    for key in schema converged solver name gradient evaluations iterations status cost nominal calibrated \
        total inconsistency distortion regularisation train test placement rows mae_nominal_m mae_m \
        std_nominal_m std_m distance_error_nominal_m distance_error_m parameters joint parameter unit \
        offset sigma identifiable rank observability elapsed_s; do
        grep -q "\"$key\":" "$dir/result.json" || { echo "no $key"; return 1; }
    done
    grep -q '"schema": "mukca.calibrate/1"' "$dir/result.json"
}
ok calibrate_json json_is_complete

evaluates() {
    "${evaluate[@]}" "$dir/side.tsv" --offsets "$dir/offsets.tsv" >"$dir/scores.tsv" 2>"$dir/err" || return 1
    awk -F'\t' 'NR == 2 { exit !($2 == "side" && $3 == 28 && $4 > 1e-4 && $5 < 1e-6) }' "$dir/scores.tsv" || return 1
    "${evaluate[@]}" "$dir/side.tsv" -q --json - | grep -q '"schema": "mukca.evaluate/1"'
}
ok evaluate_held_out evaluates

of_another_tip() { # a shorter chain and a longer one: the verdict of the table is of another arm
    sed 's|</robot>|<link name="pen"/><joint name="p" type="fixed"><parent link="ball"/><child link="pen"/></joint></robot>|' \
        "$dir/planar.urdf" >"$dir/pen.urdf"
    "$mukca" calibrate -q --urdf "$dir/pen.urdf" --tip ball --distances "$dir/distances.tsv" \
        "$dir/front.tsv" "$dir/near.tsv" -o "$dir/ball.tsv" 2>/dev/null
    for tip in pen c; do
        "$mukca" evaluate --urdf "$dir/pen.urdf" --tip $tip --offsets "$dir/ball.tsv" "$dir/side.tsv" >"$dir/out" 2>&1
        grep -q "made for another base or tip than 'base' and '$tip': its verdict does not hold" "$dir/out" || return 1
        grep -q 'These data contradict the table' "$dir/out" && [ $tip = pen ] && return 1
    done
    grep -q 'These data contradict the table' "$dir/out"
}
ok evaluate_another_tip of_another_tip
refuses calibrate_lambda 2 'lambda -1: must be' "${calibrate[@]}" -q "$dir/front.tsv" --lambda -1
refuses calibrate_unknown_parameter 2 "'j9.x' is neither a joint" "${calibrate[@]}" -q "$dir/front.tsv" --free j9.x
refuses calibrate_nothing_free 2 'no parameter is free' "${calibrate[@]}" -q "$dir/front.tsv" --freeze x,y,z,roll,pitch,yaw
exit $failed
