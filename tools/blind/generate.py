#!/usr/bin/env python3
"""Make sealed cases for `mukca diagnose`: data with one hidden cause each, labels kept apart.

usage: generate.py [--seed S] [--cases N] [--hard X] [--rows N] [--placements N] [--real DIR] OUT

OUT/case_NNN/{robot.urdf,session.tsv,holdout.tsv} and OUT/labels.json are socket sessions;
OUT/logs/log_NNN/{robot.urdf,log.tsv} and OUT/logs/labels.json are tracker pose logs (a tenth of N
more).  --hard X > 1 divides the strength of every cause by X, takes fewer rows and placements and
puts the masses further off.  A third of the sessions stands at the recorded postures of DIR.
"""
import argparse
import json
import os
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

import arms  # noqa: E402
from effects import (Part, State, bender, centred, displacement, rms,  # noqa: E402
                     unabsorbed)

DETECTABLE = 8.0        # smallest snr * sqrt(3 rows) that the truth itself would show with certainty
DISTANCE = 0.05
SINGLE = {"joint_compliance": 14, "link_bending": 10, "base_compliance": 9, "backlash": 10,
          "approach_hysteresis": 10, "joint_scale": 10, "joint_coupling": 10,
          "encoder_eccentricity": 10, "gear_harmonic": 14, "axis_wobble": 10, "joint_drift": 10,
          "readback_lag": 5, "zero_jump": 10, "ball_shift": 8, "socket_distance": 4}
OTHER = {"none": 16, "none_correlated": 14, "none_heavy": 18, "mixture": 28, "local_fault": 10,
         "cable_pull": 10, "thermal_link": 6, "joint_slip": 6, "tool_motion": 10, "tool_creep": 4,
         "wrong_socket": 8, "outlier": 6, "duplicate": 4, "effect_and_motion": 12}
OUTSIDE = ("local_fault", "cable_pull", "thermal_link", "joint_slip")
# largest believable size: rms of the joint's angle error in rad (ball_shift and distance in m)
CAP = {"joint_compliance": 5e-3, "link_bending": 2.5e-3, "base_compliance": 2.5e-3,
       "backlash": 2.5e-3, "approach_hysteresis": 2e-3, "joint_scale": 4e-3,
       "joint_coupling": 4e-3, "encoder_eccentricity": 3.5e-3, "gear_harmonic": 2e-3,
       "axis_wobble": 2.5e-3, "joint_drift": 4e-3, "readback_lag": 2e-3, "zero_jump": 4e-3,
       "ball_shift": 2e-3, "local_fault": 4e-3, "cable_pull": 4e-3, "thermal_link": 4e-3,
       "joint_slip": 5e-3}
SIGNED = {"joint_compliance", "link_bending", "base_compliance", "backlash", "readback_lag",
          "thermal_link", "axis_wobble", "approach_hysteresis"}
LOGS = (["readback_lag"] * 5 + ["none"] * 2
        + ["joint_compliance", "gear_harmonic", "joint_scale", "approach_hysteresis", "backlash"])


class Again(Exception):
    """This draw led nowhere; draw another."""


def fits(arm, q, margin=0.03):
    return np.all((q > arm.limit[:, 0] + margin) & (q < arm.limit[:, 1] - margin), axis=1)


def smooth(rng, rows, n):
    """Unit-variance wandering curves through a few knots, (rows,n)."""
    knots = rng.standard_normal((max(3, rows // 5) + 3, n))
    x = np.linspace(0, len(knots) - 1.001, rows)
    i, f = x.astype(int), (x % 1)[:, None]
    f = f * f * (3 - 2 * f)
    return knots[i] * (1 - f) + knots[i + 1] * f


def drawn_places(arm, rng, places, rows, sweep):
    """Postures around random sockets: list of (start rows of socket 0 and 1, sockets)."""
    out = []
    reach = arm.reach()
    for _ in range(400):
        if len(out) == places:
            return out
        mid, half = arm.limit.mean(axis=1), np.diff(arm.limit, axis=1)[:, 0] / 2
        q = (mid + half * rng.uniform(-0.75, 0.75, arm.n))[None]
        s = arm.sweep(q)
        p = s.ball[0]
        jac = np.cross(s.axis, s.ball[:, None] - s.origin)[0].T
        far = np.linalg.norm(p[:2])
        if not (-0.05 < p[2] < 0.65 * reach and far > 0.25 * reach
                and np.linalg.svd(jac, compute_uv=False)[2] > 0.09 * reach):
            continue
        if any(np.linalg.norm(p - o[1][0]) < 0.18 * reach for o in out):
            continue
        way = rng.standard_normal(3) * (1, 1, 0.3)
        socket = np.array([p, p + DISTANCE * way / np.linalg.norm(way)])
        spread = rng.uniform(0.25, 0.6)
        starts = []
        for k in range(2):
            want = rows * (4 if not sweep else 3)
            walk = smooth(rng, want, arm.n) if sweep else rng.standard_normal((want, arm.n))
            start, miss = arms.solve(arm, q + spread * walk, np.tile(socket[k], (want, 1)),
                                     rounds=25)
            start = start[(miss < 1e-4) & fits(arm, start)]
            if len(start) < rows:
                break
            if sweep:
                first = rng.integers(0, len(start) - rows + 1)
                starts.append(start[first:first + rows])
            else:
                starts.append(start[:rows])
        if len(starts) == 2:
            out.append((starts, socket))
    raise Again


def recorded_places(arm, rng, stock, places, rows):
    """Recorded postures; where a robot has too few placements, others turned about joint 1."""
    order = list(rng.permutation(len(stock)))
    out = []
    for i in range(places):
        both = stock[order[i % len(order)]]
        both = [b[:rows].copy() for b in both]
        if i >= len(order):
            low = arm.limit[0, 0] - min(b[:, 0].min() for b in both)
            high = arm.limit[0, 1] - max(b[:, 0].max() for b in both)
            by = rng.uniform(max(-1.2, low + 0.05), min(1.2, high - 0.05))
            for b in both:
                b[:, 0] += by
        mean = [arm.sweep(b).ball.mean(axis=0) for b in both]
        way = mean[1] - mean[0]
        out.append((both, np.array([mean[0], mean[0] + DISTANCE * way / np.linalg.norm(way)])))
    return out


class Session:
    """Rows of a recording: start angles, placement, socket and time."""

    def __init__(self, rng, places):
        q, place, socket, target, time = [], [], [], [], []
        clock, beat = 0.0, rng.uniform(5, 10)
        for i, (starts, sockets) in enumerate(places):
            for k in range(2):
                q.append(starts[k])
                m = len(starts[k])
                place += [i] * m
                socket += [k] * m
                target.append(np.tile(sockets[k], (m, 1)))
                ticks = clock + np.cumsum(beat * rng.uniform(0.8, 1.2, m))
                time.append(ticks)
                clock = ticks[-1] + (rng.uniform(5, 30) if k == 0 else rng.uniform(60, 400))
        self.q, self.target = np.vstack(q), np.vstack(target)
        self.place, self.socket, self.time = np.array(place), np.array(socket), np.hstack(time)
        self.group = 2 * self.place + self.socket
        self.rows = len(self.q)
        self.sockets = [s for _, s in places]

    def rows_of(self, place, socket):
        return np.where((self.place == place) & (self.socket == socket))[0]


def noise(rng, ses, sigma, rho, heavy):
    """Ball noise (N,3): correlated within a socket when rho, with heavy tails when asked."""
    e = rng.standard_normal((ses.rows, 3))
    if heavy == "student":
        e = rng.standard_t(3, (ses.rows, 3)) / np.sqrt(3.0)
    elif heavy == "contaminated":
        e *= np.where(rng.random(ses.rows) < 0.06, 4.0, 0.8)[:, None]
    if rho:
        for g in np.unique(ses.group):
            ix = np.where(ses.group == g)[0]
            for a, b in zip(ix[:-1], ix[1:]):
                e[b] = rho * e[a] + np.sqrt(1 - rho * rho) * e[b]
    return sigma * e


def draw_part(kind, arm, rng, st, joint, places):
    """A cause of unit amplitude at a joint, with its settings drawn."""
    q = st.q
    span = np.ptp(q, axis=0)
    phase = rng.uniform(0, 2 * np.pi)
    if kind in ("joint_compliance", "backlash"):
        load = np.sqrt((st.hold ** 2).mean(axis=0))
        if load[joint] < 0.03 * load.max():     # an upright axis carries nothing
            raise Again
        which = [joint]
        heavy = [j for j in np.argsort(-load)[:3] if j != joint]
        if rng.random() < 0.35:
            which = sorted(which + [int(heavy[0])])
        return Part(kind, which, threshold=float(rng.choice([0.3, 1.0, 3.0])))
    if kind == "base_compliance":
        return Part(kind)
    if kind == "readback_lag":
        return Part(kind)
    if kind == "joint_coupling":
        near = [k for k in (joint - 1, joint + 1) if 0 <= k < arm.n]
        return Part(kind, [joint], from_index=int(rng.choice(near)))
    if kind == "encoder_eccentricity":
        return Part(kind, [joint], order=1, phase=phase)
    if kind == "gear_harmonic":
        u = rng.random()
        order = (rng.choice([2, 3, 4, 6]) if u < 0.3 else rng.integers(7, 401) if u < 0.5 else
                 rng.choice([50, 80, 100, 101, 120, 128, 160, 200, 202, 240, 256, 320]))
        return Part(kind, [joint], order=int(order), phase=phase)
    if kind == "axis_wobble":
        return Part(kind, [joint], order=int(rng.choice([1, 2])), phase=phase,
                    after=bool(rng.random() < 0.5))
    if kind == "joint_drift":
        return Part(kind, [joint], linear=bool(rng.random() < 0.35),
                    tau_s=float(np.exp(rng.uniform(np.log(250), np.log(3500)))))
    if kind == "zero_jump":
        return Part(kind, [joint], session_only=True, placement=int(rng.integers(places)))
    if kind == "ball_shift":
        way = rng.standard_normal(3)
        return Part(kind, session_only=True, placement=int(rng.integers(places)),
                    direction=way / np.linalg.norm(way))
    if kind == "local_fault":
        if span[joint] < 0.35:
            raise Again
        return Part(kind, [joint], variant=str(rng.choice(["bump", "bump", "step", "kink"])),
                    centre=float(np.quantile(q[:, joint], rng.uniform(0.3, 0.7))),
                    width=float(rng.uniform(0.1, 0.3)))
    if kind == "cable_pull":
        near = [k for k in range(arm.n) if k != joint and abs(k - joint) <= 2 and span[k] > 0.2]
        if not near or span[joint] < 0.2:
            raise Again
        other = int(rng.choice(near))
        return Part(kind, [joint], from_index=other,
                    variant=str(rng.choice(["taut", "saddle", "hump"])),
                    centre=float(np.quantile(q[:, joint], rng.uniform(0.3, 0.7))),
                    width=float(span[joint] * rng.uniform(0.2, 0.4)),
                    centre_from=float(np.quantile(q[:, other], rng.uniform(0.3, 0.7))),
                    width_from=float(span[other] * rng.uniform(0.2, 0.4)))
    if kind == "thermal_link":
        return Part(kind, [joint], tau_s=float(rng.uniform(400, 2500)))
    if kind == "joint_slip":
        first = int(rng.integers(st.rank.size // 5, 4 * st.rank.size // 5))
        return Part(kind, [joint], session_only=True, first_row=first + 1)
    return Part(kind, [joint])


def angle_rms(part, st, about_mean=False):
    """Rms turn of a joint (the one that turns most) or of the base per unit of amplitude."""
    twist, base, _ = part.unit(st)
    if about_mean:
        twist, base = twist - twist.mean(axis=0), base - base.mean(axis=0)
    return max(np.sqrt((twist ** 2).sum(axis=2).mean(axis=0)).max(),
               np.sqrt((base ** 2).sum(axis=1).mean()))


def believable(part, st):
    """Largest amplitude of a cause."""
    top = CAP[part.kind]
    if part.kind == "ball_shift":
        return top
    if part.kind == "thermal_link":
        return top
    size = angle_rms(part, st)
    if size < 1e-12:
        raise Again
    top = min(top / size, {"joint_scale": 6e-3, "joint_coupling": 6e-3}.get(part.kind, 1e9))
    if part.kind == "joint_compliance":         # a small joint is not softer without end
        top = min(top, 5.0 * CAP[part.kind] / np.sqrt((st.hold ** 2).mean(axis=0)).max())
    if part.kind == "gear_harmonic" and part.set["order"] > 6:
        top = min(top, 7e-4, 0.25 / part.set["order"])
    return top


def imitators(part, st):
    """For a cause outside the catalogue: the ball's moves by catalogue effects that are like it."""
    if part.kind not in OUTSIDE:
        return None
    j, near = part.joints[0], [k for k in range(st.arm.n) if abs(k - part.joints[0]) <= 1]
    lever = np.cross(st.sweep.axis, st.sweep.ball[:, None] - st.sweep.origin)
    if part.kind == "thermal_link":
        warm = 1 - np.exp(-st.time / part.set["tau_s"])
        cols = [lever[:, k] * warm[:, None] for k in near]
    elif part.kind == "joint_slip":
        cols = [lever[:, j] * (st.place == p)[:, None] for p in np.unique(st.place)]
    else:
        x = st.q[:, j]
        cols = [lever[:, j] * f[:, None]
                for f in [st.q[:, k] for k in near] + [np.sin(x), np.cos(x)]]
    return np.stack(cols, axis=2)


def choose(kind, arm, rng, st, ses, places, aim, sigma, want=True):
    """Draw a cause of a kind whose visible part can reach the aim; amplitude set; its label."""
    geometry = arm.geometry(st.sweep)
    order = list(rng.permutation(arm.n))
    if kind in ("base_compliance", "readback_lag", "ball_shift"):
        order = order[:1]
    best = None
    for joint in order:
        try:
            part = draw_part(kind, arm, rng, st, int(joint), places)
            top = believable(part, st)
        except Again:
            continue
        move = displacement(part, st)
        extra = imitators(part, st)
        seen = rms(unabsorbed(move, geometry, ses.group, extra))
        if seen < 1e-12:
            continue
        amplitude = min(top, aim * sigma / seen)
        total = amplitude * seen / sigma * np.sqrt(3 * ses.rows)
        if best is None or total > best[0]:
            best = (total, part, amplitude, move, seen)
        if total >= DETECTABLE * 1.05 or not want or rng.random() < 0.12:
            best = (total, part, amplitude, move, seen)
            break
    if best is None:
        raise Again
    total, part, amplitude, move, seen = best
    sign = 1.0 if kind in SIGNED or rng.random() < 0.5 else -1.0
    part.amplitude = sign * amplitude
    label = dict(effect=kind, amplitude=part.amplitude, visible_rms_m=amplitude * seen,
                 full_rms_m=amplitude * rms(move), snr=amplitude * seen / sigma)
    if kind not in ("ball_shift", "thermal_link"):
        label["rms_rad"] = amplitude * angle_rms(part, st, about_mean=True)
    if part.joints:
        label["joints"] = [arm.joints[j] for j in part.joints]
        label["joint_index"] = part.joints[0]
    for key, value in part.set.items():
        label[key] = value.tolist() if isinstance(value, np.ndarray) else value
    return part, label


def move_tool(rng, ses, sigma, hard, creep=False):
    """A socket that moves in mid-recording: shift per row and its label."""
    place, socket = int(rng.integers(len(ses.sockets))), int(rng.integers(2))
    ix = ses.rows_of(place, socket)
    way = rng.standard_normal(3)
    size = sigma * np.exp(rng.uniform(np.log(8), np.log(28))) / np.sqrt(hard)
    shift = size * way / np.linalg.norm(way)
    after = int(rng.integers(4, len(ix) - 3))
    move = np.zeros((ses.rows, 3))
    if creep:
        move[ix] = np.linspace(0, 1, len(ix))[:, None] * shift
        after = 0
    else:
        move[ix[after:]] = shift
    return move, dict(effect="tool_motion", placement=place, socket=socket, after_row=after,
                      creep=creep, shift_m=shift.tolist(), first_row=int(ix[after]) + 1)


def distance_strength(arm, st, ses, which, sigma):
    """Whitened visible part of a 1 m change of the sockets' distance, geometry held by a prior."""
    geometry = arm.geometry(st.sweep)
    mean = lambda c, p, k: c[ses.rows_of(p, k)].mean(axis=0)  # noqa: E731
    rows, right = [], []
    for p, s in enumerate(ses.sockets):
        u = (s[1] - s[0]) / np.linalg.norm(s[1] - s[0])
        rows.append(u @ (mean(geometry, p, 1) - mean(geometry, p, 0)) / 1e-4)
        right.append(1e4 if which is None or which == p else 0.0)
    prior = np.full(geometry.shape[2], 3e-3)
    prior[-3:] = 10e-3
    a = np.vstack([centred(geometry, ses.group).reshape(-1, len(prior)) / sigma, np.array(rows),
                   np.diag(1 / prior)])
    b = np.zeros(len(a))
    b[3 * ses.rows:3 * ses.rows + len(right)] = right
    return np.linalg.norm(b - a @ np.linalg.lstsq(a, b, rcond=None)[0])


def write_table(path, arm, ses, q, effort, with_time):
    names = ["placement", "socket"] + (["time_s"] if with_time else []) + arm.joints
    if effort is not None:
        names += [j + ".effort" for j in arm.joints]
    with open(path, "w") as f:
        f.write("\t".join(names) + "\n")
        for i in range(len(q)):
            row = [f"p{ses.place[i]}", str(ses.socket[i])]
            row += [f"{ses.time[i]:.3f}"] if with_time else []
            row += [f"{v:.9f}" for v in q[i]]
            if effort is not None:
                row += [f"{v:.4f}" for v in effort[i]]
            f.write("\t".join(row) + "\n")


def record(arm, ses, rng, sigma, rho, heavy, parts, move=None, session=True):
    """Encoder angles of a session of the true arm, and the holding torques."""
    target = ses.target + noise(rng, ses, sigma, rho, heavy) + (0 if move is None else move)
    q, miss = arms.solve(arm, ses.q, target, bender(arm, parts, ses.time, ses.place, session))
    if miss.max() > 1e-7 or not np.all(fits(arm, q, 0.0)):
        raise Again
    return q, State(arm, q, ses.time, ses.place).hold


def make_case(kind, rng, hard, stock, use_real, size_asked=(0, 0)):
    """One session: returns everything to write."""
    tough = hard > 1
    places = int(rng.choice([2, 3, 4] if tough else [2, 3, 4, 5, 6],
                            p=[0.35, 0.35, 0.3] if tough else [0.1, 0.3, 0.25, 0.2, 0.15]))
    if kind in ("zero_jump", "ball_shift", "socket_distance"):
        places = max(places, 3)
    rows = int(rng.choice([12, 15, 18, 24, 30] if tough else [15, 20, 25, 30, 40]))
    places, rows = size_asked[0] or places, size_asked[1] or rows
    sweep = bool(rng.random() < 0.4)
    sigma = rng.uniform(0.4e-4, 1.1e-4)
    rho = float(rng.uniform(0.2, 0.75 if tough else 0.6)) if rng.random() < 0.4 else 0.0
    rho = 0.0 if kind == "none" else max(rho, 0.3) if kind == "none_correlated" else rho
    heavy = str(rng.choice(["student", "contaminated"])) if kind == "none_heavy" else ""
    if use_real:
        nominal, folders = stock[rng.choice(len(stock), p=[0.5, 0.3, 0.2])]
        drawn = recorded_places(nominal, rng, folders, places + 1, rows)
    else:
        nominal = arms.own_arms()[rng.integers(5)]
        drawn = drawn_places(nominal, rng, places + 1, rows, sweep)
    size = np.exp(rng.uniform(np.log(0.8), np.log(4.0)))
    size = max(size, 1.5) if tough else size
    true = nominal.perturbed(rng, size, size).reweighed(rng, 0.25 if tough else 0.10)
    ses = Session(rng, drawn[:places])
    held = Session(rng, drawn[places:])
    # the undisturbed arm at its sockets: here strength is measured
    ses.q, miss = arms.solve(true, ses.q, ses.target)
    held.q, miss2 = arms.solve(true, held.q, held.target)
    if max(miss.max(), miss2.max()) > 1e-7 or not (fits(true, ses.q, 0).all()):
        raise Again
    st = State(true, ses.q, ses.time, ses.place)
    aim = float(rng.choice([1, 2, 4, 8], p=[0.35, 0.35, 0.2, 0.1])) / hard
    want = True
    if kind in SINGLE and rng.random() < 0.15:
        aim, want = rng.uniform(2, 6) / np.sqrt(3 * ses.rows), False
    parts, labels, move, extra = [], [], None, {}
    detectable = True
    if kind.startswith("none"):
        detectable = False
    elif kind == "socket_distance":
        which = None if rng.random() < 0.4 else int(rng.integers(places))
        strength = distance_strength(true, st, ses, which, sigma)
        off = min(rng.uniform(9, 25) / np.sqrt(hard) / strength, 2.5e-3) * rng.choice([-1, 1])
        for p, s in enumerate(ses.sockets):
            if which is None or which == p:
                u = (s[1] - s[0]) / np.linalg.norm(s[1] - s[0])
                ses.target[ses.rows_of(p, 1)] += off * u
        total = abs(off) * strength
        labels = [dict(effect=kind, amplitude=off, placement=which, full_rms_m=abs(off),
                       visible_rms_m=total * sigma / np.sqrt(3 * ses.rows),
                       snr=total / np.sqrt(3 * ses.rows))]
        detectable = bool(total >= DETECTABLE)
    elif kind in SINGLE or kind in OUTSIDE:
        part, label = choose(kind, true, rng, st, ses, places, aim, sigma, want)
        parts, labels = [part], [label]
        detectable = bool(label["snr"] * np.sqrt(3 * ses.rows) >= DETECTABLE)
    elif kind == "mixture":
        names = [k for k in SINGLE if k not in ("socket_distance", "readback_lag")]
        weight = np.array([SINGLE[k] for k in names], float)
        pair = [str(k) for k in rng.choice(names, 2, p=weight / weight.sum())]
        if pair[0] == pair[1] and pair[0] not in ("joint_compliance", "gear_harmonic", "zero_jump"):
            raise Again
        for k in pair:
            part, label = choose(k, true, rng, st, ses, places, aim, sigma)
            parts.append(part)
            labels.append(label)
        if rng.random() < 0.3 and parts[0].joints and parts[1].joints and pair[0] != pair[1]:
            geometry = true.geometry(st.sweep)      # both in one joint
            part = draw_part(pair[1], true, rng, st, parts[0].joints[0], places)
            seen = rms(unabsorbed(displacement(part, st), geometry, ses.group))
            part.amplitude = min(believable(part, st), aim * sigma / max(seen, 1e-12))
            labels[1].update(joints=[true.joints[j] for j in part.joints], **part.set)
            labels[1].update(joint_index=part.joints[0], amplitude=part.amplitude,
                             full_rms_m=part.amplitude * rms(displacement(part, st)))
            parts[1] = part
            extra["same_joint"] = True
        if parts[0].joints == parts[1].joints and pair[0] == pair[1]:
            raise Again
        geometry = true.geometry(st.sweep)
        for i in (0, 1):            # each is judged by what the other cannot imitate either
            mine, other = displacement(parts[i], st), displacement(parts[1 - i], st)
            seen = rms(unabsorbed(mine, geometry, ses.group, other[:, :, None]))
            labels[i]["snr"] = abs(parts[i].amplitude) * seen / sigma
            labels[i]["visible_rms_m"] = labels[i]["snr"] * sigma
        detectable = bool(max(x["snr"] for x in labels) * np.sqrt(3 * ses.rows) >= DETECTABLE)
    elif kind in ("tool_motion", "tool_creep"):
        move, label = move_tool(rng, ses, sigma, hard, kind == "tool_creep")
        labels = [label]
    elif kind == "effect_and_motion":
        names = ["joint_compliance", "base_compliance", "link_bending", "gear_harmonic",
                 "joint_scale", "encoder_eccentricity", "approach_hysteresis"]
        part, label = choose(str(rng.choice(names)), true, rng, st, ses, places, aim, sigma)
        move, other = move_tool(rng, ses, sigma, hard)
        parts, labels = [part], [label, other]
    else:                           # wrong_socket, outlier, duplicate
        many = max(2, int(round(ses.rows * rng.uniform(0.01, 0.03))))
        many = {"wrong_socket": many, "outlier": int(rng.integers(1, 4)), "duplicate": 2}[kind]
        bad = np.sort(rng.choice(np.arange(1, ses.rows), many, replace=False))
        bad = np.array([b for b in bad if ses.group[b] == ses.group[b - 1]])
        move = np.zeros((ses.rows, 3))
        for b in bad:
            if kind == "wrong_socket":
                s = ses.sockets[ses.place[b]]
                move[b] = s[1 - ses.socket[b]] - s[ses.socket[b]]
            elif kind == "outlier":
                way = rng.standard_normal(3)
                move[b] = way / np.linalg.norm(way) * rng.uniform(1.5e-3, 8e-3)
        labels = [dict(effect=kind, rows=[int(b) for b in bad])]
        detectable = kind == "wrong_socket"
        extra["bad"] = bad
    q, hold = record(true, ses, rng, sigma, rho, heavy, parts, move)
    if kind == "duplicate":
        q[extra["bad"]] = q[extra["bad"] - 1]
        hold[extra["bad"]] = hold[extra["bad"] - 1]
    extra.pop("bad", None)
    qh, hold_h = record(true, held, rng, sigma, rho, heavy, parts, session=False)
    with_time = bool(any(p.kind in ("joint_drift", "thermal_link") for p in parts)
                     or rng.random() < 0.75)
    effort = bool(rng.random() < 0.5)
    label = dict(kind="none" if kind == "none_correlated" else kind,
                 poses="recorded" if use_real else "drawn", sweep=sweep and not use_real, ar=rho,
                 robot=nominal.name, placements=places, per_socket=rows, rows=ses.rows,
                 ball_noise_m=sigma, geometry_mm=size, tails=heavy, detectable=detectable,
                 effects=labels, columns=["t"] * with_time + ["tau"] * effort, **extra)
    jitter = [0.1 * rng.standard_normal(h.shape) for h in (hold, hold_h)]
    tables = [(ses, q, hold + jitter[0] if effort else None),
              (held, qh, hold_h + jitter[1] if effort else None)]
    return nominal, tables, with_time, label


def make_log(kind, rng, hard):
    """One tracker log of 300 poses: arm, table (header, rows), label."""
    nominal = arms.own_arms()[rng.integers(5)]
    sigma = rng.uniform(0.3e-4, 1.0e-4)
    reach = nominal.reach()
    mid, half = nominal.limit.mean(axis=1), np.diff(nominal.limit, axis=1)[:, 0] / 2
    want, wander = 300, bool(rng.random() < 0.4)
    centre = mid + half * rng.uniform(-0.4, 0.4, nominal.n)
    walk = smooth(rng, 3 * want, nominal.n) if wander else rng.standard_normal((3 * want,
                                                                                  nominal.n))
    q = centre + rng.uniform(0.3, 0.6) * walk
    q = q[fits(nominal, q) & (nominal.sweep(q).ball[:, 2] > 0.0)]
    if len(q) < want:
        raise Again
    q = q[:want]
    size = np.exp(rng.uniform(np.log(0.8), np.log(4.0)))
    true = nominal.perturbed(rng, size, size).reweighed(rng, 0.25 if hard > 1 else 0.10)
    time = np.cumsum(rng.uniform(2, 4, want))
    place = np.zeros(want, int)
    st = State(true, q, time, place)
    parts, labels, detectable = [], [], False
    if kind == "readback_lag":
        part = Part(kind, amplitude=float(rng.uniform(0.5e-3, 2e-3)) / hard)
        parts, detectable = [part], True
        labels = [dict(effect=kind, amplitude=part.amplitude,
                       snr=part.amplitude * rms(displacement(part, st)) / sigma)]
    elif kind != "none":
        ses = Session.__new__(Session)
        ses.rows, ses.group = want, place
        aim = float(rng.choice([1, 2, 4])) / hard
        part, label = choose(kind, true, rng, st, ses, 1, aim, sigma)
        parts, labels = [part], [label]
        detectable = bool(label["snr"] * np.sqrt(3 * want) >= DETECTABLE)
    bend = bender(true, parts, time, place)
    twist, base, shift = bend(q) if bend else (None, None, 0.0)
    tool = rng.normal(0, 0.02, 3)
    s = true.sweep(q, twist, base)
    p = s.ball + shift + s.last @ tool
    near = bool(rng.random() < 0.5)
    frame = arms.turn(rng.normal(0, 0.03, (1, 3)))[0] if near else arms.euler(
        *rng.uniform(-np.pi, np.pi, 3) * (0.2, 0.2, 1))
    p = p @ frame.T + (rng.normal(0, 0.02, 3) if near else rng.uniform(-1, 1, 3))
    p = p + sigma * rng.standard_normal(p.shape)
    full, command = bool(rng.random() < 0.5), bool(rng.random() < 0.5)
    names, cols = list(true.joints), [q]
    if command:         # the arm is where it was told to be; only a stale reading differs from it
        twist = np.zeros_like(st.step) if kind != "readback_lag" else np.einsum(
            "nki,nki->nk", parts[0].unit(st)[0], st.sweep.axis) * parts[0].amplitude
        names += [j + ".command" for j in true.joints]
        cols.append(q + twist + 2e-5 * rng.standard_normal(q.shape))
    names += ["x_m", "y_m", "z_m"]
    cols.append(p)
    if full:
        mount = arms.turn(rng.normal(0, 0.5, (1, 3)))[0]
        attitude = frame @ s.last @ mount @ arms.turn(1.5e-4 * rng.standard_normal((want, 3)))
        names += ["qw", "qx", "qy", "qz"]
        cols.append(arms.quaternion(attitude))
    label = dict(kind=kind, robot=nominal.name, rows=want, ball_noise_m=sigma, wander=wander,
                 full_pose=full, command=command, near_base=near, detectable=detectable,
                 effects=labels)
    return nominal, names, np.hstack(cols), label


def job(task):
    """Make and write one case; the seed and the number alone decide what it is."""
    seed, number, kind, hard, out, real, use_real, is_log, size = task
    stock = arms.recorded(real) if use_real else None
    for attempt in range(60):
        rng = np.random.default_rng([seed, number, int(is_log), attempt])
        try:
            folder = os.path.join(out, "logs" if is_log else "", f"{'log' if is_log else 'case'}"
                                  f"_{number:03d}")
            if is_log:
                arm, names, rows, label = make_log(kind, rng, hard)
                os.makedirs(folder, exist_ok=True)
                with open(os.path.join(folder, "log.tsv"), "w") as f:
                    f.write("\t".join(names) + "\n")
                    for r in rows:
                        f.write("\t".join(f"{v:.9f}" for v in r) + "\n")
            else:
                arm, tables, with_time, label = make_case(kind, rng, hard, stock, use_real,
                                                           size)
                os.makedirs(folder, exist_ok=True)
                for name, (ses, q, effort) in zip(("session", "holdout"), tables):
                    write_table(os.path.join(folder, name + ".tsv"), arm, ses, q, effort, with_time)
            with open(os.path.join(folder, "robot.urdf"), "w") as f:
                f.write(arm.urdf())
            return os.path.basename(folder), label
        except (Again, np.linalg.LinAlgError):
            continue
    raise SystemExit(f"case {number} ({kind}): no draw worked in 60 attempts")


def deal(weights, count, rng):
    """Kinds in proportion to their weights, in random order."""
    names = list(weights)
    exact = np.array([weights[k] for k in names], float) * count / sum(weights.values())
    many = np.floor(exact).astype(int)
    for i in np.argsort(many - exact)[:count - many.sum()]:
        many[i] += 1
    kinds = [k for k, m in zip(names, many) for _ in range(m)]
    return [kinds[i] for i in rng.permutation(len(kinds))]


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("out", nargs="?", default="build/blind")
    ap.add_argument("--seed", type=int, default=1)
    ap.add_argument("--cases", type=int, default=300)
    ap.add_argument("--hard", type=float, default=1.0)
    ap.add_argument("--rows", type=int, default=0, help="per socket, in place of drawn")
    ap.add_argument("--placements", type=int, default=0, help="in place of drawn")
    ap.add_argument("--jobs", type=int, default=2)
    ap.add_argument("--kinds", help="only these kinds, comma-separated")
    ap.add_argument("--real", default=os.environ.get(
        "MUKCA_REAL_DATA", os.path.join(here, "..", "..", "..", "shared", "real")))
    a = ap.parse_args()
    real = os.path.isdir(a.real)
    if not real:
        print(f"SKIPPED: no recorded postures, {a.real} is absent: all cases drawn",
              file=sys.stderr)
    rng = np.random.default_rng([a.seed, 77])
    weights = {**SINGLE, **OTHER}
    if a.kinds:
        weights = {k: 1 for k in a.kinds.split(",")}
    kinds = deal(weights, a.cases, rng)
    third = np.arange(a.cases) % 3 == 2
    tasks = [(a.seed, i, k, a.hard, a.out, a.real, bool(real and third[i]), False,
              (a.placements, a.rows))
             for i, k in enumerate(kinds)]
    if not a.kinds:
        tasks += [(a.seed, i, LOGS[i % len(LOGS)], a.hard, a.out, a.real, False, True,
                   (0, 0))
                  for i in range(a.cases // 10)]
    if os.path.exists(os.path.join(a.out, "labels.json")):
        shutil.rmtree(a.out)
    os.makedirs(os.path.join(a.out, "logs"), exist_ok=True)
    with ProcessPoolExecutor(a.jobs) as pool:
        done = list(pool.map(job, tasks, chunksize=4))
    for name, folder in (("case", a.out), ("log", os.path.join(a.out, "logs"))):
        with open(os.path.join(folder, "labels.json"), "w") as f:
            json.dump({k: v for k, v in done if k.startswith(name)}, f, indent=1)
            f.write("\n")
    strong = sum(v["detectable"] for _, v in done)
    print(f"{a.out}: {len(done)} cases, seed {a.seed}, hard {a.hard:g}, {strong} detectable")


if __name__ == "__main__":
    main()
