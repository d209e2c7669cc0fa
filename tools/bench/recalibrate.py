"""The re-calibration beside numpy's lstsq on the same rows, with text and without: processor times of runs in turn."""
import os
import statistics
import subprocess

from common import BUILD, HERE, MUKCA, goal, output, process, python_with

URDF = "data/gen3.urdf"
BENCH = os.path.join(BUILD, "bench", "bench_recalibrate")
ROWS = int(os.environ.get("BENCH_ROWS", "1000000"))
RUNS = 5


def line(words, seconds, mib, ratios=None, least=None):
    median = statistics.median(seconds)
    spread = f"[{min(seconds):.2f}, {max(seconds):.2f}]"
    tail = ""
    if ratios:
        ratio = statistics.median(ratios)
        tail = f"   {ratio:.1f} times [{min(ratios):.1f}, {max(ratios):.1f}]{goal(ratio, least, True)}"
    print(f"  {words:36}{median:8.2f} s {spread:16}{mib:8.0f} MiB{tail}")


def main():
    python = python_with("numpy")
    log = os.path.join(BUILD, "bench", "poses.tsv")
    print(f"\nre-calibration of a 7-axis arm, {ROWS} poses, 31 unknowns: medians of {RUNS} runs in turn, smallest and largest")
    with open(log, "w") as f:
        subprocess.run([BENCH, URDF, str(ROWS), "-"], check=True, stdout=f)
    ours, text, theirs, whole, kib = [], [], [], [], 0
    for _ in range(RUNS):
        ours.append(float(output(BENCH, URDF, ROWS).split()[2]))
        _, busy, mib = process(1, MUKCA, "recalibrate", "--urdf", URDF, log)
        text.append(busy)
        if python:
            _, seconds, all_seconds, _, kib = output(python, os.path.join(HERE, "peer_recalibrate.py"), URDF, log).split()
            theirs.append(float(seconds))
            whole.append(float(all_seconds))
    os.remove(log)
    line("without text", ours, process(1, BENCH, URDF, ROWS)[2], [b / a for a, b in zip(ours, theirs)], 5)
    line("with text, whole process", text, mib, [b / a for a, b in zip(text, whole)], 4)
    if python:
        line("numpy.linalg.lstsq without text", theirs, int(kib) / 1024)
        line("the same with numpy.loadtxt", whole, int(kib) / 1024)
    else:
        print("  SKIPPED numpy: it cannot be installed")
