# mukca motion: runs of a moving arm, and bad ones
. "$here/fixture.sh"
moves() { "$MUKCA" simulate --urdf "$root/data/demo/arm.urdf" --motion 30 --rate 60 --torque-noise 0.02 "$@"; }
cp "$root/data/demo/arm.urdf" motion.urdf
moves --seed 1 --effect payload=0.5,viscous:joint_3=2 -o new.tsv
moves --seed 2 -o old.tsv
answer 'viscous friction at joint_3' motion --urdf motion.urdf new.tsv
answer 'payload at' motion --urdf motion.urdf new.tsv --reference old.tsv
answer '"schema": "mukca.motion/1"' motion -q --urdf motion.urdf new.tsv --json -
answer 'nothing beyond' motion --urdf motion.urdf old.tsv
expect "the table has both effects" sh -c "'$MUKCA' motion -q --urdf motion.urdf new.tsv -o effects.tsv && \
    grep -q '^viscous	joint_3	0	N\*m\*s/rad	2\.0' effects.tsv && grep -q '^payload	joint_7	0	kg	0\.' effects.tsv"
# what a table may be like: currents, gaps, repeated and empty rows
sed '1,/^time_s/s/\.effort/.current/g' new.tsv >current.tsv
refuse 3 "give --current-gain joint_1=VALUE" motion --urdf motion.urdf current.tsv
answer 'viscous friction at joint_3' motion --urdf motion.urdf current.tsv \
    --current-gain joint_1=1,joint_2=1,joint_3=1,joint_4=1,joint_5=1,joint_6=1,joint_7=1
awk 'NR % 500 == 0 { print } { print }' new.tsv >repeated.tsv
accept "rows that repeat a time left out" motion --urdf motion.urdf repeated.tsv
awk '!/^[0-9]/ || $1 < 12 || $1 > 15' new.tsv >gap.tsv
accept "cut at 1 gap in time_s" motion --urdf motion.urdf gap.tsv
# and must not
refuse 2 "needs RUN" motion --urdf motion.urdf
refuse 2 "there is no effect 'wind'" motion --urdf motion.urdf new.tsv --without wind
refuse 2 "is not JOINT=NUMBER" motion --urdf motion.urdf new.tsv --current-gain joint_9=1
sed '1,/^time_s/s/\.effort/.torque/g' new.tsv >none.tsv
refuse 3 "no column joint_1.effort" motion --urdf motion.urdf none.tsv
sed '1,/^time_s/s/time_s/t/' new.tsv >timeless.tsv
refuse 3 "no column time_s" motion --urdf motion.urdf timeless.tsv
awk '/^[0-9]/ && NR > 900 { $1 -= 20 } { print }' OFS='\t' new.tsv >back.tsv
refuse 3 "the time falls by" motion --urdf motion.urdf back.tsv
awk '/^[0-9]/ { for (i = NF / 2 + 1.5; i <= NF; i++) $i = -$i } { print }' OFS='\t' new.tsv >sign.tsv
refuse 3 "opposite sign" motion --urdf motion.urdf sign.tsv
awk '/^[0-9]/ { for (i = 2; i <= 8; i++) $i = i / 10 } { print }' OFS='\t' new.tsv >rest.tsv
refuse 5 "no joint moves faster" motion --urdf motion.urdf rest.tsv
awk '/^[0-9]/ { for (i = 2; i <= 8; i++) $i = $1 / 20 } { print }' OFS='\t' new.tsv >oneway.tsv
refuse 5 "one direction only" motion --urdf motion.urdf oneway.tsv
head -n 300 new.tsv >short.tsv
refuse 5 "record .* s or more" motion --urdf motion.urdf short.tsv
