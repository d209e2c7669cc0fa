# data/traits: read with the masses of data/inertials for an arm of that geometry and any tool.
{
    echo '<robot name="any"><link name="panda_link0"/>'
    previous=0
    while read -r joint roll x y z; do
        echo "<link name=\"panda_link$joint\"/><joint name=\"panda_joint$joint\" type=\"revolute\">
<parent link=\"panda_link$previous\"/><child link=\"panda_link$joint\"/><axis xyz=\"0 0 1\"/>
<origin xyz=\"$x $y $z\" rpy=\"$roll 0 0\"/><limit lower=\"-2.8\" upper=\"2.8\" effort=\"87\" velocity=\"2\"/></joint>"
        previous=$joint
    done <<'JOINTS'
1 0 0 0 0.333
2 -1.5707963267948966 0 0 0
3 1.5707963267948966 0 -0.316 0
4 1.5707963267948966 0.0825 0 0
5 -1.5707963267948966 -0.0825 0.384 0
6 1.5707963267948966 0 0 0
7 1.5707963267948966 0.088 0 0
JOINTS
    echo '<link name="probe"/><joint name="mount" type="fixed"><parent link="panda_link7"/><child link="probe"/>
<origin xyz="0.03 0.01 0.2"/></joint></robot>'
} >panda.urdf
p="--urdf panda.urdf --inertials $root/data/inertials/panda.tsv"
"$MUKCA" simulate -q $p --placements 2 --rows 15 --seed 4 --perturb 1,2 --noise 1e-4 \
    --effect link_bending:panda_joint2=4.5e-5 --effect link_bending:panda_joint3=3.5e-5 \
    --effect joint_compliance:panda_joint3=2.5e-5 -o session.tsv
for file in "$root"/data/traits/*.tsv; do
    expect "$(basename "$file") names source, licence and the command that made it" sh -c \
        'grep -q "^# source: .*MIT" "$0" && grep -q "^# made by: tools/fleet/make_traits" "$0"' "$file"
done
answer "Fleet: the elastic means of 4 arms are in the table" calibrate $p session.tsv --traits "$root/data/traits/panda.tsv"
answer "^Fleet   the traits of 4 arms are the prior" diagnose $p session.tsv --traits "$root/data/traits/panda.tsv"
sed 's/0.384/0.394/' panda.urdf >longer.urdf
refuse 3 "traits of another model: the nominal geometry differs" \
    calibrate --urdf longer.urdf --inertials "$root/data/inertials/panda.tsv" session.tsv --traits "$root/data/traits/panda.tsv"
