#!/bin/bash
# The heart (make heart): at most 2,000 lines with all headers, and the minima of the full program, for the
# demo's arm and, where the data are at hand, two rows of the paper's Table I.
set -u
cd "$(dirname "$0")/.." || exit 1
build=${BUILD:-build}
. tests/ok.bash

read -ra sources <<<"$HEART_SRC"
lines=$(for file in "${sources[@]}"; do cc -MM -D_DEFAULT_SOURCE -Iinclude -Isrc "$file"; done | tr ' \\' '\n\n' |
    grep '\.[ch]$' | sort -u | xargs cat | wc -l)
ok "heart: $lines lines" test "$lines" -gt 1000 -a "$lines" -le 2000

# NAME URDF FOLDER...: cost of heart and program; the heart's mean errors are the program's, with its table
minimum() {
    local name=$1 urdf=$2
    shift 2
    "$mukca" calibrate -q --urdf "$urdf" "$@" -o "$dir/full.tsv" --force --json "$dir/full.json" || failed=1
    for solver in slsqp lbfgs; do
        "$build/heart" $solver "$dir/full.tsv" "$@" >"$dir/heart.tsv" 2>"$dir/said" || failed=1
        ok "heart, $name, $solver: $(cut -d, -f1 "$dir/said")" awk '
            /"calibrated": *{/ { inside = 1 }
            inside && /"total"/ { gsub(/[^-+.0-9e]*"total": *|,.*/, ""); want = $0 + 0; inside = 0 }
            $1 == "J" { got = $2 }
            END { exit !(want > 0 && got / want - 1 <= 1e-9 && want / got - 1 <= 1e-9) }' "$dir/full.json" "$dir/said"
    done
    "$mukca" evaluate -q --urdf "$urdf" --offsets "$dir/heart.tsv" "$@" >"$dir/scores" || failed=1
    awk -F'\t' 'NR > 1 { n += $3; nominal += $3 * $4; sum += $3 * $5 }
        END { printf "mean error %.3e m, nominal %.3e m", sum / n, nominal / n }' "$dir/scores" >"$dir/errors"
    ok "heart, $name: $(cat "$dir/errors")" grep -qFf "$dir/errors" "$dir/said"
}

# the demo's session as folders
awk -F'\t' -v OFS=, -v dir="$dir" '!/^#/ && $1 != "placement" {
    folder = dir "/demo/" $1
    if (!(folder in made)) { made[folder] = 1; system("mkdir -p " folder) }
    print $4, $5, $6, $7, $8, $9, $10 >(folder "/hole_" $2 ".csv") }' data/demo/train.tsv
minimum demo data/demo/arm.urdf "$dir"/demo/*
real=${MUKCA_REAL_DATA:-../shared/real}
if [ -d "$real" ]; then
    minimum "Table I, Panda (1)" "$real/panda.urdf" "$real/panda_2_clean/front_center"
    minimum "Table I, KUKA iiwa 14" "$real/iiwa14.urdf" "$real/kuka_14/front"
else
    echo "skip heart: Table I, no data in $real"
fi
exit $failed
