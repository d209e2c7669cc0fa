#!/usr/bin/env python3
"""What traits are worth, and what wrong ones cost: the table of docs/fleet.md.

usage: gain.py [SEEDS]

Arms of the demo's model with two elastic joints, 20 % apart from arm to arm.  A fleet of eight gives the right traits;
eight arms with other elastic joints, and eight with the same joints twice as soft, give wrong ones.  Prints the median
error on two held-out placements, mm, and how many samples it takes without traits to reach the error with them.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

import random

MUKCA = os.environ.get("MUKCA", "build/mukca")
ARM = ("--urdf", "data/demo/arm.urdf")
TRUE = (("joint_2", 3e-5), ("joint_4", 6e-5))
FLEETS = {"right": TRUE, "other": (("joint_3", 8e-5), ("joint_6", 2e-4)), "twice": (("joint_2", 6e-5), ("joint_4", 1.2e-4))}
SIZES = ((1, 10), (1, 15), (1, 20), (1, 30), (1, 40), (2, 10), (2, 20), (3, 20))
COLUMNS = ("without", *FLEETS)


def run(*words):
    done = subprocess.run([MUKCA, *words], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"mukca {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def simulate(folder, seed, effects, placements, rows, *words):
    rng = random.Random(seed)
    options = []
    for joint, mean in effects:
        options += ["--effect", f"joint_compliance:{joint}={mean * max(1 + 0.2 * rng.gauss(0, 1), 0.2):.4g}"]
    run("simulate", *ARM, "-q", "--seed", str(seed), "--perturb", "1,2", "--noise", "1e-4", "--placements",
        str(placements), "--rows", str(rows), *options, "-o", f"{folder}/train.tsv", "--force", *words)
    return f"{folder}/train.tsv"


def make_traits(folder, effects, seed):
    files = []
    for arm in range(8):
        train = simulate(folder, seed + arm, effects, 4, 20)
        files.append(f"{folder}/{arm}.json")
        run("diagnose", *ARM, "-q", train, "--arm", str(arm), "--summary", files[-1], "--force")
    run("fleet", "-q", *files, "-o", f"{folder}/{seed}.tsv", "--force")
    return f"{folder}/{seed}.tsv"


def errors(train, test, traits):
    """Held-out error of calibrate and of diagnose, without traits and with each file, mm."""
    data = (*ARM, "-q", train, "--test", test, "--json", "-")
    error = {"calibrate": {}, "diagnose": {}}
    for name in COLUMNS:
        words = ("--traits", traits[name]) if name != "without" else ()
        score = json.loads(run("calibrate", *data, *words))["test"]
        error["calibrate"][name] = 1e3 * sum(p["rows"] * p["mae_m"] for p in score) / sum(p["rows"] for p in score)
        error["diagnose"][name] = 1e3 * json.loads(run("diagnose", *data, *words))["test"]["explained_m"]
    return error


def needed(error, without):
    """Samples per socket without traits for that error: `without` has (samples, error), by interpolation."""
    for (n, e), (m, f) in zip(without, without[1:]):
        if f <= error <= e:
            return "%.0f" % (n + (m - n) * (e - error) / (e - f))
    return "more than %d" % without[-1][0] if error < without[-1][1] else "fewer than %d" % without[0][0]


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    median = {}
    with tempfile.TemporaryDirectory() as folder:
        traits = {name: make_traits(folder, effects, 1000 * (i + 1)) for i, (name, effects) in enumerate(FLEETS.items())}
        print("placements  per socket  " + "   ".join(f"{c}: " + " ".join("%8s" % n for n in COLUMNS)
                                                       for c in ("calibrate", "diagnose")))
        for placements, rows in SIZES:
            found = []
            for seed in range(1, seeds + 1):
                train = simulate(folder, 3000 + seed, TRUE, placements, rows, "--held-out", "2", "--test",
                                 f"{folder}/test.tsv")
                found.append(errors(train, f"{folder}/test.tsv", traits))
            for command in found[0]:
                for name in COLUMNS:
                    median[command, name, placements, rows] = statistics.median(f[command][name] for f in found)
            print("%10d  %10d  " % (placements, rows) + "   ".join(
                " " * (len(c) + 2) + " ".join("%8.3f" % median[c, n, placements, rows] for n in COLUMNS)
                for c in found[0]), flush=True)
    for command in ("calibrate", "diagnose"):
        without = [(r, median[command, "without", p, r]) for p, r in SIZES if p == 1]
        print(f"{command}, one placement, samples per socket without traits for the error with them: " + ", ".join(
            f"{r}: {needed(median[command, 'right', 1, r], without)}" for p, r in SIZES if p == 1))


main()
