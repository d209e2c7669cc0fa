#!/usr/bin/env python3
"""make.py CASES SEED FOLDER: sealed cases of arms in motion, simulated by MuJoCo.

Each case is a folder with arm.urdf, drives.xml (the nominal friction, damping and armature) and three runs
(time, angles, efforts); FOLDER/truth.json has what was put in, and its SHA-256 is printed.
"""
import copy
import hashlib
import json
import os
import sys

import mujoco
import numpy as np

import arm as arms
import effects as known
from catalogue import LISTED, UNLISTED

SITUATIONS = ["none", "none", "none", "slow"] + LISTED + UNLISTED + ["double"] * 3 + ["listed_and_unlisted"]
RUNS, SECONDS, RATE = 3, 8.0, 250
FASTEST, SLOW = 1.2, 0.3        # rad/s


def path(rng, arm, fastest):
    """A band-limited path from standstill: a function of time to angles and velocities."""
    n, k = arm.n, np.arange(1, 6)
    w = 2 * np.pi / SECONDS * k * rng.integers(1, 3)
    a, b = rng.standard_normal((2, n, 5))
    t = np.linspace(0, SECONDS, 800)[:, None, None]
    x, dx = ((a * np.sin(w * t) + b * np.cos(w * t)).sum(2), (w * (a * np.cos(w * t) - b * np.sin(w * t))).sum(2))
    half = np.ptp(arm.limits, axis=1) / 2
    size = np.minimum(fastest * rng.uniform(0.7, 1, n) / np.abs(dx).max(0), 0.9 * half / np.abs(x).max(0))
    a, b = a * size[:, None], b * size[:, None]
    middle = arm.limits.mean(1) + rng.uniform(-1, 1, n) * np.minimum(0.95 * half - size * np.abs(x).max(0), 0.6)

    def at(t):
        u = min(t / 1.5, 1.0)
        g, dg = u * u * (3 - 2 * u), 6 * u * (1 - u) / 1.5
        s, c = np.sin(w * t), np.cos(w * t)
        x, dx = a @ s + b @ c, (a * w) @ c - (b * w) @ s
        return middle + g * x, g * dx + dg * x
    return at


def simulate_run(arm, m, effects, at, run):
    """Time, angles and torques of the drives at each step, under computed torque with errors of tracking."""
    d, n = mujoco.MjData(m), arm.n
    d.qpos[:] = at(0)[0]
    mujoco.mj_forward(m, d)
    inertia = arm.inertia + arm.model.dof_armature
    kp, kd = inertia * (2 * np.pi * 5) ** 2, inertia * 4 * np.pi * 5
    base, play, before = m.dof_frictionloss.copy(), 0.0, d.qpos.copy()
    steps = int(SECONDS / arms.STEP)
    q, torque = np.empty((steps, n)), np.empty((steps, n))
    for i in range(steps):
        t = i * arms.STEP
        wanted, speed = at(t)
        drive = d.qfrc_bias + kp * (wanted - d.qpos) + kd * (speed - d.qvel) \
            + 0.5 * np.sign(speed) * arm.model.dof_frictionloss
        against = np.zeros(n)
        for e in effects:
            j = e["joint"]
            if e["name"] in known.FRICTION:
                m.dof_frictionloss[j] = known.friction(e, base[j], d.qvel[j], d.qfrc_bias[j], run * SECONDS + t)
            if e["name"] == "hysteresis":
                play = np.clip(play + d.qpos[j] - before[j], -e["width"], e["width"])
            against += known.resist(e, d.qpos, d.qvel, arm.scale, run, t, play)
        before[:] = q[i] = d.qpos
        torque[i] = drive
        d.qfrc_applied[:] = drive - against
        mujoco.mj_step(m, d)
    m.dof_frictionloss[:] = base
    return np.arange(steps) * arms.STEP, q, torque


def measure(t, q, torque, effects, sensors, rng):
    """Rows of a run: encoder steps, late torques with gain, offset, noise and steps of their own."""
    torque = torque.copy()
    for e in effects:
        joints = slice(None) if e["joint"] < 0 else e["joint"]
        if e["name"] == "delay":
            torque = np.stack([np.interp(t - e["size"], t, column) for column in torque.T], axis=1)
        if e["name"] == "torque_gain":
            torque[:, joints] *= 1 + e["size"]
        if e["name"] == "offset":
            torque[:, joints] += e["size"]
    scale, every = sensors["scale"], round(1 / RATE / arms.STEP)
    t, q, torque = t[::every], q[::every], torque[::every]
    torque = torque + sensors["noise"] * scale * rng.standard_normal(torque.shape)
    return t, np.round(q / sensors["step"]) * sensors["step"], np.round(torque / scale * 1024) * scale / 1024


def relevance(arm, m, e, t, q, torque):
    """Largest root mean square that an effect adds to a joint's torque, as a part of its range.

    On the path of a run without it.
    """
    scale, h = np.ptp(torque, axis=0) / 2, 5
    v = np.gradient(q, t, axis=0)
    acc = np.gradient(v, t, axis=0)
    play, change, datas = 0.0, [], []
    for model in (copy.copy(m), known.change_model(m, [e])):
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        datas.append((model, mujoco.MjData(model)))
    for i in range(h, len(t) - h, 20):
        need = []
        for model, d in datas:
            d.qpos[:], d.qvel[:], d.qacc[:] = q[i], v[i], acc[i]
            mujoco.mj_inverse(model, d)
            need.append(d.qfrc_inverse + model.dof_frictionloss * np.sign(v[i]))
        delta = need[1] - need[0]
        j = e["joint"]
        if e["name"] in known.FRICTION:
            delta[j] += np.sign(v[i, j]) * known.friction(e, 0.0, v[i, j], need[0][j], t[i])
        if e["name"] == "hysteresis":
            play = np.clip(play + q[i, j] - q[i - 20 if i > 20 else 0, j], -e["width"], e["width"])
        delta += known.resist(e, q[i], v[i], arm.scale, 0, t[i], play)
        if e["name"] == "torque_gain":
            delta[slice(None) if j < 0 else j] += (e["size"] * torque[i])[slice(None) if j < 0 else j]
        if e["name"] == "offset":
            delta[j] += e["size"]
        if e["name"] == "delay":
            delta += e["size"] * (torque[i + h] - torque[i - h]) / (t[i + h] - t[i - h])
        change.append(delta)
    return float((np.sqrt(np.mean(np.square(change), axis=0)) / scale).max())


def case(index, seed, models):
    """Arm, rows of the runs, and the truth of a case."""
    rng = np.random.default_rng([seed, index])
    rounds, kind = divmod(index, len(SITUATIONS))       # each situation on another arm in each round
    name, situation = sorted(models)[(index + rounds + seed) % len(models)], SITUATIONS[kind]
    arm = models[name]
    m = arm.built(rng)
    paths = [path(rng, arm, SLOW if situation == "slow" else FASTEST) for _ in range(RUNS)]
    plain = [simulate_run(arm, m, [], at, run) for run, at in enumerate(paths)]
    names = {"none": [], "slow": [], "double": list(rng.choice(LISTED, 2, replace=False)),
             "listed_and_unlisted": [rng.choice(LISTED), rng.choice(UNLISTED)]}.get(situation, [situation])
    effects = []
    for what in names:
        for _ in range(100):        # until it is seen: twice what counts as relevant
            e = known.draw(str(what), arm, rng, [x["joint"] for x in effects])
            e["relevance"] = relevance(arm, m, e, *plain[0])
            if e["relevance"] > 0.015:
                break
        effects.append(e)
    changed = known.change_model(m, effects)
    runs = [simulate_run(arm, changed, effects, at, run) for run, at in enumerate(paths)] if effects else plain
    sensors = {"noise": rng.uniform(0.005, 0.015), "step": 2 * np.pi / 2 ** int(rng.choice([16, 17, 18, 20])),
               "scale": np.ptp(runs[0][2], axis=0) / 2}
    rows = [measure(*run, effects, sensors, rng) for run in runs]
    rows = [(run * SECONDS + t, q, torque) for run, (t, q, torque) in enumerate(rows)]    # one clock
    truth = {"case": index, "situation": situation, "arm": name, "joints": arm.joints, "links": arm.links,
             "effects": effects}
    return arm, rows, truth


def write(folder, arm, rows):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "arm.urdf"), "w") as f:
        f.write(arm.urdf)
    with open(os.path.join(folder, "drives.xml"), "w") as f:
        f.write(arm.mjcf())
    for k, (t, q, torque) in enumerate(rows):
        names = ["time_s", *arm.joints, *(j + ".effort" for j in arm.joints)]
        np.savetxt(os.path.join(folder, "run_%d.tsv" % (k + 1)), np.column_stack([t, q, torque]), "%.9g", "\t",
                   header="\t".join(names), comments="")


def main():
    cases, seed, folder = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    models = {name: arms.Arm(text) for name, text in arms.urdfs().items()}
    truths = []
    for index in range(cases):
        arm, rows, truth = case(index, seed, models)
        write(os.path.join(folder, "case_%03d" % index), arm, rows)
        truths.append(truth)
        print("\r%d of %d" % (index + 1, cases), end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    text = json.dumps(truths, indent=1)
    with open(os.path.join(folder, "truth.json"), "w") as f:
        f.write(text)
    print("truth.json", hashlib.sha256(text.encode()).hexdigest())


if __name__ == "__main__":
    main()
