#!/usr/bin/env python3
"""A fleet of published robots: shared orders of ripple, and each arm's held-out error with the traits of the others.

Prints a table and exits with 1 where a figure is missed.  The data are not part of the project: MUKCA_REAL_DATA or
../shared/real; without them it says so.
"""
import json
import os
import subprocess
import sys
import tempfile

MUKCA = os.environ.get("MUKCA", "build/mukca")
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")
# Held-out errors to reach, mm: with the others' traits, and with nothing else elastic of the arm.  They are those of an
# independent analysis of the same recordings (numpy; panda_1, which shifts in its sockets, was not judged).
ROBOTS = {"panda_1": (None, None), "panda_2_clean": (0.246, 0.257), "panda_3": (0.129, 0.185),
          "panda_4_clean": (0.123, 0.196)}
# orders that the fleet must state without reserve
ORDERS = {("panda_joint1", 240), ("panda_joint2", 240), ("panda_joint3", 240), ("panda_joint4", 240), ("panda_joint6", 160)}
SURE = 0.95


def mukca(*words):
    done = subprocess.run([MUKCA, *words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"mukca {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def diagnose(robot, *words):
    folder = f"{DATA}/{robot}"
    placements = sorted(f"{folder}/{p}" for p in os.listdir(folder) if os.path.isdir(f"{folder}/{p}"))
    return mukca("diagnose", "-q", "--urdf", f"{DATA}/panda.urdf", "--inertials", f"{DATA}/inertials_panda.tsv",
                 *placements, *words)


def main():
    if not os.path.isdir(DATA):
        print(f"SKIPPED verify_fleet: no data in {DATA}")
        return 0
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        summary = {robot: f"{folder}/{robot}.json" for robot in ROBOTS}
        for robot, file in summary.items():
            diagnose(robot, "--summary", file)
        fleet = json.loads(mukca("fleet", *summary.values(), "--json", "-"))
        for o in fleet["orders"]:
            print(f"{o['joint']}: order {o['order']}, probability {o['probability']:.4f}, "
                  f"log Bayes factor {o['log_bayes_factor']:.0f}")
        found = {(o["joint"], o["order"]): o["probability"] for o in fleet["orders"]}
        missed += [f"order {key[1]} of {key[0]}" for key in sorted(ORDERS) if not found.get(key, 0) > SURE]
        print("\nheld-out error, mm     geometry  own causes  traits (wanted)  traits only (wanted)")
        for robot, wanted in ROBOTS.items():
            traits = f"{folder}/{robot}.traits.tsv"
            mukca("fleet", "-q", *(s for r, s in summary.items() if r != robot), "-o", traits)
            error = {}
            for option in ((), ("--traits-only",)):
                d = json.loads(diagnose(robot, "--traits", traits, *option, "--json", "-"))
                error[option] = 1e3 * d["gap"]["explained_m"]
            both = list(error.values())
            print(f"{robot:20}  {1e3 * d['gap']['geometry_m']:9.3f}  {1e3 * d['traits']['without_m']:10.3f}"
                  + "".join(f"  {e:13.3f} ({w or '-'})" for e, w in zip(both, wanted)))
            # wanted figures have three decimals
            missed += [f"{robot}: {e:.4f}, not {w}" for e, w in zip(both, wanted) if w and not e < w + 5e-4]
    print("missed: " + "; ".join(missed) if missed else "all reached")
    return 1 if missed else 0


sys.exit(main())
