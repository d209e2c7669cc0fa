"""Arms of the blind cases: kinematics, gravity and URDF text, written apart from the program.

Everything is kept in world coordinates: a sweep from the base to the ball gives, per row, the
origin and axis of every joint, the centres of mass and the ball.  Small extra rotations ("twists",
world vectors acting at a joint's origin on all that follows) are how effects enter.
"""
import copy
import os
import xml.etree.ElementTree as ET

import numpy as np

GRAVITY = np.array([0.0, 0.0, -9.80665])


def euler(roll, pitch, yaw):
    """Rotation matrix of URDF's fixed-axis angles."""
    def about(k, angle):
        i, j = (k + 1) % 3, (k + 2) % 3
        m = np.eye(3)
        m[i, i] = m[j, j] = np.cos(angle)
        m[j, i] = np.sin(angle)
        m[i, j] = -np.sin(angle)
        return m
    return about(2, yaw) @ about(1, pitch) @ about(0, roll)


def angles(m):
    """URDF's angles of a rotation matrix."""
    flat = np.hypot(m[0, 0], m[1, 0])
    if flat < 1e-9:
        return np.arctan2(-m[1, 2], m[1, 1]), np.arctan2(-m[2, 0], flat), 0.0
    return (np.arctan2(m[2, 1], m[2, 2]), np.arctan2(-m[2, 0], flat),
            np.arctan2(m[1, 0], m[0, 0]))


def turn(vectors):
    """Rotation matrices of rotation vectors: (N,3) -> (N,3,3)."""
    v = np.atleast_2d(vectors)
    x = np.linalg.norm(v, axis=1)
    u = v / np.where(x > 1e-300, x, 1.0)[:, None]
    c, s = np.cos(x)[:, None, None], np.sin(x)[:, None, None]
    cross = np.zeros((len(v), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = u
    cross[:, [1, 2, 0], [2, 0, 1]] = -u
    return c * np.eye(3) + s * cross + (1 - c) * u[:, :, None] * u[:, None, :]


def quaternion(m):
    """Unit quaternions, w first and w >= 0, of rotation matrices (N,3,3)."""
    out = np.empty((len(m), 4))
    for i, r in enumerate(m):
        k = np.array([[r[0, 0] + r[1, 1] + r[2, 2], 0, 0, 0],
                      [r[2, 1] - r[1, 2], r[0, 0] - r[1, 1] - r[2, 2], 0, 0],
                      [r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], 0],
                      [r[1, 0] - r[0, 1], r[2, 0] + r[0, 2], r[2, 1] + r[1, 2],
                       r[2, 2] - r[0, 0] - r[1, 1]]])
        out[i] = np.linalg.eigh(k)[1][:, -1]
    return out * np.where(out[:, :1] < 0, -1, 1)


class Sweep:
    """What one pass over the chain gives: see Arm.sweep."""


class Arm:
    """Serial arm: per joint a fixed placement (shift, frame), an axis and limits; then the ball."""

    def __init__(self, name, shifts, frames, axes, limits, ball, masses, flange=None, slides=()):
        self.name = name
        self.linkage = None                   # sign, low, high of q3 + sign q2: a parallel linkage
        self.shift = np.array(shifts, float)
        self.frame = np.array(frames, float)
        self.axis = np.array(axes, float)
        self.limit = np.array(limits, float)
        self.ball = np.array(ball, float)
        self.masses = masses                  # (link index, kg, centre in the link's frame)
        self.flange = flange                  # fixed (shift, frame) before the ball, or None
        self.n = len(self.axis)
        self.joints = [f"joint_{k + 1}" for k in range(self.n)]
        self.slide = np.isin(np.arange(self.n), slides)
        self.step = np.where(self.slide, 0.3, 1.0)      # metres that are like one radian

    def reach(self):
        turning = self.shift[np.argmin(self.slide) + 1:]
        return float(np.linalg.norm(turning, axis=1).sum() + np.linalg.norm(self.tool())
                     + 0.3 * np.ptp(self.limit[self.slide], axis=1).sum())

    def tool(self):
        """Ball in the last link's frame."""
        return self.ball if self.flange is None else self.flange[0] + self.flange[1] @ self.ball

    def sweep(self, q, twist=None, base=None, want_masses=False):
        """origin, axis (N,n,3), before (N,n,3,3), ball (N,3), last (N,3,3), centres (N,m,3)."""
        s = Sweep()
        rows = len(q)
        s.origin = np.empty((rows, self.n, 3))
        s.axis = np.empty((rows, self.n, 3))
        s.before = np.empty((rows, self.n, 3, 3))
        s.centre = np.empty((rows, len(self.masses), 3))
        place = np.zeros((rows, 3))
        frame = np.broadcast_to(np.eye(3), (rows, 3, 3))
        if base is not None:
            frame = turn(base)
        for k in range(self.n):
            place = place + frame @ self.shift[k]
            frame = frame @ self.frame[k]
            s.origin[:, k], s.before[:, k], s.axis[:, k] = place, frame, frame @ self.axis[k]
            if self.slide[k]:
                place = place + s.axis[:, k] * q[:, k:k + 1]
            else:
                frame = frame @ turn(q[:, k:k + 1] * self.axis[k])
            if twist is not None and np.any(twist[:, k]):
                frame = turn(twist[:, k]) @ frame
            if want_masses:
                for i, (link, _, centre) in enumerate(self.masses):
                    if link == k:
                        s.centre[:, i] = place + frame @ centre
        s.last = frame
        s.ball = place + frame @ self.tool()
        return s

    def lever(self, s):
        """Ball's derivative by the joints' angles or travels, (N,n,3)."""
        return np.where(self.slide[:, None], s.axis, np.cross(s.axis, s.ball[:, None] - s.origin))

    def gravity(self, s):
        """Gravity's moment about every joint (N,n,3) and the base (N,3), world frame; what joints hold."""
        moment, weight = np.zeros_like(s.origin), np.zeros((self.n, 3))
        base = np.zeros_like(s.ball)
        for i, (link, kg, _) in enumerate(self.masses):
            pull = kg * GRAVITY
            base += np.cross(s.centre[:, i], pull)
            for k in range(link + 1):
                moment[:, k] += np.cross(s.centre[:, i] - s.origin[:, k], pull)
                weight[k] += pull
        held = np.where(self.slide[:, None], weight, moment)
        return moment, base, -np.einsum("nki,nki->nk", held, s.axis)

    def geometry(self, s):
        """Ball's derivative by the place and attitude of every joint and the ball: (N,3,6n+3)."""
        cols = []
        for k in range(self.n):
            arm = s.ball - s.origin[:, k]
            for i in range(3):
                cols.append(s.before[:, k, :, i])
            for i in range(3):
                cols.append(np.cross(s.before[:, k, :, i], arm))
        for i in range(3):
            cols.append(s.last[:, :, i])
        return np.stack(cols, axis=2)

    def perturbed(self, rng, mm, mrad):
        """The same arm as built: every joint and the ball a little off."""
        other = copy.deepcopy(self)
        other.shift = self.shift + 1e-3 * mm * rng.standard_normal(self.shift.shape)
        other.frame = self.frame @ turn(1e-3 * mrad * rng.standard_normal((self.n, 3)))
        other.ball = self.ball + 1e-3 * mm * rng.standard_normal(3)
        other.spread = 1e-3 * mm
        return other

    def reweighed(self, rng, part):
        """The same arm with masses off by a relative deviation and centres by a few mm."""
        other = copy.deepcopy(self)
        other.urdf_masses = self.masses
        other.masses = [(link, kg * max(0.3, 1 + part * rng.standard_normal()),
                         np.asarray(c) + 0.03 * part * rng.standard_normal(3))
                        for link, kg, c in self.masses]
        return other

    def urdf(self):
        """URDF text: base, link_1.., ball; joints joint_1.., then the fixed ball_joint."""
        def vec(v):
            return " ".join("%.17g" % (x + 0.0) for x in v)
        out = ['<?xml version="1.0"?>', f'<robot name="{self.name}">', '  <link name="base"/>']
        for k in range(self.n):
            mine = [(kg, np.asarray(c)) for link, kg, c in self.masses if link == k]
            if not mine:
                out.append(f'  <link name="link_{k + 1}"/>')
                continue
            total = sum(kg for kg, _ in mine)
            centre = sum(kg * c for kg, c in mine) / total
            out += [f'  <link name="link_{k + 1}">',
                    f'    <inertial><origin xyz="{vec(centre)}" rpy="0 0 0"/>'
                    f'<mass value="{total:.17g}"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" '
                    'iyz="0" izz="0.02"/></inertial>', '  </link>']
        if self.flange is not None:
            out.append('  <link name="flange"/>')
        out.append('  <link name="ball"/>')
        parent = "base"
        for k in range(self.n):
            low, high = self.limit[k]
            kind = "prismatic" if self.slide[k] else "revolute"
            out += [f'  <joint name="joint_{k + 1}" type="{kind}">',
                    f'    <origin xyz="{vec(self.shift[k])}" rpy="{vec(angles(self.frame[k]))}"/>',
                    f'    <parent link="{parent}"/><child link="link_{k + 1}"/>',
                    f'    <axis xyz="{vec(self.axis[k])}"/>',
                    f'    <limit lower="{low:.9g}" upper="{high:.9g}" effort="150" velocity="3"/>',
                    '  </joint>']
            parent = f"link_{k + 1}"
        if self.flange is not None:
            out += ['  <joint name="flange_joint" type="fixed">',
                    f'    <origin xyz="{vec(self.flange[0])}" rpy="{vec(angles(self.flange[1]))}"/>',
                    f'    <parent link="{parent}"/><child link="flange"/>', '  </joint>']
            parent = "flange"
        out += ['  <joint name="ball_joint" type="fixed">',
                f'    <origin xyz="{vec(self.ball)}" rpy="0 0 0"/>',
                f'    <parent link="{parent}"/><child link="ball"/>', '  </joint>', '</robot>', '']
        return "\n".join(out)


def solve(arm, q, target, bend=None, rounds=40):
    """Joint angles near q that put the ball of the arm on target; bend(q) gives twist, base, shift.

    Newton with the least step, so the posture in the null space stays.  Returns q and the miss.
    """
    q = np.array(q, float)
    for _ in range(rounds):
        twist, base, shift = bend(q) if bend else (None, None, 0.0)
        s = arm.sweep(q, twist, base)
        miss = target - s.ball - shift
        worst = np.linalg.norm(miss, axis=1)
        if worst.max() < 1e-11:
            break
        jac = arm.lever(s).transpose(0, 2, 1)
        soft = 1e-4 * np.minimum(1.0, worst / 1e-2)[:, None, None] * np.eye(3)
        step = np.einsum("nji,nj->ni", jac,
                         np.linalg.solve(jac @ jac.transpose(0, 2, 1) + soft + 1e-12 * np.eye(3),
                                         miss[:, :, None])[:, :, 0])
        size = np.abs(step).max(axis=1)
        q += step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-12))[:, None]
    return q, worst


def _chain(rows):
    """Rows of (shift, angles, axis, low, high) to the arrays of an Arm."""
    return ([r[0] for r in rows], [euler(*r[1]) for r in rows], [r[2] for r in rows],
            [(r[3], r[4]) for r in rows])


def own_arms():
    """Five arms, none of them of the practice sets."""
    h = np.pi / 2
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    arms = []
    # 7 axes, straight shoulder-elbow-wrist, alternating z and y axes, heavy
    arms.append(Arm("srs7", *_chain([
        ((0, 0, 0.31), (0, 0, 0), z, -2.9, 2.9), ((0, 0, 0), (0, 0, 0), y, -2.0, 2.0),
        ((0, 0, 0.21), (0, 0, 0), z, -2.9, 2.9), ((0, 0, 0.19), (0, 0, 0), y, -2.1, 2.1),
        ((0, 0, 0.21), (0, 0, 0), z, -2.9, 2.9), ((0, 0, 0.19), (0, 0, 0), y, -2.0, 2.0),
        ((0, 0, 0.08), (0, 0, 0), z, -2.9, 2.9)]), ball=(0.055, 0.02, 0.16),
        masses=[(0, 4.4, (0.0, -0.02, -0.04)), (1, 4.1, (0, 0.03, 0.12)), (2, 3.2, (0, 0.02, 0.09)),
                (3, 2.9, (0.01, 0.02, 0.11)), (4, 2.1, (0, 0.02, 0.08)), (5, 1.7, (0, 0, 0.03)),
                (6, 0.8, (0.01, 0, 0.06))]))
    # 6 axes, three parallel ones, wrist with offsets
    arms.append(Arm("par6", *_chain([
        ((0, 0, 0.16), (0, 0, 0), z, -3.0, 3.0), ((0, 0.135, 0), (0, h, 0), y, -2.6, 0.6),
        ((0, -0.12, 0.43), (0, 0, 0), y, -2.6, 2.6), ((0, 0, 0.39), (0, h, 0), y, -2.9, 2.9),
        ((0, 0.11, 0), (0, 0, 0), z, -2.9, 2.9), ((0, 0, 0.095), (0, 0, 0), y, -3.0, 3.0)]),
        ball=(0, 0.085, 0), flange=(np.array([0.0, 0.082, 0.0]), euler(0.0, 0.4, 0.3)),
        masses=[(0, 3.5, (0, 0.03, -0.02)), (1, 8.0, (0, 0.0, 0.24)), (2, 2.4, (0, 0.0, 0.21)),
                (3, 1.3, (0, 0.02, 0.0)), (4, 1.2, (0, 0, 0.06)), (5, 0.5, (0, 0.07, 0.02))]))
    # 6 axes, shoulder and elbow offsets, spherical wrist, large
    arms.append(Arm("elb6", *_chain([
        ((0, 0, 0.40), (0, 0, 0), z, -2.9, 2.9), ((0.12, 0, 0), (h, 0, 0), z, -0.6, 2.5),
        ((0.45, 0, 0), (0, 0, -h), z, -1.2, 2.4), ((0.03, 0.0, 0), (0, h, 0), z, -3.0, 3.0),
        ((0, 0, 0.42), (0, -h, 0), z, -2.0, 2.0), ((0.0, 0, 0), (0, h, 0), z, -3.0, 3.0)]),
        ball=(0.07, 0.0, 0.21),
        masses=[(0, 14.0, (0.06, 0.0, -0.05)), (1, 11.0, (0.2, 0.02, 0.05)),
                (2, 7.0, (0.03, 0.04, 0.0)), (3, 4.0, (0, 0.01, 0.2)), (4, 2.2, (0.02, 0, 0)),
                (5, 1.3, (0.02, 0, 0.09))]))
    # 7 axes, elbow and wrist offsets, axes along x, y and z in turn
    arms.append(Arm("off7", *_chain([
        ((0, 0, 0.28), (0, 0, 0), z, -3.0, 3.0), ((0, 0, 0), (-h, 0, 0), z, -1.9, 1.9),
        ((0, -0.29, 0), (h, 0, 0), z, -3.0, 3.0), ((0.053, 0, 0), (h, 0, 0), z, 0.1, 3.6),
        ((0.078, -0.34, 0), (h, 0, h), x, -3.0, 3.0), ((0, 0, 0), (0, h, 0), y, -1.7, 3.0),
        ((0.076, 0.0, 0.0), (-h, 0, 0), z, -3.0, 3.0)]), ball=(0.05, 0.045, 0.13),
        flange=(np.array([0, 0, 0.06]), euler(0, 0, -0.6)),
        masses=[(0, 2.5, (0, 0.03, -0.06)), (1, 1.9, (0, -0.12, 0.02)), (2, 2.2, (0.04, 0.01, -0.02)),
                (3, 1.8, (0.05, -0.15, 0.02)), (4, 1.5, (0, 0.03, 0.02)), (5, 1.1, (0.05, 0, 0.02)),
                (6, 0.7, (0.02, 0.01, 0.05))]))
    # 6 axes, desk-size and light
    arms.append(Arm("desk6", *_chain([
        ((0, 0, 0.20), (0, 0, 0), z, -2.7, 2.7), ((0, -0.02, 0), (h, 0, 0), z, -1.0, 2.9),
        ((0.0, 0.26, 0), (0, np.pi, 0), z, -2.6, 2.6), ((0.0, -0.13, 0.02), (h, 0, 0), z, -2.6, 2.6),
        ((0, 0, 0.10), (0, h, 0), z, -2.5, 2.5), ((-0.09, 0, 0.02), (0, -h, 0), z, -2.6, 2.6)]),
        ball=(0.03, 0.03, 0.12),
        masses=[(0, 1.0, (0, 0, 0.02)), (1, 1.2, (0.0, 0.2, 0.03)), (2, 0.6, (0.01, -0.08, 0.01)),
                (3, 0.5, (0, 0.01, 0.06)), (4, 0.5, (-0.05, 0, 0.01)), (5, 0.35, (0, 0, 0.05))]))
    return arms


def on_slides(arm, name, slides):
    """The arm on sliding joints: rows of (shift, axis, low, high, kg)."""
    shifts, axes, limits, masses = [], [], [], []
    for k, (shift, axis, low, high, kg) in enumerate(slides):
        shifts.append(shift)
        axes.append(axis)
        limits.append((low, high))
        masses.append((k, kg, np.array([0.02, 0.01, 0.1])))
    m = len(slides)
    return Arm(name, shifts + list(arm.shift), [np.eye(3)] * m + list(arm.frame),
               axes + list(arm.axis), limits + list(arm.limit), arm.ball,
               masses + [(k + m, kg, c) for k, kg, c in arm.masses], arm.flange, range(m))


def sliding_arms():
    """A lifting column, a floor rail, and a gantry with a wrist of three axes."""
    h = np.pi / 2
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    _, par, elb, _, desk = own_arms()
    wrist = Arm("wrist", *_chain([
        ((0.0, 0.0, -0.12), (np.pi, 0, 0), z, -2.9, 2.9), ((0.04, 0, 0.11), (h, 0, 0), z, -2.0, 2.0),
        ((0, 0.10, 0), (-h, 0, 0), z, -2.9, 2.9)]), ball=(0.06, 0.02, 0.19),
        masses=[(0, 3.0, (0.01, 0, 0.05)), (1, 2.0, (0, 0.05, 0)), (2, 1.2, (0.01, 0, 0.08))])
    return [on_slides(par, "column7", [((0, 0, 0.1), z, 0.0, 0.4, 12.0)]),
            on_slides(elb, "rail7", [((0, 0, 0.05), y, -0.7, 0.7, 25.0)]),
            on_slides(desk, "lift7", [((0.1, 0, 0.2), z, -0.2, 0.2, 4.0)]),
            on_slides(wrist, "gantry6", [((0, -0.6, 1.1), x, 0.0, 1.2, 30.0),
                                         ((0, 0.1, 0), y, 0.0, 1.0, 15.0),
                                         ((0.05, 0, 0), z, -0.6, 0.0, 8.0)])]


def linkage_arms():
    """Arms whose forearm a parallelogram drives from the shoulder: its angle to the base is bounded."""
    out = []
    for arm in own_arms():
        if arm.name in ("par6", "elb6", "desk6"):       # joints 2 and 3 parallel
            sign = -1.0 if arm.name == "desk6" else 1.0
            middle = (arm.limit[2] + sign * arm.limit[1][::int(sign)]).mean()
            arm.linkage = (sign, middle - 1.1, middle + 1.1)
            out.append(arm)
    return out


def from_urdf(path, tip="ball_link", inertials=None):
    """Arm of a URDF's chain; masses of the file, or of a TSV of inertials, side branches included."""
    root = ET.parse(path).getroot()

    def numbers(node, key):
        text = node.get(key) if node is not None else None
        return np.array([float(v) for v in (text or "0 0 0").split()])
    above = {}
    for j in root.findall("joint"):
        o = j.find("origin")
        lim = j.find("limit")
        axis = j.find("axis")
        above[j.find("child").get("link")] = dict(
            kind=j.get("type"), parent=j.find("parent").get("link"), shift=numbers(o, "xyz"),
            frame=euler(*numbers(o, "rpy")),
            axis=numbers(axis, "xyz") if axis is not None else np.array([1.0, 0, 0]),
            limit=(float(lim.get("lower", "-3")), float(lim.get("upper", "3")))
            if lim is not None else (-3.0, 3.0))
    order, link = [], tip
    while link in above:
        order.append(link)
        link = above[link]["parent"]
    order.reverse()
    owner = {}              # link -> (moving index, shift, frame) of it in the moving link's frame
    shifts, frames, axes, limits = [], [], [], []
    shift, frame, k = np.zeros(3), np.eye(3), -1
    for name in order:
        j = above[name]
        shift, frame = shift + frame @ j["shift"], frame @ j["frame"]
        if j["kind"] in ("revolute", "continuous"):
            shifts.append(shift)
            frames.append(frame)
            axes.append(j["axis"] / np.linalg.norm(j["axis"]))
            limits.append(j["limit"])
            shift, frame, k = np.zeros(3), np.eye(3), k + 1
        owner[name] = (k, shift, frame)

    def find(name):
        if name in owner:
            return owner[name]
        if name not in above:
            return (-1, np.zeros(3), np.eye(3))
        up, s, f = find(above[name]["parent"])
        return (up, s + f @ above[name]["shift"], f @ above[name]["frame"])
    weights = {}
    for node in root.findall("link"):
        i = node.find("inertial")
        if i is not None and i.find("mass") is not None:
            weights[node.get("name")] = (float(i.find("mass").get("value")),
                                         numbers(i.find("origin"), "xyz"))
    if inertials:
        with open(inertials) as f:
            rows = [r.split("\t") for r in f.read().splitlines()[1:] if r and r[0] != "#"]
        weights = {r[0]: (float(r[1]), np.array([float(v) for v in r[2:5]])) for r in rows}
    masses = []
    for name, (kg, centre) in weights.items():
        at, s, f = find(name)
        if at >= 0 and kg > 0:
            masses.append((at, kg, s + f @ centre))
    name = os.path.splitext(os.path.basename(path))[0]
    return Arm(name, shifts, frames, axes, limits, shift, masses)


REAL = {"panda": ("panda.urdf", "inertials_panda.tsv",
                  ("panda_1", "panda_2", "panda_3", "panda_4")),
        "iiwa14": ("iiwa14.urdf", "inertials_iiwa14.tsv", ("kuka_14",)),
        "gen3lite": ("gen3lite.urdf", None, ("dinova_1",))}


def recorded(folder):
    """Recorded arms and postures: [(arm, [placement: (rows of socket 0, rows of socket 1)])]."""
    out = []
    for urdf, inertials, sets in REAL.values():
        arm = from_urdf(os.path.join(folder, urdf),
                        inertials=inertials and os.path.join(folder, inertials))
        places = []
        for data in sets:
            for place in sorted(os.listdir(os.path.join(folder, data))):
                both = []
                for hole in (0, 1):
                    q = np.loadtxt(os.path.join(folder, data, place, f"hole_{hole}.csv"),
                                   delimiter=",", ndmin=2)[:, :arm.n]
                    new = np.abs(np.diff(q, axis=0)).max(axis=1) > 1e-3     # not recorded twice
                    q = q[np.concatenate([[True], new])]
                    p = arm.sweep(q).ball
                    off = np.linalg.norm(p - np.median(p, axis=0), axis=1)
                    both.append(q[off < 0.025])
                if min(len(b) for b in both) >= 8:
                    places.append(tuple(both))
        every = np.vstack([q for pl in places for q in pl])
        arm.limit[:, 0] = np.minimum(arm.limit[:, 0], every.min(axis=0) - 0.05)
        arm.limit[:, 1] = np.maximum(arm.limit[:, 1], every.max(axis=0) + 0.05)
        out.append((arm, places))
    return out
