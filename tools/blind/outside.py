"""What can be wrong with a real arm and is in no catalogue: from mechanics, one function each.

A cause of unit amplitude is (turns about joints {j: (N,3)}, turn of the base (N,3) or None, move of
the ball (N,3) or None), world frame.  `near` names what a person could fairly call it: an effect at
one of the cause's joints.
"""
import numpy as np

UP = np.array([0.0, 0.0, 1.0])


class Unfit(Exception):
    """This arm or recording cannot show such a cause."""


def pick(rng, values):
    return values[int(rng.integers(len(values)))]


def unit_vector(rng, flat=False):
    v = rng.standard_normal(3) * ((1, 1, 0) if flat else 1)
    return v / np.linalg.norm(v)


def across(arm, j, phase):
    """A direction across joint j's axis, in the joint's frame."""
    a = arm.axis[j]
    side = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
    side /= np.linalg.norm(side)
    return np.cos(phase) * side + np.sin(phase) * np.cross(a, side)


def about(st, j, angle):
    return {j: angle[:, None] * st.sweep.axis[:, j]}, None, None


def loaded(st, j, part=0.1):
    """Rms holding torque; an upright axis carries nothing."""
    load = np.sqrt((st.hold ** 2).mean(axis=0)) * ~st.arm.slide
    if load[j] < part * load.max():
        raise Unfit
    return load[j]


def turning(st, j, span=0.25):
    if st.arm.slide[j] or np.ptp(st.q[:, j]) < span:
        raise Unfit


def warm(st, s):
    return 1 - np.exp(-st.time / s["tau_s"])


# ---- the causes: draw(rng, st, j) gives the settings, unit(st, j, s) the move --------------------

def hose_draw(rng, st, j):
    soft = np.exp(0.7 * rng.standard_normal(st.arm.n)) * ~st.arm.slide
    bracket = np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(0.8, 1.8)])
    return dict(bracket=bracket, softness=soft)


def hose_unit(st, j, s):
    """A hose package pulls the tool towards its bracket; every joint twists under it."""
    pull = s["bracket"] - st.sweep.ball
    pull /= np.linalg.norm(pull, axis=1)[:, None]
    torque = np.einsum("nki,ni->nk", st.arm.lever(st.sweep), pull) * s["softness"]
    return {k: torque[:, k:k + 1] * st.sweep.axis[:, k]
            for k in np.flatnonzero(s["softness"])}, None, None


def belt_draw(rng, st, j):
    near = [k for k in (j + 1, j + 2) if k < st.arm.n]
    if not near or st.arm.slide[j]:
        raise Unfit
    k = pick(rng, near)
    loaded(st, k)
    return dict(from_index=k)


def belt_unit(st, j, s):
    """A belt through joint j stretches under the load of a later joint, and turns j."""
    return about(st, j, -st.hold[:, s["from_index"]])


def spring_draw(rng, st, j):
    return dict(load=loaded(st, j), form=pick(rng, ["progressive", "dead_zone"]),
                free=float(rng.uniform(0.4, 0.9)))


def spring_unit(st, j, s):
    """A spring that stiffens, or one that engages only beyond a dead zone."""
    h = st.hold[:, j] / s["load"]
    if s["form"] == "progressive":
        return about(st, j, -np.tanh(h * np.abs(h)))
    return about(st, j, -np.sign(h) * np.maximum(np.abs(h) - s["free"], 0))


def friction_draw(rng, st, j):
    turning(st, j)
    return dict(load=loaded(st, j))


def friction_unit(st, j, s):
    """Wind-up by friction that grows with the load: where the joint rests depends on both."""
    return about(st, j, -np.tanh(st.step[:, j] / 0.02) * np.abs(st.hold[:, j]) / s["load"])


def creep_draw(rng, st, j):
    return dict(load=loaded(st, j), tau_s=float(rng.uniform(20, 90)))


def creep_unit(st, j, s):
    """Elastic after-effect (polymer gear, rubber buffer): the deflection follows the load late."""
    h, late = st.hold[:, j] / s["load"], np.empty(len(st.q))
    gain = 1 - np.exp(-np.diff(st.time, prepend=st.time[0]).clip(0) / s["tau_s"])
    now = h[0]
    for i, g in enumerate(gain):
        now += g * (h[i - 1 if i else 0] - now)
        late[i] = now
    return about(st, j, -late)


def worn_draw(rng, st, j):
    turning(st, j)
    loaded(st, j)
    q = st.q[:, j]
    return dict(centre=float(np.quantile(q, rng.uniform(0.25, 0.75))),
                width=float(np.ptp(q) * rng.uniform(0.12, 0.25)))


def worn_unit(st, j, s):
    """Teeth worn where the joint works most: free motion over a part of the range."""
    window = np.exp(-0.5 * ((st.q[:, j] - s["centre"]) / s["width"]) ** 2)
    return about(st, j, -np.tanh(st.hold[:, j]) * window)


def cold_draw(rng, st, j):
    return dict(load=loaded(st, j), tau_s=float(rng.uniform(300, 1500)))


def cold_unit(st, j, s):
    """A cold gear whose flexibility changes as it warms."""
    return about(st, j, -st.hold[:, j] / s["load"] * warm(st, s))


def lobes_draw(rng, st, j):
    turning(st, j, 0.5)
    return dict(lobes=int(rng.integers(2, 6)), phase=float(rng.uniform(0, 2 * np.pi)),
                direction=across(st.arm, j, rng.uniform(0, 2 * np.pi)))


def lobes_unit(st, j, s):
    """A bearing out of round: the axis moves sideways as the joint turns."""
    size = np.sin(s["lobes"] * st.q[:, j] + s["phase"])
    return {}, None, (st.sweep.before[:, j] @ s["direction"]) * size[:, None]


def bent_draw(rng, st, j):
    n = st.rank.size
    return dict(first_row=int(rng.integers(n // 5, 4 * n // 5)) + 1,
                direction=across(st.arm, j, rng.uniform(0, 2 * np.pi)))


def bent_unit(st, j, s):
    """A collision in mid-recording bends the link before joint j across its axis."""
    hit = st.rank >= s["first_row"] - 1
    return {j: (st.sweep.before[:, j] @ s["direction"]) * hit[:, None]}, None, None


def warp_draw(rng, st, j):
    return dict(tau_s=float(rng.uniform(300, 2500)),
                direction=across(st.arm, j, rng.uniform(0, 2 * np.pi)))


def warp_unit(st, j, s):
    """One side of a link is warmer than the other: it warps with time."""
    return {j: (st.sweep.before[:, j] @ s["direction"]) * warm(st, s)[:, None]}, None, None


def room_draw(rng, st, j):
    return dict(period_s=float(rng.uniform(0.15, 0.6) * np.ptp(st.time)),
                phase=float(rng.uniform(0, 2 * np.pi)), direction=unit_vector(rng, flat=True))


def room_unit(st, j, s):
    """The stand follows the room's temperature to and fro."""
    x = np.sin(2 * np.pi * st.time / s["period_s"] + s["phase"])
    return {}, x[:, None] * s["direction"], None


def rocking_draw(rng, st, j):
    u = unit_vector(rng, flat=True)
    m = st.base_moment @ u
    middle = float(np.quantile(m, rng.uniform(0.3, 0.7)))
    return dict(direction=u, tips_at=middle, width=float(0.15 * np.std(m) + 0.1))


def rocking_unit(st, j, s):
    """A base on a loose bolt or short foot rocks over one line: one rest or the other."""
    x = np.tanh((st.base_moment @ s["direction"] - s["tips_at"]) / s["width"])
    return {}, x[:, None] * s["direction"], None


def table_draw(rng, st, j):
    return dict(direction=unit_vector(rng, flat=True),
                place=np.array([*rng.uniform(-0.6, 0.6, 2), 0.0]))


def table_unit(st, j, s):
    """A soft table: it tips about one edge only, and sags where the arm leans."""
    u = s["direction"]
    x = st.base_moment @ u
    base = x[:, None] * u
    return {}, base, np.cross(base, -s["place"])


def socket_draw(rng, st, j):
    places = int(st.place.max()) + 1
    return dict(direction=np.array([unit_vector(rng, flat=True) for _ in range(places)]))


def socket_unit(st, j, s):
    """A worn, oval socket: the ball rests at the side to which the tool leans."""
    lean = st.sweep.ball - st.sweep.origin[:, -1]
    lean /= np.linalg.norm(lean, axis=1)[:, None] + 1e-12
    u = s["direction"][np.minimum(st.place, len(s["direction"]) - 1)]
    return {}, None, u * np.tanh(3 * np.einsum("ni,ni->n", u, lean))[:, None]


def ball_draw(rng, st, j):
    m = rng.standard_normal((3, 3))
    m = m + m.T
    return dict(shape=m - np.eye(3) * np.trace(m) / 3)


def ball_unit(st, j, s):
    """A ball out of round: how deep it sits depends on the side it stands on."""
    side = np.einsum("nij,i->nj", st.sweep.last, UP)
    return {}, None, np.einsum("ni,ij,nj->n", side, s["shape"], side)[:, None] * UP


def tool_draw(rng, st, j):
    u = unit_vector(rng)
    if np.ptp(st.sweep.last @ u @ UP) < 0.4:
        raise Unfit
    return dict(direction=u, tips_at=float(np.quantile(st.sweep.last @ u @ UP, rng.uniform(0.3, 0.7))))


def tool_unit(st, j, s):
    """A loose tool drops to one side or the other as the flange turns over."""
    u = st.sweep.last @ s["direction"]
    return {}, None, -u * np.tanh((u @ UP - s["tips_at"]) / 0.15)[:, None]


def rail_draw(rng, st, j):
    if not st.arm.slide[j] or np.ptp(st.q[:, j]) < 0.1:
        raise Unfit
    return dict(direction=across(st.arm, j, rng.uniform(0, 2 * np.pi)),
                length=float(np.ptp(st.q[:, j]) * rng.uniform(0.5, 1.2)),
                phase=float(rng.uniform(0, 2 * np.pi)))


def rail_unit(st, j, s):
    """A guide that is not straight."""
    x = np.sin(2 * np.pi * st.q[:, j] / s["length"] + s["phase"])
    return {}, None, (st.sweep.before[:, j] @ s["direction"]) * x[:, None]


def linkage_draw(rng, st, j):
    if not st.arm.linkage:
        raise Unfit
    form = pick(rng, ["gear", "spring"])
    if form == "spring":
        loaded(st, 1)
    return dict(form=form, order=int(pick(rng, [1, 2, 3, 4, 80, 100, 120])),
                phase=float(rng.uniform(0, 2 * np.pi)))


def linkage_unit(st, j, s):
    """The forearm's gear sits at the shoulder: its error goes by the forearm's angle to the base.

    The shoulder's gear carries no moment of the forearm, and the forearm does not follow it.
    """
    sign = st.arm.linkage[0]
    if s["form"] == "gear":
        return about(st, 2, np.sin(s["order"] * (st.q[:, 2] + sign * st.q[:, 1]) + s["phase"]))
    bend = -(st.hold[:, 1] - sign * st.hold[:, 2])
    axis = st.sweep.axis
    return {1: bend[:, None] * axis[:, 1], 2: -sign * bend[:, None] * axis[:, 2]}, None, None


SPRING, TIME = ("joint_compliance", "link_bending"), ("joint_drift",)
BASE = ("base_compliance", "link_bending@1")
# draw, unit, weight, has a joint, what a person could fairly call it at the joint or its neighbour
CAUSES = {
    "hose_pull": (hose_draw, hose_unit, 6, False, SPRING),
    "belt_stretch": (belt_draw, belt_unit, 6, True, SPRING),
    "nonlinear_spring": (spring_draw, spring_unit, 7, True, SPRING + ("backlash",)),
    "load_friction": (friction_draw, friction_unit, 5, True, ("approach_hysteresis", "backlash")),
    "elastic_creep": (creep_draw, creep_unit, 5, True, SPRING),
    "worn_segment": (worn_draw, worn_unit, 5, True, SPRING + ("backlash",)),
    "warming_spring": (cold_draw, cold_unit, 4, True, SPRING + TIME),
    "bearing_lobes": (lobes_draw, lobes_unit, 5, True, ("axis_wobble",)),
    "bent_link": (bent_draw, bent_unit, 4, True, ("zero_jump", "tool_motion@any") + TIME),
    "link_warp": (warp_draw, warp_unit, 4, True, TIME),
    "room_cycle": (room_draw, room_unit, 4, False, ("tool_motion@any",)),
    "rocking_base": (rocking_draw, rocking_unit, 5, False, BASE),
    "soft_table": (table_draw, table_unit, 4, False, BASE),
    "worn_socket": (socket_draw, socket_unit, 5, False, ()),
    "oval_ball": (ball_draw, ball_unit, 5, False, ()),
    "loose_tool": (tool_draw, tool_unit, 5, False, ()),
    "bent_rail": (rail_draw, rail_unit, 3, True, ()),
    "linkage_gear": (linkage_draw, linkage_unit, 4, False, ()),
}


def near(part, n):
    """What a person could fairly call the cause: [effect, joint], null for any joint."""
    out = []
    for name in CAUSES[part.kind][4]:
        effect, _, at = name.partition("@")
        joints = [] if at == "any" else [int(at)] if at else [j + 1 for j in part.joints]
        across = effect == "link_bending" and not at or part.kind in ("bent_link", "link_warp")
        joints += [j + d for j in joints for d in (-1, 1) if across and 0 < j + d <= n]
        out += [[effect, f"joint_{j}"] for j in joints] or [[effect, None]]
    return out


def imitators(part, st):
    """Moves of the ball by familiar causes near this one: strength is what they leave."""
    lever, k = st.arm.lever(st.sweep), part.kind
    cols = []
    if CAUSES[k][3]:
        j = part.joints[0]
        for i in [i for i in range(st.arm.n) if abs(i - j) <= 1]:
            cols += [lever[:, i] * f[:, None] for f in (st.q[:, i], st.hold[:, i])]
        x = st.q[:, j] if not st.arm.slide[j] else 0.0 * st.q[:, j]
        cols += [lever[:, j] * f[:, None] for f in (np.sin(x), np.cos(x), np.tanh(st.hold[:, j]),
                                                    np.tanh(st.step[:, j] / 0.02), st.time / 1000)]
    elif k == "linkage_gear":
        cols += [lever[:, i] * f[:, None] for i in (1, 2)
                 for f in (st.q[:, 1], st.q[:, 2], st.hold[:, i])]
    else:
        tilt = st.base_moment * (1, 1, 0)
        cols += [np.cross(tilt, st.sweep.ball)]
        cols += [lever[:, i] * st.hold[:, i:i + 1] for i in range(st.arm.n)]
    return np.stack(cols, axis=2)
