#!/bin/bash
# Efforts of an arm without masses: as its joints exert them, and with the opposite sign.
set -u
cd "$(dirname "$0")/.." || exit 1

# shellcheck source=tests/ok.bash
. tests/ok.bash

grep -v '<mass\|<inertia\|</inertial' data/demo/arm.urdf >"$dir/arm.urdf"
"$mukca" simulate -q --urdf data/demo/arm.urdf --rows 25 --perturb 2,3 --noise 1e-4 --effort --seed 1 \
    --effect joint_compliance:joint_2=3e-5,joint_compliance:joint_4=5e-5 -o "$dir/exerted.tsv" || exit 1
awk -F'\t' -v OFS='\t' '/^#/ { print; next } !head++ { for (i = 1; i <= NF; i++) effort[i] = $i ~ /\.effort$/; print; next }
    { for (i = 1; i <= NF; i++) if (effort[i]) $i = -$i; print }' "$dir/exerted.tsv" >"$dir/load.tsv"
for file in exerted load; do
    "$mukca" diagnose --urdf "$dir/arm.urdf" "$dir/$file.tsv" >"$dir/$file.txt" 2>"$dir/said" || tail -n 2 "$dir/said"
    sed -n '/^Found/,/^Rest/p' "$dir/$file.txt" >"$dir/$file.found"
done
ok "the efforts are the loads" sh -c "grep -c '^ *.*joint compliance at joint_[24] ' '$dir/exerted.found' | grep -qx 2"
ok "the opposite sign: the same findings" cmp "$dir/exerted.found" "$dir/load.found"
ok "and a line says so" grep -q '^Efforts the sign of the measured efforts was reversed' "$dir/load.txt"
ok "only then" sh -c "! grep -q '^Efforts' '$dir/exerted.txt'"
exit $failed
