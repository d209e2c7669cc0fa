#!/bin/bash
# The report of the demo arm: self-contained, figures present and described in words, numbers those
# of calibrate, failures clear; the page of a fleet.
set -u
cd "$(dirname "$0")/../.." || exit 1
. tests/ok.bash
out=$dir
arm=data/demo/arm.urdf
if ! "$MUKCA" report -q --urdf $arm data/demo/train.tsv --test data/demo/test.tsv -o "$out/r.html" >"$out/log" 2>&1; then
    cat "$out/log"
    echo "not ok report: made"
    exit 1
fi
page=$out/r.html

none() { ! grep -nE "$1" "$page" | cut -c1-200 | grep .; }
ok "report: no script, nothing from elsewhere" none '<script|(src|href|data|action)=["'"'"']?[^#"'"'"' >]|url\([^#]|@import'
ok "report: ids are unique" sh -c 'test -z "$(grep -oE "[ ]id=[\"'"'"'][^\"'"'"']*" "$0" | sort | uniq -d)"' "$page"
ok "report: references exist" sh -c '
    grep -oE "(href=[\"'"'"']#|url\(#)[^\"'"'"')]*" "$0" | sed "s/.*#//" | sort -u >"$1/used"
    grep -oE "[ ]id=[\"'"'"'][^\"'"'"']*" "$0" | sed "s/.*[\"'"'"']//" | sort -u >"$1/there"
    test -z "$(comm -23 "$1/used" "$1/there")"' "$page" "$out"
# One line per figure: drawn elements, length of the title, length of the description.
awk '/<svg/ {drawn = 0; words = title = ""} /<(path|use|rect|polygon|polyline|circle) / {drawn++}
    /<title id=/ {title = $0} /<desc id=/ {words = $0}
    /<\/svg>/ {print drawn, length(title), length(words)}' "$page" >"$out/drawn"
ok "report: 8 figures" test "$(wc -l <"$out/drawn")" -eq 8
ok "report: none is empty or mute" awk '$1 < (NR > 1 ? 25 : 2) || $2 < 40 || $3 < 80 {bad = 1; print} END {exit bad}' "$out/drawn"

# What opens the page, and what a reader looks for.
ok "report: the verdict is one sentence" sh -c 'test "$(sed -n "s/^<p class=.verdict [a-z]*.>\(.*\)<.p>$/\1/p" "$0" |
    grep -o "[.]" | wc -l)" -eq 1' "$page"
ok "report: accuracy, use, verdict, then what to do" sh -c 'grep -n -e "class=.verdict" -e "id=.to-do" -e "Accuracy of the tip" "$0" |
    sed "s/.*\(verdict\|to-do\|Accuracy\).*/\1/" | tr "\n" " " | grep -qx "Accuracy verdict verdict to-do "' "$page"
# each finding in the view, at its place and in the colour of what it varies with, and below it
ok "report: findings are drawn on the arm" sh -c '
    "$0" diagnose -q --urdf data/demo/arm.urdf data/demo/train.tsv --json "$1/d.json" &&
    python3 - "$1/d.json" "$2" <<END
import json, re, sys
findings = [f for f in json.load(open(sys.argv[1]))["findings"] if f["varies_with"] != "placement"]
page = open(sys.argv[2]).read()
drawn = re.findall(r"class=\"found v(\d)\"", page)
assert findings and len(drawn) == len(findings) == page.count("&#9632;</span>"), (len(findings), drawn)
END' "$MUKCA" "$out" "$page"
mkdir "$out/figures"
"$MUKCA" calibrate -q --urdf $arm data/demo/train.tsv --test data/demo/test.tsv -o "$out/o.tsv"
python3 tests/report/figures.py "$out/figures" || failed=1
ok "report: from an offsets table" sh -c '"$0" report -q --urdf data/demo/arm.urdf data/demo/train.tsv \
    --offsets "$1/o.tsv" -o "$1/p.html" && grep -q "</html>" "$1/p.html"' "$MUKCA" "$out"
# A pose log has no placements and no distortion: no nan anywhere, on the screen neither.
grep -v '^#' data/demo/train.tsv | cut -f 4-10 >"$out/q.tsv"
"$MUKCA" fk -q --urdf $arm --offsets "$out/o.tsv" "$out/q.tsv" | paste "$out/q.tsv" - >"$out/log.tsv"
ok "report: a pose log prints no nan" sh -c '"$0" report --urdf data/demo/arm.urdf "$1/log.tsv" --free-base --free-tool \
    -o "$1/log.html" >"$1/screen" 2>&1 && grep -q "</html>" "$1/log.html" && cat "$1/screen" >>"$1/log.html" &&
    ! grep -nwi nan "$1/log.html"' "$MUKCA" "$out"

# ---- the page of a fleet: the third of four arms has a joint six times as soft; all have ripple of order 60
mkdir "$out/arms"
for arm in a b c d; do
    compliance=5e-5
    [ $arm = c ] && compliance=3e-4
    "$MUKCA" simulate -q --urdf data/demo/arm.urdf --seed "$(printf %d "'$arm")" --perturb 1,2 --noise 1e-4 --placements 3 --rows 15 \
        --effect joint_compliance:joint_4=$compliance --effect gear_harmonic:joint_2@60=1e-3 -o "$out/arms/$arm.tsv" &&
        "$MUKCA" diagnose -q --urdf data/demo/arm.urdf "$out/arms/$arm.tsv" --arm "arm <$arm>" --summary "$out/arms/$arm.json"
done
page=$out/fleet.html
ok "report: a fleet: made" "$MUKCA" report -q --fleet "$out"/arms/*.json -o "$page"
ok "report: a fleet: the verdict names the broken arm" grep -q \
    '^<p class="verdict unknown">arm &lt;c&gt;: joint compliance at joint_4 [0-9.]* times softer than 3 sisters' "$page"
ok "report: a fleet: as mukca fleet says" grep -qF "$("$MUKCA" fleet -q "$out"/arms/*.json --json - | sed -n '/"departures"/,$p' |
    awk '/"value"/ {if (!n++) printf "%.3g urad", $2 * 1e6} END {if (!n) print "no value"}')" "$page"
ok "report: a fleet: the broken arm comes first" sh -c '
    sed -n "/<tbody>/,/<.tbody>/p" "$0" | sed -n 2p | grep -q "^<tr><td>arm &lt;c&gt;"' "$page"
ok "report: a fleet: the shared order" grep -q "<li>transmission ripple at joint_2, 60 per turn" "$page"
ok "report: a fleet: a table for each coefficient" sh -c 'test "$(grep -c "<table" "$0")" -ge 10' "$page"
ok "report: a fleet: no script, nothing from elsewhere, no nan" none '<script|(src|href)=["'"'"'][^#]|>-?nan<'
ok "report: a fleet: ids are unique" sh -c 'test -z "$(grep -oE "[ ]id=[\"'"'"'][^\"'"'"']*" "$0" | sort | uniq -d)"' "$page"
"$MUKCA" simulate -q --urdf data/demo/arm.urdf --seed 5 --perturb 1,2 --noise 1e-4 --placements 3 --rows 15 \
    --effect joint_compliance:joint_2=4e-4 -o "$out/e.tsv" && "$MUKCA" diagnose -q --urdf data/demo/arm.urdf "$out/e.tsv" \
    --arm e --summary "$out/e.json"
ok "report: a fleet: two broken arms, each with its reason" sh -c '"$0" report -q --fleet "$1"/arms/*.json "$1/e.json" -o "$1/more.html" &&
    grep -q ">2 of 5 arms depart from the fleet[.]<" "$1/more.html" && grep -q "^<li>e: joint compliance at joint_2 " "$1/more.html" &&
    grep -q "^<li>arm &lt;c&gt;: joint compliance at joint_4 " "$1/more.html"' "$MUKCA" "$out"
ok "report: a fleet of two: not testable" sh -c '"$0" report -q --fleet "$1/arms/a.json" "$1/arms/b.json" -o "$1/two.html" &&
    grep -q "verdict untestable" "$1/two.html" && grep -q "</html>" "$1/two.html"' "$MUKCA" "$out"
ok "report: a fleet: no --urdf" sh -c '"$0" report -q --fleet --urdf data/demo/arm.urdf "$1/arms/a.json" "$1/arms/b.json" -o "$1/n.html" 2>"$1/e"
    test $? -eq 2 && grep -q "fleet and --urdf exclude each other" "$1/e" && test ! -e "$1/n.html"' "$MUKCA" "$out"
exit $failed
