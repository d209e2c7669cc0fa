#!/usr/bin/env python3
"""Exported models in Pinocchio, MuJoCo and yourdfpy against `mukca fk`: the same tip to 1e-9 m.

Both come from PyPI into a virtual environment under build/.  The arms: the demo arm, one that is odd on
purpose, and, where they are at hand, the real ones.  Offsets are random; so are 200 postures of each.
"""
import hashlib
import os
import random
import re
import subprocess
import sys
import venv
import xml.etree.ElementTree as ET

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BUILD = os.environ.get("BUILD", os.path.join(ROOT, "build"))
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
WORK = os.path.join(BUILD, "interop")
POSTURES = 200
TOLERANCE = 1e-9
# yourdfpy asks for all of trimesh's optional packages, 200 MB of which forward kinematics needs none
PACKAGES = ["pin", "mujoco", "numpy", "trimesh", "networkx", "lxml", "anytree", "six"]
ALONE = ["yourdfpy"]

ODD = """<?xml version="1.0"?>
<robot name="odd">
  <link name="root"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
  <link name="ball"/><link name="side"/>
  <joint name="turn" type="revolute">
    <parent link="root"/><child link="a"/><axis xyz="0.6 0 -0.8"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin rpy="0.3 1.5707963267948966 -2" xyz="0.1 0.2 0.3"/>
    <parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="0.5" effort="1" velocity="1"/>
  </joint>
  <joint name="spin" type="continuous">
    <origin xyz="0 -0.2 0.1"/>
    <parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="between" type="fixed">
    <origin rpy="3.141592653589793 0 0.1" xyz="0 0 0.25"/>
    <parent link="c"/><child link="d"/>
  </joint>
  <joint name="bend" type="revolute">
    <origin rpy="0 -1.5707963267948966 0" xyz="0.2 0 0"/>
    <parent link="d"/><child link="e"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="tool" type="fixed"><origin xyz="0.05 0 0.1"/><parent link="e"/><child link="ball"/></joint>
  <joint name="branch" type="fixed"><origin xyz="0 0 1"/><parent link="c"/><child link="side"/></joint>
</robot>
"""


def enter_environment(script):
    """Run the script again inside the virtual environment, which is made where it is missing."""
    home = os.path.join(WORK, "venv")
    python = os.path.join(home, "bin", "python")
    if os.path.realpath(sys.prefix) == os.path.realpath(home):
        return
    ready = os.path.join(home, "ready-" + "-".join(ALONE))
    if not os.path.exists(ready):
        venv.create(home, with_pip=True, clear=True)
        pip = [python, "-m", "pip", "install", "-q"]
        if subprocess.run([*pip, *PACKAGES]).returncode != 0 or \
                subprocess.run([*pip, "--no-deps", *ALONE]).returncode != 0:
            print("skip interop: Pinocchio, MuJoCo and yourdfpy cannot be installed from PyPI")
            sys.exit(77)
        open(ready, "w").close()
    os.execv(python, [python, os.path.abspath(script), *sys.argv[1:]])


def chain(urdf, tip):
    """Joints from the root to the tip: (name, type, lower, upper, nominal origin)."""
    joints = {}
    for j in ET.parse(urdf).getroot().findall("joint"):
        joints[j.find("child").get("link")] = j
    path = []
    while tip in joints:
        j = joints[tip]
        origin, limit = j.find("origin"), j.find("limit")
        text = ("0 0 0" if origin is None else origin.get("xyz", "0 0 0")) + " " + \
               ("0 0 0" if origin is None else origin.get("rpy", "0 0 0"))
        lower, upper = (-3.0, 3.0)
        if j.get("type") in ("revolute", "prismatic"):
            lower, upper = float(limit.get("lower")), float(limit.get("upper"))
        path.insert(0, (j.get("name"), j.get("type"), lower, upper, [float(x) for x in text.split()]))
        tip = j.find("parent").get("link")
    return path


def write_offsets(path, urdf, joints):
    sha = hashlib.sha256(open(urdf, "rb").read()).hexdigest()
    with open(path, "w") as f:
        f.write("# urdf_sha256: %s\n" % sha)
        f.write("joint\tparameter\tnominal\tcalibrated\toffset\tsigma\tidentifiable\n")
        for name, _, _, _, origin in joints:
            for p, nominal in zip("x y z roll pitch yaw".split(), origin):
                value = nominal + random.gauss(0, 3e-3)
                f.write("%s\t%s\t%.17g\t%.17g\t%.17g\t0\t1\n" % (name, p, nominal, value, value - nominal))


def run(*args):
    return subprocess.run([MUKCA, *args], check=True, capture_output=True, text=True).stdout


def bare(xml):
    """Without meshes, which are not here."""
    return re.sub(r"<(visual|collision)\b.*?</\1>", "", xml, flags=re.S)


def by_pinocchio(xml, tip, names, rows):
    import numpy as np
    import pinocchio
    model = pinocchio.buildModelFromXML(xml)
    data = model.createData()
    frame = model.getFrameId(tip)
    for row in rows:
        q = pinocchio.neutral(model)
        for name, value in zip(names, row):
            joint = model.joints[model.getJointId(name)]
            q[joint.idx_q:joint.idx_q + joint.nq] = \
                value if joint.nq == 1 else (np.cos(value), np.sin(value))
        pinocchio.framesForwardKinematics(model, data, q)
        yield data.oMf[frame].translation


def by_mujoco(xml, tip, names, rows):
    import mujoco
    compiler = '<mujoco><compiler fusestatic="false" discardvisual="true" boundmass="0.01" ' \
               'boundinertia="0.001"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(xml.replace("</robot>", compiler))
    data = mujoco.MjData(model)
    for row in rows:
        for name, value in zip(names, row):
            data.joint(name).qpos = value
        mujoco.mj_kinematics(model, data)
        yield data.body(tip).xpos


def by_yourdfpy(xml, tip, names, rows):
    import io
    import yourdfpy
    robot = yourdfpy.URDF.load(io.StringIO(xml), load_meshes=False, build_scene_graph=True)
    for row in rows:
        robot.update_cfg(dict(zip(names, row)))
        yield robot.get_transform(tip)[:3, 3]


def fk(table, *model):
    lines = run("fk", *model, table).splitlines()[1:]
    return [[float(x) for x in line.split("\t")] for line in lines]


def compare(title, ours, xml, tip, names, rows):
    good = len(ours) == len(rows)
    for theirs in (by_pinocchio, by_mujoco, by_yourdfpy):
        worst = max(max(abs(a - b) for a, b in zip(p, t))
                    for p, t in zip(ours, theirs(xml, tip, names, rows)))
        fine = worst <= TOLERANCE
        good = good and fine
        print("%s %s of %s: largest difference %.1e m" % (
            "ok" if fine else "not ok", theirs.__name__[3:], title, worst))
    return good


def check_npy(urdf, tip, moving, rows, table):
    """The driver's formula, q += offset on the nominal arm, against the arm with turned joints."""
    import numpy as np
    import pinocchio
    axes = {j.get("name"): [float(x) for x in j.find("axis").get("xyz").split()]
            for j in ET.parse(urdf).getroot().findall("joint") if j.find("axis") is not None}
    turned = []
    for name, kind, lower, upper, origin in moving:
        if kind == "prismatic":
            return True
        turn = pinocchio.exp3(random.gauss(0, 5e-3) * np.array(axes[name]))
        R = pinocchio.rpy.rpyToMatrix(np.array(origin[3:])) @ turn
        turned.append((name, origin[:3] + list(pinocchio.rpy.matrixToRpy(R)), origin))
    offsets = os.path.join(WORK, "turned.tsv")
    sha = hashlib.sha256(open(urdf, "rb").read()).hexdigest()
    with open(offsets, "w") as f:
        f.write("# urdf_sha256: %s\n" % sha)
        f.write("joint\tparameter\tnominal\tcalibrated\toffset\tsigma\tidentifiable\n")
        for name, new, old in turned:
            for p, value, nominal in zip("x y z roll pitch yaw".split(), new, old):
                f.write("%s\t%s\t%.17g\t%.17g\t%.17g\t0\t1\n" % (name, p, nominal, value, value - nominal))
    array = os.path.join(WORK, "joint_pos_offset.npy")
    run("export", "--urdf", urdf, "--tip", tip, "--offsets", offsets, "-o", array, "--force")
    added = np.load(array)
    nominal = os.path.join(WORK, "corrected.tsv")
    with open(nominal, "w") as f:
        f.write("\t".join(j[0] for j in moving) + "\n")
        f.writelines("\t".join("%.17g" % x for x in np.array(row) + added) + "\n" for row in rows)
    a = fk(table, "--urdf", urdf, "--tip", tip, "--offsets", offsets)
    b = fk(nominal, "--urdf", urdf, "--tip", tip)
    worst = np.abs(np.array(a) - np.array(b)).max()
    fine = added.dtype == np.float64 and worst <= TOLERANCE
    print("%s npy of %s, added to the angles: largest difference %.1e m" % (
        "ok" if fine else "not ok", os.path.basename(urdf), worst))
    return fine


def check(urdf, tip):
    name = os.path.basename(urdf)
    joints = chain(urdf, tip)
    offsets, patched = os.path.join(WORK, "offsets.tsv"), os.path.join(WORK, "patched.urdf")
    write_offsets(offsets, urdf, joints)
    arm = ["--urdf", urdf, "--tip", tip]
    run("export", *arm, "--offsets", offsets, "-o", patched, "--force")
    moving = [j for j in joints if j[1] != "fixed"]
    names = [j[0] for j in moving]
    rows = [[random.uniform(j[2], j[3]) for j in moving] for _ in range(POSTURES)]
    table = os.path.join(WORK, "rows.tsv")
    with open(table, "w") as f:
        f.write("\t".join(names) + "\n")
        f.writelines("\t".join("%.17g" % x for x in row) + "\n" for row in rows)
    ours = fk(table, *arm, "--offsets", offsets)
    good = compare(name, ours, bare(open(patched).read()), tip, names, rows)
    for convention in ("dh", "mdh"):
        dh, back = os.path.join(WORK, "arm." + convention), os.path.join(WORK, convention + ".urdf")
        run("export", *arm, "--offsets", offsets, "-o", dh, "--force")
        with open(back, "w") as f:
            subprocess.run([sys.executable, "tools/dh_to_urdf.py", dh], stdout=f, check=True)
        good &= compare("%s as %s" % (name, convention), ours, open(back).read(), "tip_link", names, rows)
    factory = os.path.join(WORK, "arm.kinematics")
    run("export", *arm, "--offsets", offsets, "-o", factory, "--force")
    run("export", *arm, "--kinematics", factory, "-o", patched, "--force")
    ours = fk(table, *arm, "--kinematics", factory)
    good &= compare(name + " by its YAML", ours, bare(open(patched).read()), tip, names, rows)
    return check_npy(urdf, tip, moving, rows, table) and good


def main():
    os.makedirs(WORK, exist_ok=True)
    enter_environment(__file__)
    random.seed(1)
    odd = os.path.join(WORK, "odd.urdf")
    with open(odd, "w") as f:
        f.write(ODD)
    arms = [(odd, "ball"), (os.path.join(ROOT, "data/demo/arm.urdf"), "ball_link")]
    real = os.environ.get("MUKCA_REAL_DATA", os.path.join(ROOT, "../shared/real"))
    for name in ("panda", "iiwa14", "gen3lite"):
        path = os.path.join(real, name + ".urdf")
        if os.path.exists(path):
            arms.append((path, "ball_link"))
        else:
            print("skip %s: %s is not here (MUKCA_REAL_DATA)" % (name, path))
    results = [check(*arm) for arm in arms]
    statics = os.path.join(ROOT, "tools", "interop", "mjcf.py")
    results.append(subprocess.run([sys.executable, statics], cwd=WORK).returncode == 0)
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
