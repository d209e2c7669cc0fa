"""The hidden arm: an MJCF with errors that no controller sees, made from a URDF.

Each joint is a motor (torque, rotor inertia, friction; the encoder reads its angle). A spring or play in
series is a further hinge about the same axis, between motor and link. The peg and the walls of the hole are
rings of capsules and boxes: the allowed shift of the peg is a regular polygon around the circle of the
clearance.
"""
import dataclasses
import math
import xml.etree.ElementTree as ET

import numpy as np

SIDES = 24          # of peg and hole: a corner of the polygon is 0.9 % farther out than a side
HOLES = (16e-3, 12e-3, 10.4e-3, 10.2e-3, 10.1e-3)  # diameters, m
PEG = 5e-3          # radius, m
FILLET = 0.3e-3     # at the end of the peg, m: a deburred edge
PEG_LENGTH = 30e-3  # m
WALL = 30e-3        # half the width of a wall's box, m
# Contact with a time constant of two steps, the stiffest that the engine recommends.
STIFF = 'solref="0.002 1" solimp="0.95 0.99 0.0001"'
ARMATURE = (0.3, 0.3, 0.2, 0.2, 0.08, 0.08, 0.05)   # kg m^2, reflected rotor inertia (of the size of public models)
FRICTION = (0.4, 0.4, 0.3, 0.3, 0.15, 0.15, 0.1)    # N m, what a torque-controlled joint leaves of its friction
DAMPING = (1.0, 1.0, 0.7, 0.7, 0.3, 0.3, 0.2)       # N m s/rad


@dataclasses.dataclass
class Hidden:
    """What is wrong with an arm. Springs: compliance in rad/(N m); play: width in rad; both by joint."""
    name: str
    seed: int
    position: float = 2e-3  # standard deviation of each origin's coordinate, m
    angle: float = 3e-3     # the same of roll, pitch and yaw, rad
    springs: dict = dataclasses.field(default_factory=dict)
    play: dict = dataclasses.field(default_factory=dict)


SOFT = {"joint_2": 8e-5, "joint_4": 16e-5}  # rad/(N m): harmonic drives of light arms
ARMS = {"rigid": Hidden("rigid", 1), "sprung": Hidden("sprung", 2, springs=SOFT),
        "worn": Hidden("worn", 3, springs=SOFT, play={"joint_6": 1e-3})}


def numbers(text):
    return [float(x) for x in text.split()]


def row(values):
    return " ".join("%.12g" % x for x in values)


def chain(urdf):
    """(URDF root, [joint elements from the root link to the tip])."""
    root = ET.parse(urdf).getroot()
    joints = root.findall("joint")
    children = {j.find("child").get("link") for j in joints}
    link = next(l.get("name") for l in root.findall("link") if l.get("name") not in children)
    found = []
    while True:
        step = [j for j in joints if j.find("parent").get("link") == link]
        if not step:
            return root, found
        found.append(step[0])
        link = step[0].find("child").get("link")


def inertial(root, name):
    link = next(l for l in root.findall("link") if l.get("name") == name)
    i = link.find("inertial")
    t = i.find("inertia")
    return '<inertial pos="%s" mass="%s" fullinertia="%s"/>' % (
        i.find("origin").get("xyz"), i.find("mass").get("value"),
        row(float(t.get(k)) for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")))


def hinges(joint, k, hidden):
    """The motor of a joint with its end stops, and what is in series with it."""
    name, axis, limit = joint.get("name"), joint.find("axis").get("xyz"), joint.find("limit")
    text = ('<joint name="%s" axis="%s" armature="%g" frictionloss="%g" damping="%g" limited="true" range="%s %s"/>' % (
        name, axis, ARMATURE[k], FRICTION[k], DAMPING[k], limit.get("lower"), limit.get("upper")))
    if name in hidden.springs:  # damping: 0.001 s of the stiffness, some 10 % of critical at a few Hz
        stiffness = 1 / hidden.springs[name]
        text += '<joint name="%s.spring" axis="%s" armature="0.01" stiffness="%.12g" damping="%.12g"/>' % (
            name, axis, stiffness, 1e-3 * stiffness)
    if name in hidden.play:
        half = hidden.play[name] / 2
        text += ('<joint name="%s.play" axis="%s" armature="0.01" damping="0.1" limited="true" range="%.12g %.12g" '
                 'solreflimit="0.002 1"/>' % (name, axis, -half, half))
    return text


def mjcf(urdf, hidden):
    """The MuJoCo model's text, and the names of the motors."""
    root, joints = chain(urdf)
    random = np.random.default_rng(hidden.seed)
    bodies, end, motors = "", "", []
    for joint in joints:
        origin, name, child = joint.find("origin"), joint.get("name"), joint.find("child").get("link")
        xyz = np.array(numbers(origin.get("xyz"))) + hidden.position * random.standard_normal(3)
        rpy = np.array(numbers(origin.get("rpy"))) + hidden.angle * random.standard_normal(3)
        bodies += '<body name="%s" pos="%s" euler="%s">%s' % (child, row(xyz), row(rpy), inertial(root, child))
        if joint.get("type") != "fixed":
            bodies += hinges(joint, len(motors), hidden)
            motors.append(name)
        end += "</body>"
    bodies += '<site name="tip"/>'
    at = PEG - FILLET
    for i in range(SIDES):
        x, y = at * math.cos(2 * math.pi * i / SIDES), at * math.sin(2 * math.pi * i / SIDES)
        bodies += '<geom class="peg" fromto="%.12g %.12g %g %.12g %.12g %g"/>' % (
            x, y, -PEG_LENGTH, x, y, -FILLET)
    plates = ""  # one for each hole; robot.py brings the one in use
    for d, diameter in enumerate(HOLES):
        plates += '<body name="plate%d" mocap="true" pos="0 0 -9">' % d
        for i in range(SIDES):
            a, at = 2 * math.pi * i / SIDES, diameter / 2 + WALL
            plates += '<geom class="wall" pos="%.12g %.12g -0.01" euler="0 0 %.12g"/>' % (
                at * math.cos(a), at * math.sin(a), a)
        plates += "</body>"
    text = f"""<mujoco model="{hidden.name}">
  <compiler angle="radian" eulerseq="XYZ"/>
  <option timestep="0.001" integrator="implicitfast" gravity="0 0 -9.80665" cone="elliptic" impratio="10"/>
  <default>
    <default class="peg"><geom type="capsule" size="{FILLET}" mass="0" friction="0.2" contype="1"
      conaffinity="0" {STIFF}/></default>
    <default class="wall"><geom type="box" size="{WALL} {WALL} 0.01" friction="0.2" contype="0"
      conaffinity="1" {STIFF}/></default>
  </default>
  <worldbody>
    {bodies}{end}
    {plates}
    <body name="socket" mocap="true" pos="0 0 -1"><site name="seat"/></body>
  </worldbody>
  <equality><connect name="seat" site1="tip" site2="seat" active="false" {STIFF}/></equality>
  <actuator>{"".join('<motor joint="%s"/>' % m for m in motors)}</actuator>
</mujoco>"""
    return text, motors
