"""Growth: time and memory of whole commands from a thousand rows to a million, and over joints; a plot of them."""
import os
import shutil
import subprocess

from common import BUILD, MUKCA, goal, output, process

ARM, GEN3 = "data/demo/arm.urdf", "data/gen3.urdf"
ROWS = int(os.environ.get("BENCH_ROWS", "1000000"))
EVERY = (1001, 333, 101, 33, 9, 3, 1)  # odd: a session's sockets alternate
# wall time, s, and memory, MiB, at a million rows
GOALS = {"calibrate": (2, 260), "diagnose": (2.5, 500), "recalibrate": (None, None)}
JOINTS = (3, 4, 6, 8, 10, 12)
PLOT = """set terminal pngcairo size 900,800
set output '{folder}/growth.png'
set logscale xy
set grid
set xlabel 'rows'
set key left top
set multiplot layout 2,2
set ylabel 'processor time, s'
plot for [i=0:2] '{folder}/growth.tsv' index i using 1:2 with linespoints title columnheader(1), \\
    2e-6 * x with lines dashtype 2 title '2 us per row'
set ylabel 'peak memory, MiB'
plot for [i=0:2] '{folder}/growth.tsv' index i using 1:3 with linespoints title columnheader(1)
unset logscale
set yrange [0:]
set xlabel 'joints'
set ylabel 'processor time, s, of 600 rows'
plot for [i=3:4] '{folder}/growth.tsv' index i using 1:2 with linespoints title columnheader(1), \\
    for [i=3:4] '{folder}/growth.tsv' index i using 1:4 with lines dashtype 2 title 'in proportion'
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


def arm_of(joints, path):
    """URDF of a serial arm: axes in turn along z, y and x, links of 0.6 m / sqrt(joints), one kilogram each."""
    length = 0.6 / joints**0.5
    parts = ["<robot name='serial'><link name='l0'/>"]
    for j in range(joints):
        axis = ("0 0 1", "0 1 0", "1 0 0")[j % 3]
        parts.append(f"<link name='l{j + 1}'><inertial><origin xyz='0 0 {length / 2}'/><mass value='1'/>"
                     "<inertia ixx='.01' iyy='.01' izz='.01' ixy='0' ixz='0' iyz='0'/></inertial></link>"
                     f"<joint name='j{j + 1}' type='revolute'><parent link='l{j}'/><child link='l{j + 1}'/>"
                     f"<origin xyz='0.02 0 {length}'/><axis xyz='{axis}'/><limit lower='-2.6' upper='2.6' effort='9' velocity='9'/></joint>")
    parts.append(f"<link name='ball'/><joint name='end' type='fixed'><parent link='l{joints}'/><child link='ball'/>"
                 "<origin xyz='0.05 0.03 0.1'/></joint></robot>")
    with open(path, "w") as f:
        f.write("".join(parts))


def over_joints(folder, figures):
    """The same number of measured poses for arms of more and more joints, beside time in proportion to the joints."""
    print("\n  growth in joints: 600 measured poses")
    arm, poses = os.path.join(folder, "serial.urdf"), os.path.join(folder, "serial.tsv")
    for command in ("calibrate", "diagnose"):
        print(f'"{command}, joints"', file=figures)
        first = None
        for n in JOINTS:
            arm_of(n, arm)
            output(MUKCA, "simulate", "-q", "--force", "--urdf", arm, "--poses", 600, "--perturb", "1,2", "--noise", "1e-4",
                   "--effect", "joint_compliance:j2=4e-5", "-o", poses)
            seconds, busy, mib = process(3, MUKCA, command, "-q", "--urdf", arm, poses)
            first = first or busy / n
            print(n, busy, mib, first * n, file=figures)
            print(f"  {command:12}{n:9} joints{seconds:9.3f} s{busy:9.3f} s processor{mib:9.1f} MiB{busy / first / n:7.2f} times in "
                  "proportion")
        print("\n", file=figures)
    os.remove(arm)
    os.remove(poses)


def main():
    folder = os.path.join(BUILD, "bench")
    session, poses, part = (os.path.join(folder, name) for name in ("million.tsv", "poses.tsv", "part.tsv"))
    print(f"\ngrowth: whole commands, wall time, processor time and peak memory, up to {ROWS} rows")
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
                wall, busy, mib = process(1 if every < 9 else 3, MUKCA, command, "-q", "--urdf", urdf, part)
                seconds, memory = GOALS[command] if rows == 1000000 else (None, None)
                print(rows, busy, mib, file=figures)
                print(f"  {command:12}{rows:9} rows{wall:9.3f} s{busy:9.3f} s processor{mib:9.1f} MiB"
                      f"{1e6 * busy / rows:9.1f} us per row{goal(wall, seconds)}{goal(mib, memory)}")
            print("\n", file=figures)
        over_joints(folder, figures)
    for path in (session, poses, part):
        os.remove(path)
    if shutil.which("gnuplot"):
        subprocess.run(["gnuplot"], input=PLOT.format(folder=folder), text=True, check=True)
        print(f"  plot: {folder}/growth.png")
    else:
        print("  SKIPPED plot: no gnuplot")
