#!/usr/bin/env python3
"""Table I of the MUKCa paper, the minima of the cost, and the diagnosis, on the published robots' data.

Prints tables and exits with 1 where a figure is missed; --calibration leaves out the diagnosis. The data
are not part of the project: MUKCA_REAL_DATA or ../shared/real; without them it says so, and only simulated
logs are diagnosed.
"""
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
import verify_real_diagnosis as diagnosis  # noqa: E402

MUKCA = os.environ.get("MUKCA", "build/mukca")
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")

# name, URDF, robot's folder, training placement, published MAE (m) as printed: nominal and calibrated
# on train, the same on test; minimum of J
TABLE_I = [
    ("Panda (1)", "panda", "panda_2_clean", "front_center",
     ("8.278e-3", "1.679e-4", "7.788e-3", "3.473e-4"), 6.6220029924e-08),
    ("Panda (2)", "panda", "panda_3", "frontcenter",
     ("3.315e-3", "1.514e-4", "3.258e-3", "2.380e-4"), 3.1871652886e-08),
    ("FR3", "panda", "panda_4_clean", "front",
     ("8.515e-3", "1.607e-4", "8.808e-3", "2.776e-4"), 5.8908295037e-08),
    ("KUKA iiwa 14", "iiwa14", "kuka_14", "front",
     ("7.229e-4", "1.068e-4", "8.061e-4", "2.676e-4"), 1.4253592186e-08),
]
MORE_MINIMA = [
    ("panda_1, front", "panda", ["panda_1/front"], 9.5688640045e-08),
    ("dinova_1, front", "gen3lite", ["dinova_1/front"], 1.6073959082e-05),
    ("panda_2, all nine", "panda", "panda_2", 2.6019628944e-06),
    ("panda_2_clean, all eight", "panda", "panda_2_clean", 1.1463853711e-06),
    ("kuka_14, all three", "iiwa14", "kuka_14", 1.5234655541e-07),
]
COMBINATIONS = [(s, g) for s in ("slsqp", "lbfgs", "gauss-newton") for g in ("fd", "analytic")]
TOLERANCE = 1e-6
failures = 0


def placements(robot):
    folder = os.path.join(DATA, robot)
    return [f"{robot}/{name}" for name in sorted(os.listdir(folder))
            if os.path.isdir(os.path.join(folder, name))]


def calibrate(urdf, train, test, solver, gradient):
    command = [MUKCA, "calibrate", "-q", "--urdf", os.path.join(DATA, urdf + ".urdf"), "--json", "-",
               "--solver", solver, "--gradient", gradient, *(os.path.join(DATA, p) for p in train)]
    if test:
        command += ["--test", *(os.path.join(DATA, p) for p in test)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):  # 1: not accepted, as of a tool that moved
        sys.exit(f"verify-real: {' '.join(command)}: exit {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def mark(good):
    global failures
    failures += not good
    return "ok" if good else "MISSED"


def printed(value, published):
    """The value with the digits of the published one: 8.278e-3."""
    digits, exponent = published.split("e")
    return f"{value / 10.0 ** int(exponent):.{len(digits) - 2}f}e{exponent}"


def mean(scores, key):
    return sum(score[key] for score in scores) / len(scores)


def calibration():
    print(f"{'Table I':14}{'':4}{'nominal':>12}{'calibrated':>12}{'published':>24}")
    results = {}
    for name, urdf, robot, place, published, minimum in TABLE_I:
        train = [f"{robot}/{place}"]
        test = [p for p in placements(robot) if p not in train]
        for combination in COMBINATIONS:
            results[name, combination] = calibrate(urdf, train, test, *combination)
        for part, at in (("train", 0), ("test", 2)):
            good, shown = True, None
            for combination in COMBINATIONS:
                scores = results[name, combination][part]
                got = tuple(printed(mean(scores, key), published[at + i])
                            for i, key in enumerate(("mae_nominal_m", "mae_m")))
                good = good and got == published[at:at + 2]
                shown = shown or got
            print(f"{name if at == 0 else '':14}{part:6}{shown[0]:>10}{shown[1]:>12}"
                  f"{published[at] + ' ' + published[at + 1]:>24}  {mark(good)}")
    print(f"\nmean errors in m, the same by all {len(COMBINATIONS)} combinations of solver and gradient;"
          " test: mean over the other placements\n")
    heads = "".join(f"{s + ' ' + g[:2]:>17}" for s, g in COMBINATIONS)
    print(f"{'minimum of J, m^2: relative difference':44}{heads}")
    cases = [(name, urdf, [f"{robot}/{place}"], minimum)
             for name, urdf, robot, place, _, minimum in TABLE_I]
    cases += [(name, urdf, placements(train) if isinstance(train, str) else train, minimum)
              for name, urdf, train, minimum in MORE_MINIMA]
    for name, urdf, train, minimum in cases:
        cells, good = [], True
        for combination in COMBINATIONS:
            result = results.get((name, combination)) or calibrate(urdf, train, None, *combination)
            off = result["cost"]["calibrated"]["total"] / minimum - 1
            good = good and abs(off) <= TOLERANCE and result["converged"]
            cells.append(f"{off:>+11.1e} ({result['solver']['evaluations']:>2})")
        print(f"{name:26}{minimum:>18.10e}{''.join(f'{c:>17}' for c in cells)}  {mark(good)}")
    print(f"\n(evaluations of the cost in brackets) tolerance {TOLERANCE:g}")
    print("calibration:", "all as published" if failures == 0 else f"{failures} lines missed")


def main():
    data = os.path.isdir(DATA)
    if data:
        calibration()
    else:
        print(f"SKIPPED verify-real: no data in {DATA}; set MUKCA_REAL_DATA")
    if "--calibration" not in sys.argv[1:]:
        if data:
            diagnosis.real(DATA)
        diagnosis.stale_logs()
    print(f"\nverify-real: {failures} lines of the calibration missed, {diagnosis.missed} of the diagnosis fall short")
    return 1 if failures or diagnosis.missed else 0


if __name__ == "__main__":
    sys.exit(main())
