#!/usr/bin/env python3
"""make bench: times and memory beside references, in one run.

Forward kinematics beside CasADi, Pinocchio and KDL, the re-calibration beside numpy, LCM (lcm_speed.py), the fit
beside the method's published program and numpy, the diagnosis beside a numpy prototype, growth in rows. Each peer
is timed in turn with mukca. The published robots' data are not part of the project: MUKCA_REAL_DATA or ../shared/real. What
PyPI gives is taken as found, else installed into build/venv.
"""
import os
import sys

sys.dont_write_bytecode = True
import diagnosis  # noqa: E402
import growth  # noqa: E402
import kinematics  # noqa: E402
import recalibrate  # noqa: E402
from common import BUILD, DATA, HERE, MUKCA, REPEATS, goal, output, process, python_with  # noqa: E402

# What the method's published program needs, measured on one thread of a machine like ours: seconds
# and MiB of the whole process, seconds of it in IPOPT.
PUBLISHED = {60: (5.3, 748, 0.17), 550: (53.0, 5157, 1.5)}
START = {60: 1.2, 550: 3}  # most processor time of calibrate, in starts of python3
CASES = [("panda_2_clean/front_center", ["panda_2_clean/front_center"]), ("panda_2, nine placements", None)]


def milli(seconds):
    return f"{1e3 * seconds:10.3f} ms"


def fit():
    if not os.path.isdir(DATA):
        print(f"SKIPPED bench of the fit: no data in {DATA}; set MUKCA_REAL_DATA")
        return
    python, urdf = python_with("numpy"), os.path.join(DATA, "panda.urdf")
    if not python:
        print("SKIPPED bench of the fit: numpy cannot be installed")
        return
    for name, folders in CASES:
        folders = folders or [f"panda_2/{f}" for f in sorted(os.listdir(os.path.join(DATA, "panda_2")))]
        paths = [os.path.join(DATA, f) for f in folders]
        peer = [python, os.path.join(HERE, "peer.py"), urdf, "ball_link"]
        J, iterations, numpy_seconds, _ = output(*peer, REPEATS, *paths).split()
        numpy_seconds = float(numpy_seconds)
        lines = [line.split() for line in
                 output(os.path.join(BUILD, "bench/bench_fit"), urdf, REPEATS, *paths).splitlines()]
        rows = int(lines[0][1])
        size = 60 if rows < 300 else 550
        whole, mib, ipopt = PUBLISHED[size]
        print(f"\n{name}: {rows} rows, medians of {REPEATS} runs")
        print(f"  {'solve':34}{milli(numpy_seconds)}   numpy Gauss-Newton, {iterations} iterations, J {float(J):.8e}")
        print(f"  {'':34}{milli(ipopt)}   IPOPT in the published program")
        for _, solver, gradient, cost, seconds in (line for line in lines if line[0] == "solve"):
            print(f"  {'  ' + solver + ', ' + gradient:34}{milli(float(seconds))}   "
                  f"{numpy_seconds / float(seconds):6.1f} times faster than numpy, J {float(cost):.8e}")
        _, seconds, peak = process(REPEATS, MUKCA, "calibrate", "--urdf", urdf, *paths)
        _, python_seconds, python_peak = process(max(3, REPEATS // 5), *peer, 1, *paths)
        print(f"  {'whole process, processor time':34}{milli(seconds)} {peak:8.1f} MiB   mukca calibrate")
        _, start, _ = process(REPEATS, sys.executable, "-c", "pass")
        print(f"  {'':34}{milli(start)}{'':14}start of python3: {seconds / start:.2f} times its time"
              f"{goal(seconds / start, START[size])}")
        print(f"  {'':34}{milli(python_seconds)} {python_peak:8.1f} MiB   numpy: "
              f"{python_seconds / seconds:.1f} times the time, {python_peak / peak:.1f} times the memory")
        print(f"  {'':34}{milli(whole)} {mib:8.1f} MiB   published program: "
              f"{whole / seconds:.0f} times the time, {mib / peak:.0f} times the memory")
        for _, kernel, n, seconds in (line for line in lines if line[0] == "kernel"):
            print(f"  {kernel + ', ' + n + ' rows':34}{1e6 * float(seconds):10.2f} us   "
                  f"{1e9 * float(seconds) / int(n):6.0f} ns per row")


def machine():
    """Processor and compiler; no date."""
    with open("/proc/cpuinfo") as f:
        names = [line.split(":", 1)[1].strip() for line in f if line.startswith("model name")]
    compiler = output(*os.environ.get("CC", "gcc").split(), "--version").splitlines()[0]
    return f"{len(names)} cores of {names[0] if names else 'an unknown processor'}; {compiler}"


def others():
    print(output(sys.executable, os.path.join(HERE, "lcm_speed.py")), end="")


PARTS = {"kinematics": kinematics.main, "recalibrate": recalibrate.main, "lcm": others, "fit": fit, "diagnosis": diagnosis.main,
         "growth": growth.main}


def main():
    """All parts, or those of the command line."""
    print(machine())
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()


if __name__ == "__main__":
    main()
