"""The diagnosis beside a numpy prototype of the same recipe, on the same files; and its growth in rows.

The prototype, its practice cases and the real robots' data are not part of the project: PROTOTYPE or
../shared/prototype/mukca, PRACTICE or ../shared/blind/practice, MUKCA_REAL_DATA or ../shared/real.
"""
import json
import os
import subprocess
import xml.etree.ElementTree as ElementTree

from common import BUILD, DATA, MUKCA, REPEATS, output, process, python_with

PROTOTYPE = os.environ.get("PROTOTYPE", "../shared/prototype/mukca")
PRACTICE = os.environ.get("PRACTICE", "../shared/blind/practice")
CASES = ["case_003", "case_007", "case_017", "case_008", "case_027"]
PRACTICE_LIMIT = 0.1  # processor time, s
REAL = [("kuka_14", "iiwa14.urdf", "inertials_iiwa14.tsv", "base_link", 0.1),
        ("panda_2", "panda.urdf", "inertials_panda.tsv", "panda_link0", 0.4),
        ("panda_2_clean", "panda.urdf", "inertials_panda.tsv", "panda_link0", 0.4)]
DEMO = "data/demo/arm.urdf"
MOST_MIB, FASTER = 64, 20


def chain_of(root, tip):
    """Names of the turning joints from base to tip."""
    parent = {j.find("child").get("link"): j for j in root.findall("joint")}
    names = []
    while tip in parent:
        joint = parent[tip]
        if joint.get("type") in ("revolute", "continuous"):
            names.insert(0, joint.get("name"))
        tip = joint.find("parent").get("link")
    return names


def real_case(folder, robot, urdf, masses):
    """A robot's folders as one session file, and its URDF with the masses in it."""
    root = ElementTree.parse(os.path.join(DATA, urdf)).getroot()
    links = {link.get("name"): link for link in root.findall("link")}
    with open(os.path.join(DATA, masses)) as f:
        for line in f.read().splitlines()[1:]:
            name, kg, *com = line.split("\t")
            inertial = ElementTree.SubElement(links[name], "inertial")
            ElementTree.SubElement(inertial, "origin", xyz=" ".join(com), rpy="0 0 0")
            ElementTree.SubElement(inertial, "mass", value=kg)
            ElementTree.SubElement(inertial, "inertia", ixx="0.01", iyy="0.01", izz="0.01",
                                   ixy="0", ixz="0", iyz="0")
    os.makedirs(folder, exist_ok=True)
    ElementTree.ElementTree(root).write(os.path.join(folder, "robot.urdf"))
    with open(os.path.join(folder, "session.tsv"), "w") as out:
        print("placement", "socket", *chain_of(root, "ball_link"), sep="\t", file=out)
        for place in sorted(os.listdir(os.path.join(DATA, robot))):
            for hole in (0, 1):
                path = os.path.join(DATA, robot, place, f"hole_{hole}.csv")
                for line in open(path) if os.path.exists(path) else ():
                    print(place, hole, *(v.strip() for v in line.split(",")), sep="\t", file=out)


def first(answer):
    cause = (answer["causes"] or [{}])[0]
    return " ".join(filter(None, (answer["verdict"], cause.get("effect"), cause.get("joint"))))


def beside(prototype, name, folder, base, tip, limit):
    arguments = ["--urdf", os.path.join(folder, "robot.urdf"), "--base", base, "--tip", tip,
                 "--distance", "0.05", os.path.join(folder, "session.tsv"), "--json", "-"]
    with open(os.path.join(folder, "session.tsv")) as f:
        rows = sum(1 for _ in f) - 1
    ours = [MUKCA, "diagnose", "-q", *arguments]
    seconds, busy, mib = process(max(3, REPEATS // 3), *ours)
    line = f"  {name:26}{rows:5}{1e3 * seconds:10.1f} ms{1e3 * busy:10.1f} ms{mib:7.1f} MiB"
    if prototype:
        theirs = [*prototype, "diagnose", *arguments]
        other, other_busy, other_mib = process(1, *theirs)
        line += (f"{other:8.2f} s{other_busy:8.2f} s{other_mib:7.0f} MiB{other_busy / busy:7.0f} "
                 f"{'' if other_busy >= FASTER * busy else 'FALLS SHORT':12}"
                 f"{first(json.loads(output(*ours)))} | {first(json.loads(output(*theirs)))}")
    print(line)
    if limit:
        print(f"  {'':26}goal: under {1e3 * limit:.0f} ms and {MOST_MIB} MiB: "
              f"{'reached' if busy < limit and mib < MOST_MIB else 'FALLS SHORT'}")


def growth():
    """The same arm and effects in ever more placements."""
    print("\n  growth in rows: demo arm, 60 rows per placement, compliance and gear ripple")
    each = []
    for placements in (2, 4, 8, 16, 32):
        session = os.path.join(BUILD, f"bench/grown_{placements}.tsv")
        subprocess.run([MUKCA, "simulate", "-q", "--force", "--urdf", DEMO, "--placements", str(placements),
                        "--rows", "30", "--perturb", "1,2", "--noise", "5e-5", "--seed", "1", "--effect",
                        "joint_compliance:joint_2=2e-5,gear_harmonic:joint_4@160=3e-4", "-o", session],
                       check=True)
        seconds, busy, mib = process(max(3, REPEATS // 3), MUKCA, "diagnose", "-q", "--urdf", DEMO, session)
        rows = 60 * placements
        each.append(busy / rows)
        print(f"  {placements:4} placements {rows:5} rows{1e3 * seconds:10.1f} ms{1e3 * busy:10.1f} ms"
              f"{mib:7.1f} MiB{1e6 * busy / rows:8.0f} us per row")
    print(f"  linear would be the same time per row; {each[-1] / each[1]:.1f} times that of 4 placements at 32")


def main():
    print("\ndiagnosis: whole process, medians of wall and processor time, peak memory")
    prototype = None
    if os.path.exists(PROTOTYPE):
        python = python_with("numpy", "scipy")
        if python:
            prototype = [python, PROTOTYPE]
        else:
            print("  SKIPPED prototype: numpy and scipy cannot be installed")
    else:
        print(f"  SKIPPED prototype: no {PROTOTYPE}")
    print(f"  {'':26}{'rows':>5}{'mukca':>13}{'processor':>13}{'memory':>11}"
          + (f"{'prototype':>10}{'processor':>10}{'memory':>11}{'ratio':>7}{'':13}"
             "verdict and first cause: mukca | prototype" if prototype else ""))
    for case in CASES if os.path.isdir(PRACTICE) else ():
        beside(prototype, f"practice/{case}", os.path.join(PRACTICE, case), "base", "ball", PRACTICE_LIMIT)
    if not os.path.isdir(PRACTICE):
        print(f"  SKIPPED practice cases: no {PRACTICE}")
    if not os.path.isdir(DATA):
        print(f"  SKIPPED real robots: no data in {DATA}; set MUKCA_REAL_DATA")
    else:
        for robot, urdf, masses, base, limit in REAL:
            folder = os.path.join(BUILD, "bench", robot)
            real_case(folder, robot, urdf, masses)
            beside(prototype, robot, folder, base, "ball_link", limit)
    growth()
