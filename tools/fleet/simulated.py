#!/usr/bin/env python3
"""Simulated fleets by the independent generator of tools/blind: what mukca fleet finds in them.

usage: simulated.py [--kind null|shared|broken] [--fleets N] [--arms 12] [--seed S] [--jobs 2]

The arms of a fleet have one nominal model; each has its own errors of geometry, postures and noise.
null:   no effect.
shared: one elastic effect whose size differs by 20 % from arm to arm, and ripple of one order with
        its own phase in each arm; neither is strong enough to be named in one arm alone.
broken: the same, and one arm that is several times softer at one joint.
Prints counts, with the share of 95 % intervals that hold the truth.  Exits with 1 where a goal is missed.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "blind"))
import numpy as np  # noqa: E402

import arms  # noqa: E402
import generate  # noqa: E402
from effects import Part, State, displacement, rms, unabsorbed  # noqa: E402

MUKCA = os.environ.get("MUKCA", "build/mukca")
# Visible strength in one arm, standard deviations of all its samples together: what the truth itself would show.
# tools/blind calls 8 certain; a diagnosis names an effect of 5 now and then.
ELASTIC, RIPPLE, BREAK = 3.5, 4.5, 12.0
SCATTER, NOISE, PLACES, ROWS = 0.2, 0.7e-4, 3, 15
ORDERS = (50, 80, 100, 120, 160, 200, 240)
EFFECTS = ("joint_compliance", "link_bending")
NAMED = 0.5  # as the screen lists it


def session(nominal, rng, size):
    """One arm's true geometry, its recording plan and state."""
    true = nominal.perturbed(rng, size, size)
    ses = generate.Session(rng, generate.drawn_places(nominal, rng, PLACES, ROWS, False))
    ses.q, miss = arms.solve(true, ses.q, ses.target)
    if miss.max() > 1e-7 or not generate.fits(true, ses.q, 0).all():
        raise generate.Again
    return true, ses, State(true, ses.q, ses.time, ses.place)


def strength(part, true, ses, st):
    """What one unit of amplitude shows, in standard deviations of noise."""
    seen = rms(unabsorbed(displacement(part, st), true.geometry(st.sweep), ses.group))
    return seen / NOISE * np.sqrt(3 * ses.rows)


def make_fleet(kind, n, seed, folder):
    """Write the sessions of a fleet; returns the truth."""
    for attempt in range(200):
        rng = np.random.default_rng([seed, 13, attempt])
        nominal = arms.own_arms()[rng.integers(5)]
        body = nominal.reweighed(rng, 0.10)  # the model's masses are a little off for all alike
        try:
            all_arms = [session(body, rng, rng.uniform(0.8, 3)) for _ in range(n)]
            truth = {"kind": kind, "arms": [{} for _ in all_arms]}
            parts = [[] for _ in all_arms]
            if kind != "null":
                elastic(rng, all_arms, parts, truth)
                ripple(rng, all_arms, parts, truth)
            if kind == "broken":
                damage(rng, all_arms, parts, truth)
            for i, (true, ses, _) in enumerate(all_arms):
                q, hold = generate.record(true, ses, rng, NOISE, 0.0, "", parts[i])
                os.makedirs(f"{folder}/arm{i:02d}")
                generate.write_table(f"{folder}/arm{i:02d}/session.tsv", true, ses, q, None, False)
            with open(f"{folder}/robot.urdf", "w") as f:
                f.write(nominal.urdf())
            return truth
        except (generate.Again, np.linalg.LinAlgError):
            subprocess.run(["rm", "-rf"] + [f"{folder}/arm{i:02d}" for i in range(n)], check=True)
    raise SystemExit(f"fleet of seed {seed}: no draw worked")


def loaded(all_arms, name, joint):
    unit = [strength(Part(name, [joint]), *a) for a in all_arms]
    return float(np.median(unit))


def elastic(rng, all_arms, parts, truth):
    name, n = str(rng.choice(EFFECTS)), all_arms[0][0].n
    joint = int(rng.integers(1, n - 1))
    unit = loaded(all_arms, name, joint)
    mean = ELASTIC / unit if unit > 0 else np.inf
    if not 2e-6 < mean < 400e-6:  # springs of real gears
        raise generate.Again
    truth.update(effect=name, joint=all_arms[0][0].joints[joint], index=joint, mean=mean)
    for i in range(len(all_arms)):
        own = mean * max(1 + SCATTER * rng.standard_normal(), 0.1)
        truth["arms"][i]["own"] = own
        parts[i].append(Part(name, [joint], amplitude=own))


def ripple(rng, all_arms, parts, truth):
    joint, order = int(rng.integers(0, all_arms[0][0].n - 1)), int(rng.choice(ORDERS))
    unit = float(np.median([strength(Part("gear_harmonic", [joint], order=order, phase=0.3), *a) for a in all_arms]))
    if not RIPPLE / unit < 0.5e-3:
        raise generate.Again
    truth.update(order=order, ripple_joint=all_arms[0][0].joints[joint])
    for i in range(len(all_arms)):
        parts[i].append(Part("gear_harmonic", [joint], amplitude=RIPPLE / unit, order=order,
                             phase=float(rng.uniform(0, 2 * np.pi))))


def damage(rng, all_arms, parts, truth):
    arm, joint = int(rng.integers(len(all_arms))), int(rng.integers(1, all_arms[0][0].n - 1))
    part = Part("joint_compliance", [joint])
    unit = strength(part, *all_arms[arm])
    if not (unit > 0 and BREAK / unit < 500e-6):
        raise generate.Again
    part.amplitude = BREAK / unit
    truth.update(broken=f"arm{arm:02d}", broken_joint=all_arms[0][0].joints[joint])
    parts[arm].append(part)


def run(*words):
    done = subprocess.run([MUKCA, *words], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"mukca {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")


def one(task):
    kind, n, seed = task
    with tempfile.TemporaryDirectory() as folder:
        truth = make_fleet(kind, n, seed, folder)
        summaries = []
        for i in range(n):
            arm = f"{folder}/arm{i:02d}"
            run("diagnose", "-q", "--urdf", f"{folder}/robot.urdf", f"{arm}/session.tsv", "--summary", f"{arm}.json")
            summaries.append(f"{arm}.json")
        run("fleet", "-q", *summaries, "--json", f"{folder}/fleet.json")
        with open(f"{folder}/fleet.json") as f:
            return truth, json.load(f)


def judge(truth, found):
    """What is right and wrong in one fleet."""
    shared = [(e["effect"], e["joint"]) for e in found["effects"]
              if e["effect"] != "gear_harmonic" and e["probability"] >= NAMED]
    orders = [(o["joint"], o["order"]) for o in found["orders"] if o["probability"] >= NAMED]
    departed = [d["arm"] for d in found["departures"]]
    want = (truth.get("effect"), truth.get("joint"))
    result = {"named": want in shared, "others": [s for s in shared if s != want],
              "order": (truth.get("ripple_joint"), truth.get("order")) in orders,
              "other_orders": [o for o in orders if o != (truth.get("ripple_joint"), truth.get("order"))],
              "found": truth.get("broken") in departed,
              "accused": [d for d in departed if d != truth.get("broken")], "mean": None, "own": []}
    for e in found["effects"]:
        if (e["effect"], e["joint"]) == want:
            result["mean"] = e["ci95"][0] <= truth["mean"] <= e["ci95"][1]
    for arm in found["arms"]:
        for e in arm["effects"]:
            if (e["effect"], e["joint"]) == want and arm["arm"] != truth.get("broken"):
                own = truth["arms"][int(arm["arm"][3:])]["own"]
                result["own"].append(e["ci95"][0] <= own <= e["ci95"][1])
    return result


def share(values):
    values = [v for v in values if v is not None]
    return f"{100 * sum(values) / max(len(values), 1):.1f} % of {len(values)}"


def report(kind, results):
    """Print the counts; returns whether the goals are met."""
    n = len(results)
    named, order = sum(r["named"] for r in results), sum(r["order"] for r in results)
    false = sum(bool(r["others"] or r["other_orders"]) for r in results)
    accused = sum(bool(r["accused"]) for r in results)
    met = accused <= 0.02 * n
    print(f"{kind}: {n} fleets")
    if kind != "null":
        print(f"  elastic effect named {named}, ripple's order {order}, another one named {false}")
        print(f"  95 % intervals that hold the truth: mean {share([r['mean'] for r in results])}, "
              f"own coefficient of an arm {share([x for r in results for x in r['own']])}")
        met &= named >= 0.95 * n and order >= 0.95 * n
    else:
        print(f"  something named {false}")
        met &= false <= 0.02 * n
    if kind == "broken":
        found = sum(r["found"] for r in results)
        print(f"  broken arm found {found}")
        met &= found >= 0.9 * n
    print(f"  a sound arm accused {accused}", flush=True)
    return met


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("--kind", action="append", choices=("null", "shared", "broken"))
    ap.add_argument("--fleets", type=int, default=20)
    ap.add_argument("--arms", type=int, default=12)
    ap.add_argument("--seed", type=int, default=1)
    ap.add_argument("--jobs", type=int, default=2)
    ap.add_argument("-v", action="store_true", help="each fleet")
    a = ap.parse_args()
    met = True
    for kind in a.kind or ("null", "shared", "broken"):
        tasks = [(kind, a.arms, 1000 * a.seed + i) for i in range(a.fleets)]
        with ProcessPoolExecutor(a.jobs) as pool:
            done = list(pool.map(one, tasks))
        results = [judge(*d) for d in done]
        for (truth, found), r in zip(done, results):
            if a.v:
                print(json.dumps({k: v for k, v in truth.items() if k != "arms"}), json.dumps(r))
                rows = sorted(found["effects"], key=lambda e: -e["probability"])[:4]
                print("   ", [(e["effect"], e["joint"], e["order"], round(1e6 * e["mean"], 1), round(1e6 * (e["spread"] or 0), 1),
                                round(e["log_bayes_factor"], 1), round(e["probability"], 3)) for e in rows], flush=True)
        met &= report(kind, results)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
