"""Effects of the exam: how large they are, and what MuJoCo or numpy does with them.

An effect is a dict: name, joint (index; -1: all), size (in the unit of the catalogue), and what else it
needs (catalogue.py has the names).
"""
import copy

import numpy as np

import arm as arms
from catalogue import PUSHED

DRIVES = {"coulomb": "dof_frictionloss", "viscous": "dof_damping", "armature": "dof_armature"}
FRICTION = ("stribeck", "load_friction", "thermal_friction")       # varying frictionloss


def draw(name, arm, rng, taken):
    """An effect of that name at a joint that has none yet."""
    U, n, m = rng.uniform, arm.n, arm.model
    free = [j for j in range(n) if j not in taken]
    if name == "load_friction":
        free = [j for j in free if 0 < j < 5]                       # those that carry weight
    if name in ("link_mass", "link_centre"):
        free = [j for j in free if 0 < j < n - 1]
    if name == "coupling":
        free = [j for j in free if j < n - 1]
    j, sign, scale = int(rng.choice(free)), rng.choice([-1, 1]), arm.scale
    friction, damping, mass = m.dof_frictionloss[j], m.dof_damping[j], m.body_mass
    total = mass[m.jnt_bodyid].sum()
    e = {"name": name, "joint": j}
    if name == "payload":
        e.update(joint=n - 1, size=U(0.02, 0.08) * total, at=U(-0.08, 0.08, 3).tolist())
    if name == "link_mass":
        e.update(size=U(0.15, 0.5) * mass[m.jnt_bodyid[j]])
    if name == "link_centre":
        at = rng.standard_normal(3)
        e.update(size=U(0.02, 0.06), at=(at / np.linalg.norm(at)).tolist())
    if name == "stribeck":
        e.update(size=friction * U(0.5, 1.5), velocity=U(0.08, 0.25))
    if name == "thermal_friction":
        e.update(size=friction * U(0.6, 1.5), constant=U(10, 40))
    if name == "cogging":
        e.update(size=scale[j] * U(0.03, 0.08), order=int(rng.integers(6, 19)), phase=U(0, 2 * np.pi))
    if name == "torque_gain_all":
        e.update(name="torque_gain", joint=-1, size=sign * U(0.06, 0.2))
    if name == "delay":
        e.update(joint=-1, size=U(0.004, 0.03))
    if name == "spring":
        e.update(size=scale[j] * U(0.05, 0.12), zero=U(-1, 1))
    if name == "hysteresis":
        e.update(size=scale[j] * U(0.03, 0.08), width=U(0.08, 0.3))
    if name == "push":
        e.update(joint=2, size=U(0.1, 0.25), times=U(2, 7, (3, 3)).tolist())
    sizes = {"coulomb": lambda: friction * U(0.5, 2), "viscous": lambda: damping * U(0.7, 2.5),
             "asymmetry": lambda: sign * damping * U(0.5, 1.2), "armature": lambda: m.dof_armature[j] * U(0.5, 2),
             "load_friction": lambda: U(0.03, 0.1), "torque_gain": lambda: sign * U(0.06, 0.2),
             "offset": lambda: sign * scale[j] * U(0.02, 0.06), "drag": lambda: damping * U(0.7, 2),
             "coupling": lambda: sign * damping * U(0.5, 1.5)}
    if "size" not in e:
        e["size"] = sizes[name]()
    e["size"] = float(e["size"])
    return e


def change_model(m, effects):
    """The model with masses, friction, damping and armature of the effects."""
    m = copy.copy(m)
    for e in effects:
        j, b = e["joint"], m.jnt_bodyid[e["joint"]]
        kg, com, tensor = arms.body(m, b)
        if e["name"] in DRIVES:
            getattr(m, DRIVES[e["name"]])[j] += e["size"]
        if e["name"] == "payload":
            arms.add_point(m, b, e["size"], com + e["at"])
        if e["name"] == "link_mass":
            factor = 1 + e["size"] / kg
            arms.set_body(m, b, kg * factor, com, tensor * factor)
        if e["name"] == "link_centre":
            arms.set_body(m, b, kg, com + e["size"] * np.array(e["at"]), tensor)
    return m


def friction(e, base, v, load, clock):
    """Frictionloss of its joint under an effect of FRICTION."""
    if e["name"] == "stribeck":
        return base + e["size"] * np.exp(-(v / e["velocity"]) ** 2)
    if e["name"] == "load_friction":
        return base + e["size"] * np.abs(load)
    return base + e["size"] * np.exp(-clock / e["constant"])


def resist(e, q, v, scale, run, t, play):
    """Torque on all joints against which the drives work; 0 for effects that MuJoCo or the sensors have."""
    out, j, size = np.zeros(len(q)), e["joint"], e["size"]
    name = e["name"]
    if name == "asymmetry":
        out[j] = size * abs(v[j])
    if name == "drag":
        out[j] = size * v[j] * abs(v[j])
    if name == "coupling":
        out[j] = size * v[j + 1]
    if name == "spring":
        out[j] = size * (q[j] - e["zero"])
    if name == "cogging":
        out[j] = size * np.sin(e["order"] * q[j] + e["phase"])
    if name == "hysteresis":
        out[j] = size * play / e["width"]
    if name == "push" and np.any(np.abs(t - np.array(e["times"][run])) < 0.3):
        for k, part in PUSHED.items():
            out[k] = -size * scale[k] * part
    return out
