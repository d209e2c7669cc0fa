#!/usr/bin/env python3
"""Make single-effect cases harder rung by rung, to find where `mukca diagnose` breaks.

usage: ladder.py MUKCA_BINARY OUT [--cases 150] [--seed 21] [--jobs 2]

Prints Markdown: what became of the detectable cases of each rung; of all cases by strength, rows and
placements; of strength against the program's own detection limit; what was taken for what.
"""
import argparse
import collections
import json
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import generate  # noqa: E402
from score import SURE, alias, call, effect_ok, right  # noqa: E402

OUTCOMES = ("right", "right class", "tied, truth inside", "declared alias", "none", "unknown",
            "wrong, tied", "WRONG")
# strength divided by, rows per socket, placements (0: as drawn)
RUNGS = [(1, 0, 0), (2, 0, 0), (3, 0, 0), (5, 0, 0), (8, 0, 0), (12, 0, 0),
         (2, 8, 0), (2, 6, 0), (2, 0, 2), (2, 0, 1)]
FAINT, PLAIN = 4, 16    # snr*sqrt(3 rows) between which rows, placements and kinds are compared


def outcome(answer, truth):
    """What was said of a single true effect."""
    causes = answer.get("causes", [])
    if not causes:
        return "none" if answer.get("verdict") in ("none", "untestable") else "unknown"
    named = [causes[0]] + causes[0].get("ties", [])
    if right(causes[0], truth):
        return "right"
    if any(right(c, truth) for c in named):
        return "tied, truth inside"
    if effect_ok(causes[0], truth):
        return "right class"
    if any(alias(c, truth) for c in named):
        return "declared alias"
    if answer.get("unexplained"):
        return "unknown"
    return "wrong, tied" if answer.get("verdict") == "tied" else "WRONG"


def limit_of(answer, truth):
    """The least rms angle that the program says it would see of the true effect."""
    at = [t.get("detection_limit") for t in answer.get("tested", [])
          if t.get("effect") == truth["effect"] and t.get("joint") in (truth.get("joints") or [None])]
    at = [x for x in at if x]
    return min(at) if at else None


def band(value, edges):
    low = max((e for e in edges if value >= e), default=None)
    high = min((e for e in edges if value < e), default=None)
    return f"< {high:g}" if low is None else f">= {low:g}" if high is None else f"{low:g}-{high:g}"


class Table:
    """Outcomes by group, in order of the groups' keys."""

    def __init__(self, title):
        self.title, self.rows = title, collections.defaultdict(collections.Counter)

    def add(self, key, what):
        self.rows[key][what] += 1

    def show(self):
        used = [o for o in OUTCOMES if any(c[o] for c in self.rows.values())]
        print(f"\n| {self.title} | n | {' | '.join(used)} | right or tied |")
        print("| --- |" + " --- |" * (len(used) + 2))

        def order(key):
            text = str(key).lstrip("<>= ").split("-")[0].split(",")[0]
            number = float(text) if text.replace(".", "").isdigit() else 0.0
            return (number - ("<" in str(key)), ">" in str(key), str(key))
        for key in sorted(self.rows, key=order):
            c = self.rows[key]
            n = sum(c.values())
            good = 100 * (c["right"] + c["tied, truth inside"]) / n
            print(f"| {key} | {n} | {' | '.join(str(c[o]) for o in used)} | {good:.0f} % |")


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("binary")
    ap.add_argument("out")
    ap.add_argument("--cases", type=int, default=150)
    ap.add_argument("--seed", type=int, default=21, help="of the first rung")
    ap.add_argument("--jobs", type=int, default=2)
    a = ap.parse_args()
    binary = os.path.abspath(a.binary)
    here = os.path.dirname(os.path.abspath(__file__))
    tables = {key: Table(title) for key, title in (
        ("all", "strength divided by, all cases"), ("hard", "strength divided by, detectable cases"),
        ("strength", "snr·√(3·rows), all cases"), ("rows", "rows per socket, faint to plain"),
        ("placements", "placements, faint to plain"), ("effect", "effect, faint to plain"),
        ("limit", "rms angle over the program's own limit"))}
    confused, pool = collections.Counter(), ThreadPoolExecutor(a.jobs)
    for rung, (hard, rows, placements) in enumerate(RUNGS):
        few = f", {rows} rows" * (rows > 0) + f", {placements} placements" * (placements > 0)
        folder = os.path.join(a.out, f"hard_{hard}_{rows}_{placements}")
        kinds = [k for k in generate.SINGLE
                 if not 0 < placements < 3 or k not in ("zero_jump", "ball_shift", "socket_distance")]
        if not os.path.exists(os.path.join(folder, "labels.json")):
            subprocess.run([sys.executable, "-B", os.path.join(here, "generate.py"), "--seed",
                            str(a.seed + rung), "--cases", str(a.cases), "--hard", str(hard), "--rows",
                            str(rows), "--placements", str(placements), "--jobs", str(a.jobs),
                            "--kinds", ",".join(kinds), folder], check=True,
                           stdout=subprocess.DEVNULL)
        with open(os.path.join(folder, "labels.json")) as f:
            labels = json.load(f)

        def one(name):
            at = os.path.join(folder, name)
            return call(binary, [os.path.join(at, x) for x in ("robot.urdf", "session.tsv")],
                        ["--distance", "0.05", "session.tsv"])
        for name, (answer, _, why) in zip(sorted(labels), pool.map(one, sorted(labels))):
            label = labels[name]
            truth = label["effects"][0]
            if answer is None:
                print(f"hard {hard}{few} {name}: FAILED {why}", file=sys.stderr)
                continue
            what = outcome(answer, truth)
            strength = truth["snr"] * math.sqrt(3 * label["rows"])
            tables["strength"].add(band(strength, (2, 4, 6, 8, 10, 12, 16, 24)), what)
            limit = limit_of(answer, truth)
            if limit and truth.get("rms_rad"):
                tables["limit"].add(band(truth["rms_rad"] / limit, (0.5, 0.8, 1, 1.25, 2)), what)
            tables["all"].add(f"{hard}{few}", what)
            if strength >= SURE:
                tables["hard"].add(f"{hard}{few}", what)
            if FAINT <= strength < PLAIN:
                tables["rows"].add(label["per_socket"], what)
                tables["placements"].add(label["placements"], what)
                tables["effect"].add(truth["effect"], what)
            if strength >= FAINT:
                if what in ("WRONG", "wrong, tied", "declared alias", "right class"):
                    said = answer["causes"][0]
                    where = ("" if (said.get("joint") in truth.get("joints", []))
                             or not said.get("joint") else " of another joint")
                    confused[f"{truth['effect']} -> {said['effect']}{where}"] += 1
                elif what in ("none", "unknown"):
                    confused[f"{truth['effect']} -> {what}"] += 1
    for table in tables.values():
        table.show()
    print(f"\nMissed, snr·√(3·rows) of {FAINT} or more: " + "; ".join(f"{k} {n}" for k, n in confused.most_common()))


if __name__ == "__main__":
    main()
