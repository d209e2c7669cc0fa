#!/usr/bin/env python3
"""make -f tools/Makefile verify-paper: Kana et al., Sensors 2022, 22, 2295, Tables 3 to 12, ours beside theirs.

The true arm is the Gen3 of their Table 2 with their Table 3 built in. Two runs: without compliance, where
nothing but rounding may be left, and with 3e-4 rad/(N m) in joints 2, 4 and 6, which their section 7
blames. Exits with 1 where a claim of ours fails.
"""
import hashlib
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
MUKCA = os.environ.get("MUKCA", os.path.join(ROOT, "build", "mukca"))
URDF = os.path.join(ROOT, "data", "gen3.urdf")
RECIPES = os.path.join(os.environ.get("BUILD", os.path.join(ROOT, "build")), "bench", "bench_recipes")
JOINTS = [f"joint_{i}" for i in range(1, 8)] + ["tool_joint"]
TURN = [1, 0.5, -0.5, 0.5, -0.5, 0.5, -0.5, 1]  # times pi about x
P = [(0, 0, .1564), (0, .0054, -.1284), (0, -.2104, -.0064), (0, .0064, -.2104), (0, -.2084, -.0064),
     (0, 0, -.1059), (0, -.1059, 0), (0, 0, -.0615)]
TABLE_3 = ([.0044, .0088, -.0035, -.0043, .0068, .0026, -.0084],
           [(.0085, .0003, -.0083), (-.0068, 0, 0), (-.0001, -.0041, .0028), (-.0003, .0015, 0), (.0001, 0, 0),
            (-.0003, -.0001, -.0024), (.0009, 0, 0), (.0009, -.0003, 0)])
TABLE_8 = ([.0048, .0080, -.0076, -.0034, .0110, .0025, -.0090],
           [(.0082, .0003, -.0078), (-.0063, -.0029, 0), (0, 0, 0), (0, 0, -.0043), (.0001, -.0020, -.0017),
            (-.0023, 0, 0), (.0026, .0004, 0), (.0007, -.0006, 0)])
# max, mean, std in mm: before, angular offsets, both
POSITION = {4: ((19.4, 9.1, 2.7), (14.5, 5.3, 3.3), (5.9, 0.8, 1.1)),
            6: ((14.9, 12.5, 1.5), (8.2, 6.4, 0.9), (9.1, 5.8, 1.5)),
            9: ((19.43, 9.66, 2.61), (14.27, 5.80, 2.88), (6.04, 1.26, 1.08)),
            11: ((13.52, 11.44, 1.21), (8.52, 7.08, 0.80), (2.87, 1.47, 0.66))}
# max, mean, std in mrad of |ex|, |ey|, |ez|: before, after
ORIENTATION = {
    5: (((17.1, 5.1, 3.9), (19.4, 7.0, 4.3), (10.8, 1.5, 1.7)), ((11.5, 3.5, 2.8), (14.4, 3.9, 4.0), (2.9, .74, .75))),
    7: (((16.9, 13.5, 1.1), (7.6, 3.1, 2), (13.1, 5.7, 2.4)), ((6.9, 4.0, 9.3), (4.6, 1.7, .9), (4.1, 2.2, 1.1))),
    10: (((17.1, 6.3, 4.5), (19.4, 8.1, 4.5), (21.6, 3.8, 4.6)), ((11.6, 3.1, 3.1), (14.5, 3.5, 3.7), (5.8, .9, 1.0))),
    12: (((12.2, 8.3, 1.7), (17.0, 13.4, 2.8), (13.4, 8.3, 3.0)), ((5.6, 2.2, 1.3), (3.1, 2.6, 1.3), (4.1, 1.2, 1.0)))}
COMPLIANCE = ",".join(f"joint_compliance:joint_{j}=3e-4" for j in (2, 4, 6))
failed = []


def claim(good, text):
    print(("ok      " if good else "NOT SO  ") + text)
    if not good:
        failed.append(text)


def run(*arguments):
    done = subprocess.run([MUKCA, *arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"mukca {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def rpy_of(turn, zero):
    """Rx(turn) Rz(zero) as roll, pitch, yaw near (turn, 0, 0)."""
    c, s = math.cos(zero), math.sin(zero)
    r = (math.sin(turn) * s, math.sin(turn) * c, math.cos(turn))
    roll = math.atan2(r[1], r[2])
    return (roll + 2 * math.pi * round((turn - roll) / (2 * math.pi)), math.atan2(-r[0], math.hypot(r[1], r[2])),
            math.atan2(math.cos(turn) * s, c))


def write_truth(path):
    with open(path, "w") as f:
        f.write("# urdf_sha256: %s\n" % hashlib.sha256(open(URDF, "rb").read()).hexdigest())
        f.write("joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n")
        for k, joint in enumerate(JOINTS):
            rows = [(n, "m", P[k][i], TABLE_3[1][k][i]) for i, n in enumerate("xyz")]
            if k < 7:
                turn = TURN[k] * math.pi
                for n, nominal, value in zip(("roll", "pitch", "yaw"), (turn, 0, 0), rpy_of(turn, TABLE_3[0][k])):
                    rows.append((n, "rad", nominal, value - nominal))
            for name, unit, nominal, offset in rows:
                f.write(f"{joint}\t{name}\t{unit}\t{nominal!r}\t{nominal + offset!r}\t{offset!r}\t0\t1\t-\n")


def record(folder, name, truth, *more):
    logs = {}
    for recipe in ("sweeps", "raster", "targeted", "targeted-test"):
        logs[recipe] = os.path.join(folder, f"{name}_{recipe}.tsv")
        angles = os.path.join(folder, f"{recipe}.tsv")
        with open(angles, "w") as f:
            subprocess.run([RECIPES, URDF, recipe], stdout=f, check=True)
        run("simulate", "--urdf", URDF, "--offsets", truth, "--at", angles, "-o", logs[recipe], "-q", *more)
    return logs


def table(text):
    lines = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0], (float(v) for v in line))) for line in lines[1:]]


def peaks(folder, log):
    """What model 1 leaves on the sweeps, mm: the largest error of each joint's sweep, on either side of 0."""
    offsets = os.path.join(folder, "offsets.tsv")
    run("recalibrate", "--urdf", URDF, log, "-o", offsets, "--force", "-q")
    rows = table(open(log).read())
    found = table(run("fk", "--urdf", URDF, "--offsets", offsets, log))
    largest = {}
    for row, tip in zip(rows, found):
        moving = max(JOINTS[:7], key=lambda j: abs(row[j]))
        error = 1e3 * math.dist([row[k] for k in ("x_m", "y_m", "z_m")], [tip[k] for k in ("x_m", "y_m", "z_m")])
        largest[moving, row[moving] > 0] = max(error, largest.get((moving, row[moving] > 0), 0))
    return largest


def recalibrate(folder, logs, test):
    """[model 1 of the sweeps, model 2 of sweeps and work volume]"""
    path = os.path.join(folder, "result.json")
    results = []
    for data in (("sweeps",), ("sweeps", "targeted")):
        run("recalibrate", "--urdf", URDF, *(logs[d] for d in data), "--test", logs[test],
            "--json", path, "--force", "-q")
        results.append(json.load(open(path))["models"][0])
    return results


def three(moments, suffix, factor=1e3):
    return tuple(factor * moments[k + suffix] for k in ("max_", "mean_", "std_"))


def show_position(number, title, rigid, soft):
    print(f"\nTable {number}, {title}: position error, mm (max; mean +- std)")
    print(f"  {'':17}{'paper':>26}{'ours, rigid arm':>30}{'ours, compliant arm':>30}")
    for i, stage in enumerate(("before", "angles", "both")):
        cells = [POSITION[number][i]] + [three(r["position"][stage], "m") for r in (rigid, soft)]
        line = "".join(f"{c[0]:.3f}; {c[1]:.3f} +- {c[2]:.3f}".rjust(30 if k else 26) for k, c in enumerate(cells))
        print(f"  {('before', 'angular offsets', 'both')[i]:17}{line}")
    for i, stage in ((1, "angles"), (2, "both")):
        before, after = POSITION[number][0], POSITION[number][i]
        pairs = [(before, after)] + [[three(r["position"][s], "m") for s in ("before", stage)] for r in (rigid, soft)]
        removed = [[100 * (1 - a / b) for b, a in zip(*pair)][:2] for pair in pairs]
        print(f"  removed, {('', 'angles', 'both')[i]:8}" + "".join(
            f"{c[0]:.1f} %; {c[1]:.1f} %".rjust(30 if k else 26) for k, c in enumerate(removed)))


def show_orientation(number, title, rigid, soft):
    print(f"\nTable {number}, {title}: orientation error, mrad (max; mean +- std)")
    print(f"  {'':17}{'paper':>26}{'ours, rigid arm':>30}{'ours, compliant arm':>30}")
    for i, stage in ((0, "before"), (1, "both")):
        for a, axis in enumerate(("|ex|", "|ey|", "|ez|")):
            cells = [ORIENTATION[number][i][a]]
            cells += [three(r["orientation"][stage]["axes"][a], "rad") for r in (rigid, soft)]
            line = "".join(f"{c[0]:.3f}; {c[1]:.3f} +- {c[2]:.3f}".rjust(30 if k else 26) for k, c in enumerate(cells))
            print(f"  {('before', 'after')[i] + ' ' + axis:17}{line}")


def identifiable_part(offsets):
    """What poses can tell of the lengths: a joint's origin along the joint's own axis and the next origin's z
    act alike, so only their sum counts; it is shown at the joint, and the next z is 0."""
    values = [list(v) for v in offsets]
    for k in range(6, -1, -1):
        axis = (0, -math.sin(TURN[k] * math.pi), math.cos(TURN[k] * math.pi))
        for i in range(3):
            values[k][i] += axis[i] * values[k + 1][2]
        values[k + 1][2] = 0.0
    return values


def offsets_of(model):
    value = {o["name"]: o["value"] for o in model["offsets"]}
    return [value[f"{j} zero"] for j in JOINTS[:7]], [tuple(value[f"{j} {a}"] for a in "xyz") for j in JOINTS]


def show_offsets(number, paper, model, soft):
    ours, ours_soft = offsets_of(model), offsets_of(soft)
    parts = [identifiable_part(x[1]) for x in (paper, ours, ours_soft)]
    print(f"\nTable {number}: offsets, mrad and mm; lengths as far as poses can tell them (17 of 24), see the code")
    print(f"  {'':12}{'paper':>34}{'ours, rigid arm':>34}{'ours, compliant arm':>34}")
    for k, joint in enumerate(JOINTS):
        cells = []
        for x, part in zip((paper, ours, ours_soft), parts):
            angle = f"{1e3 * x[0][k]:7.2f}" if k < 7 else "      -"
            cells.append(angle + " | " + " ".join(f"{1e3 * v + 0.0:7.3f}" for v in part[k]))
        print(f"  {joint:12}" + "".join(c.rjust(34) for c in cells))
    return ours, parts


def main():
    with tempfile.TemporaryDirectory() as folder:
        truth = os.path.join(folder, "truth.tsv")
        write_truth(truth)
        rigid, soft = record(folder, "rigid", truth), record(folder, "soft", truth, "--effect", COMPLIANCE)
        noisy = record(folder, "noisy", truth, "--effect", COMPLIANCE, "--noise", "1e-4", "--rotation-noise", "1e-4")
        one = recalibrate(folder, rigid, "raster")[0]
        two = recalibrate(folder, rigid, "targeted-test")[1]
        soft_raster = recalibrate(folder, soft, "raster")
        soft_targeted = recalibrate(folder, soft, "targeted-test")
        diagnosis = os.path.join(folder, "diagnosis.json")
        run("diagnose", "--urdf", URDF, noisy["sweeps"], noisy["raster"], "--json", diagnosis, "-q")
        found = json.load(open(diagnosis))["causes"]
        peak = peaks(folder, soft["sweeps"])

    ours, parts = show_offsets(3, TABLE_3, one, soft_raster[0])
    show_position(4, "model 1, sweeps", one["train"], soft_raster[0]["train"])
    show_orientation(5, "model 1, sweeps", one["train"], soft_raster[0]["train"])
    show_position(6, "model 1, raster", one["test"], soft_raster[0]["test"])
    show_orientation(7, "model 1, raster", one["test"], soft_raster[0]["test"])
    show_offsets(8, TABLE_8, two, soft_targeted[1])
    show_position(9, "model 2, sweeps and work volume", two["train"], soft_targeted[1]["train"])
    show_orientation(10, "model 2, sweeps and work volume", two["train"], soft_targeted[1]["train"])
    show_position(11, "model 2, targeted test", two["test"], soft_targeted[1]["test"])
    show_orientation(12, "model 2, targeted test", two["test"], soft_targeted[1]["test"])

    print("""
What the figures are. `before` is kinematics alone and agrees with the paper within its robot's differences (our
raster and work volume are our own: the paper does not list its points). The paper's residual after both steps
(0.8 mm on the sweeps, 5.8 mm on the raster) cannot be had from kinematics: an arm that differs by constants alone
leaves rounding (rigid arm). With compliance in joints 2, 4 and 6 our residual has the shape that the paper shows:
small over most of the sweep, some mm where joints 2, 4, 6 hold the arm out, worst for the joint nearest the base;
several mm on the raster, which the sweeps do not predict; about 1 mm again in the work volume once rows from
there are fitted (Table 11). The paper's Table 8 differs from its Table 3 for the same reason: constants bend to
take up compliance; ours do so, too (last column), while those of the rigid arm stay what was built in.
""")
    test, left = one["test"], one["train"]["position"]["both"]
    claim(left["max_m"] < 1e-6, "the fit leaves under 1 um on the sweeps: "
          f"{1e6 * left['mean_m']:.4f} um mean, {1e6 * left['max_m']:.4f} um max")
    claim(test["position"]["both"]["max_m"] < 2e-6 and test["orientation"]["both"]["max_rad"] < 2e-6,
          f"poses not seen (raster) to {1e6 * test['position']['both']['max_m']:.6f} um, "
          f"{1e6 * test['orientation']['both']['max_rad']:.6f} urad")
    claim(one["rank"] == 24 and one["unknowns"] == 31, f"rank {one['rank'] - 7} of 24 lengths, 7 of 7 angles")
    claim(max(abs(a - b) for a, b in zip(ours[0], TABLE_3[0])) < 1e-9, "the angles of Table 3 come back")
    claim(max(abs(a - b) for x, y in zip(parts[0], parts[1]) for a, b in zip(x, y)) < 1e-9,
          "the lengths of Table 3 come back, as far as poses can tell them")
    mean = soft_raster[0]["train"]["position"]["both"]["mean_m"]
    worst = soft_raster[0]["train"]["position"]["both"]["max_m"]
    claim(2e-4 < mean < 1.1e-3 and 4e-3 < worst < 8e-3,
          f"compliance leaves {1e3 * mean:.2f} mm mean, {1e3 * worst:.1f} mm max on the sweeps (paper: 0.8, 5.9)")
    a, b = (m["test"]["position"]["both"]["mean_m"] for m in soft_targeted)
    claim(b < 0.5 * a, f"model 2 beats model 1 in the work volume: {1e3 * b:.2f} mm against {1e3 * a:.2f} mm")
    print("        largest error of each sweep, mm, below and above 0: " + ", ".join(
        f"{j} {peak[j, False]:.1f} {peak[j, True]:.1f}" for j in JOINTS[:7]))
    pairs = [(peak[j, False], peak[j, True]) for j in ("joint_2", "joint_4", "joint_6")]
    claim(all(max(p) < 2.1 * min(p) for p in pairs) and min(pairs[0]) > max(pairs[1]) and min(pairs[1]) > max(pairs[2]),
          "three pairs of peaks of like size, in the sweeps of joints 2, 4, 6, falling towards the tip")
    claim(min(pairs[1]) > max(peak[j, side] for j in JOINTS[:7:2] for side in (False, True)),
          "the other joints' sweeps leave less than those of joints 2 and 4")
    named = [(c["effect"], c["joint"]) for c in found[:2]]
    claim(set(named) == {("joint_compliance", "joint_2"), ("joint_compliance", "joint_4")} and
          all(2.4e-4 < c["amplitude"] < 3.6e-4 for c in found[:2]),
          "diagnose (0.1 mm of noise, sweeps and raster) names first: " + ", ".join(
              f"{c['effect']} at {c['joint']}, {1e6 * c['amplitude']:.0f} urad/(N m)" for c in found[:2]))
    third = [c for c in found[2:] if c["joint"] == "joint_6" and
             "joint_compliance" in [c["effect"]] + [t["effect"] for t in c["ties"]]]
    claim(bool(third), "and at joint_6, where the torque is least, compliance or what ties with it: " + ", ".join(
        f"{c['effect']} (ties: {', '.join(t['effect'] for t in c['ties']) or 'none'})" for c in third))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
