#!/usr/bin/env python3
"""How many findings on sealed cases are right, and with the class of the hidden effect withheld.

usage: exam.py BINARY CASES... [--jobs 1] [-v]

Each folder of generate.py, or the logs of a tracker in it, is a column of the table.  A mixture holds two effects of the catalogue
that are both detectable.
Base compliance and link bending, one function at the first joint, are withheld together.
Recordings in which a column is of another convention are left out, since they are answered by
naming the column, and so are faults of single sockets, which are no findings.
"""
import argparse
import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import findings  # noqa: E402
from cases import call, share  # noqa: E402
from causes import DETECTABLE  # noqa: E402

LOG = ["--free-base", "--free-tool"]
OTHER_ANSWERS = {"convention", "wrong_socket"}
SAME = {"base_compliance", "link_bending"}      # one function at the first joint
ROWS = {"right": "findings of effects of the catalogue that are right",
        "said": "detectable cases with a finding",
        "exact": "detectable cases with an exact one",
        "accused": "cases without an effect that have a finding",
        "both": "mixtures of which both effects are found",
        "beside": "findings beside a cause outside the catalogue that are right",
        "outside": "findings of causes outside the catalogue that are right",
        "left": "findings that may be left by a larger cause outside the catalogue, and are right",
        "withheld right": "class withheld: findings that are right",
        "withheld said": "class withheld: cases with a finding",
        "withheld name": "class withheld: cases with the name of another effect"}


def judge(label, answer, n, withheld):
    """(row, hit) of all that a case counts for, and the findings that are wrong."""
    out, true, found = [], findings.truths(label, n), answer["findings"]
    right = [findings.right(f, true, n, found) for f in found]
    names = any(f["kind"] == "effect" and not ok for f, ok in zip(found, right))
    wrong = [f for f, ok in zip(found, right) if not ok]
    out += [("left", ok) for f, ok in zip(found, right) if f["beside_unknown"]]
    if withheld:
        return (out + [("withheld right", ok) for ok in right] +
                [("withheld said", bool(found)), ("withheld name", names)], wrong)
    if not true:
        return [("accused", bool(found))], found
    outside = findings.outside(true)
    row = "right" if not outside else "beside" if len(label["effects"]) > 1 else "outside"
    out += [(row, ok) for ok in right]
    if label["detectable"] and not outside:
        out.append(("said", bool(found)))
        out.append(("exact", any(ok and findings.exact(f) for f, ok in zip(found, right))))
        if label["kind"] == "mixture" and DETECTABLE <= (3 * label["postures"]) ** 0.5 * min(
                e["snr"] for e in label["effects"]):
            out.append(("both", all(any(findings.right(f, [t for t in true if t.cause is e], n,
                                                       found)
                                        for f in found) for e in label["effects"])))
    return out, wrong


def tasks(folder):
    """(folder, case, label, withheld class or None) of all questions about a folder."""
    with open(os.path.join(folder, "labels.json")) as f:
        labels = json.load(f)
    for case, label in sorted(labels.items()):
        if label["kind"] in OTHER_ANSWERS:
            continue
        yield folder, case, label, None
        effects = label.get("effects") or []
        name = effects[0]["effect"] if len(effects) == 1 else None
        if label["detectable"] and name in findings.FAMILY and \
                name not in ("tool_motion", "local_fault"):
            yield folder, case, label, ",".join(sorted(SAME)) if name in SAME else name


def main():
    ap = argparse.ArgumentParser(usage=__doc__)
    ap.add_argument("binary")
    ap.add_argument("cases", nargs="+")
    ap.add_argument("--jobs", type=int, default=1)
    ap.add_argument("-v", action="store_true", help="print the findings that are wrong")
    a = ap.parse_args()
    binary = os.path.abspath(a.binary)
    todo = [t for folder in a.cases for t in tasks(folder)]
    counts = {folder: {row: [0, 0] for row in ROWS} for folder in a.cases}

    def one(task):
        folder, case, label, withheld = task
        log = os.path.exists(os.path.join(folder, case, "log.tsv"))
        name = "log.tsv" if log else "session.tsv"
        files = [os.path.join(folder, case, x) for x in ("robot.urdf", name)]
        answer, why = call(binary, files, [name] + LOG * log +
                           (["--without", withheld] if withheld else []))
        if answer is None:
            sys.exit(f"{case}: {why}")
        return judge(label, answer, findings.joints_of(files[1]), bool(withheld))
    with ThreadPoolExecutor(a.jobs) as pool:
        for (folder, case, label, withheld), (rows, wrong) in zip(todo, pool.map(one, todo)):
            for row, hit in rows:
                counts[folder][row][0] += bool(hit)
                counts[folder][row][1] += 1
            for f in wrong if a.v else []:
                print(case, label["kind"], withheld or "", f["kind"],
                      f["effect"] or f["varies_with"], f["from"], f["to"], f["probability"])
    print("| figure | " + " | ".join(map(os.path.basename, a.cases)) + " |")
    print("| --- |" + " --- |" * len(a.cases))
    for row, title in ROWS.items():
        cells = [share(*counts[folder][row]) if counts[folder][row][1] else "" for folder in a.cases]
        print(f"| {title} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
