#!/usr/bin/env python3
"""Joint torques of moving arms against Pinocchio and MuJoCo: the same to 1e-9 of the largest torque.

run.py makes the virtual environment of both.  `--reference` prints the motions and torques of
tests/unit/torques.urdf as they stand in tests/unit/test_dynamics.c.
"""
import os
import subprocess
import sys

import run

run.enter_environment(__file__)

import mujoco            # noqa: E402
import numpy as np       # noqa: E402
import pinocchio         # noqa: E402

GRAVITY = np.array([0, 0, -9.80665])
ARMS = [("tests/unit/torques.urdf", "ball"), ("data/panda/arm.urdf", "ball_link"), ("data/gen3.urdf", "tool_link"),
        ("data/demo/arm.urdf", "ball_link")]
ROWS = 200


def by_pinocchio(xml, names, rows):
    model = pinocchio.buildModelFromXML(xml)
    model.gravity.linear = GRAVITY
    data = model.createData()
    ids = [model.joints[model.getJointId(name)] for name in names]
    out = []
    for q, dq, ddq in rows:
        state, v, a = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for joint, *values in zip(ids, q, dq, ddq):
            state[joint.idx_q:joint.idx_q + joint.nq] = \
                values[0] if joint.nq == 1 else (np.cos(values[0]), np.sin(values[0]))
            v[joint.idx_v], a[joint.idx_v] = values[1:]
        torque = pinocchio.rnea(model, data, state, v, a)
        out.append([torque[joint.idx_v] for joint in ids])
    return np.array(out)


def by_mujoco(xml, names, rows):
    compiler = '<mujoco><compiler fusestatic="false" discardvisual="true" balanceinertia="false"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(xml.replace("</robot>", compiler))
    model.opt.gravity, model.opt.disableflags = GRAVITY, mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    out = []
    for q, dq, ddq in rows:
        for name, *values in zip(names, q, dq, ddq):
            data.joint(name).qpos, data.joint(name).qvel, data.joint(name).qacc = values
        mujoco.mj_inverse(model, data)
        out.append([data.joint(name).qfrc_inverse[0] for name in names])
    return np.array(out)


def motions(urdf, tip, rows):
    joints = [j for j in run.chain(urdf, tip) if j[1] != "fixed"]
    rng = np.random.default_rng(7)
    low, high = (np.array([max(min(j[k], 3), -3) for j in joints]) for k in (2, 3))
    n = len(joints)
    return [j[0] for j in joints], np.stack([rng.uniform(low, high, (rows, n)), rng.normal(0, 1.5, (rows, n)),
                                             rng.normal(0, 5, (rows, n))], axis=1)


def by_mukca(urdf, tip, rows):
    """Direct torques, torques by the regressor, nanoseconds of both."""
    text = "\n".join(" ".join("%.17g" % x for x in row.ravel()) for row in rows)
    out = subprocess.run([os.path.join(run.BUILD, "bench", "bench_dynamics"), urdf, tip], input=text, check=True,
                         capture_output=True, text=True).stdout.splitlines()
    values = np.array([[float(x) for x in line.split()] for line in out[:-1]])
    return *np.split(values, 2, axis=1), out[-1][2:].split()


def print_reference():
    urdf, tip = ARMS[0]
    xml = run.bare(open(urdf).read())
    names, rows = motions(urdf, tip, 3)
    rows = rows.round(3)
    torques = [by(xml, names, rows) for by in (by_pinocchio, by_mujoco)]
    assert np.abs(torques[0] - torques[1]).max() < 1e-12 * np.abs(torques[0]).max()
    for row, torque in zip(rows, torques[0]):
        print("{" + ", ".join("{" + ", ".join("%.15g" % x for x in part) + "}" for part in (*row, torque)) + "},")


def main():
    good = True
    for urdf, tip in ARMS:
        names, rows = motions(urdf, tip, ROWS)
        xml = run.bare(open(urdf).read())
        direct, regressor, ns = by_mukca(urdf, tip, rows)
        for title, theirs in (("pinocchio", by_pinocchio(xml, names, rows)), ("mujoco", by_mujoco(xml, names, rows))):
            for way, ours in (("direct", direct), ("regressor", regressor)):
                worst = np.abs(ours - theirs).max() / np.abs(theirs).max()
                good = good and worst <= run.TOLERANCE
                print("%s torques of %s, %s, against %s: %.1e of %.0f N m" % (
                    "ok" if worst <= run.TOLERANCE else "not ok", urdf, way, title, worst, np.abs(theirs).max()))
        print("# %s: %s ns direct, %s ns regressor" % (urdf, *ns))
    sys.exit(not good)


if __name__ == "__main__":
    os.chdir(run.ROOT)
    print_reference() if "--reference" in sys.argv else main()
