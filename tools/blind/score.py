#!/usr/bin/env python3
"""Score `mukca diagnose` on sealed cases (generate.py's, or any set of the same form).

usage: score.py MUKCA_BINARY CASES_DIR [--limit N] [--jobs 2] [--kinds A,B] [--without-class]
                [--averaged] [--no-logs] [--keep FILE.json] [-q]

Every case is run in a temporary folder where the labels are not.  Prints a line per case, then the
figures with Wilson 95 % intervals, the calibration table, and where it breaks.  --without-class
instead takes the true effect out of the catalogue of every detectable single-effect case (diagnose
--without EFFECT) and counts what is said in its place.  --averaged gives the program one row per
posture, the mean of its readings.  --keep writes the records, from which results.py makes tables.
"""
import argparse
import collections
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import results  # noqa: E402
from judge import effect_ok, record, right  # noqa: E402


def read_table(path):
    with open(path) as f:
        rows = [line.rstrip("\n").split("\t") for line in f if not line.startswith("#")]
    return rows[0], rows[1:]


def average(path):
    """One row per posture: rows of a socket within 1 mrad of its first reading are averaged."""
    head, rows = read_table(path)
    joints = [i for i, h in enumerate(head) if h.startswith("joint_") and "." not in h]
    groups = []
    for row in rows:
        q = [float(row[i]) for i in joints]
        for first, members in groups:
            if row[:2] == members[0][:2] and max(abs(a - b) for a, b in zip(q, first)) < 1e-3:
                members.append(row)
                break
        else:
            groups.append((q, [row]))
    with open(path, "w") as f:
        f.write("\t".join(head) + "\n")
        for _, m in groups:
            mean = [f"{sum(float(r[i]) for r in m) / len(m):.9f}" for i in range(2, len(head))]
            f.write("\t".join(m[0][:2] + mean) + "\n")


def call(binary, files, arguments, averaged=False, limit=300):
    """Run in a folder of its own; the answer or None, seconds, what went wrong."""
    with tempfile.TemporaryDirectory() as tmp:
        for f in files:
            shutil.copy(f, tmp)
        if averaged:
            average(os.path.join(tmp, "session.tsv"))
        env = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
        start = time.time()
        try:
            p = subprocess.run([binary, "diagnose", "--urdf", "robot.urdf", "--base", "base",
                                "--tip", "ball"] + arguments + ["--json", "-"], cwd=tmp,
                               env=env, capture_output=True, text=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return None, limit, "time out"
        took = time.time() - start
    if p.returncode not in (0, 1):
        return None, took, f"exit {p.returncode}: {p.stderr.strip()[:200]}"
    try:
        return json.loads(p.stdout), took, ""
    except ValueError as x:
        return None, took, f"no JSON: {x} {p.stderr.strip()[-200:]}"


def said(answer):
    return [f"{c.get('effect')}/{c.get('joint') or c.get('placement')}"
            for c in (answer or {}).get("causes", [])][:4]


def score_sessions(a, binary, labels, names, pool):
    """Records of all sessions."""
    files = ("robot.urdf", "session.tsv") + (() if a.without_class else ("holdout.tsv",))

    def one(name):
        more = (["--without", labels[name]["kind"], "session.tsv"] if a.without_class
                else ["session.tsv", "--test", "holdout.tsv"])
        return call(binary, [os.path.join(a.cases, name, x) for x in files],
                    ["--distance", "0.05"] + more, a.averaged)
    out = []
    for name, (answer, took, why) in zip(names, pool.map(one, names)):
        label = labels[name]
        r = record(name, label, answer, took, a.without_class)
        out.append(r)
        if not a.quiet or any(w in r["note"] for w in ("WRONG", "MIS", "ALARM", "FAILED")):
            print(name, label["kind"], [(e["effect"], e.get("joints")) for e in label["effects"]],
                  "->", r["verdict"], said(answer), r["note"], why, f"{took:.2f}s", flush=True)
    return out


def score_logs(folder, binary, labels, pool, quiet):
    """Tracker pose logs: records with figures of their own."""
    names = sorted(labels)

    def one(name):
        return call(binary, [os.path.join(folder, name, x) for x in ("robot.urdf", "log.tsv")],
                    ["--free-base", "--free-tool", "log.tsv"])
    out = []
    for name, (r, took, why) in zip(names, pool.map(one, names)):
        label, kind, flags = labels[name], labels[name]["kind"], {}
        flags["logs: failures"] = r is None
        causes = (r or {}).get("causes") or []
        top = causes[0] if causes else {}
        how = "with commands" if label["command"] else "readings only"
        if r is None:
            ok = False
        elif kind == "none":
            ok = r.get("verdict") == "none"
            flags["logs: false alarms on null"] = not ok
        elif kind == "readback_lag":
            ok = top.get("effect") == kind
            flags["logs: stale read-back first, " + how] = ok
            flags["logs: stale read-back called play of a joint"] = any(
                c.get("effect") in ("backlash", "approach_hysteresis") for c in causes)
        elif label["detectable"]:
            ok = flags["logs: other effects, joint right"] = bool(top) and right(
                top, label["effects"][0])
        else:
            ok = r.get("verdict") != "named" or effect_ok(top, label["effects"][0])
            flags["logs: faint effect misnamed"] = not ok
        out.append(dict(case=name, kind=kind, flags=flags, seconds=took, claims=[]))
        if not quiet or not ok:
            print(name, kind, how, "->", (r or {}).get("verdict"), said(r), "ok" if ok else "WRONG",
                  why, f"{took:.2f}s", flush=True)
    return out


def by_effect(records):
    """Markdown: single effects, each class in a row."""
    table = collections.OrderedDict()
    for r in sorted((r for r in records if r.get("answer")), key=lambda r: r["kind"]):
        table.setdefault(r["kind"], []).append(r)
    if not table:
        return
    print("\n| effect | detectable | class | class and joint | in tie set | unknown | none |\n"
          "| --- | --- | --- | --- | --- | --- | --- |")
    for kind, rs in table.items():
        d = [r for r in rs if r["detectable"]]
        print(f"| {kind} | {len(d)} |", " | ".join(str(sum(r["answer"][i] for r in d))
                                                     for i in range(3)), "|",
              " | ".join(str(sum(r["verdict"] == v for r in d)) for v in ("unknown", "none")), "|")


def by_outside(records):
    kinds = collections.OrderedDict()
    for r in sorted((r for r in records if r.get("class") == "unknown" and r["detectable"]),
                    key=lambda r: r["kind"]):
        kinds.setdefault(r["kind"], collections.Counter())[r["note"].split(" SURE")[0]] += 1
    if kinds:
        print("\nOutside the catalogue, detectable:")
        for kind, notes in kinds.items():
            print(f"  {kind}: " + ", ".join(f"{k} {n}" for k, n in notes.most_common()))


def by_band(records):
    bands = collections.OrderedDict()
    for r in records:
        for group, value in r.get("bands", {}).items():
            hit = bands.setdefault(group, {}).setdefault(value, [0, 0])
            hit[0] += r["answer"][1]
            hit[1] += 1

    def order(v):
        head = v.split("-")[0].strip("> ")
        return (1, int(head), v) if head.isdigit() else (0, 0, v)
    if bands:
        print("\nclass and joint right, detectable single effects, by")
    for group, c in bands.items():
        print(f"  {group}: " + "; ".join(f"{v}: {c[v][0]}/{c[v][1]}" for v in sorted(c, key=order)))


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("binary")
    ap.add_argument("cases")
    ap.add_argument("--limit", type=int, default=0)
    ap.add_argument("--jobs", type=int, default=2)
    ap.add_argument("--kinds")
    ap.add_argument("--without-class", action="store_true")
    ap.add_argument("--averaged", action="store_true")
    ap.add_argument("--no-logs", action="store_true")
    ap.add_argument("--keep")
    ap.add_argument("-q", "--quiet", action="store_true")
    a = ap.parse_args()
    binary, pool = os.path.abspath(a.binary), ThreadPoolExecutor(a.jobs)
    with open(os.path.join(a.cases, "labels.json")) as f:
        labels = json.load(f)
    names = [n for n in sorted(labels) if not a.kinds or labels[n]["kind"] in a.kinds.split(",")]
    if a.without_class:
        names = [n for n in names if labels[n]["detectable"] and len(labels[n]["effects"]) == 1
                 and record(n, labels[n], None, 0)["class"] == "effect"]
    records = score_sessions(a, binary, labels, names[:a.limit or None], pool)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    logs = os.path.join(a.cases, "logs", "labels.json")
    if os.path.exists(logs) and not (a.no_logs or a.kinds or a.without_class):
        with open(logs) as f:
            records += score_logs(os.path.dirname(logs), binary, json.load(f), pool, a.quiet)
    print()
    results.show(records)
    print(f"{'processor seconds per session, mean':60s} "
          f"{(used.ru_utime + used.ru_stime) / max(1, len(names)):.3f}; {a.jobs} at a time")
    print()
    print("\n".join(results.calibration(records)))
    if a.without_class:
        print("\n" + "\n".join(results.withheld(records)))
    else:
        by_effect(records)
        by_outside(records)
        by_band(records)
    if a.keep:
        with open(a.keep, "w") as f:
            json.dump(records, f, indent=0)


if __name__ == "__main__":
    sys.exit(main())
