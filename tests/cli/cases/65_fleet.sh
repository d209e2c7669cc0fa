# fleet, diagnose --summary and --traits: bad input gets one clear line; parts give the same bytes as
# the whole.
demo=$root/data/demo
a="--urdf $demo/arm.urdf"
mkdir seven && cp "$demo/train.tsv" seven/
expect "a summary is written" "$MUKCA" diagnose -q $a seven/train.tsv --summary 7.json
expect "the label is the folder's name" grep -q '"arm":"seven"' 7.json
expect "another one" "$MUKCA" diagnose -q $a "$demo/test.tsv" --arm eight --summary 8.json
expect "a summary is a few tens of kB" test "$(wc -c <7.json)" -lt 40000
"$MUKCA" simulate $a --placements 3 --rows 15 --seed 3 --perturb 1,2 --noise 1e-4 \
    --effect joint_compliance:joint_4=5e-5 -o nine.tsv
expect "a third one" "$MUKCA" diagnose -q $a nine.tsv --arm nine --summary 9.json
answer "joint compliance at joint_4, 4" fleet 7.json 8.json 9.json -o all.traits.tsv --json all.json
expect "its JSON has effects, orders and departures" grep -q '"departures"' all.json
"$MUKCA" fleet -q --partial 9.json 7.json -o part.json
"$MUKCA" fleet -q --partial part.json 8.json -o whole.json
"$MUKCA" fleet -q --partial 7.json 8.json 9.json -o once.json
expect "a tree of partial jobs gives the same bytes" cmp whole.json once.json
"$MUKCA" fleet -q 8.json part.json -o tree.traits.tsv
expect "and so do the traits" cmp tree.traits.tsv all.traits.tsv
answer "^Fleet   the traits of 3 arms" diagnose $a seven/train.tsv --traits all.traits.tsv
answer "only the means of 3 arms" diagnose $a seven/train.tsv --traits all.traits.tsv --traits-only
# joint_4's compliance from the fleet alone explains most of what the geometry leaves
run diagnose $a seven/train.tsv --traits all.traits.tsv --traits-only -q --json -
expect "the means alone make the held-out error smaller" awk '/"geometry_m"/ && !g { g = $2 + 0 }
    /"explained_m"/ && !e { e = $2 + 0 } END { exit !(e > 0 && e < 0.85 * g) }' "$scratch/out"
# a traits file of other arms: the arm's own fit wins, and that is said
awk -F '\t' -v OFS='\t' '$1 == "joint_compliance" && $2 == "joint_4" { $5 = 0; $6 = 1e-6; $10 = 1e-6 }
    $1 == "joint_compliance" && $2 == "joint_2" { $5 = 3e-4; $6 = 1e-6; $10 = 1e-6 } { print }' \
    all.traits.tsv >wrong.traits.tsv
answer "contradict this arm's data" diagnose $a seven/train.tsv --traits wrong.traits.tsv

answer "Fleet: the elastic means of 3 arms are in the table" calibrate $a seven/train.tsv --traits all.traits.tsv -o with.tsv
expect "the table has them" grep -q "^joint_4	joint_compliance	" with.tsv
answer "Fleet: the data do not support the traits of 3 arms" calibrate $a seven/train.tsv --traits wrong.traits.tsv -o own.tsv
expect "and has none" sh -c '! grep -q joint_compliance own.tsv'
awk -F '\t' -v OFS='\t' '$1 == "joint_compliance" { $5 *= 2 } { print }' all.traits.tsv >soft.traits.tsv
answer "half of the elastic means of 3 arms is in the table" calibrate $a seven/train.tsv --traits soft.traits.tsv
"$MUKCA" evaluate -q $a seven/train.tsv --offsets with.tsv -o scores.tsv
"$MUKCA" evaluate -q $a seven/train.tsv --offsets own.tsv -o own_scores.tsv
expect "the corrected arm fits its raw angles better" sh -c 'awk -F "\t" "FNR > 1 { s[FILENAME] += \$5 }
    END { exit !(s[\"scores.tsv\"] > 0 && s[\"scores.tsv\"] < s[\"own_scores.tsv\"]) }" scores.tsv own_scores.tsv'

# strong ripple of one joint is no ripple of another
mkdir ripple
for arm in 00 01 02 03 04 05 06 07 08 09 10 11; do
    "$MUKCA" simulate -q $a --seed 1$arm --perturb 1,2 --noise 1e-4 --placements 3 --rows 10 --effect joint_compliance:joint_4=5e-5 \
        --effect gear_harmonic:joint_2@60=1e-3 -o ripple/$arm.tsv &&
        "$MUKCA" diagnose -q $a ripple/$arm.tsv --arm $arm --summary ripple/$arm.json
done
answer "transmission ripple at joint_2, 60 per turn" fleet ripple/*.json
expect "and at no other joint" sh -c "test \$(grep -c 'per turn' '$scratch/out') -eq 1"

run capture $a --lcm-url "file://$root/data/demo/guided.lcmlog" --trigger --traits all.traits.tsv -o live.tsv
expect "capture names the command that uses it" grep -q "^Next    mukca calibrate .* --traits all.traits.tsv" "$scratch/out"
# a fleet may share nothing
awk -F '\t' '/^#/ || $1 == "effect"' all.traits.tsv >empty.traits.tsv
answer "Fleet: the traits of 3 arms contain no elastic coefficient" calibrate $a seven/train.tsv --traits empty.traits.tsv
answer "^Fleet   the traits table of 3 arms is empty" diagnose $a seven/train.tsv --traits empty.traits.tsv

refuse 3 "missing.json: cannot read: No such file" fleet missing.json
refuse 3 "7.json: the only arm ('seven'); a fleet needs two arms" fleet 7.json -o new.tsv
refuse 3 "the same recording as" fleet 7.json 8.json 7.json -o new.tsv
head -c 5000 8.json >cut.json
refuse 3 "cut.json:1: the file is cut off" fleet 7.json cut.json
: >empty.json
refuse 3 "empty.json: the file is empty" fleet 7.json empty.json
wrong_summary() { # SED PATTERN: a summary that is refused for what is wrong with it
    sed "$1" 8.json >bad.json
    refuse 3 "bad.json$2" fleet 7.json bad.json
}
wrong_summary 's/summary\/1/summary\/2/' ":1: of another version than mukca.summary/1"
refuse 3 "all.traits.tsv:1: a traits table, which cannot be pooled again; give the summaries" fleet 7.json all.traits.tsv
echo '{"schema": "other"}' >other.json
refuse 3 "other.json:1: not a summary" fleet 7.json other.json
"$MUKCA" fleet 7.json 8.json -q --json fleet.json
refuse 3 "fleet.json:1: no summary; give the files of diagnose --summary" fleet 7.json fleet.json
wrong_summary 's/"vector":\[[^,]*/"vector":[1e999/' ":1: no summary; give the files of diagnose --summary or fleet --partial"
wrong_summary 's/"vector":\[[^,]*/"vector":[null/' ':1: `vector` is missing or damaged'
wrong_summary 's/"joint_3"/"elbow"/' ": of another model than 7.json: the names of the joints differ"
wrong_summary 's/"ripple":\["...../"ripple":["*****/' ':1: `ripple` is missing or damaged'
refuse 2 "is an input of this command" fleet 7.json 8.json -o 7.json --force
refuse 2 "partial needs --output" fleet --partial 7.json 8.json
refuse 2 "traits-only needs --traits" diagnose $a seven/train.tsv --traits-only
refuse 2 "arm needs --summary" diagnose $a seven/train.tsv --arm x
refuse 2 "1 to 63 bytes" diagnose $a seven/train.tsv --arm "$(printf 'a\tb')" --summary new2.json
refuse 2 "cannot both go to" diagnose $a seven/train.tsv --json x.json --summary x.json
refuse 2 "do not lie in one folder" diagnose $a seven/train.tsv "$demo/test.tsv" --summary new2.json
for place in arms/eleven/front arms/twelve/front; do # their folders name an arm each
    mkdir -p $place
    for hole in 0 1; do printf '0,0,0,0,0,0,0\n0,0,0,1,0,1,1\n' >$place/hole_$hole.csv; done
done
refuse 2 "do not lie in one folder" diagnose $a arms/eleven arms/twelve --summary new2.json
sed 's/<mass value="[^"]*"/<mass value="2.5"/' "$demo/arm.urdf" >masses.urdf
refuse 3 "traits of another model: the link masses differ" diagnose --urdf masses.urdf seven/train.tsv --traits all.traits.tsv
refuse 3 "8.json:1: two columns are called" diagnose $a seven/train.tsv --traits 8.json
wrong() { # SED PATTERN: a traits table that is refused for what is wrong with it
    sed "$1" all.traits.tsv >bad.traits.tsv
    refuse 3 "$2" diagnose $a seven/train.tsv --traits bad.traits.tsv
}
wrong 's/^joint_compliance/backlash/' "bad.traits.tsv:[0-9]*: column 'effect': 'backlash' is no trait"
wrong 's/	joint_4	/	joint_9	/' "'joint_9' is no joint of the arm"
wrong '/^joint_compliance	joint_4/ { p; }' "the same trait twice"
for arms in many 3x 2.5 -3 99999999999 ''; do
    wrong "s/^# arms:.*/# arms: $arms/" 'bad.traits.tsv:8: `# arms:` is no number; make the table again'
done
wrong '2s/^/\n/; s/^# arms:.*/# arms: many/' 'bad.traits.tsv:9: `# arms:` is no number'
wrong '/^base_compliance/ s/rad\/(N\*m)	[^	]*/rad\/(N*m)	nan/' "bad.traits.tsv:[0-9]*: column 'mean': 'nan' is not a finite number"
head -c -5 all.traits.tsv >bad.traits.tsv
refuse 3 "bad.traits.tsv:[0-9]*: the file is cut off; make it again" diagnose $a seven/train.tsv --traits bad.traits.tsv
awk '/^#/ || /^placement/ || ($1 == "front" && row[$2]++ < 2)' seven/train.tsv >few.tsv
refuse 5 "no summary to write: too few" diagnose $a few.tsv --arm x --summary new2.json
