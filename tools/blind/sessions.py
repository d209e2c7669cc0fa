"""Sessions of the blind cases: postures around sockets, read once or several times, and their noise."""
import numpy as np

import arms
from effects import State, bender

DISTANCE = 0.05


class Again(Exception):
    """This draw led nowhere; draw another."""


def fits(arm, q, margin=0.03):
    good = np.all((q > arm.limit[:, 0] + margin) & (q < arm.limit[:, 1] - margin), axis=1)
    if arm.linkage:
        sign, low, high = arm.linkage
        forearm = q[:, 2] + sign * q[:, 1]
        good &= (forearm > low) & (forearm < high)
    return good


def smooth(rng, rows, n):
    """Unit-variance wandering curves through a few knots, (rows,n)."""
    knots = rng.standard_normal((max(3, rows // 5) + 3, n))
    x = np.linspace(0, len(knots) - 1.001, rows)
    i, f = x.astype(int), (x % 1)[:, None]
    f = f * f * (3 - 2 * f)
    return knots[i] * (1 - f) + knots[i + 1] * f


def drawn_places(arm, rng, places, rows, sweep):
    """Postures around random sockets: list of (start rows of socket 0 and 1, sockets)."""
    out = []
    reach = arm.reach()
    for _ in range(400):
        if len(out) == places:
            return out
        mid, half = arm.limit.mean(axis=1), np.diff(arm.limit, axis=1)[:, 0] / 2
        q = (mid + half * rng.uniform(-0.75, 0.75, arm.n))[None]
        s = arm.sweep(q)
        p = s.ball[0]
        jac = arm.lever(s)[0].T
        far = np.linalg.norm(p[:2] - s.origin[0, np.argmin(arm.slide), :2] * arm.slide.any())
        high = s.origin[0, 0, 2] * (arm.slide.sum() > 1) + 0.65 * reach
        if not (-0.05 < p[2] < high and (far > 0.25 * reach or arm.slide.sum() > 1)
                and np.linalg.svd(jac, compute_uv=False)[2] > 0.09 * reach):
            continue
        if any(np.linalg.norm(p - o[1][0]) < 0.18 * reach for o in out):
            continue
        way = rng.standard_normal(3) * (1, 1, 0.3)
        socket = np.array([p, p + DISTANCE * way / np.linalg.norm(way)])
        spread = rng.uniform(0.25, 0.6)
        starts = []
        for k in range(2):
            want = rows * (4 if not sweep else 3)
            walk = smooth(rng, want, arm.n) if sweep else rng.standard_normal((want, arm.n))
            start, miss = arms.solve(arm, q + spread * arm.step * walk, np.tile(socket[k], (want, 1)),
                                     rounds=25)
            start = start[(miss < 1e-4) & fits(arm, start)]
            if len(start) < rows:
                break
            if sweep:
                first = rng.integers(0, len(start) - rows + 1)
                starts.append(start[first:first + rows])
            else:
                starts.append(start[:rows])
        if len(starts) == 2:
            out.append((starts, socket))
    raise Again


def recorded_places(arm, rng, stock, places, rows):
    """Recorded postures; where a robot has too few placements, others turned about joint 1."""
    order = list(rng.permutation(len(stock)))
    out = []
    for i in range(places):
        both = stock[order[i % len(order)]]
        both = [b[:rows].copy() for b in both]
        if i >= len(order):
            low = arm.limit[0, 0] - min(b[:, 0].min() for b in both)
            high = arm.limit[0, 1] - max(b[:, 0].max() for b in both)
            by = rng.uniform(max(-1.2, low + 0.05), min(1.2, high - 0.05))
            for b in both:
                b[:, 0] += by
        mean = [arm.sweep(b).ball.mean(axis=0) for b in both]
        way = mean[1] - mean[0]
        out.append((both, np.array([mean[0], mean[0] + DISTANCE * way / np.linalg.norm(way)])))
    return out


class Session:
    """Rows of a recording: start angles, posture, placement, socket and time."""

    def __init__(self, rng, places):
        groups = [(i, k, q) for i, (starts, _) in enumerate(places) for k, q in enumerate(starts)]
        self.sockets = [s for _, s in places]
        self.q = np.vstack([q for _, _, q in groups])
        self.place = np.repeat([i for i, _, _ in groups], [len(q) for _, _, q in groups])
        self.socket = np.repeat([k for _, k, _ in groups], [len(q) for _, _, q in groups])
        self.target = np.array([self.sockets[i][k] for i, k in zip(self.place, self.socket)])
        self.posture = np.arange(len(self.q))
        self.postures = len(self.q)
        self.beat = rng.uniform(5, 10)
        self.clock(rng)

    def clock(self, rng):
        """Group of each row, and times: readings of one posture are a second or two apart."""
        self.rows, self.group = len(self.q), 2 * self.place + self.socket
        step = self.beat * rng.uniform(0.8, 1.2, self.rows)
        new = np.diff(self.posture, prepend=-1) != 0
        step[~new] = rng.uniform(1, 2, (~new).sum())
        turned = np.diff(self.group, prepend=0) != 0
        moved = np.diff(self.place, prepend=0) != 0
        step[turned] += rng.uniform(5, 30, turned.sum())
        step[moved] += rng.uniform(60, 400, moved.sum())
        self.time = np.cumsum(step)

    def read_again(self, rng, way, most=1500):
        """Each posture several times: the arm dwells, or its list of postures is run in rounds."""
        if way == "dwell":
            mean = min(np.exp(rng.uniform(np.log(3), np.log(22))), most / self.postures)
            many = np.clip(np.round(mean * rng.uniform(0.6, 1.4, self.postures)), 3, 30)
            order = np.repeat(np.arange(self.postures), many.astype(int))
        else:
            rounds = int(min(rng.integers(3, 11), max(3, most // self.postures)))
            order = np.hstack([np.tile(np.flatnonzero(self.group == g), rounds)
                               for g in np.unique(self.group)])
        for name in ("q", "target", "place", "socket", "posture"):
            setattr(self, name, getattr(self, name)[order])
        self.clock(rng)

    def rows_of(self, place, socket):
        return np.where((self.place == place) & (self.socket == socket))[0]


def noise(rng, ses, sigma, rho, heavy):
    """Seating error (N,3), shared by a posture's readings: correlated within a socket when rho."""
    group = ses.group[np.unique(ses.posture, return_index=True)[1]]
    e = rng.standard_normal((ses.postures, 3))
    if heavy == "student":
        e = rng.standard_t(3, (ses.postures, 3)) / np.sqrt(3.0)
    elif heavy == "contaminated":
        e *= np.where(rng.random(ses.postures) < 0.06, 4.0, 0.8)[:, None]
    if rho:
        for g in np.unique(group):
            ix = np.where(group == g)[0]
            for a, b in zip(ix[:-1], ix[1:]):
                e[b] = rho * e[a] + np.sqrt(1 - rho * rho) * e[b]
    return sigma * e[ses.posture]


def write_table(path, arm, ses, q, effort, with_time):
    names = ["placement", "socket"] + (["time_s"] if with_time else []) + arm.joints
    if effort is not None:
        names += [j + ".effort" for j in arm.joints]
    with open(path, "w") as f:
        f.write("\t".join(names) + "\n")
        for i in range(len(q)):
            row = [f"p{ses.place[i]}", str(ses.socket[i])]
            row += [f"{ses.time[i]:.3f}"] if with_time else []
            row += [f"{v:.9f}" for v in q[i]]
            if effort is not None:
                row += [f"{v:.4f}" for v in effort[i]]
            f.write("\t".join(row) + "\n")


def record(arm, ses, rng, sigma, rho, heavy, parts, move=None, session=True, encoder=0.0):
    """Encoder angles of a session of the true arm, and the holding torques."""
    target = ses.target + noise(rng, ses, sigma, rho, heavy) + (0 if move is None else move)
    q, miss = arms.solve(arm, ses.q, target,
                         bender(arm, parts, ses.time, ses.place, session, ses.posture))
    if miss.max() > 1e-7 or not np.all(fits(arm, q, 0.0)):
        raise Again
    read = q + encoder * arm.step * rng.standard_normal(q.shape)
    return read, State(arm, q, ses.time, ses.place).hold
