#!/usr/bin/env python3
"""judge.py FOLDER [PROGRAM]: `mukca motion` on the cases of make.py, judged by their truth.

A single effect of the catalogue is run a second time with --without it: then what remains is its family at
its joint.  The program's JSON is kept beside each case; a case with answers is not run again.  The terms:

    accused    a finding where nothing was put in
    right      a finding at the effect's place that names it, has it among its alternatives, or (coarser) what
               its torque varies with; one that spans the whole arm must say with what
    withheld right, misnamed: family and place, whatever it is called; and another effect at one place
    exact      a finding of the effect at its joint alone
    false      a finding that is right for no effect of its case
    misnamed   a finding of one effect at one place that is wrong
    covered    intervals of exact findings that hold the size that was put in
"""
import json
import os
import subprocess
import sys
from collections import defaultdict

from catalogue import LISTED, PUSHED, VARIES_WITH

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", ".."))
# At the last link a payload is a mass of the link off its centre.
BODY = ("payload", "link_mass", "link_centre")
TARGETS = {"accused": "<= 2", "right": ">= 95", "exact": ">= 75", "withheld right": ">= 85", "withheld misnamed": "<= 2",
           "covered": "90 to 98"}


def answers(program, folder, truth):
    """JSON of the case, and of the case without its effect or None."""
    runs = sorted(os.path.join(folder, f) for f in os.listdir(folder) if f.startswith("run_"))

    def run(name, *options):
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            done = subprocess.run([program, "motion", "-q", "--urdf", os.path.join(folder, "arm.urdf"),
                                   "--mjcf", os.path.join(folder, "drives.xml"), *options, *runs, "--json", path],
                                  capture_output=True, text=True)
            if not os.path.exists(path):
                print("%s: %s" % (folder, done.stderr.strip()))
                return {"findings": []}
        return json.load(open(path))
    single = len(truth["effects"]) == 1 and truth["effects"][0]["name"] in LISTED
    return run("motion.json"), run("withheld.json", "--without", truth["effects"][0]["name"]) if single else None


def span(entry, truth):
    """First and last joint index of a finding or an alternative; a link belongs to the joint before it."""
    names = truth["links"] if entry.get("on") == "links" else truth["joints"]

    def index(name, outside):
        return names.index(name) if name in names else {"base": -1, "tool": len(names)}.get(name, outside)
    first, last = entry.get("from"), entry.get("to")
    return index(first, -1), index(last, len(names))


def is_at(entry, effect, truth):
    """At the effect's place alone."""
    n = len(truth["joints"])
    first, last = span(entry, truth)
    if effect["joint"] < 0:
        return first <= 0 and last >= n - 1
    return first in (effect["joint"], n) and last in (effect["joint"], n) or \
        (effect["name"] == "payload" and first >= n - 1)


def names(entry, effect, truth):
    last = effect["joint"] == len(truth["joints"]) - 1
    same = BODY if effect["name"] in BODY and last else (effect["name"],)
    return entry.get("effect") in same


def is_exact(finding, effect, truth):
    return finding["kind"] == "effect" and names(finding, effect, truth) and is_at(finding, effect, truth)


def is_right(finding, effect, truth, withheld=False):
    n = len(truth["joints"])
    first, last = span(finding, truth)
    whole = first <= 0 and last >= n - 1
    if effect["joint"] >= 0 and not first <= effect["joint"] <= last and not is_at(finding, effect, truth):
        return False
    if effect["name"] == "push" and finding["varies_with"] != "time":
        return False
    if not withheld and (is_exact(finding, effect, truth) or
                         any(names(a, effect, truth) and is_at(a, effect, truth) for a in finding["alternatives"])):
        return True
    if not withheld and finding["effect"] is not None and not names(finding, effect, truth):
        return False
    if finding["varies_with"] is None:
        return finding["kind"] == "place" and not whole
    return finding["varies_with"] in VARIES_WITH[effect["name"]]


def places_of(effect):
    """The effect at each of its places: a push acts at several joints."""
    return [dict(effect, joint=j) for j in PUSHED] if effect["name"] == "push" else [effect]


class Score:
    """Counts by name: how often, out of how many."""

    def __init__(self):
        self.count = defaultdict(lambda: [0, 0])

    def add(self, name, yes):
        self.count[name][0] += bool(yes)
        self.count[name][1] += 1

    def line(self, name):
        yes, of = self.count[name]
        return "%-32s %4d of %4d  %5.1f %%   %s" % (name, yes, of, 100 * yes / max(of, 1), TARGETS.get(name, ""))


def judge(score, truth, answer, withheld):
    findings, what = answer["findings"], truth["situation"]
    effects = truth["effects"]
    places = [p for e in effects for p in places_of(e)]
    if not effects:
        score.add("accused" if what == "none" else "accused in slow motion", findings)
    right = [any(is_right(f, p, truth) for f in findings for p in places_of(e)) for e in effects]
    exact = [any(is_exact(f, e, truth) for f in findings) for e in effects]
    group = "single" if len(effects) == 1 and effects[0]["name"] in LISTED else \
        "unlisted" if len(effects) == 1 else "several"
    for e, r, x in zip(effects, right, exact):
        prefix = "" if group == "single" else group + " "
        score.add(prefix + "right", r)
        if e["name"] in LISTED:
            score.add(prefix + "exact", x)
        score.add("by effect: " + what, x if group == "single" else r)
    wrong = [f for f in findings if not any(is_right(f, p, truth) for p in places)]
    for f in findings:
        score.add("findings false", f in wrong)
    score.add("cases with a misnamed effect", any(is_single(f, truth) for f in wrong))
    for e in effects:
        for f in findings:
            value = f.get("coefficient")
            if value and value.get("ci95") and is_exact(f, e, truth) and known_size(f, e):
                low, high = value["ci95"]
                score.add("covered", low <= e["size"] <= high)
                if not low <= e["size"] <= high:
                    report(truth, "size", [f], [])
    if wrong or not all(right):
        report(truth, "", findings, wrong)
    if withheld is not None:
        rest = withheld["findings"]
        found = any(is_right(f, effects[0], truth, True) for f in rest)
        named = [f for f in rest if is_single(f, truth) and not names(f, effects[0], truth)]
        score.add("withheld right", found)
        score.add("withheld misnamed", named)
        if named or not found:
            report(truth, "withheld", rest, named)


def report(truth, what, findings, wrong):
    """A line about a case: what was put in, and what was found."""
    def sized(f):
        value = f.get("coefficient") if what == "size" else None
        return f["sentence"] + (", %.3g to %.3g" % tuple(value["ci95"]) if value else "")
    print("%03d %-7s %-8s %s | %s" % (
        truth["case"], truth["arm"], what,
        "; ".join("%s at %s, %.3g" % (e["name"], place(e, truth), e["size"]) for e in truth["effects"]) or "nothing",
        "; ".join(sized(f) + (" (false)" if f in wrong else "") for f in findings) or "nothing"))


def place(effect, truth):
    return truth["joints"][effect["joint"]] if effect["joint"] >= 0 else "all joints"


def is_single(finding, truth):
    """One effect of the catalogue at one place, or at all joints."""
    first, last = span(finding, truth)
    return finding["kind"] == "effect" and (first == last or first <= 0 and last >= len(truth["joints"]) - 1)


def known_size(finding, effect):
    """Whether the coefficient and the size are the same quantity."""
    if effect["name"] == "link_centre":
        return False            # a vector
    return finding["effect"] == effect["name"] or {finding["effect"], effect["name"]} == {"payload", "link_mass"}


def main():
    folder = sys.argv[1]
    program = sys.argv[2] if len(sys.argv) > 2 else os.environ.get("MUKCA", os.path.join(ROOT, "build", "mukca"))
    score = Score()
    truths = json.load(open(os.path.join(folder, "truth.json")))
    for truth in truths:
        judge(score, truth, *answers(program, os.path.join(folder, "case_%03d" % truth["case"]), truth))
    print("\n%d cases" % len(truths))
    first = [n for n in score.count if not n.startswith("by effect")]
    for name in first + sorted(n for n in score.count if n.startswith("by effect")):
        print(score.line(name))


if __name__ == "__main__":
    main()
