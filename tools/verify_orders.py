#!/usr/bin/env python3
"""The findings of the published robots in another order of the samples, and in each half of them.

Prints a table and exits with 1 if one agrees with no finding as recorded, nor with what may be one: they have a place
in common, and the effect, or what the error varies with, if both name it. The data are not part of the project:
MUKCA_REAL_DATA or ../shared/real; without them it says so.
"""
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

MUKCA = os.environ.get("MUKCA", "build/mukca")
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")
ROBOTS = [("panda_3", "panda"), ("panda_4", "panda"), ("panda_2_clean", "panda"), ("kuka_14", "iiwa14")]
ORDERS = {
    "as recorded": lambda rows: rows,
    "shuffled": lambda rows: random.Random(3).sample(rows, len(rows)),
    "even rows": lambda rows: rows[0::2],
    "odd rows": lambda rows: rows[1::2],
}


def said(model, folder):
    """Findings, and what may be: effect, what it varies with, place."""
    placements = sorted(os.path.join(folder, p) for p in os.listdir(folder))
    command = [MUKCA, "diagnose", "-q", "--urdf", f"{DATA}/{model}.urdf", "--inertials",
               f"{DATA}/inertials_{model}.tsv", "--json", "-", *placements]
    answer = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    place = ["base", *answer["joints"], "tool"]
    return [[(f["effect"], f["varies_with"], place.index(f["from"]), place.index(f["to"])) for f in answer[key]]
            for key in ("findings", "maybe")]


def may_be_same(a, b):
    both = [x == y for x, y in zip(a[:2], b[:2]) if x and y]
    return a[2] <= b[3] and b[2] <= a[3] and (not both or both[0])


def copy(robot, folder, order):
    for placement in os.listdir(f"{DATA}/{robot}"):
        source = f"{DATA}/{robot}/{placement}"
        if not os.path.isdir(source):
            continue
        os.makedirs(f"{folder}/{placement}")
        for hole in ("hole_0.csv", "hole_1.csv"):
            with open(f"{source}/{hole}") as file:
                rows = file.read().splitlines()
            with open(f"{folder}/{placement}/{hole}", "w") as file:
                file.write("\n".join(order(rows)) + "\n")


def main():
    if not os.path.isdir(DATA):
        print(f"SKIPPED verify_orders: no data in {DATA}")
        return 0
    strange = 0
    for robot, model in ROBOTS:
        scratch = tempfile.mkdtemp()
        whole = []
        for number, (name, order) in enumerate(ORDERS.items()):
            copy(robot, f"{scratch}/{number}", order)
            found, maybe = said(model, f"{scratch}/{number}")
            whole = whole or found + maybe
            other = [f for f in found if not any(may_be_same(f, w) for w in whole)]
            strange += len(other)
            print(f"{robot:14} {name:12} {len(found)} findings, {len(other)} not as recorded", *other)
        shutil.rmtree(scratch)
    return 1 if strange else 0


sys.exit(main())
