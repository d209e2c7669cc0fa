"""run.py calls this: the exported MuJoCo model comes to rest where `mukca fk` has the arm, effects included.

Statics are MuJoCo's own: springs and stops move until mj_forward leaves no force on them; some
configurations are also left to swing out in mj_step.
"""
import hashlib
import os
import re
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
MUKCA = os.environ.get("MUKCA", os.path.join(ROOT, "build", "mukca"))
URDF = os.path.join(ROOT, "data", "gen3.urdf")

GEOMETRY = [("joint_2", "x", 0.0), ("joint_3", "y", -0.2104), ("joint_4", "z", -0.2104)]
EFFECTS = [
    ("joint_2", "joint_compliance", 5e-5, "-"), ("joint_4", "joint_compliance", 4e-5, "-"),
    ("joint_3", "link_bending", 3e-5, "-"), ("-", "base_compliance", 6.6e-5, "-"),
]
PLAY = [("joint_4", "backlash", 8e-4, "torque_scale=300mNm")]


def write_table(path, effects):
    sha = hashlib.sha256(open(URDF, "rb").read()).hexdigest()
    with open(path, "w") as f:
        f.write(f"# mukca offsets table\n# robot: kinova_gen3\n# urdf_sha256: {sha}\n")
        f.write("joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n")
        for joint, parameter, nominal in GEOMETRY:
            f.write(f"{joint}\t{parameter}\tm\t{nominal}\t{nominal + 2e-3}\t0.002\t0\t1\t-\n")
        for joint, effect, value, term in effects:
            unit = "rad" if effect == "backlash" else "rad/(N*m)"
            f.write(f"{joint}\t{effect}\t{unit}\t0\t{value}\t{value}\t0\t1\t{term}\n")


def run(*arguments, text=None):
    return subprocess.run([MUKCA, *arguments], input=text, check=True, capture_output=True,
                          text=True).stdout


class Statics:
    def __init__(self, path):
        self.model = mujoco.MjModel.from_xml_path(path)
        self.data = mujoco.MjData(self.model)
        m = self.model
        names = [m.joint(j).name for j in range(m.njnt)]
        self.main = [names.index(f"joint_{i + 1}") for i in range(7)]
        self.given = [j for j in range(m.njnt) if j not in self.main]

    def set_main(self, q):
        mujoco.mj_resetData(self.model, self.data)
        for j, angle in zip(self.main, q):
            self.data.qpos[self.model.jnt_qposadr[j]] = angle

    def rest(self, q):
        """Fixed point of the springs under mj_forward's gravity; (tip, torque in the play)."""
        m, d = self.model, self.data
        self.set_main(q)
        load = np.inf
        for _ in range(12):
            mujoco.mj_forward(m, d)
            left = 0.0
            for j in self.given:
                dof, at, k = m.jnt_dofadr[j], m.jnt_qposadr[j], m.jnt_stiffness[j]
                if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL:
                    force = -d.qfrc_bias[dof:dof + 3]
                    left = max(left, np.abs(force + d.qfrc_passive[dof:dof + 3]).max())
                    w = force / k
                    angle = np.linalg.norm(w)
                    mujoco.mju_axisAngle2Quat(d.qpos[at:at + 4], w / max(angle, 1e-300), angle)
                elif k > 0:
                    left = max(left, abs(d.qfrc_passive[dof] - d.qfrc_bias[dof]))
                    d.qpos[at] = -d.qfrc_bias[dof] / k
                else:  # play: gravity decides on the side
                    load = abs(d.qfrc_bias[dof])
                    d.qpos[at] = m.jnt_range[j][0 if d.qfrc_bias[dof] > 0 else 1]
        mujoco.mj_forward(m, d)
        assert left < 1e-6, left
        return d.site("tip").xpos.copy(), load

    def swing_out(self, q, seconds):
        m, d = self.model, self.data
        self.set_main(q)
        for j in self.main:  # the drives hold: rotors of immense inertia
            m.dof_armature[m.jnt_dofadr[j]] = 1e9
        for _ in range(int(seconds / m.opt.timestep)):
            mujoco.mj_step(m, d)
        mujoco.mj_forward(m, d)
        return d.site("tip").xpos.copy()


def compare(folder, title, effects, count):
    table, model = os.path.join(folder, "t.tsv"), os.path.join(folder, "m.xml")
    write_table(table, effects)
    arm = ["--urdf", URDF, "--offsets", table, "--accept-other-arm", "--force", "-q"]
    run("export", *arm, "--format", "mjcf", "-o", model)
    random = np.random.default_rng(7)
    q = random.uniform(-2, 2, (count, 7))
    text = "\n".join(",".join(repr(float(v)) for v in row) for row in q)
    expected = np.loadtxt(run("fk", *arm, text=text).splitlines(), skiprows=1)
    statics = Statics(model)
    found = [statics.rest(row) for row in q]
    # a stop has no middle: where hardly any torque is in the play, the gear floats
    decided = np.array([load > 1.5 for _, load in found])
    error = np.linalg.norm(np.array([tip for tip, _ in found]) - expected, axis=1)[decided]
    worst = error.max()
    print(f"{'ok' if worst < 1e-6 else 'not ok'} mjcf: {title}: {decided.sum()} of {count} "
          f"configurations, worst {worst * 1e6:.4f} um")
    # a lightly loaded stop bounces in mj_step, by up to the whole play
    pressed = [i for i, (_, load) in enumerate(found) if load > 3][:10]
    swung = max(np.linalg.norm(statics.swing_out(q[i], 2.0) - expected[i]) for i in pressed)
    soft = 5e-5 if effects == EFFECTS + PLAY else 1e-6  # stops are soft in mj_step
    print(f"{'ok' if swung < soft else 'not ok'} mjcf: {title}: 10 left to swing out, worst "
          f"{swung * 1e6:.4f} um")
    return worst < 1e-6 and swung < soft


def tensor(body):
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    return turn.reshape(3, 3) @ np.diag(body.inertia) @ turn.reshape(3, 3).T


def tensors(folder):
    """Masses and inertia tensors of the export against MuJoCo's own reading of the URDF."""
    plain, model = os.path.join(folder, "plain.urdf"), os.path.join(folder, "m.xml")
    with open(URDF, encoding="utf-8") as urdf, open(plain, "w", encoding="utf-8") as out:
        out.write(re.sub(r"<(visual|collision)>.*?</\1>", "", urdf.read(), flags=re.S))  # meshes
    run("export", "--urdf", URDF, "--format", "mjcf", "-o", model, "--force")
    theirs, ours = mujoco.MjModel.from_xml_path(plain), mujoco.MjModel.from_xml_path(model)
    worst = 0.0
    for i in range(1, theirs.nbody):
        a, b = theirs.body(i), ours.body(theirs.body(i).name)
        worst = max(worst, abs(a.mass - b.mass).max(), abs(a.ipos - b.ipos).max(), abs(tensor(a) - tensor(b)).max())
    print(f"{'ok' if worst < 1e-9 else 'not ok'} mjcf: masses and inertia tensors, worst {worst:.1e} of kg, m, kg m^2")
    return worst < 1e-9


with tempfile.TemporaryDirectory() as scratch:
    good = [tensors(scratch),
            compare(scratch, "geometry", [], 1000),
            compare(scratch, "geometry and springs", EFFECTS, 1000),
            compare(scratch, "geometry, springs and play", EFFECTS + PLAY, 1000)]
sys.exit(0 if all(good) else 1)
