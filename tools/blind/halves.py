#!/usr/bin/env python3
"""Diagnose each half of the postures: confident names that the other half does not list.

usage: halves.py MUKCA_BINARY CASES OUT.tsv [--splits 1] [--limit N] [--kinds A,B] [--jobs 2] [CASE...]

CASES holds folders of sealed cases (session.tsv) or of recordings (train.tsv, test.tsv, args.json).  Postures
are split at random; readings of one posture (all joints within 1 mrad of its first) stay together,
and so do the sockets: each half has its share of every socket.  A name counts if it is stated above
0.9 without a tie or an unknown beside it.  OUT gets a line per name that the other half does not list,
or lists at another order (by more than 3 and 2 %).  Of sealed cases the truth is known: a faint cause
can be true and yet be seen in one half only.
"""
import argparse
import collections
import json
import os
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
from judge import plain, true_of  # noqa: E402
from results import share  # noqa: E402

NO_JOINT = {"placement", "socket", "time_s", "temperature_c", "payload_kg", "x_m", "y_m", "z_m",
            "qw", "qx", "qy", "qz"}
OF_DATA = {"tool_motion", "socket_distance", "zero_jump", "ball_shift"}  # not of the arm as such


def read(path):
    with open(path) as f:
        lines = f.read().splitlines()
    rows = [x.split("\t") for x in lines if x and x[0] != "#"]
    return [x for x in lines if x.startswith("#")], rows[0], rows[1:]


def cells(q):
    """A posture's cell of 1 mrad; its neighbours are searched for cells that touch."""
    return tuple(int(v // 1e-3) for v in q[:2])


def postures(head, rows):
    """Row indices by socket and posture."""
    joints = [i for i, h in enumerate(head) if h not in NO_JOINT and "." not in h]
    where = [head.index(c) for c in ("placement", "socket") if c in head]
    out, near = collections.defaultdict(list), collections.defaultdict(list)
    for i, row in enumerate(rows):
        at, q = tuple(row[k] for k in where), [float(row[k]) for k in joints]
        x, y = (cells(q) + (0,))[:2]
        same = (k for dx in (-1, 0, 1) for dy in (-1, 0, 1) for k in near[at, x + dx, y + dy]
                if max(abs(a - b) for a, b in zip(q, k[1])) < 1e-3)
        found = next(same, None)
        if found is None:
            found = (at, tuple(q))
            near[at, x, y].append(found)
        out[found].append(i)
    groups = collections.defaultdict(list)
    for (at, _), members in out.items():
        groups[at].append(members)
    return groups


def split(groups, rng):
    """Two halves of the rows, each in recording order."""
    halves = ([], [])
    for members in groups.values():
        order = rng.sample(members, len(members))
        for k, m in enumerate(order):
            halves[k % 2].extend(m)
    return [sorted(h) for h in halves]


def diagnose(binary, arguments, note, head, rows):
    with tempfile.TemporaryDirectory() as tmp:
        path = os.path.join(tmp, "half.tsv")
        with open(path, "w") as f:
            f.write("\n".join(note + ["\t".join(head)] + ["\t".join(r) for r in rows]) + "\n")
        env = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
        try:
            p = subprocess.run([binary, "diagnose", *arguments, path, "--json", "-"], env=env,
                               capture_output=True, text=True, timeout=300)
            return json.loads(p.stdout)
        except (ValueError, subprocess.TimeoutExpired):
            return None


def name(c):
    return c["effect"], c.get("joint")


def compare(one, other):
    """Per confident name of one half: '', 'ABSENT' or another order in the other half."""
    listed = [x for c in other["causes"] for x in [c] + c.get("ties", [])]
    out = []
    for c in one["causes"]:
        if c["effect"] in OF_DATA or not plain(c) or not (c.get("probability") or 0) > 0.9:
            continue
        same = [x for x in listed if name(x) == name(c)]
        orders = [x["order"] for x in same if x.get("order")]
        verdict = "" if same else "ABSENT"
        if c.get("order") and orders:
            off = min(abs(c["order"] - o) for o in orders)
            if off > max(3, 0.02 * c["order"]):
                verdict = f"ORDER {c['order']} against {orders}"
        out.append((c, verdict))
    return out


def case_halves(binary, folder, splits):
    """All splits of one case: (split, half, answer, names), or None where a half fails."""
    case = os.path.basename(folder)
    args = os.path.join(folder, "args.json")
    if os.path.exists(args):
        with open(args) as f:
            arguments = [x.replace("{dir}", folder) for x in json.load(f)["common"]]
    else:
        arguments = ["--base", "base", "--tip", "ball", "--distance", "0.05"]
    train = os.path.join(folder, "train.tsv")
    if os.path.exists(train):
        note, head, rows = read(train)
        _, other, more = read(os.path.join(folder, "test.tsv"))
        rows += more if other == head else []
    else:
        note, head, rows = read(os.path.join(folder, "session.tsv"))
    groups, out = postures(head, rows), []
    for s in range(splits):
        rng = random.Random(f"{case} {s}")
        answers = [diagnose(binary, ["--urdf", os.path.join(folder, "robot.urdf")] + arguments, note,
                            head, [rows[i] for i in half]) for half in split(groups, rng)]
        if None in answers:
            out.append(None)
            continue
        for k in (0, 1):
            out.append((s, k, answers[k], compare(answers[k], answers[1 - k])))
    return out


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("binary")
    ap.add_argument("cases")
    ap.add_argument("out")
    ap.add_argument("case", nargs="*")
    ap.add_argument("--splits", type=int, default=1)
    ap.add_argument("--limit", type=int, default=0)
    ap.add_argument("--kinds")
    ap.add_argument("--jobs", type=int, default=2)
    a = ap.parse_args()
    labels, path = {}, os.path.join(a.cases, "labels.json")
    if os.path.exists(path):
        with open(path) as f:
            labels = json.load(f)
    names = a.case or sorted(labels) or sorted(
        d for d in os.listdir(a.cases) if os.path.exists(os.path.join(a.cases, d, "robot.urdf")))
    if a.kinds:
        names = [n for n in names if labels[n]["kind"] in a.kinds.split(",")]
    names = names[:a.limit or None]
    binary, root = os.path.abspath(a.binary), os.path.abspath(a.cases)
    by_class, failed = collections.OrderedDict(), 0
    with ThreadPoolExecutor(a.jobs) as pool, open(a.out, "w") as f:
        f.write("case\tsplit\thalf\teffect\tjoint\torder\tprobability\twhat\tverdict\n")
        done = pool.map(lambda n: case_halves(binary, os.path.join(root, n), a.splits), names)
        for case, results in zip(names, done):
            label = labels.get(case, {})
            group = label.get("class", case)
            how = label.get("situation", {}).get("readings", "")
            for got in results:
                if got is None:
                    failed += 1
                    continue
                s, k, answer, compared = got
                for c, what in compared:
                    for key in {"all", f"{group} {how}".strip()}:
                        n = by_class.setdefault(key, collections.Counter())
                        n["names"] += 1
                        n[what.split(" ")[0]] += 1
                        n["true"] += bool(what and true_of(c, label.get("effects", [])))
                    if what:
                        f.write("\t".join([case, str(s), str(k), c["effect"], str(c.get("joint")),
                                           str(c.get("order")), f"{c['probability']:.4f}", what,
                                           answer["verdict"]]) + "\n")
    for key in sorted(by_class, key=lambda k: (k == "all", k)):
        n = by_class[key]
        print(f"{key:30s} confident names not confirmed: {share(n['names'] - n[''], n['names'])}; "
              f"absent {n['ABSENT']}, another order {n['ORDER']}; true all the same {n['true']}")
    print(f"halves that failed: {2 * failed}")


if __name__ == "__main__":
    main()
