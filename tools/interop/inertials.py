#!/usr/bin/env python3
"""data/inertials against the URDFs of PyPI's example-robot-data: the same gravity moments to 1e-9 N m.

The URDF as it is, and the same without the masses of the links that the file lists, with --inertials. Every joint
has a compliance of 1e-3 rad/(N m), so that a moment that differs by 1e-9 N m moves the tip. The package (400 MB) is
taken from MUKCA_EXAMPLE_ROBOTS, a folder, where that is set; else it is installed under build/.
"""
import glob
import hashlib
import os
import random
import subprocess
import sys
import venv
import xml.etree.ElementTree as ET

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BUILD = os.environ.get("BUILD", os.path.join(ROOT, "build"))
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
WORK = os.path.join(BUILD, "interop")
ARMS = [("panda", "panda_description/urdf/panda.urdf", "panda_link8"),
        ("xarm7", "xarm_description/urdf/xarm7.urdf", "link_eef")]
COMPLIANCE = 1e-3  # rad/(N m)


def robots():
    folder = os.environ.get("MUKCA_EXAMPLE_ROBOTS")
    if folder:
        return folder
    home = os.path.join(WORK, "robots")
    pattern = os.path.join(home, "lib", "python*", "site-packages", "cmeel.prefix", "share", "example-robot-data",
                           "robots")
    if not glob.glob(pattern):
        venv.create(home, with_pip=True)
        subprocess.run([os.path.join(home, "bin", "pip"), "install", "-q", "--no-deps", "example-robot-data"],
                       check=False)
    found = glob.glob(pattern)
    return found[0] if found else None


def fk(urdf, tip, table, rows, *options):
    done = subprocess.run([MUKCA, "fk", "--urdf", urdf, "--tip", tip, "--offsets", table, "-q", *options, "-"],
                          input=rows, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"mukca fk {urdf}: {done.stderr}")
    return [[float(x) for x in line.split("\t")] for line in done.stdout.splitlines()[1:]]


def compare(name, urdf, tip):
    masses = os.path.join(ROOT, "data", "inertials", name + ".tsv")
    with open(masses) as file:
        listed = [line.split("\t")[0] for line in file if not line.startswith("#")][1:]
    tree = ET.parse(urdf)
    removed = 0
    for link in tree.getroot().findall("link"):
        inertial = link.find("inertial")
        if inertial is not None and any(link.get("name") in (row, f"panda_{row}") for row in listed):
            link.remove(inertial)
            removed += 1
    joints, parent = [], {j.find("child").get("link"): j for j in tree.getroot().findall("joint")}
    link = tip
    while link in parent:
        if parent[link].get("type") != "fixed":
            joints.insert(0, parent[link].get("name"))
        link = parent[link].find("parent").get("link")
    bare = os.path.join(WORK, name + "_bare.urdf")
    tree.write(bare)
    rng = random.Random(1)
    rows = "\t".join(joints) + "\n"
    rows += "".join("\t".join(f"{rng.uniform(-2, 2):.6f}" for _ in joints) + "\n" for _ in range(100))
    got = []
    for path, options in ((urdf, ()), (bare, ("--inertials", masses))):
        table = os.path.join(WORK, "compliant.tsv")
        with open(path, "rb") as file:
            sha = hashlib.sha256(file.read()).hexdigest()
        with open(table, "w") as file:
            file.write(f"# urdf_sha256: {sha}\njoint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\t"
                       "identifiable\tterm\n")
            for joint in joints:
                file.write(f"{joint}\tjoint_compliance\trad/(N*m)\t0\t{COMPLIANCE}\t{COMPLIANCE}\t0\t1\t-\n")
        got.append(fk(path, tip, table, rows, *options))
    worst = max(abs(a - b) for p, q in zip(*got) for a, b in zip(p, q))
    good = removed == len(listed) and len(got[0]) == 100 and worst <= COMPLIANCE * 1e-9
    print(f"{'ok' if good else 'not ok'} {name}: {removed} links, tips differ by {worst:.2g} m")
    return good


def main():
    folder = robots()
    if not folder:
        print("skip data/inertials: example-robot-data cannot be installed (MUKCA_EXAMPLE_ROBOTS)")
        sys.exit(77)
    os.makedirs(WORK, exist_ok=True)
    good = [compare(name, os.path.join(folder, path), tip) for name, path, tip in ARMS]
    sys.exit(not all(good))


main()
