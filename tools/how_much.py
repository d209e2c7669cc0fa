#!/usr/bin/env python3
"""How much data is enough: the table of docs/guide.md.

    tools/how_much.py [SEEDS]

Simulates the demo arm with other origins, 0.1 mm of noise per axis and one elastic joint. Calibrates
and diagnoses it, and tests both on two placements that took no part. Prints medians over the seeds.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

MUKCA = os.environ.get("MUKCA", "build/mukca")
ARM = "data/demo/arm.urdf"
TRUTH = ("joint_compliance", "joint_4")
PLACEMENTS, ROWS = (1, 2, 3, 4, 6), (10, 20, 40)


def run(*words):
    done = subprocess.run([MUKCA, *words], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"mukca {' '.join(words)}: exit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def one(placements, rows, seed, folder):
    train, test = os.path.join(folder, "train.tsv"), os.path.join(folder, "test.tsv")
    run("simulate", "--urdf", ARM, "--seed", str(seed), "--perturb", "2,3", "--noise", "1e-4",
        "--effect", "%s:%s=5e-5" % TRUTH, "--placements", str(placements), "--rows", str(rows),
        "--held-out", "2", "-o", train, "--test", test, "--force", "-q")
    data = ("--urdf", ARM, train, "--test", test, "--json", "-", "-q")
    calibration, diagnosis = json.loads(run("calibrate", *data)), json.loads(run("diagnose", *data))
    total = sum(p["rows"] for p in calibration["test"])
    geometry = sum(p["rows"] * p["mae_m"] for p in calibration["test"]) / total
    names = [(c["effect"], c["joint"]) for c in diagnosis["causes"]]
    ties = [(t["effect"], t["joint"]) for c in diagnosis["causes"] for t in c["ties"] or []]
    verdict = "named" if TRUTH in names and diagnosis["verdict"] == "named" else \
        "tied" if TRUTH in names + ties else "missed" if not names else "wrong"
    return geometry, diagnosis["test"]["geometry_m"], diagnosis["test"]["explained_m"], verdict


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    print("placements  per socket   calibrate  diagnose_geometry  diagnose_causes  "
          "named  tied  missed  wrong")
    with tempfile.TemporaryDirectory() as folder:
        for placements in PLACEMENTS:
            for rows in ROWS:
                results = [one(placements, rows, 1 + s, folder) for s in range(seeds)]
                errors = [1e3 * statistics.median(r[i] for r in results) for i in range(3)]
                verdicts = [sum(r[3] == v for r in results)
                            for v in ("named", "tied", "missed", "wrong")]
                print("%10d  %11d  %9.3f  %17.3f  %15.3f  %5d  %4d  %6d  %5d" %
                      (placements, rows, *errors, *verdicts), flush=True)


main()
