#!/usr/bin/env python3
"""The leading cause of the published robots in another order of the samples, and in each half of them.

Prints a table and exits with 1 where effect or joint of the first cause differ. The data are not part of the project:
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


def first_cause(model, folder):
    placements = sorted(os.path.join(folder, p) for p in os.listdir(folder))
    command = [MUKCA, "diagnose", "-q", "--urdf", f"{DATA}/{model}.urdf", "--inertials",
               f"{DATA}/inertials_{model}.tsv", "--json", "-", *placements]
    answer = subprocess.run(command, capture_output=True, text=True)
    causes = json.loads(answer.stdout)["causes"] if answer.returncode == 0 else []
    return f"{causes[0]['effect']} {causes[0]['joint']}" if causes else "none"


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
    differ = 0
    for robot, model in ROBOTS:
        scratch = tempfile.mkdtemp()
        found = {}
        for number, (name, order) in enumerate(ORDERS.items()):
            copy(robot, f"{scratch}/{number}", order)
            found[name] = first_cause(model, f"{scratch}/{number}")
            print(f"{robot:14} {name:12} {found[name]}")
        shutil.rmtree(scratch)
        differ += len(set(found.values())) > 1
    return 1 if differ else 0


sys.exit(main())
