# mukca motion: runs of a moving arm, and bad ones
moves() { "$MUKCA" simulate --urdf "$root/data/demo/arm.urdf" --motion 30 --rate 60 --torque-noise 0.02 "$@"; }
cp "$root/data/demo/arm.urdf" motion.urdf
moves --seed 1 --effect payload=0.5,viscous:joint_3=2 -o new.tsv
moves --seed 2 -o old.tsv
answer 'viscous friction at joint_3' motion --urdf motion.urdf new.tsv
answer 'payload at' motion --urdf motion.urdf new.tsv --reference old.tsv
answer '"schema": "mukca.motion/1"' motion -q --urdf motion.urdf new.tsv --json -
answer 'nothing beyond' motion --urdf motion.urdf old.tsv
expect "the table has both effects" sh -c "'$MUKCA' motion -q --urdf motion.urdf new.tsv -o effects.tsv && \
    grep -q '^viscous	joint_3	damping	N\*m\*s/rad	2\.0' effects.tsv && grep -q '^payload	joint_7	mass	kg	0\.' effects.tsv"
spoilt() { # VERB PATTERN COMMAND...: a run that the command prints
    verb=$1 part=$2
    shift 2
    "$@" >spoilt.tsv
    $verb "$part" motion --urdf motion.urdf spoilt.tsv
}
# what a table may be like: currents, gaps, repeated and empty rows
spoilt 'refuse 3' "give --current-gain joint_1=VALUE" sed '1,/^time_s/s/\.effort/.current/g' new.tsv
answer 'viscous friction at joint_3' motion --urdf motion.urdf spoilt.tsv \
    --current-gain joint_1=1,joint_2=1,joint_3=1,joint_4=1,joint_5=1,joint_6=1,joint_7=1
refuse 3 "spoilt.tsv has motor currents, new.tsv torques" motion --urdf motion.urdf spoilt.tsv --test new.tsv \
    --current-gain joint_1=1,joint_2=1,joint_3=1,joint_4=1,joint_5=1,joint_6=1,joint_7=1
spoilt accept "rows that repeat a time left out" awk 'NR % 500 == 0 { print } { print }' new.tsv
spoilt accept "cut at 1 gap in time_s" awk '!/^[0-9]/ || $1 < 12 || $1 > 15' new.tsv
# and must not
refuse 2 "there is no effect 'wind'" motion --urdf motion.urdf new.tsv --without wind
refuse 2 "is not JOINT=NUMBER" motion --urdf motion.urdf new.tsv --current-gain joint_9=1
refuse 2 "no value for joint_1" motion --urdf motion.urdf new.tsv --kp joint_2=100
spoilt 'refuse 3' "no column joint_1.effort" sed '1,/^time_s/s/\.effort/.torque/g' new.tsv
spoilt 'refuse 3' "no column time_s" sed '1,/^time_s/s/time_s/t/' new.tsv
spoilt 'refuse 3' "the time falls by" awk '/^[0-9]/ && NR > 900 { $1 -= 20 } { print }' OFS='\t' new.tsv
interrupted motion --urdf motion.urdf new.tsv
# joint states: lines of ros2 topic echo --csv, JSON, a log of lcm-logger; recorded velocities
cat >states.py <<'PY'
import struct, sys
rows = [line.rstrip("\n").split("\t") for line in open(sys.argv[1]) if not line.startswith("#")]
names = [n for n in rows[0][1:] if "." not in n]
n, values = len(names), [list(map(float, row)) for row in rows[1:]]
ros, lines, log, table = open("ros.csv", "w"), open("lines.json", "w"), open("run.lcmlog", "wb"), open("velocities.tsv", "w")
table.write("\t".join(["time_s"] + names + [j + e for e in (".velocity", ".effort") for j in names]) + "\n")
for i, (t, *x) in enumerate(values):
    a, b = values[max(i - 1, 0)], values[min(i + 1, len(values) - 1)]
    v = [(b[1 + j] - a[1 + j]) / (b[0] - a[0]) for j in range(n)]
    q, effort = x[:n], x[n:]
    table.write("\t".join(map(repr, [t] + q + v + effort)) + "\n")
    stamp = 1700000000000000 + round(1e6 * t)
    if i % 10 == 3:     # a gripper publishes on the same topic
        ros.write("%d,%d,,finger,0.01,0.0,1.0\n" % (stamp // 10**6, stamp % 10**6 * 1000))
    ros.write(",".join(map(str, [stamp // 10**6, stamp % 10**6 * 1000, ""] + names[::-1] + q[::-1] + v[::-1] + effort[::-1])) + "\n")
    lines.write('{"utime": %d, "name": [%s], "position": %s, "effort": %s}\n'
                % (stamp, ", ".join('"%s"' % j for j in names), q, effort))
    message = struct.pack(">Qqh", 0x3e377b4cebc593a4, stamp, n)     # bot_core.joint_state_t
    for name in names:
        message += struct.pack(">i", len(name) + 1) + name.encode() + b"\0"
    for array in (q, v, effort):
        message += struct.pack(">%df" % n, *array)
    log.write(struct.pack(">IqqII", 0xeda1da01, i, stamp, 5, len(message)) + b"STATE" + message)
PY
"${PYTHON:-python3}" states.py new.tsv
run motion --urdf motion.urdf new.tsv
grep -A 5 '^Found' "$scratch/out" >of_table
for each in ros.csv lines.json run.lcmlog velocities.tsv; do
    run motion --urdf motion.urdf $each
    expect "$each gives the findings of the table" sh -c "grep -A 5 '^Found' '$scratch/out' | cmp - of_table"
done
accept "joint states of others left out" motion --urdf motion.urdf ros.csv
spoilt accept "the last line is cut off" head -c -40 ros.csv
spoilt 'refuse 3' "the joint states have no efforts" sed '1,$s/"effort"/"force"/' lines.json
spoilt 'refuse 3' "no joint state has all 7 joints of the arm; check the names" sed 's/joint_7/joint_9/g' ros.csv
spoilt accept "the velocities of joint_2 are 57.[0-9] times the derivative of its angle" awk -F'\t' '/^[0-9]/ { for (i = 9; i <= 15; i++) $i *= 57.29578 } { print }' OFS='\t' velocities.tsv
spoilt accept "the velocities of joint_2 are not the derivative of its angle" awk -F'\t' '/^[0-9]/ { v = $9; $9 = $10; $10 = v } { print }' OFS='\t' velocities.tsv
# the effects in a model of one's own, here the exported one; the report
run export --urdf motion.urdf -f mjcf -o plain.xml
accept "body 'link_7': mass 0.62 kg to" export --urdf motion.urdf --motion effects.tsv --into plain.xml -o patched.xml
expect "damping is in the model" grep -q '<joint name="joint_3".* damping="2\.0' patched.xml
accept "joint 'joint_3': damping 0 to 2" export --urdf motion.urdf --motion effects.tsv -o patched.urdf
expect "and in the URDF" grep -q '<dynamics damping="2\.0' patched.urdf
answer 'nothing beyond' motion --urdf patched.urdf new.tsv
refuse 2 "motion and --format exclude each other" export --urdf motion.urdf --motion effects.tsv -f yaml
sed 's/base_link/base_frame/g' motion.urdf >other.urdf
refuse 3 "made with another URDF than --urdf" export --urdf other.urdf --motion effects.tsv
sed 's/"joint_3"/"joint_x"/' plain.xml >missing.xml
refuse 3 "missing.xml: joint 'joint_3' is missing" export --urdf motion.urdf --motion effects.tsv --into missing.xml
sed 's/^viscous	joint_3/viscous	joint_x/' effects.tsv >foreign.tsv
refuse 3 "'joint_x' is no joint of the arm" export --urdf motion.urdf --motion foreign.tsv --into plain.xml
run motion -q --urdf motion.urdf new.tsv --report motion.html
expect "the report has its figures" test "$(grep -c '<svg' motion.html)" = 21
expect "and no number is missing" sh -c '! grep -nwi nan motion.html'
