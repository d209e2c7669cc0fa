#!/bin/sh
# The report of the demo arm: self-contained, its figures there and told in words, its numbers those
# of calibrate, its failures clear.
set -u
cd "$(dirname "$0")/../.." || exit 1
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
failed=0
tell() { # name, then a command that must succeed
    name=$1
    shift
    if "$@"; then echo "ok report: $name"; else echo "not ok report: $name"; failed=1; fi
}
arm=data/demo/arm.urdf
if ! "$MUKCA" report -q --urdf $arm data/demo/train.tsv --test data/demo/test.tsv -o "$out/r.html" \
    --plots "$out/png" >"$out/log" 2>&1; then
    cat "$out/log"
    echo "not ok report: made"
    exit 1
fi
page=$out/r.html

none() { ! grep -nE "$1" "$page" | cut -c1-200 | grep .; }
tell "no script" none '<script'
tell "nothing from elsewhere" none '(src|href|data|action)=["'"'"']?[^#"'"'"' >]|url\([^#]|@import'
tell "ids are unique" sh -c 'test -z "$(grep -oE "[ ]id=[\"'"'"'][^\"'"'"']*" "$0" | sort | uniq -d)"' "$page"
tell "references exist" sh -c '
    grep -oE "(href=[\"'"'"']#|url\(#)[^\"'"'"')]*" "$0" | sed "s/.*#//" | sort -u >"$1/used"
    grep -oE "[ ]id=[\"'"'"'][^\"'"'"']*" "$0" | sed "s/.*[\"'"'"']//" | sort -u >"$1/there"
    test -z "$(comm -23 "$1/used" "$1/there")"' "$page" "$out"
# One line per figure: drawn elements, length of the title, length of the description.
awk '/<svg/ {drawn = 0; words = title = ""} /<(path|use|rect|polygon|circle) / {drawn++}
    /<title id=/ {title = $0} /<desc id=/ {words = $0}
    /<\/svg>/ {print drawn, length(title), length(words)}' "$page" >"$out/figures"
tell "20 figures" test "$(wc -l <"$out/figures")" -eq 20
tell "none is empty or mute" awk '$1 < 25 || $2 < 40 || $3 < 80 {bad = 1; print} END {exit bad}' "$out/figures"
tell "images as files" sh -c 'test "$(find "$0" -name "*.png" -size +5k | wc -l)" -eq 20' "$out/png"

"$MUKCA" calibrate -q --urdf $arm data/demo/train.tsv --test data/demo/test.tsv -o "$out/o.tsv" --json "$out/c.json"
tell "held-out error as calibrate says" grep -q "$(awk -v m="$(tr -d '\n' <"$out/c.json" |
    sed 's/.*"test": *\[\([^]]*\)\].*/\1/; s/.*"mae_m": *\([0-9.e-]*\).*/\1/')" \
    'BEGIN {printf "calibrated, test data</dt><dd>%#.3g ", m * 1000}')" "$page"
tell "from an offsets table" sh -c '"$0" report -q --urdf data/demo/arm.urdf data/demo/train.tsv \
    --offsets "$1/o.tsv" -o "$1/p.html" --plots "$1/pdf" --format pdf && grep -q "</html>" "$1/p.html" &&
    head -c 5 "$1/pdf/samples.pdf" | grep -q "%PDF-"' "$MUKCA" "$out"
tell "an existing page stays" sh -c '"$0" report -q --urdf data/demo/arm.urdf data/demo/train.tsv \
    -o "$1/p.html" 2>"$1/e"; test $? -eq 3 && grep -q -- --force "$1/e"' "$MUKCA" "$out"
mkdir "$out/bin"
tell "without gnuplot" sh -c 'PATH=$1/bin "$0" report -q --urdf data/demo/arm.urdf data/demo/train.tsv \
    -o "$1/q.html" 2>"$1/e"; test $? -eq 3 && test ! -e "$1/q.html"; s=$?; PATH=/usr/bin:/bin
    grep -q "install the package gnuplot-nox" "$1/e" && exit $s' "$MUKCA" "$out"
exit $failed
