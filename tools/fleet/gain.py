#!/usr/bin/env python3
"""What traits are worth, and what wrong ones cost: the table of docs/fleet.md.

usage: gain.py [SEEDS]

Arms of the demo's model with two elastic joints, 20 % apart from arm to arm.  A fleet of eight gives the right traits;
eight arms with other elastic joints give the wrong ones.  Prints the median error on two held-out placements, mm.
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
TRUE, OTHER = (("joint_2", 3e-5), ("joint_4", 6e-5)), (("joint_3", 8e-5), ("joint_6", 2e-4))
SIZES = ((1, 10), (1, 20), (2, 10), (2, 20), (3, 20), (4, 20))


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


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    with tempfile.TemporaryDirectory() as folder:
        right, wrong = make_traits(folder, TRUE, 1000), make_traits(folder, OTHER, 2000)
        print("placements  per socket   without  right traits  wrong traits (used)")
        for placements, rows in SIZES:
            error = {"without": [], "right": [], "wrong": []}
            used = 0
            for seed in range(1, seeds + 1):
                train = simulate(folder, 3000 + seed, TRUE, placements, rows, "--held-out", "2", "--test",
                                 f"{folder}/test.tsv")
                for name, traits in (("right", right), ("wrong", wrong)):
                    d = json.loads(run("diagnose", *ARM, "-q", train, "--test", f"{folder}/test.tsv", "--traits",
                                       traits, "--json", "-"))
                    error[name].append(1e3 * d["test"]["explained_m"])
                    used += name == "wrong" and d["traits"]["used"]
                error["without"].append(1e3 * d["traits"]["test_without_m"])
            print("%10d  %10d  %8.3f  %12.3f  %12.3f (%d of %d)" %
                  (placements, rows, *(statistics.median(error[k]) for k in error), used, seeds), flush=True)


main()
