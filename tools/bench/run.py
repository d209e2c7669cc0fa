#!/usr/bin/env python3
"""make bench: the re-calibration (recalibrate.py), then the fit beside the method's published program and beside numpy, in one run.

The published robots' data are not part of the project: MUKCA_REAL_DATA or ../shared/real. numpy is
taken as it is found, else installed into build/venv.
"""
import importlib.util
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BUILD = os.environ.get("BUILD", "build")
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
DATA = os.environ.get("MUKCA_REAL_DATA", "../shared/real")
REPEATS = int(os.environ.get("BENCH_REPEATS", "31"))

# What the method's published program needs, measured on one thread of a machine like ours: seconds
# and MiB of the whole process, seconds of it in IPOPT.
PUBLISHED = {60: (5.3, 748, 0.17), 550: (53.0, 5157, 1.5)}
CASES = [("panda_2_clean/front_center", ["panda_2_clean/front_center"]), ("panda_2, nine placements", None)]


def output(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {command[0]} {command[1]}: {done.stderr.strip()}")
    return done.stdout


def numpy_python():
    if importlib.util.find_spec("numpy"):
        return sys.executable
    python = os.path.join(BUILD, "venv", "bin", "python3")
    if not os.path.exists(python):
        output(sys.executable, "-m", "venv", os.path.join(BUILD, "venv"))
    if subprocess.run([python, "-c", "import numpy"], capture_output=True).returncode != 0:
        output(python, "-m", "pip", "install", "-q", "numpy")
    return python


def milli(seconds):
    return f"{1e3 * seconds:10.3f} ms"


def process(repeats, *command):
    seconds, kib = output(os.path.join(BUILD, "bench/bench_process"), repeats, *command).split()
    return float(seconds), int(kib) / 1024


def main():
    python = numpy_python()
    print(output(sys.executable, os.path.join(HERE, "recalibrate.py"), python), end="")
    print(output(sys.executable, os.path.join(HERE, "lcm_speed.py")), end="")
    if not os.path.isdir(DATA):
        print(f"SKIPPED bench of the fit: no data in {DATA}; set MUKCA_REAL_DATA")
        return 0
    urdf = os.path.join(DATA, "panda.urdf")
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
        seconds, peak = process(REPEATS, MUKCA, "calibrate", "--urdf", urdf, *paths)
        python_seconds, python_peak = process(max(3, REPEATS // 5), *peer, 1, *paths)
        print(f"  {'whole process':34}{milli(seconds)} {peak:8.1f} MiB   mukca calibrate")
        print(f"  {'':34}{milli(python_seconds)} {python_peak:8.1f} MiB   numpy: "
              f"{python_seconds / seconds:.0f} times the time, {python_peak / peak:.0f} times the memory")
        print(f"  {'':34}{milli(whole)} {mib:8.1f} MiB   published program: "
              f"{whole / seconds:.0f} times the time, {mib / peak:.0f} times the memory")
        for _, kernel, n, seconds in (line for line in lines if line[0] == "kernel"):
            print(f"  {kernel + ', ' + n + ' rows':34}{1e6 * float(seconds):10.2f} us   "
                  f"{1e9 * float(seconds) / int(n):6.0f} ns per row")
    return 0


if __name__ == "__main__":
    sys.exit(main())
