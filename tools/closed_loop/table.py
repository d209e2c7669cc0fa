"""The table beside the paper's, what it must show, and the figure (gnuplot)."""
import json
import os
import shutil
import subprocess

import numpy as np

import arm
import tasks

MODELS = ("nominal", "geometry", "causes")
# Franzese et al., arXiv 2503.12584; "-": not stated there, or not in our notes of it.
PAPER = {"insert 16.0": ("fails", "-"), "insert 10.4": ("-", "20 of 20"), "cross": ("-", "24 of 24")}
MOST_FORCE = 30.0  # N
TITLES = {"nominal": "nominal model", "geometry": "geometry", "causes": "geometry and causes"}


def gather(results, task, name, model):
    """Results of the parts of a task, joined."""
    return [x for (t, a, m, _), r in sorted(results.items()) if (t, a, m) == (task, name, model) for x in r]


def hole(attempts, diameter):
    """Of one diameter: successes, attempts, forces of the successes. A hole that was not tried counts as failed."""
    done = [x for a in attempts for x in a if x["diameter"] == diameter]
    return sum(x["success"] for x in done), len(attempts), [x["force"] for x in done if x["success"]]


def forces(values):
    return "%.1f, %.1f, %.1f" % (np.mean(values), np.max(values), np.min(values)) if values else "-"


def retrace(paths):
    a, b = np.array(paths)
    d = tasks.distances(b, a)
    return 1e3 * d.mean(), 1e3 * d.max()


def of_arm(name, results, diagnosis):
    """Rows (label, key, {model: text}) and numbers {model: {...}} of one arm."""
    models = [m for m in MODELS if ("draw", name, m, 0) in results]
    rows, numbers = [], {m: {} for m in models}
    gap = diagnosis["gap"]
    error = {"nominal": gap["nominal_m"], "geometry": gap["geometry_m"], "causes": gap["explained_m"]}
    rows.append(("held-out error of the calibration, mm", "error",
                 {m: "%.2f" % (1e3 * error[m]) if error[m] is not None else "-" for m in models}))
    tried = {x["diameter"] for m in models for a in gather(results, "insert", name, m) for x in a}
    for d in sorted(tried, reverse=True):
        key, texts, force = "insert %.1f" % (1e3 * d), {}, {}
        for m in models:
            good, tried, force[m] = hole(gather(results, "insert", name, m), d)
            numbers[m][key], numbers[m][key + " force"] = (good, tried), force[m]
            texts[m] = "%d of %d" % (good, tried)
        rows.append(("10 mm peg, %.1f mm hole" % (1e3 * d), key, texts))
        rows.append(("  force, N: mean, max, min", "", {m: forces(force[m]) for m in models}))
    texts, force = {}, {}
    for m in models:
        attempts = gather(results, "cross", name, m)
        force[m] = [x["force"] for x in attempts if x["success"]]
        numbers[m]["cross"], numbers[m]["cross force"] = (len(force[m]), len(attempts)), force[m]
        texts[m] = "%d of %d" % (len(force[m]), len(attempts))
    rows.append(("10.4 mm holes at known offsets", "cross", texts))
    rows.append(("  force, N: mean, max, min", "", {m: forces(force[m]) for m in models}))
    texts = {}
    for m in models:
        numbers[m]["draw"] = retrace(results["draw", name, m, 0])
        texts[m] = "%.2f, %.2f" % numbers[m]["draw"]
    rows.append(("drawing retraced, mm: mean, max", "draw", texts))
    return rows, numbers


def claims(numbers, diagnoses, hidden):
    """[(what must hold, whether it does)]"""
    found = []
    for name, by_model in numbers.items():
        best = [m for m in MODELS if m in by_model][-1]
        good, tried = by_model["nominal"]["insert 16.0"]
        found.append((name + ": the nominal model fails at 16 mm", good <= tried // 2))
        good, tried = by_model[best]["insert 10.4"]
        found.append((name + ": %s: in the 10.4 mm hole every time" % TITLES[best], good == tried))
        holes, of = by_model[best]["cross"]
        found.append((name + ": %s: in all holes at known offsets" % TITLES[best], holes == of))
        most = max(by_model[best]["insert 10.4 force"] + by_model[best]["cross force"] + [0])
        found.append((name + ": at most %g N" % MOST_FORCE, most <= MOST_FORCE))
        if best == "causes" and "geometry" in by_model:
            alone = by_model["geometry"]
            found.append((name + ": geometry alone fails at 10.4 mm or needs more force",
                          alone["insert 10.4"][0] < tried or
                          max(alone["insert 10.4 force"]) > max(by_model[best]["insert 10.4 force"])))
        ratio = np.array(by_model["nominal"]["draw"]) / by_model[best]["draw"]
        found.append((name + ": retracing error down ten times", bool(ratio[0] >= 10)))
        causes = diagnoses[name]["causes"]
        named = {(c["effect"], c["joint"]): c for c in causes}
        for joint, compliance in hidden[name].springs.items():
            c = named.pop(("joint_compliance", joint), None)
            found.append((name + ": the spring at %s is named, its stiffness within the interval" % joint,
                          bool(c) and c["ci95"][0] <= compliance <= c["ci95"][1]))
        for joint in hidden[name].play:
            named.pop(("backlash", joint), None)
        found.append((name + ": nothing else is blamed", not named))
    return found


PLOT = """set terminal pngcairo size 1300,500 font 'sans,11'
set output '{picture}'
set multiplot layout 1,3
set size ratio -1
set key top right
set lmargin 6
set rmargin 1
set style fill empty
set xlabel 'mm'
set title 'peg (10 mm) above the hole (16 mm; dashed: 10.4 mm)'
set object 1 circle at 0,0 size 8 fc rgb 'black' lw 2
set object 2 circle at 0,0 size 5.2 fc rgb 'black' dt 2 lw 2
plot [-18:18] [-18:18] '{out}/nominal-pegs' using 1:2:(5) with circles lc rgb '#d95f02' title 'nominal model', \\
    '{out}/{best}-pegs' using 1:2:(5) with circles lc rgb '#1b7837' title '{title}'
unset object 1
unset object 2
set title 'drawing from two postures: nominal model'
plot [-55:55] [-55:55] '{out}/nominal-drawn0' with lines lw 2 lc rgb '#4575b4' title 'first', \\
    '{out}/nominal-drawn1' with lines lc rgb '#d73027' title 'second'
set title 'drawing from two postures: {title}'
plot [-55:55] [-55:55] '{out}/{best}-drawn0' with lines lw 2 lc rgb '#4575b4' title 'first', \\
    '{out}/{best}-drawn1' with lines lc rgb '#d73027' title 'second'
"""


def plot(out, picture, name, results):
    """Peg against hole, and the drawing from two postures: nominal model, and the best one."""
    if not shutil.which("gnuplot"):
        print("no gnuplot: no picture")
        return
    best = [m for m in MODELS if ("draw", name, m, 0) in results][-1]
    for m in ("nominal", best):
        lines = {"pegs": [a[0]["aside"] for a in gather(results, "insert", name, m)]}
        for i, line in enumerate(results["draw", name, m, 0]):
            lines["drawn%d" % i] = line - tasks.HOLE[:2]
        for kind, points in lines.items():
            np.savetxt(os.path.join(out, "%s-%s" % (m, kind)), 1e3 * np.array(points), "%.5f")
    subprocess.run(["gnuplot"], input=PLOT.format(picture=picture, out=out, best=best, title=TITLES[best]), text=True,
                   check=True)


def report(names, diagnoses, results, out, picture):
    """Print everything; the exit code."""
    numbers = {}
    with open(os.path.join(out, "results.json"), "w") as f:
        json.dump([[list(k), r] for k, r in results.items()], f)
    for name in names:
        rows, numbers[name] = of_arm(name, results, diagnoses[name])
        h = arm.ARMS[name]
        print("\n%s arm: origins off by %g mm and %g mrad%s%s" % (
            name, 1e3 * h.position, 1e3 * h.angle,
            "".join("; %s %g urad/(N m)" % (j, 1e6 * c) for j, c in h.springs.items()),
            "".join("; play of %g mrad at %s" % (1e3 * w, j) for j, w in h.play.items())))
        for c in diagnoses[name]["causes"]:
            print("  diagnose: %s at %s, %.4g %s [%.4g, %.4g]" % (c["effect"], c["joint"], c["amplitude"], c["unit"],
                                                                  *c["ci95"]))
        line = "%-38s %-16s %-16s %-16s %-16s"
        print(line % ("", "nominal", "geometry", "with causes", "paper: before; after"))
        for label, key, texts in rows:
            paper = PAPER.get(key)
            print((line % (label, *(texts.get(m, "") for m in MODELS), "%s; %s" % paper if paper else "")).rstrip())
    plot(out, picture, "sprung" if "sprung" in names else names[0], results)
    found = claims(numbers, diagnoses, arm.ARMS)
    print()
    for what, holds in found:
        print(("ok " if holds else "not ok ") + what)
    return 0 if all(holds for _, holds in found) else 1
