#!/usr/bin/env python3
"""Make sealed cases for `mukca diagnose`: data with one hidden cause each, labels kept apart.

usage: generate.py [--seed S] [--cases N] [--hard X] [--rows N] [--placements N] [--kinds A,B]
                   [--readings once|dwell|rounds|many] [--real DIR] OUT

OUT/case_NNN/{robot.urdf,session.tsv,holdout.tsv} and OUT/labels.json are socket sessions;
OUT/logs/log_NNN/{robot.urdf,log.tsv} and OUT/logs/labels.json are tracker pose logs (a tenth of N
more).  --hard X > 1 divides the strength of every cause by X, takes fewer rows and placements and
puts the masses further off.  A third of the sessions stands at the recorded postures of DIR.
Of the others, one in six is an arm with sliding joints, one in twelve one with a parallel linkage.
A quarter reads each posture 3 to 30 times, dwelling there or in rounds through the list.
"""
import argparse
import functools
import json
import os
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

import arms  # noqa: E402
from causes import (DETECTABLE, ONCE, OTHER, OUTSIDE, SINGLE, believable, choose,  # noqa: E402
                    distance_strength, draw_part, imitators, move_tool)
from effects import Part, State, bender, displacement, rms, unabsorbed  # noqa: E402
from sessions import (Again, Session, drawn_places, fits, record,  # noqa: E402
                      recorded_places, smooth, write_table)

LOGS = (["readback_lag"] * 5 + ["none"] * 2
        + ["joint_compliance", "gear_harmonic", "joint_scale", "approach_hysteresis", "backlash"])


def situation(kind, rng, asked, use_real, stock):
    """Arm and recorded postures to draw from, and how often a posture is read."""
    readings = str(rng.choice(["once", "dwell", "rounds"], p=[0.74, 0.14, 0.12]))
    if asked == "many":
        readings = str(rng.choice(["dwell", "rounds"]))
    elif asked or kind in ONCE:
        readings = "once" if kind in ONCE else asked
    if use_real and kind not in ("convention", "linkage_gear", "bent_rail"):
        arm, folders = stock[rng.choice(len(stock), p=[0.5, 0.3, 0.2])]
        return arm, folders, readings, "serial"
    form = str(rng.choice(["serial", "sliding", "linkage"], p=[0.75, 0.165, 0.085]))
    form = {"convention": "linkage", "linkage_gear": "linkage", "bent_rail": "sliding"}.get(kind, form)
    make = {"serial": arms.own_arms, "sliding": arms.sliding_arms, "linkage": arms.linkage_arms}
    choice = make[form]()
    return choice[rng.integers(len(choice))], None, readings, form


def set_up(kind, rng, hard, stock, use_real, asked):
    """The true arm at its sockets, without any effect: here strength is measured."""
    tough = hard > 1
    places = int(rng.choice([2, 3, 4] if tough else [2, 3, 4, 5, 6],
                            p=[0.35, 0.35, 0.3] if tough else [0.1, 0.3, 0.25, 0.2, 0.15]))
    if kind in ("zero_jump", "ball_shift", "socket_distance"):
        places = max(places, 3)
    nominal, folders, readings, form = situation(kind, rng, asked[2], use_real, stock)
    rows = int(rng.choice([12, 15, 18, 24, 30] if tough else [15, 20, 25, 30, 40]))
    if readings != "once":
        rows = int(rng.choice([6, 8, 12, 16, 20]))
    places, rows = asked[0] or places, asked[1] or rows
    sweep = not folders and bool(rng.random() < 0.4)
    drawn = (recorded_places(nominal, rng, folders, places + 1, rows) if folders
             else drawn_places(nominal, rng, places + 1, rows, sweep))
    size = np.exp(rng.uniform(np.log(0.8), np.log(4.0)))
    size = max(size, 1.5) if tough else size
    true = nominal.perturbed(rng, size, size).reweighed(rng, 0.25 if tough else 0.10)
    ses, held = Session(rng, drawn[:places]), Session(rng, drawn[places:])
    encoder = 0.0
    if readings != "once":
        ses.read_again(rng, readings)
        encoder = float(np.exp(rng.uniform(np.log(1e-5), np.log(1.5e-4))))
    ses.q, miss = arms.solve(true, ses.q, ses.target)
    held.q, miss2 = arms.solve(true, held.q, held.target)
    if max(miss.max(), miss2.max()) > 1e-7 or not fits(true, ses.q, 0).all():
        raise Again
    label = dict(poses="recorded" if folders else "drawn", sweep=sweep, robot=nominal.name,
                 placements=places, per_socket=rows, rows=ses.rows, postures=ses.postures,
                 geometry_mm=size, situation=dict(arm=form, readings=readings, encoder_rad=encoder))
    return nominal, true, ses, held, label


def make_case(kind, rng, hard, stock, use_real, asked):
    """One session: returns everything to write."""
    tough = hard > 1
    nominal, true, ses, held, about = set_up(kind, rng, hard, stock, use_real, asked)
    places, encoder = about["placements"], about["situation"]["encoder_rad"]
    rho = float(rng.uniform(0.2, 0.75 if tough else 0.6)) if rng.random() < 0.4 else 0.0
    rho = 0.0 if kind == "none" else max(rho, 0.3) if kind == "none_correlated" else rho
    heavy = str(rng.choice(["student", "contaminated"])) if kind == "none_heavy" else ""
    st = State(true, ses.q, ses.time, ses.place, posture=ses.posture)
    seating = rng.uniform(0.4e-4, 1.1e-4)
    read = encoder * rms(np.linalg.norm(true.lever(st.sweep) * true.step[:, None], axis=1))
    sigma = float(np.hypot(seating, read / np.sqrt(ses.rows / ses.postures)))    # of a posture
    aim = float(rng.choice([1, 2, 4, 8], p=[0.35, 0.35, 0.2, 0.1])) / hard
    want = True
    if kind in SINGLE and rng.random() < 0.15:
        aim, want = rng.uniform(2, 6) / np.sqrt(3 * ses.postures), False
    parts, labels, move, extra = [], [], None, {}
    detectable = True
    if kind == "convention":
        labels = [dict(effect="joint_coupling", amplitude=true.linkage[0], joints=["joint_3"],
                       joint_index=2, from_index=1)]
    elif kind.startswith("none"):
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
                       visible_rms_m=total * sigma / np.sqrt(3 * ses.postures),
                       snr=total / np.sqrt(3 * ses.postures))]
        detectable = bool(total >= DETECTABLE)
    elif kind in SINGLE or kind in OUTSIDE:
        part, label = choose(kind, true, rng, st, ses, places, aim, sigma, want)
        parts, labels = [part], [label]
        detectable = bool(label["snr"] * np.sqrt(3 * ses.postures) >= DETECTABLE)
    elif kind in ("mixture", "beside"):
        names = [k for k in SINGLE if k not in ("socket_distance", "readback_lag")]
        weight = np.array([SINGLE[k] for k in names], float)
        pair = [str(k) for k in rng.choice(names, 2, p=weight / weight.sum())]
        if kind == "beside":        # the second is in no catalogue
            weight = np.array(list(OUTSIDE.values()), float)
            pair[1] = str(rng.choice(list(OUTSIDE), p=weight / weight.sum()))
        if pair[0] == pair[1] and pair[0] not in ("joint_compliance", "gear_harmonic", "zero_jump"):
            raise Again
        for k in pair:
            part, label = choose(k, true, rng, st, ses, places, aim, sigma)
            parts.append(part)
            labels.append(label)
        together = kind == "mixture" and pair[0] != pair[1] and rng.random() < 0.3
        if together and parts[0].joints and parts[1].joints:
            geometry = true.geometry(st.sweep)      # both in one joint
            part = draw_part(pair[1], true, rng, st, parts[0].joints[0], places)
            seen = rms(unabsorbed(displacement(part, st), geometry, ses.group))
            part.amplitude = min(believable(part, st), aim * sigma / max(seen, 1e-12))
            for of_another in ("left_rms_m", "by_urdf_masses"):
                labels[1].pop(of_another, None)
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
            rest = imitators(parts[i], st)
            other = other[:, :, None] if rest is None else np.dstack([other, rest])
            seen = rms(unabsorbed(mine, geometry, ses.group, other))
            labels[i]["snr"] = abs(parts[i].amplitude) * seen / sigma
            labels[i]["visible_rms_m"] = labels[i]["snr"] * sigma
        seen = [x["snr"] * np.sqrt(3 * ses.postures) >= DETECTABLE for x in labels]
        detectable = bool(any(seen) if kind == "mixture" else all(seen))
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
        bad = np.array([b for b in bad if ses.group[b] == ses.group[b - 1]], dtype=int)
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
    q, hold = record(true, ses, rng, seating, rho, heavy, parts, move, encoder=encoder)
    if kind == "duplicate":
        q[extra["bad"]] = q[extra["bad"] - 1]
        hold[extra["bad"]] = hold[extra["bad"] - 1]
    extra.pop("bad", None)
    qh, hold_h = record(true, held, rng, seating, rho, heavy, parts, session=False)
    if kind == "convention":        # the columns count joint 3 from the horizontal, the URDF does not
        for angles in (q, qh):
            angles[:, 2] -= true.linkage[0] * angles[:, 1]
    timed = kind == "duplicate" or any(
        "tau_s" in p.set or "period_s" in p.set or p.kind == "joint_drift" for p in parts)
    with_time = bool(timed or rng.random() < 0.75)
    effort = bool(rng.random() < 0.5)
    group = ("none" if kind.startswith("none") else "unknown" if kind in OUTSIDE else
             "fault" if kind in ONCE - {"socket_distance"} else kind if kind in OTHER else "effect")
    label = dict(kind="none" if kind == "none_correlated" else kind, ar=rho, tails=heavy,
                 ball_noise_m=seating, noise_m=sigma, detectable=detectable, effects=labels,
                 columns=["t"] * with_time + ["tau"] * effort, **{"class": group}, **about, **extra)
    jitter = [0.1 * rng.standard_normal(h.shape) for h in (hold, hold_h)]
    tables = [(ses, q, hold + jitter[0] if effort else None),
              (held, qh, hold_h + jitter[1] if effort else None)]
    return nominal, tables, with_time, label


def make_log(kind, rng, hard):
    """One tracker log of 300 poses: arm, table (header, rows), label."""
    nominal = arms.own_arms()[rng.integers(5)]
    sigma = rng.uniform(0.3e-4, 1.0e-4)
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
        ses.rows, ses.postures, ses.group = want, want, place
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


@functools.cache
def recorded(folder):
    return arms.recorded(folder)


def job(task):
    """Make and write one case; the seed and the number alone decide what it is."""
    seed, number, kind, hard, out, real, use_real, is_log, size = task
    stock = recorded(real) if use_real else None
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
    ap.add_argument("--readings", choices=("once", "dwell", "rounds", "many"),
                    help="in place of drawn; many: dwell or rounds")
    ap.add_argument("--kinds", help="only these kinds, comma-separated")
    ap.add_argument("--real", default=os.environ.get(
        "MUKCA_REAL_DATA", os.path.join(here, "..", "..", "..", "shared", "real")))
    a = ap.parse_args()
    real = os.path.isdir(a.real)
    if not real:
        print(f"SKIPPED: no recorded postures, {a.real} is absent: all cases drawn",
              file=sys.stderr)
    rng = np.random.default_rng([a.seed, 77])
    weights = {**SINGLE, **OTHER, **OUTSIDE}
    if a.kinds:
        weights = {k: 1 for k in a.kinds.split(",")}
    kinds = deal(weights, a.cases, rng)
    third = np.arange(a.cases) % 3 == 2
    tasks = [(a.seed, i, k, a.hard, a.out, a.real, bool(real and third[i]), False,
              (a.placements, a.rows, a.readings))
             for i, k in enumerate(kinds)]
    if not a.kinds:
        tasks += [(a.seed, i, LOGS[i % len(LOGS)], a.hard, a.out, a.real, False, True,
                   (0, 0, None))
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
