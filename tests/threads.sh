#!/bin/bash
# The answer of a diagnosis is the same for every number of threads; `make -f tools/Makefile tsan` runs this under the
# thread sanitizer.
cd "$(dirname "$0")/.." || exit 1
. tests/ok.bash
same() { # NAME MUKCA-ARGUMENTS...
    local name=$1 n
    shift
    for n in 1 2 3; do
        "$mukca" "$@" -q --threads $n --json "$dir/$n.json" --force >/dev/null || return 1
        sed -i '/"elapsed_s"/d' "$dir/$n.json"
    done
    grep -q '"verdict": "\(named\|tied\|unknown\)"' "$dir/1.json" && cmp "$dir/1.json" "$dir/2.json" &&
        cmp "$dir/1.json" "$dir/3.json" && echo "$name"
}
for n in 120 5000; do # the larger one is read ahead
    "$mukca" simulate -q --urdf data/gen3.urdf --poses $n --perturb 1,2 --seed 3 --noise 1e-4 --rotation-noise 1e-4 \
        --effect backlash:joint_2=1e-3,gear_harmonic:joint_4@100=3e-4 -o "$dir/$n.tsv" || failed=1
done
ok "sockets: one to three threads" same sockets diagnose --urdf data/demo/arm.urdf data/demo/train.tsv --test data/demo/test.tsv
ok "measured poses: one to three threads" same poses diagnose --urdf data/gen3.urdf --free-base --free-tool "$dir/120.tsv"
ok "a large file: one to three threads" same large diagnose --urdf data/gen3.urdf --free-base --free-tool "$dir/5000.tsv"
exit $failed
