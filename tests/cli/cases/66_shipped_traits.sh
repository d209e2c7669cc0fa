# data/traits: read with the masses of data/inertials for an arm of that geometry and any tool.
{
    sed '/<inertial>/,/<\/inertial>/d; /panda_hand_joint/,$d' "$root/data/panda/arm.urdf"
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
