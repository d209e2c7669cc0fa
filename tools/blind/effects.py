"""What can be wrong with a real arm, as seen in the world frame: the true effects of the blind cases.

A Part is one hidden cause.  Given the recorded state (angles, steps, time, placement, gravity's
moments of the arm as built) it returns, for unit amplitude, small rotations about the joints'
origins, about the base, and a displacement of the ball.
"""
import numpy as np

import outside


class State:
    """Everything a cause may depend on, for the encoder angles q of one recording."""

    def __init__(self, arm, q, time, place, rank=None, posture=None):
        s = arm.sweep(q, want_masses=True)
        self.arm, self.q, self.time, self.place, self.sweep = arm, q, time, place, s
        self.rank = np.arange(len(q)) if rank is None else rank
        self.moment, self.base_moment, self.hold = arm.gravity(s)
        posture = np.arange(len(q)) if posture is None else posture
        at = np.arange(len(q))
        first = np.maximum.accumulate(np.where(np.diff(posture, prepend=-1) != 0, at, 0))
        self.reading = at - first               # since the arm arrived
        self.step = np.vstack([np.zeros((1, q.shape[1])), np.diff(q, axis=0)])[first]


class Part:
    """One cause: kind, joints (indices), settings, amplitude."""

    def __init__(self, kind, joints=(), amplitude=1.0, session_only=False, **settings):
        self.kind, self.joints, self.amplitude = kind, list(joints), amplitude
        self.session_only = session_only        # tied to a placement or row of the session
        self.set = settings

    def unit(self, st):
        """twist (N,n,3), base (N,3), shift (N,3) for amplitude 1, world frame."""
        rows, n = st.q.shape
        twist, base, shift = np.zeros((rows, n, 3)), np.zeros((rows, 3)), np.zeros((rows, 3))
        if self.kind in outside.CAUSES:
            turns, tilt, move = outside.CAUSES[self.kind][1](st, (self.joints or [0])[0], self.set)
            for j, t in turns.items():
                twist[:, j] = t
            base = base if tilt is None else tilt
            shift = shift if move is None else move
        elif self.kind == "base_compliance":
            base = st.base_moment.copy()
            base[:, 2] = 0.0
        elif self.kind == "ball_shift":
            hit = st.place == self.set["placement"]
            shift[hit] = st.sweep.last[hit] @ self.set["direction"]
        elif self.kind == "readback_lag":
            top = np.abs(st.step / st.arm.step).max(axis=1, keepdims=True)
            part = np.divide(st.step, top, out=np.zeros_like(st.step), where=top > 1e-12)
            if self.set.get("settle"):      # a dwelling arm: later readings lag less
                part = part * np.exp(-st.reading / self.set["settle"])[:, None]
            move = part[:, :, None] * st.sweep.axis
            twist = np.where(st.arm.slide[:, None], 0.0, move)
            shift = move[:, st.arm.slide].sum(axis=1)
        elif self.kind == "thermal_link":
            j = self.joints[0]      # the span from joint j to the next grows with its warmth
            nxt = st.sweep.origin[:, j + 1] if j + 1 < n else st.sweep.ball
            span = nxt - st.sweep.origin[:, j]
            shift = span * (1 - np.exp(-st.time / self.set["tau_s"]))[:, None]
        elif self.kind == "link_bending":
            j = self.joints[0]
            m, a = st.moment[:, j], st.sweep.axis[:, j]
            twist[:, j] = m - np.einsum("ni,ni->n", m, a)[:, None] * a
        elif self.kind == "axis_wobble":
            j = self.joints[0]
            a = st.arm.axis[j]
            side = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
            side /= np.linalg.norm(side)
            other = np.cross(a, side)
            frame = st.sweep.before[:, j]
            if self.set["after"]:
                frame = frame @ _spin(a, st.q[:, j])
            x = self.set["order"] * st.q[:, j] + self.set["phase"]
            twist[:, j] = (frame @ side) * np.cos(x)[:, None] + (frame @ other) * np.sin(x)[:, None]
        else:
            for j in self.joints:
                move = self.angle(st, j)[:, None] * st.sweep.axis[:, j]
                if st.arm.slide[j]:
                    shift = shift + move
                else:
                    twist[:, j] = move
        return twist, base, shift

    def angle(self, st, j):
        """Error of joint j's angle for amplitude 1: what the arm does beyond its encoder."""
        q, s, k = st.q[:, j], self.set, self.kind
        if k == "joint_compliance":
            return -st.hold[:, j]
        if k == "backlash":
            return -0.5 * np.tanh(st.hold[:, j] / s["threshold"])
        if k == "approach_hysteresis":
            return -0.5 * np.tanh(st.step[:, j] / (0.02 * st.arm.step[j]))
        if k == "joint_scale":
            return q
        if k == "joint_coupling":
            return st.q[:, s["from_index"]]
        if k in ("encoder_eccentricity", "gear_harmonic"):
            return np.sin(s["order"] * q + s["phase"])
        if k == "joint_drift":
            return st.time / 1000.0 if s["linear"] else 1.0 - np.exp(-st.time / s["tau_s"])
        if k == "zero_jump":
            return (st.place == s["placement"]).astype(float)
        if k == "joint_slip":
            return (st.rank >= s["first_row"] - 1).astype(float)
        if k == "local_fault":
            x = (q - s["centre"]) / s["width"]
            return {"bump": np.exp(-0.5 * x * x), "step": np.tanh(3 * x),
                    "kink": np.sqrt(x * x + 0.01)}[s["variant"]]
        if k == "cable_pull":
            x = (q - s["centre"]) / s["width"]
            y = (st.q[:, s["from_index"]] - s["centre_from"]) / s["width_from"]
            if s["variant"] == "taut":          # slack until both joints have wound it up
                return np.logaddexp(0.0, 3.0 * (x + y)) / 3.0
            if s["variant"] == "saddle":
                return np.tanh(x) * np.tanh(y)
            return np.exp(-0.5 * (x * x + y * y))
        raise ValueError(k)


def _spin(axis, angle):
    """Rotations about one fixed axis, (N,3,3)."""
    u = np.asarray(axis, float)
    k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    return (np.eye(3) + np.sin(angle)[:, None, None] * k
            + (1 - np.cos(angle))[:, None, None] * (k @ k))


def displacement(part, st):
    """First-order move of the ball for amplitude 1, (N,3)."""
    twist, base, shift = part.unit(st)
    arm = st.sweep.ball[:, None] - st.sweep.origin
    return np.cross(twist, arm).sum(axis=1) + np.cross(base, st.sweep.ball) + shift


def bender(arm, parts, time, place, session=True, posture=None):
    """The function that arms.solve wants: all causes together at given encoder angles."""
    live = [p for p in parts if session or not p.session_only]

    def bend(q):
        st = State(arm, q, time, place, posture=posture)
        twist = np.zeros(q.shape + (3,))
        base, shift = np.zeros((len(q), 3)), np.zeros((len(q), 3))
        for p in live:
            t, b, s = p.unit(st)
            twist += p.amplitude * t
            base += p.amplitude * b
            shift += p.amplitude * s
        return twist, base, shift
    return bend if live else None


def centred(x, group):
    """Less the mean of its group (socket), per column; x is (N,3,...)."""
    out = np.array(x, float)
    for g in np.unique(group):
        out[group == g] -= out[group == g].mean(axis=0)
    return out


def unabsorbed(move, geometry, group, extra=None):
    """What no change of geometry (and of extra columns) can imitate of a move of the ball, (N,3)."""
    cols = geometry if extra is None else np.concatenate([geometry, extra], axis=2)
    a = centred(cols, group).reshape(-1, cols.shape[2])
    norm = np.linalg.norm(a, axis=0)
    a = a[:, norm > 1e-12] / norm[norm > 1e-12]
    u, sv, _ = np.linalg.svd(a, full_matrices=False)
    u = u[:, sv > 1e-7 * sv[0]]
    y = centred(move, group).reshape(-1)
    return (y - u @ (u.T @ y)).reshape(-1, 3)


def rms(x):
    """Root mean square per axis of (N,3)."""
    return float(np.sqrt(np.mean(np.square(x))))
