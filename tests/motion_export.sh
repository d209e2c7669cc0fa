#!/bin/bash
# What mukca motion found, patched into a MuJoCo model and loaded by MuJoCo: its inverse dynamics is that
# of the arm that was recorded.
set -u
cd "$(dirname "$0")/.." || exit 1
. tests/ok.bash
python=${PYTHON:-python3}
"$python" -c 'import mujoco' 2>/dev/null || skip "motion_export: python3 has no mujoco (pip install mujoco)"
arm=data/demo/arm.urdf
"$mukca" export -q --urdf $arm -f mjcf -o "$dir/plain.xml" || exit 1
# a model of one's own: drives with friction, and a last body whose frame is turned by 90 degrees about x
"$python" - "$dir" <<'PY'
import re, sys
text = open(sys.argv[1] + "/plain.xml").read()
for j, (friction, damping, armature) in enumerate([(1.5, 2, 0.1), (2, 1, 0.2), (1, 3, 0.1), (1, 0.5, 0.05)], 1):
    text = text.replace('<joint name="joint_%d"' % j, '<joint name="joint_%d" frictionloss="%g" damping="%g" armature="%g"'
                        % (j, friction, damping, armature))
head, last = text.split('<body name="link_7"')
for before, after in (('quat="0.7071067811865476 0.7071067811865475 0 0"', 'quat="0 1 0 0"'), ('axis="0 0 1"', 'axis="0 1 0"'),
                      ('pos="0.006 0.004 0.079"', 'pos="0.006 0.079 -0.004"'),
                      ('fullinertia="0.00067 0.00067 0.0005', 'fullinertia="0.00067 0.0005 0.00067'),
                      ('pos="0.058 0 0.165" quat="1 0 0 0"', 'pos="0.058 0.165 0" quat="0.7071067811865476 -0.7071067811865475 0 0"')):
    assert before in last, before
    last = last.replace(before, after, 1)
open(sys.argv[1] + "/own.xml", "w").write(head + '<body name="link_7"' + last)
PY
"$mukca" simulate -q --urdf $arm --motion 60 --rate 100 --torque-noise 0.02 --seed 3 \
    --effect payload=0.8,0.02,0.01,0.05 --effect coulomb:joint_1=1.5,coulomb:joint_2=3.5,coulomb:joint_3=1,coulomb:joint_4=1 --effect \
    viscous:joint_1=2,viscous:joint_2=1,viscous:joint_3=5,viscous:joint_4=0.5 --effect \
    armature:joint_1=0.1,armature:joint_2=0.2,armature:joint_3=0.1,armature:joint_4=0.45 \
    -o "$dir/run.tsv" --truth "$dir/truth.tsv" || exit 1
ok "the arm's effects are found" "$mukca" motion --urdf $arm --mjcf "$dir/own.xml" "$dir/run.tsv" -o "$dir/effects.tsv"
sed 's/^/# /' "$dir/out"
ok "own.xml is patched" "$mukca" export --urdf $arm --motion "$dir/effects.tsv" --into "$dir/own.xml" -o "$dir/patched.xml"
ok "the URDF is patched" "$mukca" export --urdf $arm --motion "$dir/effects.tsv" -o "$dir/patched.urdf"
ok "all else is as it was" "$python" - "$dir" <<'PY'
import re, sys
def rest(name):
    text = open(sys.argv[1] + "/" + name).read()
    return re.sub(r"<inertial[^>]*/>", "", re.sub(r' (frictionloss|damping|armature)="[^"]*"', "", text))
assert rest("own.xml") == rest("patched.xml")
PY
cat >"$dir/check.py" <<'PY'
import sys
import mujoco, numpy as np
folder = sys.argv[1]
m = mujoco.MjModel.from_xml_path(folder + "/patched.xml")
own = mujoco.MjModel.from_xml_path(folder + "/own.xml")
joint = {n: m.joint(n).dofadr[0] for n in ("joint_1", "joint_2", "joint_3", "joint_4", "joint_5")}
def near(what, value, wanted, part):
    print("%s: %.4g, put in %.4g" % (what, value, wanted))
    assert abs(value - wanted) <= part * abs(wanted), what
near("frictionloss joint_2", m.dof_frictionloss[joint["joint_2"]], 3.5, 0.02)
near("damping joint_3", m.dof_damping.reshape(m.nv, -1)[joint["joint_3"], 0], 5, 0.03)
near("armature joint_4", m.dof_armature[joint["joint_4"]], 0.45, 0.03)
for name, value in (("joint_1", 1.5), ("joint_5", 0)):
    near("frictionloss " + name, m.dof_frictionloss[joint[name]], value, 1e-9)
last = m.jnt_bodyid[-1]
near("mass of the last body", m.body_mass[last], own.body_mass[last] + 0.8, 0.05)
# the torques of the recording, without noise: those of the patched model
lines = [line.rstrip("\n").split("\t") for line in open(folder + "/run.tsv") if not line.startswith("#")]
rows = dict(zip(lines[0], np.array(lines[1:], float).T))
names = [m.joint(j).name for j in range(m.njnt)]
t, q = rows["time_s"], np.column_stack([rows[n] for n in names])
tau = np.column_stack([rows[n + ".effort"] for n in names])
h, w = t[1] - t[0], 7
kernel = np.hanning(2 * w + 3)[1:-1]; kernel /= kernel.sum()
smooth = lambda x: np.apply_along_axis(lambda c: np.convolve(c, kernel, "same"), 0, x)
q = smooth(q)
v = np.gradient(q, h, axis=0); a = np.gradient(v, h, axis=0)
def error(model, rows_of=slice(200, -200, 5)):
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    d, out = mujoco.MjData(model), []
    for i in range(len(t))[rows_of]:
        d.qpos[:], d.qvel[:], d.qacc[:] = q[i], v[i], a[i]
        mujoco.mj_inverse(model, d)
        out.append(d.qfrc_inverse + model.dof_frictionloss * np.sign(v[i]))
    return np.sqrt(np.mean((np.array(out) - smooth(tau)[rows_of]) ** 2, axis=0)) / np.ptp(tau, axis=0)
before, after = error(own), error(m)
print("error of the torques, part of the range:", before.round(3), "patched:", after.round(3))
assert np.all(after < 0.03) and after.max() < 0.25 * before.max()
PY
ok "MuJoCo: right friction, damping, armature, mass and torques" "$python" "$dir/check.py" "$dir"
sed 's/^/# /' "$dir/out"
ok "MuJoCo reads the patched URDF" "$python" -c "
import mujoco, re, sys
text = re.sub(r'<(visual|collision)>.*?</\1>', '', open('$dir/patched.urdf').read(), flags=re.S)
m = mujoco.MjModel.from_xml_string(text)
j = m.joint('joint_2').dofadr[0]
assert abs(m.dof_frictionloss[j] - 3.5) < 0.07, m.dof_frictionloss[j]"
exit $failed
