"""Growth: processor time and memory of whole commands from a thousand rows to a million, and a plot of them."""
import os
import shutil
import subprocess

from common import BUILD, MUKCA, goal, output, process

ARM, GEN3 = "data/demo/arm.urdf", "data/gen3.urdf"
ROWS = int(os.environ.get("BENCH_ROWS", "1000000"))
EVERY = (1001, 333, 101, 33, 9, 3, 1)  # odd: a session's sockets alternate
# processor time, s, and memory, MiB, at a million rows
GOALS = {"calibrate": (2, None), "diagnose": (None, 500), "recalibrate": (None, None)}
PLOT = """set terminal pngcairo size 900,420
set output '{folder}/growth.png'
set logscale xy
set grid
set xlabel 'rows'
set key left top
set multiplot layout 1,2
set ylabel 'processor time, s'
plot for [i=0:2] '{folder}/growth.tsv' index i using 1:2 with linespoints title columnheader(1)
set ylabel 'peak memory, MiB'
plot for [i=0:2] '{folder}/growth.tsv' index i using 1:3 with linespoints title columnheader(1)
"""


def thin(path, every, out):
    """Every k-th row of a table below its header."""
    rows, header = 0, False
    with open(path) as source, open(out, "w") as to:
        for line in source:
            if line.startswith("#") or not header:
                header = header or not line.startswith("#")
                to.write(line)
                continue
            if rows % every == 0:
                to.write(line)
            rows += 1
    return (rows + every - 1) // every


def main():
    folder = os.path.join(BUILD, "bench")
    session, poses, part = (os.path.join(folder, name) for name in ("million.tsv", "poses.tsv", "part.tsv"))
    print(f"\ngrowth: whole commands, processor time and peak memory, up to {ROWS} rows")
    output(MUKCA, "simulate", "-q", "--force", "--urdf", ARM, "--placements", 5, "--rows", max(2, ROWS // 10), "--perturb", "1,2",
           "--noise", "1e-4", "--effect", "joint_compliance:joint_4=4e-5", "-o", session)
    with open(poses, "w") as f:
        subprocess.run([os.path.join(folder, "bench_recalibrate"), GEN3, str(ROWS), "-"], check=True, stdout=f)
    with open(os.path.join(folder, "growth.tsv"), "w") as figures:
        for command, urdf, table in (("calibrate", ARM, session), ("diagnose", ARM, session), ("recalibrate", GEN3, poses)):
            print(command, file=figures)
            for every in EVERY:
                rows = thin(table, every, part)
                if rows < 500:
                    continue
                _, busy, mib = process(1 if every < 9 else 3, MUKCA, command, "-q", "--urdf", urdf, part)
                seconds, memory = GOALS[command] if rows == 1000000 else (None, None)
                print(rows, busy, mib, file=figures)
                print(f"  {command:12}{rows:9} rows{busy:9.3f} s{mib:9.1f} MiB{1e6 * busy / rows:9.1f} us per row"
                      f"{goal(busy, seconds)}{goal(mib, memory)}")
            print("\n", file=figures)
    for path in (session, poses, part):
        os.remove(path)
    if shutil.which("gnuplot"):
        subprocess.run(["gnuplot"], input=PLOT.format(folder=folder), text=True, check=True)
        print(f"  plot: {folder}/growth.png")
    else:
        print("  SKIPPED plot: no gnuplot")
