"""Arms of the exam in motion: MuJoCo models of URDFs with masses, drives, and arms as they were built."""
import copy
import os
import re
import sys

import mujoco
import numpy as np

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", ".."))
sys.path.append(os.path.join(ROOT, "tools", "blind"))
import arms as static_arms      # noqa: E402

STEP = 0.002                    # s, of the simulation
GRAVITY = (0, 0, -9.80665)


def industrial():
    """The URDF of a six-axis arm of 40 kg, with tensors of bodies of 10 cm radius of gyration."""
    arm = next(a for a in static_arms.own_arms() if a.name == "elb6")
    return re.sub(r'(<mass value="([^"]*)"/>)<inertia[^>]*/>',
                  lambda m: '%s<inertia ixx="%.6g" ixy="0" ixz="0" iyy="%.6g" iyz="0" izz="%.6g"/>' % (
                      m[1], *(0.01 * float(m[2]) * k for k in (1.2, 1, 0.7))), arm.urdf())


def urdfs():
    """Names and texts of the four arms."""
    files = {"panda": "data/panda/arm.urdf", "gen3": "data/gen3.urdf", "heron7": "data/demo/arm.urdf"}
    texts = {name: open(os.path.join(ROOT, path)).read() for name, path in files.items()}
    return {**texts, "elb6": industrial()}


class Arm:
    """A nominal arm: its URDF and, as MuJoCo has it, its friction, damping and armature."""

    def __init__(self, urdf):
        self.urdf = urdf
        bare = re.sub(r"<(visual|collision)\b.*?</\1>", "", urdf, flags=re.S)
        compiler = '<mujoco><compiler discardvisual="true" balanceinertia="true"/></mujoco></robot>'
        self.spec = mujoco.MjSpec.from_string(bare.replace("</robot>", compiler))
        self.model = m = self.spec.compile()
        m.opt.timestep, m.opt.gravity = STEP, GRAVITY
        m.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        m.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
        self.n = m.nv
        self.joints = [m.joint(j).name for j in range(self.n)]
        self.links = [m.body(m.jnt_bodyid[j]).name for j in range(self.n)]
        self.limits = np.where(m.jnt_limited[:, None] == 1, m.jnt_range, (-2.8, 2.8))
        self.set_drives()

    def set_drives(self):
        """Friction, damping and armature: usual parts of the torques and inertias of a joint."""
        rng = np.random.default_rng(0)
        m, data, mass = self.model, mujoco.MjData(self.model), np.zeros((self.n, self.n))
        torques, inertia = [], []
        for _ in range(200):
            data.qpos[:] = rng.uniform(*self.limits.T)
            data.qvel[:], data.qacc[:] = rng.uniform(-1, 1, self.n), rng.uniform(-3, 3, self.n)
            mujoco.mj_inverse(m, data)
            mujoco.mj_fullM(m, data, mass)
            torques.append(np.abs(data.qfrc_inverse))
            inertia.append(np.diag(mass).copy())
        self.scale, self.inertia = np.max(torques, axis=0), np.mean(inertia, axis=0)
        m.dof_frictionloss[:] = np.maximum(0.05 * self.scale, 0.2)
        m.dof_damping[:] = np.maximum(0.04 * self.scale, 0.2)
        m.dof_armature[:] = np.maximum(0.3 * self.inertia, 0.02)
        m.dof_solref[:] = (2 * STEP, 1)             # friction as stiff as the step allows
        m.dof_solimp[:, :3] = (0.98, 0.99, 0.001)
        for j, name in enumerate(self.joints):
            joint = self.spec.joint(name)
            joint.frictionloss, joint.armature = m.dof_frictionloss[j], m.dof_armature[j]
            joint.damping = [m.dof_damping[j], 0, 0]
        self.spec.compile()

    def mjcf(self):
        return self.spec.to_xml()

    def built(self, rng, unit=1.0):
        """The arm as it was built: masses within 3 %, centres 3 mm, tensors 10 %, friction 10 %, armature 5 %."""
        m = copy.copy(self.model)

        def factors(part, n):
            return np.exp(part * unit * rng.standard_normal(n))
        for b in m.jnt_bodyid:
            kg, com, tensor = body(m, b)
            set_body(m, b, kg * factors(0.03, 1)[0], com + 0.003 * unit * rng.standard_normal(3),
                     tensor * factors(0.1, 1)[0])
        m.dof_frictionloss *= factors(0.1, self.n)
        m.dof_damping *= factors(0.1, self.n)
        m.dof_armature *= factors(0.05, self.n)
        return m


def body(m, b):
    """Mass, centre and tensor about it of a body, in its frame."""
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, m.body_iquat[b])
    R = R.reshape(3, 3)
    return m.body_mass[b], m.body_ipos[b].copy(), R @ np.diag(m.body_inertia[b]) @ R.T


def set_body(m, b, kg, com, tensor):
    values, axes = np.linalg.eigh(tensor)
    axes[:, 0] *= np.linalg.det(axes)
    m.body_mass[b], m.body_ipos[b], m.body_inertia[b] = kg, com, values
    mujoco.mju_mat2Quat(m.body_iquat[b], axes.ravel())
    mujoco.mj_setConst(m, mujoco.MjData(m))


def add_point(m, b, kg, at):
    """Add a ball of 5 cm radius of gyration to a body."""
    old, com, tensor = body(m, b)
    centre = (old * com + kg * at) / (old + kg)

    def shifted(mass, r):
        return mass * (r @ r * np.eye(3) - np.outer(r, r))
    set_body(m, b, old + kg, centre, tensor + shifted(old, com - centre) + shifted(kg, at - centre)
             + 0.0025 * kg * np.eye(3))
