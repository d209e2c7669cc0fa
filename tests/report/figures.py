#!/usr/bin/env python3
"""Every figure of the screen, the JSON and the report of a diagnosis, on three data sets.

Prints a line for each comparison; the last argument of each is the page's or the screen's text.
"""
import html
import json
import os
import re
import subprocess
import sys

MUKCA, folder = os.environ["MUKCA"], sys.argv[1]
ARM = ["--urdf", "data/demo/arm.urdf"]
failed = False


def run(*arguments):
    done = subprocess.run([MUKCA, *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{arguments}: {done.stderr}")
    return done.stdout


def same(name, wanted, got):
    global failed
    if wanted != got:
        failed = True
        print(f"not ok report: {name}: {wanted} is {got}")
    else:
        print(f"ok report: {name}")


def mm(value, digits=3):
    return "" if value is None else f"{1e3 * value:.{digits}f}"


def steps(d):
    """The rows of errors that the JSON implies: name, cross-validated, test."""
    gap, test = d["gap"], d["test"] or {}
    rows = [("nominal model", gap["nominal_m"], test.get("nominal_m")),
            ("calibrated geometry", gap["geometry_m"], test.get("geometry_m"))]
    if d["data_faults"]:
        rows.append(("faulty samples excluded", gap["faults_excused_m"], None))
    of_arm = [c for c in d["causes"] if c["motion"] is None]
    for k, cause in enumerate(of_arm[:-1]):
        rows.append(("and a further cause" if k else "geometry and the first cause", cause["cumulative_m"], None))
    if d["causes"]:
        last = ["tool motion", "the cause", "both causes", "all causes"][min(len(of_arm), 3)]
        rows.append((f"geometry and {last}", gap["explained_m"], test.get("explained_m")))
    if gap["with_unknown_m"] is not None and gap["with_unknown_m"] < gap["explained_m"]:
        rows.append(("and unexplained structure", gap["with_unknown_m"], None))
    return [(n, mm(c), mm(t)) for n, c, t in rows + [("noise floor", gap["noise_floor_m"], None)]]


def cells(page, caption):
    """The body of the table whose caption begins so, without the bars."""
    body = page[page.index(f"<caption>{caption}"):]
    body = body[body.index("<tbody>"):body.index("</tbody>")]
    body = re.sub(r'<td class="bar">.*?</td>', "", body)
    return [[html.unescape(c).replace("\u2013", "") for c in re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row)]
            for row in re.findall(r"<tr>(.*?)</tr>", body)]


def words(text):
    return " ".join(text.split())


def compare(name, *data):
    base = os.path.join(folder, name)
    screen = run("diagnose", "-v", *ARM, *data, "--json", base + ".json", "-o", base + ".tsv")
    run("report", "-q", *ARM, *data, "-o", base + ".html")
    with open(base + ".json") as file, open(base + ".html") as other:
        d, page = json.load(file), other.read()
    a = d["acceptance"]
    lines = screen[screen.index("Mean error, mm"):].split("\n")[1:]
    shown = [re.match(r"  (\D+?) +([\d.]+)(?: +([\d.]+))?$", line) for line in lines]
    same(f"{name}: errors on the screen", steps(d), [(m[1], m[2], m[3] or "") for m in shown if m])
    same(f"{name}: errors on the page", steps(d), [tuple((*row, "")[:3]) for row in cells(page, "Mean error")])
    here = [mm(a[f"error_{k}_m"], 2) for k in ("here", "here_low", "here_high", "before_here", "here_distance")]
    tip = re.search(r"^Tip .*?(?=^\S|^$)", screen, re.M | re.S)
    same(f"{name}: accuracy on the screen", here, re.findall(r"\d+\.\d\d", tip[0]) if tip else None)
    accuracy = re.search(r"Accuracy of the tip:</strong> (.*?)</p>", page)[1]
    same(f"{name}: accuracy on the page", here, re.findall(r"\d+\.\d\d", accuracy))
    use = words(re.search(r"^Use .*?(?=^\S|^$)", screen, re.M | re.S)[0])
    same(f"{name}: use on the page", use.split(": ", 1)[1] + ".",
         words(html.unescape(re.search(r"Use the result\?</strong> Yes: (.*?)</p>", page)[1])))
    same(f"{name}: use in the JSON", [mm(a["error_m"]), mm(a["error_nominal_m"]), mm(a["tip_change_m"], 2)],
         re.findall(r"(\d+\.\d+) mm", use))
    for finding, row in zip(d["findings"], cells(page, "Findings") if d["findings"] else []):
        sizes = [mm(finding["size_m"]), *map(mm, finding["size_ci95_m"])]
        same(f"{name}: size of {row[0]}", sizes, re.findall(r"\d+\.\d+", row[1]))
        same(f"{name}: {row[0]} on the screen", True, words(row[2]) in words(screen) and row[0] in words(screen))
    limits = words(re.search(r"^Detection limits, .*?(?=^Not|^joint_drift|^Next|^$)", screen + "\n", re.M | re.S)[0])
    same(f"{name}: detection limits", True, f"<p>{limits}.</p>" in page)
    run("evaluate", "-q", *ARM, "--offsets", base + ".tsv", *data, "--json", base + "_e.json")
    with open(base + "_e.json") as file:
        e = json.load(file)
    wanted = [[f"{p['placement']} ({name}, {p['rows']} samples)", mm(p["mae_nominal_m"]), mm(p["mae_m"]),
               mm(p["distance_error_nominal_m"]), mm(p["distance_error_m"])]
              for name, key in (("training", "data"), ("test", "test")) for p in e[key] or []]
    same(f"{name}: errors of the table by placement", wanted, cells(page, "Errors of the table of offsets"))
    rows = [line.rstrip("\n").split("\t") for line in open(base + ".tsv") if line[0] != "#"][1:]
    factor = {"rad/(N*m)": 1e6}
    same(f"{name}: parameters", [[f"{factor.get(r[2], 1e3) * float(r[5]):.3f}", f"{factor.get(r[2], 1e3) * float(r[6]):.3f}"
                                  if float(r[6]) < 9e99 else ""] for r in rows],
         [[row[2].replace("&ndash;", ""), row[3].replace("&ndash;", "")] for row in cells(page, "Parameters")])


compare("demo", "data/demo/train.tsv", "--test", "data/demo/test.tsv")
with open(os.path.join(folder, "demo.json")) as demo:
    rungs = json.load(demo)
rungs = [rungs["gap"]["geometry_m"], *(c["cumulative_m"] for c in rungs["causes"])]
same("demo: each step of the ladder is a fit of its own", True, len(rungs) == 3 and
     all(b < 0.9 * a for a, b in zip(rungs, rungs[1:])))
faults = os.path.join(folder, "faults_data.tsv")
run("simulate", "-q", *ARM, "--seed", "4", "--placements", "4", "--rows", "20", "--perturb", "2,3", "--noise", "1e-4",
    "--effect", "joint_compliance:joint_2=4e-5", "--effect", "tool_motion:p2/1@12=2e-3", "-o", faults)
compare("faults", faults)
log = os.path.join(folder, "eccentric_data.tsv")
run("simulate", "-q", *ARM, "--seed", "8", "--placements", "5", "--rows", "20", "--perturb", "2,3", "--noise", "1e-4",
    "--effect", "encoder_eccentricity:joint_3=1e-3", "-o", log)
compare("eccentric", log)
sys.exit(failed)
