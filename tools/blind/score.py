#!/usr/bin/env python3
"""Score `mukca diagnose` on sealed cases (generate.py's, or any set of the same form).

usage: score.py MUKCA_BINARY CASES_DIR [--out DIR] [--limit N] [--jobs 2] [--kinds A,B]
                [--without-class] [--no-logs] [-q]

Every case is run in a temporary folder where the labels are not.  Prints a line per case, then the
figures with Wilson 95 % intervals, then where it breaks.  --without-class instead takes the true
effect out of the catalogue of every detectable single-effect case (diagnose --without EFFECT) and
counts what is said in its place.
"""
import argparse
import collections
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

NOISE_LENGTH = 1.5958       # mean length of a normal vector in space, unit deviation per axis
SURE = 8.0                  # snr * sqrt(3 rows) from which an effect ought to be found
OUTSIDE_FUNCTION = {"local_fault", "cable_pull"}    # a function of joint angles nobody knows
OUTSIDE_NEAR = {"joint_slip": ("zero_jump", "joint_drift"), "thermal_link": ()}
OUTSIDE = OUTSIDE_FUNCTION | set(OUTSIDE_NEAR)
FAULTS = {"tool_motion", "tool_creep", "wrong_socket", "outlier", "duplicate",
          "effect_and_motion"}


def wilson(hits, n):
    """95 % interval of a share."""
    if not n:
        return 0.0, 1.0
    z, p = 1.959964, hits / n
    mid, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, (mid - half) / (1 + z * z / n)), min(1.0, (mid + half) / (1 + z * z / n))


def share(hits, n):
    if not n:
        return "-"
    low, high = wilson(hits, n)
    return f"{hits}/{n} = {100 * hits / n:.1f} % [{100 * low:.1f}, {100 * high:.1f}]"


def effect_ok(cause, truth):
    """Right effect; a tilting base and bending at joint 1 count as one thing."""
    said, true = cause.get("effect"), truth["effect"]
    if said == true:
        return True
    if true == "base_compliance":
        return said == "link_bending" and cause.get("joint") == "joint_1"
    if true == "link_bending" and truth.get("joints") == ["joint_1"]:
        return said == "base_compliance"
    return False


def right(cause, truth):
    """Right effect in the right joint (or placement, for what belongs to one)."""
    if not effect_ok(cause, truth):
        return False
    if truth["effect"] == "ball_shift":
        return cause.get("placement") in (None, f"p{truth['placement']}")
    if not truth.get("joints") or cause.get("effect") == "base_compliance":
        return True
    return cause.get("joint") in truth["joints"]


def alias(cause, truth):
    """Pairs that the design declares hard to tell apart, other than the truth itself."""
    number = lambda j: int(j.rsplit("_", 1)[1]) if j else 0  # noqa: E731
    said, at = cause.get("effect"), number(cause.get("joint"))
    true = truth["effect"]
    for j in [number(x) for x in truth.get("joints", [])] or [0]:
        for a, p, b, q in ((said, at, true, j), (true, j, said, at)):
            if a == "link_bending" and b == "joint_compliance" and p - q in (0, 1):
                return True
            if p == q and (a, b) in (("joint_scale", "encoder_eccentricity"),
                                     ("backlash", "joint_compliance")):
                return True
            if a == "base_compliance" and b == "joint_compliance" and q == 2:
                return True
            if a == "base_compliance" and b == "link_bending" and q in (1, 2):
                return True
    return False


def call(binary, files, arguments, limit=300):
    """Run in a folder of its own; the answer or None, seconds, what went wrong."""
    with tempfile.TemporaryDirectory() as tmp:
        for f in files:
            shutil.copy(f, tmp)
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


class Count:
    """Hits among trials by name, in order of first use."""

    def __init__(self):
        self.n = collections.OrderedDict()

    def add(self, name, hit):
        got = self.n.setdefault(name, [0, 0])
        got[0] += bool(hit)
        got[1] += 1

    def text(self, name):
        return share(*self.n.get(name, (0, 0)))


def rows_said(answer, kinds):
    return {f.get("row") for f in answer.get("data_faults", []) if f.get("kind") in kinds}


def motion_found(answer, e):
    """The moved socket is named; a step within three rows of where it happened."""
    for c in answer.get("causes", []) + [dict(f, effect=f.get("kind"))
                                          for f in answer.get("data_faults", [])]:
        if (c.get("effect") == "tool_motion" and c.get("placement") == f"p{e['placement']}"
                and str(c.get("socket")) == str(e["socket"])):
            if e.get("creep") or abs((c.get("row") or -99) - e["first_row"]) <= 3:
                return True
    return False


def judge(label, r, count, by_kind, bands, brier, ties):
    """Score one socket case; returns the note for its line."""
    kind, truths = label["kind"], label["effects"]
    rows = label.get("rows", 2 * label["placements"] * label["per_socket"])
    verdict, causes = r.get("verdict"), r.get("causes", [])
    top = causes[0] if causes else {}
    named = [top] + top.get("ties", []) if top else []
    note = ""
    if kind.startswith("none"):
        faults = {f.get("kind") for f in r.get("data_faults", [])}
        bad = verdict != "none" or bool(faults if kind == "none" else faults - {"outlier"})
        name = "heavy" if kind == "none_heavy" else "correlated" if label["ar"] else "Gaussian"
        count.add("false alarms on null", bad)
        count.add("false alarms, " + name, bad)
        note = "FALSE ALARM" if bad else "ok"
    elif kind in OUTSIDE:
        e = truths[0]
        if label["detectable"]:
            hit = verdict == "unknown" or bool(r.get("unexplained"))
            where = sorted(r.get("where", {}).get("joints", []), key=lambda x: -x.get("share", 0))
            near = any(c.get("joint") in e["joints"] and c.get("effect") in OUTSIDE_NEAR.get(kind, ())
                       for c in causes)
            what = "outside the catalogue" if kind in OUTSIDE_FUNCTION else "outside, " + kind
            count.add(what + ": unknown", hit)
            count.add(what + ": confident name",
                      verdict in ("named", "tied") and not hit and not near)
            if kind in OUTSIDE_FUNCTION:
                count.add(what + ": joint located", where and where[0].get("joint") in e["joints"])
            note = ("ok" if hit else "near name" if near else "missed" if verdict == "none"
                    else "MISNAMED")
        else:
            count.add("faint effect misnamed", verdict == "named")
            note = "faint " + ("WRONG" if verdict == "named" else "ok")
    elif kind == "wrong_socket":
        said = rows_said(r, ("wrong_socket", "outlier"))
        true = {x + 1 for x in truths[0]["rows"]}
        hit = true <= said and len(said) <= len(true) + 3
        count.add("wrong sockets found", hit)
        count.add("wrong sockets: nothing else blamed", verdict == "none")
        note = "ok" if hit else "missed"
    elif kind == "outlier":
        true = {x + 1 for x in truths[0]["rows"]}
        count.add("outlier rows flagged", true <= rows_said(r, ("outlier", "wrong_socket")))
        count.add("outlier alone leaves none", verdict == "none")
        note = str(verdict)
    elif kind == "duplicate":
        said = rows_said(r, ("duplicate",))
        hit = all({x, x + 1} & said for x in truths[0]["rows"])
        count.add("duplicate rows flagged", hit)
        count.add("duplicate alone leaves none", verdict == "none")
        note = "ok" if hit else "missed"
    elif kind in ("tool_motion", "tool_creep", "effect_and_motion"):
        hit = motion_found(r, truths[-1])
        note = "ok" if hit else "missed"
        if kind == "effect_and_motion":
            count.add("effect beside a moved tool: motion", hit)
            if truths[0]["snr"] * math.sqrt(3 * rows) >= SURE:
                ok = any(effect_ok(c, truths[0]) for c in causes)
                count.add("effect beside a moved tool: effect", ok)
                note += ", effect " + ("ok" if ok else "missed")
        else:
            count.add("tool motion found" if kind == "tool_motion" else "tool creep found", hit)
            extra = [c for c in causes if c.get("effect") != "tool_motion"]
            count.add("tool motion: something else blamed", extra)
    elif kind == "mixture":
        if all(e["snr"] * math.sqrt(3 * rows) >= SURE for e in truths):
            hits = [any(effect_ok(c, e) for c in causes) for e in truths]
            count.add("mixtures: first cause right",
                      top and any(effect_ok(top, e) for e in truths))
            count.add("mixtures: both found", all(hits))
            count.add("mixtures: something spurious", any(
                not any(effect_ok(c, e) for e in truths) for c in causes))
            if label.get("same_joint"):
                count.add("mixtures in one joint: both found", all(hits))
            note = f"{sum(hits)}/2"
        else:
            bad = verdict == "named" and not any(effect_ok(c, e) for c in named for e in truths)
            count.add("faint effect misnamed", bad)
            note = "faint mixture"
    else:
        e = truths[0]
        inside = any(right(c, e) for c in named)
        if label["detectable"]:
            cls, whole = bool(top) and effect_ok(top, e), bool(top) and right(top, e)
            count.add("effect class right (first)", cls)
            count.add("effect and joint right (first)", whole)
            count.add("truth in the reported tie set", inside)
            ties.append(max(1, len(named)))
            if top.get("probability") is not None:
                brier["detectable"].append((top["probability"] - float(whole)) ** 2)
            note = ("ok" if whole else "class only" if cls else "tied" if inside
                    else f"WRONG {verdict} {top.get('effect')}/{top.get('joint')}")
            total = e["snr"] * math.sqrt(3 * rows)
            band = next(t for x, t in ((12, "8-12"), (20, "12-20"), (40, "20-40"), (1e9, "> 40"))
                        if total < x)
            for group, value in (("snr*sqrt(3 rows)", band), ("placements", label["placements"]),
                                 ("rows per socket", label["per_socket"]),
                                 ("postures", label.get("poses", "drawn")),
                                 ("robot", label["robot"])):
                bands.setdefault(group, Count()).add(str(value), whole)
        else:
            bad = verdict == "named" and not any(effect_ok(c, e) for c in named)
            count.add("faint effect misnamed", bad)
            note = "faint " + ("WRONG" if bad else "ok")
        by_kind.setdefault(kind, []).append(
            (label["detectable"], bool(top) and effect_ok(top, e), bool(top) and right(top, e),
             inside, verdict))
    if verdict in ("named", "tied") and top.get("probability") is not None:
        good = any(right(top, e) for e in truths if e["effect"] not in OUTSIDE)
        if top.get("effect") == "tool_motion":
            good = any(e["effect"] == "tool_motion" and motion_found(r, e) for e in truths)
        brier["all"].append((top["probability"] - float(good)) ** 2)
        if not good and top["probability"] > 0.9:
            note += " SURE AND WRONG"
            count.add("stated above 0.9 and wrong, of all answers", True)
        else:
            count.add("stated above 0.9 and wrong, of all answers", False)
    return note


def said(r):
    return [f"{c.get('effect')}/{c.get('joint') or c.get('placement')}"
            for c in r.get("causes", [])][:4]


def score_logs(folder, binary, names, labels, pool, quiet):
    """Tracker pose logs: figures of their own."""
    count = Count()

    def one(name):
        f = os.path.join(folder, name)
        return call(binary, [os.path.join(f, x) for x in ("robot.urdf", "log.tsv")],
                    ["--free-base", "--free-tool", "log.tsv"])
    times = []
    for name, (r, took, why) in zip(names, pool.map(one, names)):
        label = labels[name]
        times.append(took)
        kind = label["kind"]
        if r is None:
            count.add("logs: failures", True)
            print(name, kind, "FAILED", why, flush=True)
            continue
        count.add("logs: failures", False)
        top = (r.get("causes") or [{}])[0]
        how = "with commands" if label["command"] else "readings only"
        if kind == "none":
            note = r.get("verdict") == "none"
            count.add("logs: false alarms on null", not note)
        elif kind == "readback_lag":
            note = top.get("effect") == kind
            count.add("logs: stale read-back first", note)
            count.add(f"logs: stale read-back first, {how}", note)
            count.add("logs: stale read-back called play of a joint", any(
                c.get("effect") in ("backlash", "approach_hysteresis")
                for c in r.get("causes", [])))
        elif label["detectable"]:
            note = bool(top) and right(top, label["effects"][0])
            count.add("logs: other effects, joint right", note)
        else:
            note = r.get("verdict") != "named" or effect_ok(top, label["effects"][0])
            count.add("logs: faint effect misnamed", not note)
        if not quiet:
            print(name, kind, "full" if label["full_pose"] else "position", how, "->",
                  r.get("verdict"), said(r), "ok" if note else "WRONG", f"{took:.2f}s", flush=True)
    return count, sorted(times)


def score_withheld(folder, binary, names, labels, pool, quiet):
    """The true effect is taken out of the catalogue: what is said in its place?"""
    count, by_kind = Count(), collections.OrderedDict()
    names = [n for n in names if labels[n]["detectable"] and len(labels[n]["effects"]) == 1
             and labels[n]["kind"] not in OUTSIDE | FAULTS and labels[n]["kind"] != "mixture"]

    def one(name):
        f = os.path.join(folder, name)
        return call(binary, [os.path.join(f, x) for x in ("robot.urdf", "session.tsv")],
                    ["--distance", "0.05", "--without", labels[name]["kind"], "session.tsv"])
    for name, (r, took, why) in zip(names, pool.map(one, names)):
        kind, e = labels[name]["kind"], labels[name]["effects"][0]
        if r is None:
            print(name, kind, "FAILED", why, flush=True)
            count.add("withheld: failures", True)
            continue
        verdict, causes = r.get("verdict"), r.get("causes", [])
        top = causes[0] if causes else {}
        if verdict == "unknown" or r.get("unexplained"):
            what = "unknown"
        elif not causes:
            what = "none"
        elif any(alias(c, e) or effect_ok(c, e) for c in [top] + top.get("ties", [])):
            what = "declared alias"
        elif verdict == "tied":
            what = "tied wrong names"
        else:
            what = "CONFIDENT WRONG NAME"
        for w in ("unknown", "declared alias", "none", "tied wrong names", "CONFIDENT WRONG NAME"):
            count.add("withheld: " + w, w == what)
            by_kind.setdefault(kind, Count()).add(w, w == what)
        if not quiet:
            print(name, kind, e.get("joints"), "withheld ->", verdict, said(r), what,
                  f"p={top.get('probability')} {took:.2f}s", flush=True)
    print()
    for k in count.n:
        print(f"{k:46s}", count.text(k))
    print("\n| withheld class | n | unknown | alias | none | tied wrong | confident wrong |\n"
          "| --- | --- | --- | --- | --- | --- | --- |")
    for k, c in sorted(by_kind.items()):
        print("|", k, "|", c.n["unknown"][1], "|", " | ".join(str(v[0]) for v in c.n.values()), "|")
    return count


def main():
    ap = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    ap.add_argument("binary")
    ap.add_argument("cases")
    ap.add_argument("--out")
    ap.add_argument("--limit", type=int, default=0)
    ap.add_argument("--jobs", type=int, default=2)
    ap.add_argument("--kinds")
    ap.add_argument("--without-class", action="store_true")
    ap.add_argument("--no-logs", action="store_true")
    ap.add_argument("-q", "--quiet", action="store_true")
    a = ap.parse_args()
    binary = os.path.abspath(a.binary)
    if a.out:
        os.makedirs(a.out, exist_ok=True)
    with open(os.path.join(a.cases, "labels.json")) as f:
        labels = json.load(f)
    names = [n for n in sorted(labels) if not a.kinds or labels[n]["kind"] in a.kinds.split(",")]
    names = names[:a.limit or None]
    pool = ThreadPoolExecutor(a.jobs)
    if a.without_class:
        score_withheld(a.cases, binary, names, labels, pool, a.quiet)
        return

    def one(name):
        f = os.path.join(a.cases, name)
        return call(binary,
                    [os.path.join(f, x) for x in ("robot.urdf", "session.tsv", "holdout.tsv")],
                    ["--distance", "0.05", "session.tsv", "--test", "holdout.tsv"])
    count, by_kind, bands = Count(), {}, collections.OrderedDict()
    brier, ties, rho, times, failures = {"detectable": [], "all": []}, [], [], [], 0
    for name, (r, took, why) in zip(names, pool.map(one, names)):
        label = labels[name]
        times.append(took)
        if r is None:
            failures += 1
            print(name, label["kind"], "FAILED", why, flush=True)
            continue
        if a.out:
            with open(os.path.join(a.out, name + ".json"), "w") as f:
                json.dump(r, f, indent=1)
        note = judge(label, r, count, by_kind, bands, brier, ties)
        t = r.get("test") or {}
        if (label["detectable"] and label["kind"] not in OUTSIDE | FAULTS
                and label["kind"] not in ("zero_jump", "ball_shift", "socket_distance")
                and t.get("geometry_m") and t.get("explained_m")):
            floor = NOISE_LENGTH * label["ball_noise_m"]
            if t["geometry_m"] > 1.3 * floor:
                rho.append((t["geometry_m"] - t["explained_m"]) / (t["geometry_m"] - floor))
        if not a.quiet or "WRONG" in note or "MIS" in note or "ALARM" in note:
            print(name, label["kind"], [(e["effect"], e.get("joints")) for e in label["effects"]],
                  "->", r.get("verdict"), said(r), note, f"{took:.2f}s", flush=True)
    print()
    for k in sorted(count.n, key=lambda k: k.split(":")[0]):
        print(f"{k:46s}", count.text(k))
    if ties:
        print(f"{'mean size of the tie set':46s} {sum(ties) / len(ties):.2f}")
    rho.sort()
    times.sort()
    mid = lambda x: x[len(x) // 2] if x else float("nan")  # noqa: E731
    mean = lambda x: sum(x) / len(x) if x else float("nan")  # noqa: E731
    print(f"{'removable held-out gap removed, median':46s} {mid(rho):.3f} of {len(rho)}")
    print(f"{'Brier score, detectable singles':46s} {mean(brier['detectable']):.3f} "
          f"of {len(brier['detectable'])}")
    print(f"{'Brier score, every named or tied answer':46s} {mean(brier['all']):.3f} "
          f"of {len(brier['all'])}")
    print(f"{'seconds per case: median, largest':46s} {mid(times):.3f} "
          f"{times[-1] if times else float('nan'):.3f}; failures {failures}; {a.jobs} at a time")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{'processor seconds per case, mean':46s} "
          f"{(used.ru_utime + used.ru_stime) / max(1, len(times)):.3f}")
    if by_kind:
        print("\n| effect | detectable | class | class and joint | in tie set | unknown | none "
              "| faint: named wrongly |\n| --- | --- | --- | --- | --- | --- | --- | --- |")
        for k, v in sorted(by_kind.items()):
            d, f = [x for x in v if x[0]], [x for x in v if not x[0]]
            print(f"| {k} | {len(d)} | {sum(x[1] for x in d)} | {sum(x[2] for x in d)} "
                  f"| {sum(x[3] for x in d)} | {sum(x[4] == 'unknown' for x in d)} "
                  f"| {sum(x[4] == 'none' for x in d)} "
                  f"| {sum(x[4] == 'named' and not x[1] for x in f)} of {len(f)} |")
    if bands:
        print("\nclass and joint right, detectable single effects, by")
        for group, c in bands.items():
            def order(v):
                head = v.split("-")[0].strip("> ")
                return (1, int(head)) if head.isdigit() else (0, 0)
            print(f"  {group}: " + "; ".join(f"{v}: {c.n[v][0]}/{c.n[v][1]}"
                                              for v in sorted(c.n, key=order)))
    logs = os.path.join(a.cases, "logs", "labels.json")
    if os.path.exists(logs) and not a.no_logs and not a.kinds:
        with open(logs) as f:
            labels = json.load(f)
        names = sorted(labels)[:a.limit or None]
        print()
        lc, lt = score_logs(os.path.dirname(logs), binary, names, labels, pool, a.quiet)
        print()
        for k in lc.n:
            print(f"{k:46s}", lc.text(k))
        print(f"{'logs: seconds, median':46s} {mid(lt):.3f}")
        count.n.update(lc.n)
    if a.out:
        with open(os.path.join(a.out, "score.json"), "w") as f:
            json.dump(dict(counts=count.n, rho_median=mid(rho), seconds_median=mid(times),
                           brier={k: mean(v) for k, v in brier.items()}), f, indent=1)


if __name__ == "__main__":
    sys.exit(main())
