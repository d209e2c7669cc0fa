# Factory files: read as the model to start from, kept apart from the URDF's, written back.
. "$here/fixture.sh"
. "$here/ur5e.sh"
ur='--urdf ur5e.urdf --kinematics factory.yaml'
awk 'BEGIN { for (i = 1; i <= 12; i++) for (j = 1; j <= 6; j++)
    printf "%.6f%s", 2.5 * sin(1.7 * i * j + j), j < 6 ? "," : "\n" }' >rows.csv

# the factory file takes the place of the URDF's origins
"$MUKCA" fk --urdf ur5e.urdf rows.csv >nominal.tsv
"$MUKCA" fk $ur rows.csv >factory.tsv
expect "a factory file changes the arm" sh -c '! cmp -s nominal.tsv factory.tsv'
"$MUKCA" export $ur -o factory.urdf
"$MUKCA" fk --urdf factory.urdf rows.csv >as_urdf.tsv
expect "a factory file can be exported as a URDF" equal factory.tsv as_urdf.tsv

# arms of one model have factory files of their own: their fleet is that of the URDF
sed 's/z: 0.1/z: 0.1001/' factory.yaml >sister.yaml
for arm in factory sister; do
    "$MUKCA" simulate -q --urdf ur5e.urdf --kinematics $arm.yaml --placements 3 --rows 12 --seed 3 --noise 5e-5 \
        --perturb 0.1,0.2 -o $arm.session.tsv
    "$MUKCA" diagnose -q --urdf ur5e.urdf --kinematics $arm.yaml $arm.session.tsv --arm $arm --summary $arm.json
done
expect "arms with factory files of their own are a fleet" "$MUKCA" fleet -q factory.json sister.json -o ur.traits.tsv
answer '^Fleet' diagnose $ur factory.session.tsv --traits ur.traits.tsv

# calibrated from there, evaluated next to the others, and written back
"$MUKCA" simulate -q $ur --placements 3 --rows 15 --seed 3 --noise 5e-5 --perturb 0.1,0.2 -o session.tsv --force
"$MUKCA" calibrate -q $ur session.tsv -o table.tsv
answer 'factory model 0' calibrate $ur session.tsv
answer 'nominal      factory   calibrated' evaluate $ur --offsets table.tsv session.tsv -o scores.tsv
expect "evaluate has the factory's errors: calibrated < factory < nominal" awk -F '\t' '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i }
    NR > 1 { if (!($at["mae_m"] < $at["mae_factory_m"] && $at["mae_factory_m"] < $at["mae_nominal_m"])) exit 1 }
    END { if (NR != 4) exit 1 }' scores.tsv
for tip in '' '--tip wrist_3_link'; do
    "$MUKCA" export -q $ur --offsets table.tsv $tip -f kinematics -o own.yaml --force
    "$MUKCA" fk --urdf ur5e.urdf --kinematics own.yaml --tip wrist_3_link rows.csv >back.tsv
    "$MUKCA" fk -q $ur --offsets table.tsv --tip wrist_3_link rows.csv >wrist.tsv
    expect "export -f kinematics $tip, read back, is the calibrated arm to 1e-9 m" near 1e-9 3 wrist.tsv back.tsv
done
expect "UR's hash stays that of the robot" grep -q '^  hash: calib_12345678901234567890$' own.yaml
accept "calibrated origin of 'ball' is not exported" export $ur --offsets table.tsv -f kinematics
refuse 2 'this format needs --kinematics FILE' export --urdf ur5e.urdf -f kinematics
refuse 3 'was made with a factory file (--kinematics)' evaluate --urdf ur5e.urdf --offsets table.tsv session.tsv
refuse 3 'or a file that was edited or made anew' \
    evaluate --urdf ur5e.urdf --kinematics own.yaml --offsets table.tsv session.tsv
refuse 2 'factory.yaml is an input of this command' calibrate $ur session.tsv -o factory.yaml --force

# nominal, factory and calibrated compared
answer 'base and tool aligned' compare --urdf ur5e.urdf ur5e.urdf factory.yaml
answer 'base and tool aligned' compare --urdf ur5e.urdf factory.yaml table.tsv
refuse 2 'factory.yaml: --urdf FILE is needed' compare ur5e.urdf factory.yaml

# UR's hash marks the robot: of another one, or of a file that was edited
sed 's/calib_12345678901234567890/calib_987/' factory.yaml >other_robot.yaml
sed 's/x: -0.42542/x: -0.42642/' factory.yaml >edited.yaml
expect "a table holds the hash of its factory file" grep -qx '# kinematics_hash: calib_12345678901234567890' table.tsv
refuse 3 'table.tsv: is of the robot calib_12345678901234567890, the factory file of calib_987: another' \
    fk --urdf ur5e.urdf --kinematics other_robot.yaml --offsets table.tsv rows.csv
accept 'table.tsv: made for another factory file' \
    fk --urdf ur5e.urdf --kinematics other_robot.yaml --offsets table.tsv rows.csv --accept-other-arm
refuse 3 'is of the robot calib_12345678901234567890, the factory file of calib_12345678901234567890' \
    export --urdf ur5e.urdf --kinematics edited.yaml --offsets table.tsv -f yaml
accept 'hash calib_12345678901234567890 marks the robot, for its driver; the origins are fitted' \
    export $ur --offsets table.tsv -f kinematics
answer '^kinematics:' export $ur -f kinematics
expect "a factory file written back as it was needs no word about its hash" sh -c "! grep -q 'the robot' '$scratch/err' '$scratch/out'"
refuse 2 '--kinematics: give the file as A or as B' compare $ur ur5e.urdf table.tsv

# Franka's and UFACTORY's layouts
sed -e '/^kinematics/d' -e '/hash/d' -e 's/^    /      /' -e 's/^  \([a-z_0-9]*\):$/\1:\n  kinematic:/' \
    -e 's/^      /    /' factory.yaml >franka.yaml
"$MUKCA" fk --urdf ur5e.urdf --kinematics franka.yaml rows.csv >other.tsv
expect "Franka's layout is read" cmp factory.tsv other.tsv
"$MUKCA" export -q --urdf ur5e.urdf --kinematics franka.yaml -f kinematics -o written.yaml
"$MUKCA" fk --urdf ur5e.urdf --kinematics written.yaml rows.csv >other.tsv
expect "Franka's layout is written" sh -c 'cmp factory.tsv other.tsv && grep -q kinematic: written.yaml'
sed 's/j\([123]\)"/joint\1"/' arm.urdf >ufactory.urdf
{
    echo kinematics:
    printf '  joint%d:\n    x: %s\n    y: 0\n    z: %s\n    roll: 0\n    pitch: 0\n    yaw: 0\n' 1 0 0.25 2 0 0 3 0.5 0
} >xarm.yaml
"$MUKCA" export --urdf ufactory.urdf --kinematics xarm.yaml -f kinematics -o ufactory.yaml
rows 1 12 >twelve.csv
"$MUKCA" fk --urdf ufactory.urdf twelve.csv >arm.tsv
"$MUKCA" fk --urdf ufactory.urdf --kinematics ufactory.yaml twelve.csv >other.tsv
expect "UFACTORY's layout is written" grep -q "^  joint2:" ufactory.yaml
expect "UFACTORY's layout, written and read, is the same arm" equal arm.tsv other.tsv

# bad files: one line each
bad() { sed "$1" factory.yaml >bad.yaml; }
f='fk --urdf ur5e.urdf --kinematics bad.yaml rows.csv'
wrong() { # SED PATTERN: refused for what is wrong with it
    bad "$1"
    refuse 3 "$2" $f
}
wrong '/pitch: 0.0021/d' "bad.yaml:16: 'forearm' has no pitch"
wrong 's/z: 0.1338.*/z: o.13/' "bad.yaml:26: no number: 'o.13'"
wrong 's/z: 0.1338.*/z: 1e9/' 'bad.yaml:26: out of range (lengths are in m, angles in rad)'
wrong 's/roll: 1.5693801556761988/roll: 89.9/' 'bad.yaml:34: out of range'
wrong 's/    pitch: 0.0021/    tilt: 0.0021/' "bad.yaml:21: expected x, y, z, roll, pitch, yaw of a joint, not 'tilt'"
wrong 's/wrist_2:/wrist_9:/' "bad.yaml: no entry for joint 'wrist_2_joint' (child link 'wrist_2_link'); entries bear the name of the joint or of its child link: is it of this arm?"
wrong 's/wrist_2:/wrist_1:/' "bad.yaml:30: a second entry 'wrist_1'"
wrong 's/z: 0.1338.*/z: [1, 2]/' 'bad.yaml:26: expected NAME: NUMBER, not a list or an alias'
wrong 's/z: 0.1338.*/z: !degrees 3/' 'bad.yaml:26: tags are not read'
wrong 's/z: 0.1338.*/z: {/' 'bad.yaml:[0-9]*: '
wrong 's/^kinematics:/kinematics: {{{{{/' 'bad.yaml:[0-9]*: '
printf 'kinematics: 3\n' >bad.yaml
refuse 3 "bad.yaml:1: expected x, y, z, roll, pitch, yaw of a joint, not 'kinematics'" $f
printf 'no yaml\n' >bad.yaml
refuse 3 'bad.yaml:1: expected `kinematics:` or names of joints' $f
printf '# nothing\n' >bad.yaml
refuse 3 'bad.yaml: no joint; expected x, y, z' $f
bad 's/z: 0.1338.*/z: 0.17/'
accept "joint 'wrist_1_joint' is 37 mm and 0.00 rad from the URDF; is it of this arm?" $f
