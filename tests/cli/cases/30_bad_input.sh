# Bad input: one clear line, the right exit code, nothing half-written.
. "$here/fixture.sh"
a='--urdf arm.urdf'

# good data are taken, so that what follows is refused for its own fault
run calibrate $a good -o offsets.tsv
expect "good data are taken" test -s offsets.tsv
sed -i -e 's/^# accepted: no.*/# accepted: yes/' -e '/^# digest/d' offsets.tsv # for all that their angles mean nothing

# files that are not there or cannot be read
refuse 3 'nix.urdf: cannot read: No such file' calibrate --urdf nix.urdf good -o new.tsv
refuse 3 'nowhere: cannot read: No such file' calibrate $a nowhere -o new.tsv
refuse 3 'good: cannot read: Is a directory' fk $a good
if [ "$(id -u)" -ne 0 ]; then # root may read everything
    cp arm.urdf secret.urdf && chmod 000 secret.urdf
    refuse 3 'secret.urdf: cannot read: Permission denied' calibrate --urdf secret.urdf good
    chmod 600 secret.urdf
fi

# URDFs
edit() { sed "$1" arm.urdf >bad.urdf; }
wrong_urdf() { # SED PATTERN: refused for what is wrong with it
    edit "$1"
    refuse 3 "$2" calibrate --urdf bad.urdf good -o new.tsv
}
wrong_urdf 's/<\/robot>//' 'bad.urdf:[0-9]*: broken XML'
awk 'BEGIN { printf "<robot name=\"x\">"; for (i = 0; i < 100; i++) printf "<a>"
    for (i = 0; i < 100; i++) printf "</a>"; print "</robot>" }' >bad.urdf
refuse 3 'bad.urdf:1: elements nested more than' calibrate --urdf bad.urdf good -o new.tsv
head -c 40000000 /dev/zero | tr '\0' ' ' >bad.urdf
refuse 3 'bad.urdf: is larger than' calibrate --urdf bad.urdf good -o new.tsv
wrong_urdf 's/0 0 0.25/0 0 ${height}/' 'bad.urdf:9: joint .*three numbers each (a xacro file: expand it first)'
wrong_urdf 's/<robot name="small">/<robot name="small" xmlns:xacro="http:\/\/x"><xacro:arg name="y"\/>/' 'bad.urdf:2: contains xacro macros; expand them first'
wrong_urdf 's/name="j2" type="revolute"/name="j2" type="floating"/' "bad.urdf:15: joint 'j2': planar and floating joints"
wrong_urdf 's/<child link="upper"/<child link="base"/' 'bad.urdf:'
wrong_urdf 's/<\/robot>/<link name="x"\/><link name="y"\/><joint name="m" type="fixed"><parent link="x"\/><child link="y"\/><\/joint><joint name="n" type="fixed"><parent link="y"\/><child link="x"\/><\/joint><\/robot>/' "joint 'n': link 'x' is part of a cycle"
wrong_urdf 's/<axis xyz="0 0 1"/<axis xyz="0 0 0"/' "bad.urdf:9: joint 'j1': its axis is 0 0 0"
wrong_urdf 's/<axis xyz="0 0 1"\/>/<axis xyz="0 0 1"\/><mimic joint="j2"\/>/' "bad.urdf:9: joint 'j1': it mimics 'j2'"
refuse 3 "has no link 'bal' (--tip); did you mean ball?" calibrate $a --tip bal good
refuse 3 "has no link 'wrist' (--base); links: ball, base, fore, hand, upper" calibrate $a --base wrist good
refuse 3 "link 'upper' (--tip) is not below 'fore' (--base); the ends below it are ball" calibrate $a --tip upper --base fore good
# a --base that is a leaf beside the arm, as 'base' of a UR's URDF
sed 's/<link name="base"\/>/<link name="base_link"\/><link name="base"\/>/; s/link="base"/link="base_link"/
    s/<\/robot>/<joint name="b" type="fixed"><parent link="base_link"\/><child link="base"\/><\/joint><\/robot>/' arm.urdf >bad.urdf
refuse 3 "link 'ball' (--tip) is not below 'base' (--base), and no link is; for this tip give --base base_link\$" \
    calibrate --urdf bad.urdf --tip ball --base base good
for name in placement x_m '#1' 'a,b' ' a' 'a\&#9;b' ''; do
    edit "s/name=\"j1\"/name=\"$name\"/"
    refuse 3 'bad.urdf:9: joint .*: its name cannot be the name of a column' calibrate --urdf bad.urdf good
done
wrong_urdf 's/xyz="0 0 0.25"/xyz="0 0 1e300"/' "joint 'j1': its origin is farther away than any arm reaches"
mass() { edit "s/<link name=\"upper\"\/>/<link name=\"upper\"><inertial><origin xyz=\"$2 0 0\"\/><mass value=\"$1\"\/><\/inertial><\/link>/"; }
for heavy in '1e308 0' '1 1e300'; do
    mass $heavy
    refuse 3 "link 'upper': its mass or centre of mass is larger than any arm's" calibrate --urdf bad.urdf good
done
for wrong in 'nan 0' '1,5 0' '1 nan'; do
    mass $wrong
    accept 'bad.urdf: urdfdom skips what it cannot read, perhaps masses: .*' fk --urdf bad.urdf good/hole_0.csv
done
wrong_urdf 's/name="ball"/name="stub"/; s/link="ball"/link="stub"/; s/<\/robot>/<link name="left"\/><joint name="l" type="fixed"><parent link="hand"\/><child link="left"\/><\/joint><\/robot>/' 'has several ends; choose one with --tip: left, stub'

# session files
head_line() { printf 'placement\tsocket\tj1\tj2\tj3\n'; }
session() { sed "$1" session.tsv >bad.tsv; }
wrong_session() { # SED PATTERN: refused for what is wrong with it
    session "$1"
    refuse 3 "$2" calibrate $a bad.tsv -o new.tsv
}
wrong_session '1s/j3/axis_3_deg/' "no column for joint 'j3' (columns: placement, socket, j1, j2, axis_3_deg); name"
wrong_session '1s/j3/j3_deg/' "rename column 'j3_deg' with --columns 'j3_deg=j3', and give --units deg"
session '1s/placement/station/'
doubt "bad.tsv: no column 'placement'; all samples count as one placement" calibrate $a bad.tsv
session '1s/$/\tmood/; 2,$s/$/\tgood/'
doubt 'bad.tsv: 1 unknown column ignored: mood' calibrate $a bad.tsv
wrong_session '1s/j3/j2/' "bad.tsv:1: two columns are called 'j2'; rename one"
wrong_session '4s/\t[^\t]*$/\tfive/' "bad.tsv:4: column 'j3': 'five' is not a finite number"
wrong_session '4s/\t[^\t]*$/\t/' "bad.tsv:4: column 'j3': is empty"
printf '%s' "$(cat session.tsv)" | sed '$s/\t[^\t]*\t[^\t]*$//' >cut.tsv
refuse 3 'cut.tsv:13: 3 columns, but 5 in the header; the last line is cut off' calibrate $a cut.tsv
wrong_session '5s/\t[^\t]*$/\t57.3/' "bad.tsv:5: column 'j3': joint 'j3' is 57.3, more than two turns; angles are in rad"
wrong_session '2,$s/^p\t0/p\t1/' "placement 'p': only one socket; at least two"
head -n 3 session.tsv >bad.tsv
refuse 3 "socket '[01]': 1 row; at least 2 are needed" calibrate $a bad.tsv
head_line >bad.tsv
refuse 3 'bad.tsv: has a header but no rows' calibrate $a bad.tsv
tail -n +2 session.tsv >bad.tsv
refuse 3 "bad.tsv:1: no column for joint 'j1'; the first line must be a header of names" calibrate $a bad.tsv
tail -n +2 session.tsv | cut -f 3- >bad.tsv
refuse 3 'bad.tsv:1: starts with numbers; name the columns in the first line or by --columns' calibrate $a bad.tsv
: >bad.tsv
refuse 3 'bad.tsv: is empty' calibrate $a bad.tsv
head -c 5000 /dev/zero >bad.tsv
refuse 3 'bad.tsv:1: contains a zero byte' calibrate $a bad.tsv

LC_ALL=C sed '2,$s/^p/gr\xfcn/' session.tsv >bad.tsv
refuse 3 "bad.tsv:2: column 'placement': is not UTF-8" calibrate $a bad.tsv
LC_ALL=C sed '1s/?>/ encoding="ISO-8859-1"?>/; s/"j1"/"j\xfc"/' arm.urdf >bad.urdf
run calibrate --urdf bad.urdf good -o named.tsv --force
expect "a URDF in another encoding that it names" grep -q "^jü	x" named.tsv
LC_ALL=C sed 's/"j1"/"j\xfc"/' arm.urdf >bad.urdf
refuse 3 "bad.urdf:[0-9]*: broken XML: Input is not proper UTF-8" calibrate --urdf bad.urdf good
# --columns: renames apply to the names in the file, whatever their order; units are read or refused
sed '1s/j1/J/; 1s/j2/j1/; 1s/J/j2/' session.tsv >swapped.tsv
run evaluate $a session.tsv -o straight.tsv
for columns in j1=j2,j2=j1 j2=j1,j1=j2; do
    run evaluate $a swapped.tsv --columns $columns -o $columns.out
    expect "--columns $columns swaps" cmp straight.tsv $columns.out
done
refuse 3 "swapped.tsv:1: two columns are called 'j1'; rename one" evaluate $a swapped.tsv --columns j2=j1
refuse 3 "swapped.tsv:1: no column 'j1', which --columns renames" evaluate $a swapped.tsv --columns j1=j2,j1=j3,j2=j1
awk -F'\t' -v OFS='\t' 'NR > 1 { $3 *= 57.29577951308232 } NR == 1 { $3 = "q [grad]" } { print }' session.tsv >units.tsv
refuse 3 "units.tsv:1: --columns: '\[grad\]' is no unit that is read; convert the column" \
    evaluate $a units.tsv --columns 'q [grad]=j1'
sed -i '1s/q \[grad\]/q/' units.tsv
refuse 3 "units.tsv:1: --columns: '(turns)' is no unit that is read" evaluate $a units.tsv --columns 'q=j1 (turns)'
run evaluate $a units.tsv --columns 'q=j1 [deg]' -o unit.out
expect "--columns states a unit" near 1e-6 8 straight.tsv unit.out
# options of pose logs
for option in --free-base --free-tool --inverse-poses "--rotation XYZ"; do
    refuse 2 "${option% XYZ} is for pose logs, and these are samples of sockets" calibrate $a session.tsv $option
    refuse 2 "${option% XYZ} is for pose logs" diagnose $a good $option
done
refuse 2 "inverse-poses is for pose logs" evaluate $a good --inverse-poses
# names with control characters are refused, those of files are shown without
escape=$(printf '\033]0;x\007')
wrong_session "2,\$s/^p/p$escape/" "bad.tsv:2: column 'placement': is not UTF-8, or has control characters"
wrong_session "2,\$s/^p\t/p\t$(printf '\302\233')/" "bad.tsv:2: column 'socket': is not UTF-8, or has control"
wrong_urdf 's/name="j1"/name="j\&#x9b;1"/' "bad.urdf: the name 'j??1' has control characters; rename it in the URDF"
wrong_urdf 's/name="ball"/name="\&#x9b;ball"/; s/link="ball"/link="\&#x9b;ball"/' "bad.urdf: the name '??ball' has control"
wrong_urdf 's/robot name="/robot name="\&#x9b;/' "bad.urdf: the name '??small' has control"
odd=$(printf 'a\033]0;x\007b\302\233c\342\200\256d')
cp -r good "$odd" && cut -f 2- session.tsv >"$odd.tsv"
for command in "evaluate -v" "diagnose -v" "calibrate -v -o $odd.out" "report -o $odd.html"; do
    run $command $a "$odd" "$odd.tsv"
    for file in "$odd.html" "$odd.out"; do [ ! -f "$file" ] || cat "$file" >>"$scratch/out"; done
    expect "$command shows no control characters" sh -c \
        '! LC_ALL=C grep -qP "[\x01-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xe2\x80\xae" "$@"' sh "$scratch/out" "$scratch/err"
done
rm -r "$odd" "$odd".*
# a file's name is what it is, but must not cost a result, nor be cut within a letter
latin=$(printf 'gr\374n.tsv')
long=$(printf 'é%.0s' $(seq 40)).tsv
for odd in "$latin" "$(printf '\200\201.tsv')" "x$long" "$long"; do
    cut -f 2- session.tsv >"$odd"
    run evaluate $a -q "$odd" --json named.json --force
    expect "a file's name, whatever it is, keeps its result" grep -q '"rows": 12' named.json
    expect "and the placement has a name" grep -q '"placement": "[^"]' named.json
    run report $a -q "$odd" -o named.html --force
    expect "and the report is UTF-8" iconv -f UTF-8 -t UTF-16 named.html
    rm "$odd"
done
awk '{ printf "%s\r", $0 }' session.tsv >bad.tsv
refuse 3 'bad.tsv:1: lines end in carriage returns; save it with line feeds' calibrate $a bad.tsv
head -n 3 session.tsv >bad.tsv
refuse 3 "bad.tsv: placement 'p', socket '[01]': 1 row" calibrate $a good --test bad.tsv
awk '{ print $3 "\t" $4 "\t" $5 "\t" (NR == 1 ? "x_m\ty_m\tz_m" : "0.5\t0\t0.3") }' session.tsv >bad.tsv
refuse 3 'all positions are the same while the joints move' recalibrate $a bad.tsv
"$MUKCA" simulate $a --poses 40 --perturb 0.1,0.1 | grep -v '^#' >seen.tsv
awk -F'\t' -v OFS='\t' 'NR > 1 { $(NF - 6) = $(NF - 5) = $(NF - 4) = "nan" } { print }' seen.tsv >blind.tsv
for command in calibrate evaluate diagnose report; do
    refuse 3 'blind.tsv: no row has a measured position' $command $a blind.tsv
done
# as many targets out of sight as rows, in turn: all others were seen
awk -F'\t' -v OFS='\t' '{ x = $(NF - 6); y = $(NF - 5); z = $(NF - 4); NF -= 7
    if (NR == 1) print $0, "x_m.A\ty_m.A\tz_m.A\tx_m.B\ty_m.B\tz_m.B"
    else if (NR % 2) print $0, x, y, z, "nan\tnan\tnan"; else print $0, "nan\tnan\tnan", x, y, z }' seen.tsv >turns.tsv
accept 'turns.tsv: 40 of 80 measurements ignored: no measured position' evaluate $a turns.tsv
long=$(printf 'é%.0s' $(seq 40))
awk -v OFS='\t' -v name="$long" '{ print $0, NR == 1 ? "target" : name NR % 2 }' seen.tsv >bad.tsv
refuse 3 "bad.tsv:2: column 'target': 'é*[?]*...' is longer than 63" recalibrate $a bad.tsv
expect "a name that is cut stays UTF-8" iconv -f UTF-8 -t UTF-16 "$scratch/err"
whole=p$(printf 'é%.0s' $(seq 30))
"$MUKCA" simulate $a --seed 5 --rows 3 --placements 2 | sed "s/^p1/$whole/" >bad.tsv
run evaluate $a bad.tsv -o whole.tsv --json whole.json --force
expect "long names of placements are whole in the table" grep -q "	$whole	" whole.tsv
expect "and in JSON" grep -q "\"placement\": *\"$whole\"" whole.json
awk -v OFS='\t' '{ print $0, NR == 1 ? "payload_kg" : NR == 4 ? -1 : 2 }' session.tsv >bad.tsv
refuse 3 "bad.tsv:4: column 'payload_kg': -1 is no mass in kg" diagnose $a bad.tsv
refuse 2 '--payload 1,2,3: give one mass in kg .*, those of --test last' evaluate $a good --test session.tsv --payload 1,2,3
expect "a mass for the data and one for the test" "$MUKCA" evaluate $a good --test session.tsv --payload 1,2
refuse 3 'a payload of 500 kg on an arm of .* kg; payload_kg and --payload are in kg' evaluate --urdf "$root/data/demo/arm.urdf" "$root/data/demo/test.tsv" --payload 500

# folders
mkdir bad
rows 1 5 >bad/hole_0.csv
refuse 3 'bad: no hole_1.csv' calibrate $a bad -o new.tsv
: >bad/hole_1.csv
refuse 3 "placement 'bad', socket '1': 0 rows; at least 2 are needed" calibrate $a bad
printf '0,0,0\n0,0\n' >bad/hole_1.csv
refuse 3 'bad/hole_1.csv:2: 2 columns, but 3 in the first row' calibrate $a bad
printf '0,0\n0,0\n' >bad/hole_1.csv
refuse 3 'bad/hole_1.csv:1: 2 columns, but the chain has 3 joints' calibrate $a bad
printf '0,0,0\n10,90,45\n' >bad/hole_1.csv
refuse 3 "bad/hole_1.csv:2: column 2: joint 'j2' is 90, more than two turns" calibrate $a bad

rows 1 4 | tee bad/hole_0.csv bad/hole_1.csv >bad/hole_3.csv
refuse 3 'bad: no hole_2.csv; .* and so on' calibrate $a bad
rm bad/hole_3.csv

# fewer rows than parameters
rows 1 2 >bad/hole_0.csv
rows 9 2 >bad/hole_1.csv
doubt 'numbers for .* parameters' calibrate $a bad

# distances
refuse 2 'distance 5: must be a number above 0, at most 2, in m' calibrate $a --distance 5 good
run simulate $a --seed 1 --rows 20 --placements 2 -o sim.tsv
doubt 'sockets differs by 30.0' calibrate $a --distance 0.02 sim.tsv
doubt 'no fixed joint ends the chain at hand' calibrate $a --tip hand good
doubt 'nominal model is [0-9]* mm off; check the units' calibrate $a --distance 0.5 --tip hand good
doubt '^Use     no: the samples do not fit this arm' calibrate $a --distance 0.5 good
refuse 3 'every row is also training data' calibrate $a good --test good
run simulate $a --seed 3 --rows 4 --placements 2 -o copied.tsv
awk '/^p[0-9]/ { print } { print }' copied.tsv >twice.tsv
refuse 3 'every row is also training data' calibrate $a copied.tsv --test twice.tsv
run simulate $a --seed 4 --rows 4 --placements 2 -o other.tsv
{ cat other.tsv; grep '^p[0-9]' copied.tsv; } >mixed.tsv
doubt 'mixed.tsv: 16 of 32 rows repeat rows of copied.tsv to the last digit; not used for testing' calibrate $a copied.tsv --test mixed.tsv
# both labels in one socket
run simulate $a --seed 6 --rows 20 --placements 2 --noise 1e-4 -o two_holes.tsv
run simulate $a --seed 7 --rows 20 --placements 2 --noise 1e-4 -o first.tsv
awk 'BEGIN { FS = OFS = "\t" } /^p[0-9]/ { if ($2 == 1) next; $2 = n++ % 2 } { print }' first.tsv >one_hole.tsv
{ cat two_holes.tsv; sed -n 's/^p1/p9/p' one_hole.tsv; } >some.tsv
doubt "placement 'p9': sockets '0' and '1' coincide within .* mm; .*; their distance is not used" calibrate $a some.tsv
refuse 3 "coincide within .* mm; both labels may have been recorded in one socket; record them again" diagnose $a one_hole.tsv
refuse 3 'nix.tsv: cannot read' calibrate $a --distances nix.tsv good

# offsets tables
sed 's/\(urdf_sha256: \)./\1x/' offsets.tsv >other.tsv
refuse 3 'session.tsv: no offsets table' export $a --offsets session.tsv -o new.urdf
refuse 3 'other.tsv: was made for another URDF.*--accept-other-arm' fk $a --offsets other.tsv --force good/hole_0.csv -o new.tsv
accept 'made for another URDF' fk $a --offsets other.tsv --accept-other-arm good/hole_0.csv

row() { # row SED: the last row of the table, with one thing wrong, behind it
    printf 'j2\tjoint_scale\trad/rad\t0\t1e-3\t1e-3\t1e-5\t1\t-\n' | sed "$1" | cat offsets.tsv - >bad.tsv
}
wrong_row() { # SED PATTERN
    row "$1"
    refuse 3 "$2" fk $a --offsets bad.tsv good/hole_0.csv
}
row ''
expect "an effect's row is taken" "$MUKCA" fk $a --offsets bad.tsv good/hole_0.csv
row 's/1e-3/1e300/g'
refuse 3 "bad.tsv:[0-9]*: column 'calibrated': is larger than any arm's" evaluate $a --offsets bad.tsv good
wrong_row 's/j2\tjoint_scale/j1\tjoint_coupling/; s/-$/neighbour=-1/' "does not fit the effect at this joint"
printf 'link\tmass_kg\tcom_x_m\tcom_y_m\tcom_z_m\nfore\t1\t1e308\t0\t0\n' >inertials.tsv
refuse 3 "inertials.tsv:2: column 'com_x_m': 1e+308 is larger than any arm's" fk $a --inertials inertials.tsv good/hole_0.csv
for g in 0,0,1e200 0,0,-1 0,-981,0 0,0,-9806.65; do
    refuse 2 'gravity: .* m/s^2 is not that of the earth; give m/s^2' fk $a --gravity $g good/hole_0.csv
done
refuse 2 "is larger than any arm's" simulate $a --effect joint_scale:j2=1e300

# outputs
refuse 3 'offsets.tsv: exists already; --force overwrites it' calibrate $a good -o offsets.tsv
refuse 6 '/dev/full: cannot write: No space left on device' calibrate $a good -o /dev/full
refuse 6 '/dev/full: cannot write: No space left on device' calibrate $a good --json /dev/full
refuse 6 '/dev/full: cannot write: No space left on device' export $a -o /dev/full
refuse 3 '/proc/new.tsv: cannot write' calibrate $a good -o /proc/new.tsv
refuse 3 '/proc/new.json: cannot write' calibrate $a good --json /proc/new.json
refuse 3 'nowhere/new.tsv: cannot write: No such file.*; make its folder first' calibrate $a good -o nowhere/new.tsv
refuse 3 'good: is a folder' calibrate $a good -o good
refuse 2 'cannot both go to -' calibrate $a good -o - --json -

# the environment's locale and comma decimals change nothing
"$MUKCA" fk $a --pose good/hole_0.csv >plain.tsv
for locale in de_DE.UTF-8 de_DE tr_TR.UTF-8 xx_YY; do
    LC_ALL=$locale LC_NUMERIC=$locale LANG=$locale "$MUKCA" fk $a --pose good/hole_0.csv >foreign.tsv
    expect "$locale changes nothing" equal plain.tsv foreign.tsv
done
expect "no source sets the locale" sh -c "! grep -rn setlocale '$root/src'"

# a stream that had stopped
awk 'NR > 1 && !row { row = $3 "\t" $4 "\t" $5 } NR == 1 { print; next }
    { print $1 "\t" $2 "\t" row }' session.tsv >dead.tsv
refuse 5 "socket '1': all 6 samples have the same joint angles" calibrate $a good --test dead.tsv -o new.tsv
for command in calibrate evaluate "plan --rows 2"; do
    refuse 5 "socket '1': all 6 samples have the same joint angles" $command $a dead.tsv -o new.tsv
done
# nor is there an error to test where a socket has one posture
awk 'BEGIN { OFS = "\t" } NR > 1 { $5 += NR * 1e-5 } 1' dead.tsv >one.tsv
refuse 5 "all 6 samples have the same joint angles; record other postures" evaluate $a --max-mae 1e-3 one.tsv
# data of another arm
awk 'BEGIN { OFS = "\t" } NR > 1 { $3 = $4; $4 = 0.3 } 1' session.tsv >foreign.tsv
refuse 1 "foreign.tsv: the predictions of a socket scatter by [0-9]* mm per axis" plan --rows 2 $a foreign.tsv
# a number that was cut is a number
printf '%s' "$(cat session.tsv)" >cut.tsv
accept "cut.tsv:13: the last line has no line end" evaluate $a cut.tsv
# a unit of another quantity
wrong_session '1s/j3/j3 [mm]/' "bad.tsv:1: column 'j3' has the unit of something else"

# limits of the URDF: one note for a joint, however many files
sed 's/upper="3"/upper="-0.5"/' arm.urdf >narrow.urdf
run evaluate --urdf narrow.urdf good
expect "a note of exceeded limits for each joint" test "$(grep -c 'beyond its limits' "$scratch/err")" = 3
