#!/usr/bin/env python3
"""How often the 95 % intervals of sizes cover the truth of simulated arms with one hidden effect.

usage: sizes.py BINARY CASES [--seed S --number N] [--jobs 1] [--kinds A,B] [--keep FILE.json]

CASES is made by generate.py if it is absent.  Of each right finding two statements are judged: its
rms displacement of the tip that a calibration leaves (size_ci95_m), and its coefficient at one
joint.  Two joints that hide one effect each have their own displacement.  A coefficient is
judged for the effects whose amplitude means the same to generator and program: a drift has another
time constant, a lag a length.  The masses of the arm as built are 10 % off: a compliance in the
physical sense differs from that which goes with the URDF's masses; both are judged.  A distance of
the sockets displaces no tip (its size is that of what the geometry does about it) and is left out.
"""
import argparse
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import findings  # noqa: E402
from cases import call, share  # noqa: E402
from causes import SINGLE  # noqa: E402

LINEAR = {"joint_compliance", "link_bending", "base_compliance", "joint_scale", "joint_coupling",
          "approach_hysteresis", "backlash", "zero_jump"}


def size_of(cause, finding, n):
    """True rms displacement in m of what a finding holds of a cause."""
    low, high = (findings.position(finding[k], n) for k in ("from", "to"))
    whole, *own = cause["left_rms_m"]
    at = [int(j.rsplit("_", 1)[1]) - 1 for j in cause.get("joints") or []]
    inside = [s for s, j in zip(own, at) if low <= j <= high]
    return 3 ** 0.5 * (sum(inside) if len(inside) < len(own) else whole)


def factor_at(cause, at):
    """by_urdf_masses of the joint at a position."""
    joints = [int(j.rsplit("_", 1)[1]) - 1 for j in cause.get("joints") or []]
    return cause["by_urdf_masses"][joints.index(at) if at in joints else 0]


def judge(label, answer, n):
    """[statement, effect, kind of finding, truth, value, low, high] of each right finding."""
    out, cause = [], label["effects"][0]
    true = findings.truths(label, n)
    for f in answer["findings"]:
        if not findings.right(f, true, n, answer["findings"]):
            continue
        row = [cause["effect"], f["kind"]]
        if cause["effect"] != "socket_distance":
            out.append(["size"] + row + [size_of(cause, f, n), f["size_m"], *f["size_ci95_m"]])
        c = f["coefficient"]
        if c and cause["effect"] in LINEAR and f["kind"] == "effect" and f["from"] == f["to"]:
            # the sign is a convention of the two programs
            value, (low, high) = c["value"], c["ci95"]
            if value < 0:
                value, low, high = -value, -high, -low
            physical = abs(cause["amplitude"])
            out.append(["coefficient"] + row + [physical, value, low, high])
            if "by_urdf_masses" in cause:
                factor = factor_at(cause, findings.position(f["from"], n))
                out.append(["of its masses"] + row + [physical * factor, value, low, high])
    return out


def table(rows, name):
    """Markdown lines: coverage of a statement by effect."""
    out = [f"| {name} | intervals | cover | too small | too large | ratio to the truth, median "
           "| half width over value, median |", "| --- " * 7 + "|"]
    for effect in sorted({r[1] for r in rows}) + ["all"]:
        mine = [r for r in rows if effect in (r[1], "all")]
        low = sum(r[6] < r[3] for r in mine)
        high = sum(r[5] > r[3] for r in mine)
        ratio = sorted(r[4] / r[3] for r in mine)
        width = sorted((r[6] - r[5]) / 2 / max(abs(r[4]), 1e-12) for r in mine)
        out.append(f"| {effect} | {len(mine)} | {share(len(mine) - low - high, len(mine))} | {low} "
                   f"| {high} | {ratio[len(ratio) // 2]:.3f} | {width[len(width) // 2]:.3f} |")
    return out


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("binary")
    ap.add_argument("cases")
    ap.add_argument("--seed", type=int, default=31)
    ap.add_argument("--number", type=int, default=435)
    ap.add_argument("--kinds", default=",".join(k for k in SINGLE if k != "socket_distance"))
    ap.add_argument("--jobs", type=int, default=1)
    ap.add_argument("--keep")
    ap.add_argument("--replay")
    a = ap.parse_args()
    path = os.path.join(a.cases, "labels.json")
    if not os.path.exists(path):
        here = os.path.dirname(os.path.abspath(__file__))
        subprocess.run([sys.executable, os.path.join(here, "generate.py"), "--seed", str(a.seed),
                        "--cases", str(a.number), "--jobs", str(a.jobs), "--kinds", a.kinds,
                        a.cases], check=True)
    with open(path) as f:
        labels = json.load(f)
    binary, rows = os.path.abspath(a.binary), {}
    names = sorted(labels)

    def one(name):
        files = [os.path.join(a.cases, name, x) for x in ("robot.urdf", "session.tsv")]
        answer, why = call(binary, files, ["session.tsv"])
        if answer is None:
            print(name, why, file=sys.stderr)
            return []
        return judge(labels[name], answer, findings.joints_of(files[1]))
    if a.replay:
        with open(a.replay) as f:
            rows = json.load(f)
    else:
        with ThreadPoolExecutor(a.jobs) as pool:
            rows = dict(zip(names, pool.map(one, names)))
    if a.keep:
        with open(a.keep, "w") as f:
            json.dump(rows, f)
    every = [r for name in names for r in rows[name]]
    print(f"{len(names)} arms, {sum(bool(rows[n]) for n in names)} with a right finding")
    for statement, title in (("size", "size at the tip"), ("coefficient", "coefficient"),
                             ("of its masses", "the same by the URDF's masses")):
        print("\n" + "\n".join(table([r for r in every if r[0] == statement], title)))


if __name__ == "__main__":
    main()
