# Simulated recordings.
cp "$root/data/demo/arm.urdf" arm.urdf
simulate() { "$MUKCA" simulate --urdf arm.urdf "$@"; }
run simulate --urdf arm.urdf --placements 2 --rows 5 --seed 1 --perturb 1,2 --noise 1e-4 \
    --effect gear_harmonic:joint_4@160=5e-4
expect "the example of the help records 20 rows" test "$(grep -c '^p[12]' "$scratch/out")" -eq 20
cp "$scratch/out" first.tsv
run simulate --urdf arm.urdf --placements 2 --rows 5 --seed 1 --perturb 1,2 --noise 1e-4 \
    --effect gear_harmonic:joint_4@160=5e-4
expect "the same seed gives the same bytes" cmp first.tsv "$scratch/out"

# what --truth says is what was recorded, with one of everything that acts on the arm: seen through it, every socket
# is one point, and as far from the other one as was put in
simulate --seed 3 --rows 6 --perturb 1,2 --command --truth truth.tsv -o session.tsv --held-out 2 --test test.csv \
    --effect joint_compliance:joint_2=2e-5,link_bending:joint_3=1e-5,base_compliance=5e-6,backlash:joint_4@300=1e-3 \
    --effect approach_hysteresis:joint_1=1e-3,joint_scale:joint_2=1e-3,joint_coupling:joint_5@-1=1e-3,readback_lag=1e-3 \
    --effect encoder_eccentricity:joint_3=1e-3,gear_harmonic:joint_4@240=5e-4,axis_wobble:joint_2@turning2=1e-3 \
    --effect axis_wobble:joint_3@cone+3=1e-3,joint_drift:joint_1@300=1e-3,joint_drift:joint_6=2e-3 \
    --effect zero_jump:joint_3/p2=1e-3,ball_shift:p3=1e-3,socket_distance=1e-3
expect "evaluate reads the recording and its truth" "$MUKCA" evaluate --urdf arm.urdf \
    --offsets truth.tsv session.tsv --test test.csv --max-mae 1e-9 -o scores.tsv
expect "all effects are in the recording as the truth has them" awk -F '\t' '
    NR > 1 { n++; if (!($5 < 1e-9 && ($9 - 1e-3) ^ 2 < 1e-18)) exit 1 } END { if (n < 4) exit 1 }' scores.tsv
doubt 'is above --max-mae' evaluate --urdf arm.urdf session.tsv --max-mae 1e-3

# pose logs
simulate --poses 20 --perturb 0.3,1 --effect joint_compliance:joint_2=3e-5 --truth poses_truth.tsv --command --effort -o poses.tsv
expect "a pose log has as many rows as asked" test "$(grep -vc '^#' poses.tsv)" -eq 21
"$MUKCA" fk --urdf arm.urdf --offsets poses_truth.tsv poses.tsv >seen
grep -v '^#' poses.tsv | cut -f 23-25 >told
expect "its positions are those of fk with the truth" near 1e-11 3 seen told
grep -v '^#' poses.tsv | cut -f 2-8 >angles.tsv
"$MUKCA" simulate --urdf arm.urdf --offsets poses_truth.tsv --at angles.tsv | grep -v '^#' | cut -f 9-11 >again
expect "its angles with the same arm give the same poses" near 1e-11 3 again told

# joints that have the names of measured quantities keep their columns
sed 's/"joint_5"/"target"/; s/"joint_6"/"yaw"/; s/"joint_4"/"roll"/; s/"joint_3"/"pitch"/' arm.urdf >rpy.urdf
run simulate --urdf rpy.urdf --poses 9 -o rpy.tsv
grep -v '^#' rpy.tsv | cut -f 1-11 >rpy_positions.tsv
run evaluate --urdf rpy.urdf rpy_positions.tsv --json -
expect "joints roll, pitch, yaw are no orientation" sh -c "grep -q 'mae_m.: [0-9.]*e-1[0-9]' '$scratch/out' && ! grep -q rotation '$scratch/out'"
# a sliding joint yields by metres per newton; older tables say rad/(N*m)
sed 's/name="joint_3" type="revolute"/name="joint_3" type="prismatic"/' arm.urdf >slide.urdf
run simulate --urdf slide.urdf --effect joint_compliance:joint_3=1e-5 --rows 5 --truth slide_truth.tsv -o slide.tsv
expect "the unit is m/N" grep -q 'joint_compliance	m/N' slide_truth.tsv
sed 's#m/N#rad/(N*m)#; /^# digest/d' slide_truth.tsv >older.tsv
for table in slide_truth older; do
    expect "$table is read" "$MUKCA" evaluate --urdf slide.urdf --offsets $table.tsv slide.tsv --max-mae 1e-9
done
refuse 2 "a pose log has no placements and no sockets" simulate --urdf arm.urdf --poses 9 --effect tool_motion:p1/0@2=1e-3
refuse 2 "must be MM,MRAD" simulate --urdf arm.urdf --perturb 1
refuse 2 "must be a number, 0 to 1, in m" simulate --urdf arm.urdf --noise -1
refuse 2 "must be a whole number, 2 to 100000" simulate --urdf arm.urdf --rows 1
refuse 2 "must be a whole number, 1 to" simulate --urdf arm.urdf --placements 0
refuse 2 "held-out needs --test" simulate --urdf arm.urdf --held-out 2
refuse 2 "two placements have the name 'a'" simulate --urdf arm.urdf --place a --place a
refuse 2 "needs NAME=X,Y,Z" simulate --urdf arm.urdf --place a=1,2
refuse 2 "at and --poses exclude each other" simulate --urdf arm.urdf --at angles.tsv --poses 9
refuse 3 "does not reach socket 0" simulate --urdf arm.urdf --place far=9,0,0

# runs of a moving arm
simulate --motion 10 --rate 50 --seed 1 --runs 2 --truth effects.tsv -o runs.tsv \
    --effect payload=0.5,viscous:joint_3=2,stribeck:joint_2=1
expect "two runs have their rows" test "$(grep -vc '^[#t]' runs.tsv)" -eq 1002
expect "time, angles, efforts" test "$(grep -m 1 time_s runs.tsv | wc -w)" -eq 15
expect "the truth names effect, joint and unit" grep -q 'viscous	joint_3	damping	N\*m\*s/rad	2	0	1' effects.tsv
refuse 2 "motion and --poses exclude each other" simulate --urdf arm.urdf --motion 9 --poses 9
refuse 2 "rate needs --motion" simulate --urdf arm.urdf --rate 100
sed '/<inertial>/,/<.inertial>/d' arm.urdf >weightless.urdf
refuse 2 "motion needs link masses" simulate --urdf weightless.urdf --motion 9
