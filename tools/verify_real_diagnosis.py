"""The diagnosis on the published real robots, on tracker data, and on simulated tracker logs.

Part of verify_real.py. Errors are held-out means in mm, leave one placement out; the goals stand beside
them. No option differs between robots but the URDF and its masses.
"""
import json
import os
import subprocess
import tempfile
import time

MUKCA = os.environ.get("MUKCA", "build/mukca")
SHOWN = {"rad/(N*m)": (1e6, "urad/(N*m)"), "rad": (1e3, "mrad"), "m": (1e3, "mm")}
ELASTIC = ("joint_compliance", "link_bending")
# robot, URDF, masses, geometry expected, explained at most (mm; None: no goal)
ROBOTS = [
    ("kuka_14", "iiwa14", "inertials_iiwa14.tsv", 0.239, 0.120),
    ("panda_3", "panda", "inertials_panda.tsv", 0.196, 0.135),
    ("panda_4", "panda", "inertials_panda.tsv", 0.238, 0.140),
    ("panda_2_clean", "panda", "inertials_panda.tsv", 0.282, 0.250),
    ("panda_1", "panda", "inertials_panda.tsv", 0.792, None),
    ("dinova_1", "gen3lite", None, 3.74, None),
    ("panda_2", "panda", "inertials_panda.tsv", None, None),
    ("panda_4_clean", "panda", "inertials_panda.tsv", None, None),
]
# The blemishes listed with the data, which counts rows from 0: robot, kind, placement, socket, row as the
# program counts from 1 (None: any), mm (None: not told).
FAULTS = [
    ("kuka_14", "tool_motion", "raised_left", "0", None, 0.75),
    ("kuka_14", "tool_motion", "raised_left", "1", None, 0.75),
    ("dinova_1", "tool_motion", "front", "0", 8, 11.7),
    ("panda_2", "tool_motion", "high", None, 26, 1.8),
    ("panda_2", "tool_motion", "high", None, 20, 1.1),
]
for robot in ("panda_2", "panda_2_clean"):
    FAULTS += [(robot, "duplicate", "back_right", "0", 7, None),
               (robot, "outlier", "front_left", "1", 22, None),
               (robot, "outlier", "front_left", "1", 23, None),
               (robot, "outlier", "front_right", "0", 15, None)]
NO_MOTION = ("panda_3", "panda_4")
NEAR = 3  # rows by which the start of a motion may be off
missed = 0


def mark(good):
    global missed
    missed += not good
    return "pass" if good else "FALLS SHORT"


def diagnose(urdf, *arguments):
    """The answer, and the seconds of the whole process."""
    began = time.time()
    done = subprocess.run([MUKCA, "diagnose", "-q", "--urdf", urdf, *arguments, "--json", "-"],
                          capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"verify-real: {done.args}: exit {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout), time.time() - began


def milli(value):
    return "-" if value is None else f"{1e3 * value:.3f}"


def name_of(cause):
    where = cause.get("joint") or cause.get("placement") or ""
    order = f"@{cause['order']}" if cause.get("order") else ""
    return f"{cause['effect']}:{where}{order}" if where else cause["effect"]


def sized(cause):
    factor, unit = SHOWN.get(cause["unit"], (1, cause["unit"]))
    return f"{name_of(cause)} {factor * cause['amplitude']:.2g} {unit}"


def named(cause):
    """(effect, joint) of a cause and of those that it ties with."""
    return [(c["effect"], c.get("joint") or "") for c in [cause] + (cause.get("ties") or [])]


def found(fault, answer):
    """The fault of the answer that is the listed one, else None."""
    _, kind, placement, socket, row, _ = fault
    slack = NEAR if kind == "tool_motion" else 0
    near = [f for f in answer["data_faults"]
            if f["kind"] == kind and f["placement"] == placement and socket in (None, str(f["socket"]))
            and (row is None or abs(f["row"] - row) <= slack)]
    return min(near, key=lambda f: abs(f["row"] - (row or 0)), default=None)


def claims(robot, answer):
    """What the robot's answer must hold, as (sentence, bool)."""
    causes = [c for c in answer["causes"] if c["effect"] != "tool_motion"]
    ripple = [c for c in causes if c["effect"] == "gear_harmonic"]
    out = []
    if robot == "kuka_14":
        out.append(("flexibility of the elbow named first", causes and any(
            effect in ELASTIC and joint in ("joint_a3", "joint_a4", "joint_a5")
            for effect, joint in named(causes[0]))))
    elif robot == "panda_4":
        out.append(("ripple of joint 4, 240 per turn, named", any(
            c["joint"] == "panda_joint4" and c["order"] == 240 for c in ripple)))
    elif robot == "panda_1":
        out.append(("base tilt named", any(
            effect == "base_compliance" for c in causes for effect, _ in named(c))))
    elif robot == "dinova_1":
        gain = answer["gap"]["held_out"]
        out.append(("no shrink is claimed", not causes or gain is None or gain["ci95"][0] <= 0))
    if robot in NO_MOTION:
        out.append(("no motion of the tool flagged", all(
            f["kind"] != "tool_motion" for f in answer["data_faults"])))
    return out


def robots(data):
    print("\nDiagnosis, held-out mean error in mm, leave one placement out\n")
    print(f"{'robot':14}{'rows':>5}{'s':>6} {'verdict':11}{'nominal':>8}{'geometry':>9}{'excused':>8}"
          f"{'explained':>10}{'goal':>8}  {'':12}first causes")
    answers = {}
    for robot, urdf, masses, _, goal in ROBOTS:
        folder = os.path.join(data, robot)
        places = [os.path.join(folder, p) for p in sorted(os.listdir(folder))
                  if os.path.isdir(os.path.join(folder, p))]
        rows = sum(1 for p in places for hole in (0, 1)
                   for _ in open(os.path.join(p, f"hole_{hole}.csv")))
        extra = ["--inertials", os.path.join(data, masses)] if masses else []
        answer, seconds = diagnose(os.path.join(data, urdf + ".urdf"), *extra, *places)
        answers[robot] = answer
        gap = answer["gap"]
        explained = gap["explained_m"]
        last = explained if explained is not None else gap["faults_excused_m"]
        verdict = answer["verdict"] + ("+" if answer["unexplained"] else "")
        print(f"{robot:14}{rows:5}{seconds:6.2f} {verdict:11}{milli(gap['nominal_m']):>8}"
              f"{milli(gap['geometry_m']):>9}{milli(gap['faults_excused_m']):>8}{milli(explained):>10}"
              f"{'' if goal is None else f'<= {goal:.3f}':>9} "
              f"{'' if goal is None else mark(1e3 * last <= goal):12}"
              f"{', '.join(name_of(c) for c in answer['causes'][:4])}")
    print("\n+: structure remains that no effect of the catalogue explains; s: the whole process")
    print("geometry expected: " + ", ".join(
        f"{robot} {expected}" for robot, _, _, expected, _ in ROBOTS if expected))
    print("\nSizes of all causes (docs/diagnosis.md quotes them)\n")
    for robot, answer in answers.items():
        print(f"{robot:14}{', '.join(sized(c) for c in answer['causes'])}")
    print()
    for robot, answer in answers.items():
        for sentence, good in claims(robot, answer):
            print(f"{robot:14}{sentence:44}{mark(good)}")
    print("\nFaults of recording, as listed with the data")
    for fault in FAULTS:
        robot, kind, placement, socket, row, size = fault
        got = found(fault, answers[robot])
        listed = (f"{robot + '/' + placement:26}socket {socket or '?'}, row {row or '?':>2}, {kind:12}"
                  f"{'' if size is None else f'{size:.2f} mm':>9}")
        said = (f"socket {got['socket']}, row {got['row']}"
                + (f", {1e3 * got['size_m']:.2f} mm" if got.get("size_m") else "")) if got else "not found"
        print(f"{listed}  {said:30}{mark(got is not None)}")
    for robot, answer in answers.items():
        listed = [found(fault, answer) for fault in FAULTS if fault[0] == robot]
        extra = [f for f in answer["data_faults"] if f not in listed]
        if extra:
            print(f"{robot}: besides the listed: " + ", ".join(
                f"{f['kind']} {f['placement']}/{f['socket']}:{f['row']}" for f in extra))


def tracker(folder):
    print("\nTracked UR5: no single confident cause is right (repeatability 0.1 mm)\n")
    log, urdf = os.path.join(folder, "ur5_grid.tsv"), os.path.join(folder, "ur5.urdf")
    test = ["--test", os.path.join(folder, "ur5_random.tsv")]
    for free in ([], ["--free-base", "--free-tool"]):
        answer, seconds = diagnose(urdf, *free, log, *test)
        gap = answer["gap"]
        print(f"ur5_grid {' '.join(free):25}{seconds:5.2f} s  nominal {milli(gap['nominal_m'])}, geometry "
              f"{milli(gap['geometry_m'])}, explained {milli(gap['explained_m'])}; "
              f"{answer['verdict']} {[name_of(c) for c in answer['causes'][:3]]}  "
              f"{mark(answer['verdict'] != 'named')}")


def stale_logs():
    """Simulated tracker logs: 300 poses, every reading lags a millirad along the last move."""
    print("\nSimulated tracker logs, 300 poses, read-back 1 mrad stale: readback_lag first, play of a joint"
          " never\n")
    urdfs = [p for p in ("data/demo/arm.urdf", "data/gen3.urdf") if os.path.exists(p)]
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(12):
            urdf, command = urdfs[seed // 2 % len(urdfs)], seed % 2 == 1
            position_only = seed % 4 >= 2
            log = os.path.join(folder, f"log_{seed}.tsv")
            subprocess.run(
                [MUKCA, "simulate", "-q", "--urdf", urdf, "--poses", "300", "--perturb", "1,2", "--noise",
                 "5e-5", "--rotation-noise", "1e-4", "--effect", "readback_lag=1e-3", "--seed", str(seed),
                 "-o", log] + ["--command"] * command + ["--position-only"] * position_only, check=True)
            answer, seconds = diagnose(urdf, "--free-base", "--free-tool", log)
            causes = answer["causes"]
            play = any(c["effect"] in ("backlash", "approach_hysteresis") for c in causes)
            size = f"{causes[0]['amplitude']:.3g} {causes[0]['unit'] or ''}" if causes else ""
            good = causes and causes[0]["effect"] == "readback_lag" and not play
            print(f"{seed:2} {os.path.basename(urdf):10}{'commands' if command else 'readings only':15}"
                  f"{'positions' if position_only else 'poses':11}{seconds:5.2f} s  {answer['verdict']:9}"
                  f"{', '.join(name_of(c) for c in causes[:3]):40}{size:>14}  {mark(good)}")


def real(data):
    """Robots and tracker, where their data are."""
    robots(data)
    folder = os.path.join(data, "..", "tracker")
    if os.path.isdir(folder):
        tracker(folder)
    else:
        print(f"\nSKIPPED tracker: no data in {folder}")
