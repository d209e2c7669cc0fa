# Forward kinematics and exports.
. "$here/fixture.sh"
printf '0,0,0\n0,0,0\n' >zero.csv
printf '# a comment\nj3\tj1\tj2\tcolour\n0\t0\t0\tred\n' >named.tsv
golden fk_pose fk --urdf arm.urdf --pose --tip hand named.tsv zero.csv
table_of arm.urdf 'j1\tz\tm\t0.25\t0.375\t0.125\t1e-5\t1\t-' 'j2\tx\tm\t0\t-0.125\t-0.125\tinf\t0\t-' \
    'tool\tz\tm\t0.125\t0.25\t0.125\t1e-5\t1\t-' >offsets.tsv
golden fk_offsets fk --urdf arm.urdf --offsets offsets.tsv zero.csv
golden export_yaml export --urdf arm.urdf --offsets offsets.tsv --format yaml
"$MUKCA" export --urdf arm.urdf --offsets offsets.tsv -o ending.yaml
expect "the file's ending means a format" cmp "$scratch/out" ending.yaml
accept "arm.urdf: robot small, base to ball, 3 joints" fk -v --urdf arm.urdf zero.csv
"$MUKCA" compensate -q --urdf arm.urdf --offsets offsets.tsv zero.csv -o corrected.tsv
refuse 3 "were corrected by mukca compensate" compensate --urdf arm.urdf --offsets offsets.tsv corrected.tsv
accept "no --offsets" compensate --urdf arm.urdf zero.csv

# a time that is missing: 8 s after the row before, and never nan
printf 'j2\tjoint_drift\trad\t0\t1\t1\t0\t1\ttime_constant=0s\n' | cat offsets.tsv - >drift.tsv
printf 'time_s\tj1\tj2\tj3\n\t0\t0\t0\n100\t0\t0\t0\n\t0\t0\t0\n102\t0\t0\t0\n' >untimed.tsv
printf 'time_s\tj1\tj2\tj3\n0\t0\t0\t0\n8\t0\t0\t0\n16\t0\t0\t0\n10\t0\t0\t0\n' >timed.tsv
for command in fk "compensate --position-only"; do
    "$MUKCA" $command -q --urdf arm.urdf --offsets drift.tsv untimed.tsv | cut -f 2- >untimed.txt
    "$MUKCA" $command -q --urdf arm.urdf --offsets drift.tsv timed.tsv | cut -f 2- >timed.txt
    expect "$command goes on at 8 s per row where a time is missing" equal untimed.txt timed.txt
done
run export --urdf arm.urdf
expect "an export without offsets changes no byte" cmp "$scratch/out" arm.urdf

"$MUKCA" export --urdf arm.urdf --offsets offsets.tsv -o calibrated.urdf
rows 1 50 >fifty.csv
"$MUKCA" fk --urdf arm.urdf --offsets offsets.tsv --pose fifty.csv >with_table.tsv
"$MUKCA" fk --urdf calibrated.urdf --pose fifty.csv >with_urdf.tsv
expect "the exported URDF is the calibrated arm" equal with_table.tsv with_urdf.tsv
awk -F '\t' '!/^#/ { for (i = NF; i > 1; i--) printf "%s\t", $i; $0 = $1 } { print }' drift.tsv >reversed.tsv
for table in drift reversed; do "$MUKCA" fk -q --urdf arm.urdf --offsets $table.tsv fifty.csv >$table.txt; done
expect "the columns of a table may stand in any order" equal drift.txt reversed.txt

# the header as its own comment says to use it, compiled by the user's compiler
"$MUKCA" export --urdf arm.urdf --offsets offsets.tsv --format c -o small.h
cat >use.c <<'C'
#include <math.h>
#include <stdio.h>
#ifndef ALONE
#include "mukca/corrected.h"
#endif
#include "small.h"

static void rotate(double v[3], const double w[4]) /* v by the quaternion w */
{
    double t[3] = {2 * (w[2] * v[2] - w[3] * v[1]), 2 * (w[3] * v[0] - w[1] * v[2]),
                   2 * (w[1] * v[1] - w[2] * v[0])};
    double u[3] = {w[2] * t[2] - w[3] * t[1], w[3] * t[0] - w[1] * t[2], w[1] * t[1] - w[2] * t[0]};
    for (int i = 0; i < 3; i++) v[i] += w[0] * t[i] + u[i];
}

int main(void)
{
    double q[3];
    puts("x_m\ty_m\tz_m");
    while (scanf("%lf,%lf,%lf", &q[0], &q[1], &q[2]) == 3) {
        double p[3] = {0, 0, 0};
        for (int k = small_elements - 1; k >= 0; k--) {
            if (small_joint[k] >= 0) {
                double half = q[small_joint[k]] / 2, s = sin(half);
                const double *a = small_axis[k];
                const double turn[4] = {cos(half), s * a[0], s * a[1], s * a[2]};
                rotate(p, turn);
            }
            rotate(p, small_quaternion[k]);
            for (int i = 0; i < 3; i++) p[i] += small_xyz[k][i];
        }
#ifndef ALONE
        double at[3];
        mukca_corrected_position(at, &small_arm, q, NULL);
        for (int i = 0; i < 3; i++)
            if (!(fabs(at[i] - p[i]) <= 1e-12)) return 1;
#endif
        printf("%.12f\t%.12f\t%.12f\n", p[0], p[1], p[2]);
    }
    return 0;
}
C
rt=${BUILD:-$root/build}/libmukca_rt.a
echo 'int main(void) { return 0; }' >probe.c # does not link with one of another processor, or with sanitizers
${CC:-cc} -o probe probe.c -Wl,--whole-archive "$rt" -Wl,--no-whole-archive -lm 2>probe.log || rt=-DALONE
if ${CC:-cc} -std=c11 -Wall -Wextra -Werror -I"$root/include" -o use use.c "$rt" -lm 2>compile.log; then
    expect "the arm of the header, for libmukca_rt, has the positions of its arrays" sh -c './use <fifty.csv >from_use.tsv'
    cut -f 1-3 with_table.tsv >positions.tsv
    expect "a program with the exported C header computes the same positions" near 1e-11 3 positions.tsv from_use.tsv
else
    fail "the exported C header compiles" "$(cat compile.log)"
fi
refuse 2 "arm.sdf: no format has this ending; choose one with --format .*gz sdf -p" export --urdf arm.urdf -o arm.sdf
expect "--format decides, whatever the ending" "$MUKCA" export --urdf arm.urdf --format urdf -o arm.sdf

# the inertia tensors of the URDF, in MuJoCo's order: xx yy zz xy xz yz
cat >tensor.urdf <<'URDF'
<robot name="t"><link name="a"/><link name="b"><inertial><mass value="2"/><origin xyz="0.1 0 0"/>
<inertia ixx="0.03" iyy="0.04" izz="0.05" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>
URDF
run export --urdf tensor.urdf -f mjcf -o tensor.xml
expect "MJCF has the tensor of the URDF" grep -q 'mass="2" fullinertia="0.03 0.04 0.05 0.001 0.002 0.003"' tensor.xml

# one's own MuJoCo model: bodies found by name, also without the prefix; the rest stays
run simulate --urdf arm.urdf --seed 3 --placements 3 --rows 20 --perturb 2,4 --noise 1e-4 -o into.tsv
run calibrate --urdf arm.urdf into.tsv -o into_table.tsv
bodies() { sed -n 's/.*<body.*\(pos="[^"]*"\).*\(quat="[^"]*"\).*/\1 \2/p' "$1"; }
run export --urdf arm.urdf -f mjcf -o own.xml
sed -i 's/<site name="tip"\/>/<!-- <body name="fore"> --><geom size="0.01"\/>/; s/name="fore"/name="arm_fore"/' own.xml
run export --urdf arm.urdf --offsets into_table.tsv -f mjcf -o whole.xml
accept "note: body 'fore': moved by [0-9.]* mm, [0-9.]* mrad" export --urdf arm.urdf --offsets into_table.tsv --into own.xml -o patched.xml
expect "export --into has the poses of the whole export" test "$(bodies patched.xml)" = "$(bodies whole.xml)"
expect "export --into keeps the rest" test "$(sed 's/ \(pos\|quat\)="[^"]*"//g' patched.xml)" = "$(sed 's/ \(pos\|quat\)="[^"]*"//g' own.xml)"
sed "s|<joint name=|<joint/>&|" arm.urdf >nameless.urdf
answer "<joint/><joint name=" export --urdf arm.urdf --into nameless.urdf
wrong_into() { # MODEL SED PATTERN: refused for what is wrong with it
    sed "$2" "$1" >"wrong.${1##*.}"
    refuse 3 "wrong.${1##*.}: $3" export --urdf arm.urdf --offsets into_table.tsv --into "wrong.${1##*.}"
}
wrong_into own.xml '/name="hand"/ s/pos="[^"]*"/pos="0.4 0 0"/' "body 'hand' is not where the URDF has it"
wrong_into own.xml 's/name="hand"/name="palm"/' "body 'hand' is missing"
wrong_into own.xml 's/name="hand"/name="left_hand"/; s/name="ball"/name="right_hand"/' "body 'hand' is there more than once"
# bodies turned and shifted along the axes of their joints, the ball turned: the same arm, moved by MuJoCo's rules
cat >turned.xml <<'XML'
<mujoco><default><joint axis="0 0 1"/></default><worldbody><body name="base">
  <body name="upper" pos="0 0 0.35" quat="1 0 0 1"><joint name="j1"/>
    <body name="fore" pos="0.2 0 -0.1" quat="0.5 -0.5 0.5 -0.5"><joint name="j2" pos="0 0 0.3"/>
      <body name="hand" pos="0.5 0 0.1"><joint name="j3"/><body name="ball" pos="0.25 -0.125 -0.3" quat="0 1 0 0"/></body>
    </body></body></body></worldbody></mujoco>
XML
cat >mujoco.py <<'PY'
import math, sys, xml.etree.ElementTree as ET
def product(a, b):
    w, x, y, z = a; s, t, u, v = b
    return (w*s - x*t - y*u - z*v, w*t + x*s + y*v - z*u, w*u - x*v + y*s + z*t, w*v + x*u - y*t + z*s)
def turn(q, v):
    return product(product(q, (0, *v)), (q[0], -q[1], -q[2], -q[3]))[1:]
def numbers(tag, key, default):
    return [float(x) for x in tag.get(key, default).split()]
angles, at, q = [0.3, -0.8, 1.1], [0, 0, 0], (1, 0, 0, 0)
body = ET.parse(sys.argv[1]).find("worldbody")
while (body := body.find("body")) is not None:
    at = [a + b for a, b in zip(at, turn(q, numbers(body, "pos", "0 0 0")))]
    p = numbers(body, "quat", "1 0 0 0")
    size = math.sqrt(sum(x * x for x in p))
    q = product(q, [x / size for x in p])
    if (joint := body.find("joint")) is not None:
        angle, pos = angles.pop(0), numbers(joint, "pos", "0 0 0")
        before = turn(q, pos)
        q = product(q, (math.cos(angle / 2), *(math.sin(angle / 2) * x for x in numbers(joint, "axis", "0 0 1"))))
        at = [a + b - c for a, b, c in zip(at, before, turn(q, pos))]
print(" ".join("%.7f" % (x + 0.0) for x in at))
PY
accept "note: body 'hand': moved by" export --urdf arm.urdf --offsets into_table.tsv --into turned.xml -o turned_patched.xml
echo 0.3,-0.8,1.1 >three.csv
run fk --urdf arm.urdf --offsets into_table.tsv three.csv
tip=$(awk 'NR == 2 { printf "%.7f %.7f %.7f", $1, $2, $3 }' "$scratch/out")
for model in patched turned_patched; do
    expect "$model.xml has the tip of fk" test "$("${PYTHON:-python3}" mujoco.py $model.xml)" = "$tip"
done
wrong_into turned.xml 's/pos="0.5 0 0.1"/pos="0.51 0 0.1"/' "body 'hand' is not where the URDF has it"

# one's own URDF: joints found by name, with a prefix or without; the rest stays
sed 's/name="j\([123]\)"/name="left_j\1"/; s/<origin xyz="0 0 0.25" rpy="0 0 0"/<origin xyz="0 0 0.2501"/; /name="tool"/,$d' arm.urdf >own.urdf
echo '<link name="camera"/><joint name="mount" type="fixed"><parent link="hand"/><child link="camera"/></joint></robot>' >>own.urdf
accept "no joint 'tool': its offsets are left out" export --urdf arm.urdf --offsets into_table.tsv --into own.urdf -o own_out.urdf
run export --urdf arm.urdf --offsets into_table.tsv -o all.urdf
origin() { grep -A 1 "name=\"$2\"" "$1" | sed -n 's/.*\(xyz="[^"]*"\).*/\1/p'; }
expect "export --into has the origins of the whole URDF" test "$(origin own_out.urdf left_j3)" = "$(origin all.urdf j3)"
expect "and keeps the rest" test "$(grep -v '<origin\|<joint' own_out.urdf)" = "$(grep -v '<origin\|<joint' own.urdf)"
wrong_into own.urdf 's/name="left_j3"/name="left_j4"/' "joint 'j3' is missing"
wrong_into own.urdf 's/name="mount"/name="right_j3"/' "joint 'j3' is there more than once"
wrong_into own.urdf 's/xyz="0.5 0 0"/xyz="0.6 0 0"/' "joint 'j3' is not where"
refuse 2 "into and --format exclude each other" export --urdf arm.urdf --into own.xml -f yaml

# arrays of numpy.save, and its text with spaces
"${PYTHON:-python3}" -c "
import struct
rows = [[float(x) for x in line.split(',')] for line in open('fifty.csv')]
head = '{\'descr\': \'<f8\', \'fortran_order\': False, \'shape\': (%d, %d), }' % (len(rows), len(rows[0]))
head = head.ljust(117) + '\n'
data = struct.pack('<%dd' % sum(map(len, rows)), *sum(rows, []))
open('fifty.npy', 'wb').write(b'\x93NUMPY\x01\x00' + struct.pack('<H', len(head)) + head.encode() + data)
open('fifty.txt', 'w').writelines(' '.join('%.18e' % x for x in row) + '\n' for row in rows)"
for each in csv npy txt; do "$MUKCA" fk --urdf arm.urdf fifty.$each -q >of_$each.tsv; done
expect "a .npy array is the table of its numbers" sh -c 'test "$(wc -l <of_csv.tsv)" -eq 51 && cmp of_csv.tsv of_npy.tsv'
expect "numpy's text, with spaces, too" cmp of_csv.tsv of_txt.tsv
