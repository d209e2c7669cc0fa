"""Hidden causes of the blind cases: which there are, how they are drawn, how strong they show."""
import copy

import numpy as np

import outside
from effects import Part, State, centred, displacement, rms, unabsorbed
from sessions import Again

DETECTABLE = 8.0        # smallest snr * sqrt(3 rows) that the truth itself would show with certainty
SINGLE = {"joint_compliance": 14, "link_bending": 10, "base_compliance": 9, "backlash": 10,
          "approach_hysteresis": 10, "joint_scale": 10, "joint_coupling": 10,
          "encoder_eccentricity": 10, "gear_harmonic": 14, "axis_wobble": 10, "joint_drift": 10,
          "readback_lag": 5, "zero_jump": 10, "ball_shift": 8, "socket_distance": 4}
OTHER = {"none": 16, "none_correlated": 14, "none_heavy": 18, "mixture": 28, "beside": 55,
         "tool_motion": 10, "tool_creep": 4, "wrong_socket": 8, "outlier": 6, "duplicate": 4,
         "effect_and_motion": 12, "convention": 6}
# Three cases of ten: half of them alone, half beside an effect of the catalogue.
OUTSIDE = {"local_fault": 5, "cable_pull": 5, "thermal_link": 3, "joint_slip": 3,
           **{k: c[2] / 2 for k, c in outside.CAUSES.items()}}
ONCE = {"tool_motion", "tool_creep", "wrong_socket", "outlier", "duplicate", "effect_and_motion",
        "socket_distance"}      # kinds whose postures are read once
JOINTLESS = {"base_compliance", "readback_lag", "ball_shift"} | {
    k for k, c in outside.CAUSES.items() if not c[3]}
# largest believable size: rms of the joint's angle error in rad (ball_shift and distance in m)
CAP = {"joint_compliance": 5e-3, "link_bending": 2.5e-3, "base_compliance": 2.5e-3,
       "backlash": 2.5e-3, "approach_hysteresis": 2e-3, "joint_scale": 4e-3,
       "joint_coupling": 4e-3, "encoder_eccentricity": 3.5e-3, "gear_harmonic": 2e-3,
       "axis_wobble": 2.5e-3, "joint_drift": 4e-3, "readback_lag": 2e-3, "zero_jump": 4e-3,
       "ball_shift": 2e-3, "local_fault": 4e-3, "cable_pull": 4e-3, "thermal_link": 4e-3,
       "joint_slip": 5e-3}
SIGNED = {"joint_compliance", "link_bending", "base_compliance", "backlash", "readback_lag",
          "thermal_link", "axis_wobble", "approach_hysteresis", "hose_pull", "belt_stretch",
          "nonlinear_spring", "load_friction", "elastic_creep", "worn_segment", "warming_spring",
          "rocking_base", "soft_table", "worn_socket", "loose_tool", "linkage_gear"}


def draw_part(kind, arm, rng, st, joint, places):
    """A cause of unit amplitude at a joint, with its settings drawn."""
    q = st.q
    span = np.ptp(q, axis=0)
    phase = rng.uniform(0, 2 * np.pi)
    if kind in outside.CAUSES:
        try:
            settings = outside.CAUSES[kind][0](rng, st, joint)
        except outside.Unfit:
            raise Again from None
        return Part(kind, [] if kind in JOINTLESS else [joint],
                    session_only=kind in ("bent_link", "worn_socket"), **settings)
    if arm.slide[joint] and kind not in JOINTLESS | {"joint_scale", "approach_hysteresis"}:
        raise Again
    if kind in ("joint_compliance", "backlash"):
        load = np.sqrt((st.hold ** 2).mean(axis=0)) * ~arm.slide
        if load[joint] < 0.03 * load.max():     # an upright axis carries nothing
            raise Again
        which = [joint]
        heavy = [j for j in np.argsort(-load)[:3] if j != joint]
        if rng.random() < 0.35:
            which = sorted(which + [int(heavy[0])])
        threshold = float(rng.choice([0.3, 1.0, 3.0]))
        if kind == "backlash" and np.abs(st.hold[:, which]).max(axis=0).min() < threshold:
            raise Again     # held between the flanks, a joint turns as one with a spring
        return Part(kind, which, threshold=threshold)
    if kind == "base_compliance":
        return Part(kind)
    if kind == "readback_lag":          # of the readings of one posture, all lag or the first ones
        return Part(kind, settle=float(rng.choice([0, 1, 3])) if np.any(st.reading) else 0.0)
    if kind == "joint_coupling":
        near = [k for k in (joint - 1, joint + 1) if 0 <= k < arm.n and not arm.slide[k]]
        return Part(kind, [joint], from_index=int(rng.choice(near)))
    if kind == "encoder_eccentricity":
        return Part(kind, [joint], order=1, phase=phase)
    if kind == "gear_harmonic":
        u = rng.random()
        order = (rng.choice([2, 3, 4, 6]) if u < 0.3 else rng.integers(7, 401) if u < 0.5 else
                 rng.choice([50, 80, 100, 101, 120, 128, 160, 200, 202, 240, 256, 320]))
        return Part(kind, [joint], order=int(order), phase=phase)
    if kind == "axis_wobble":
        return Part(kind, [joint], order=int(rng.choice([1, 2])), phase=phase,
                    after=bool(rng.random() < 0.5))
    if kind == "joint_drift":
        return Part(kind, [joint], linear=bool(rng.random() < 0.35),
                    tau_s=float(np.exp(rng.uniform(np.log(250), np.log(3500)))))
    if kind == "zero_jump":
        return Part(kind, [joint], session_only=True, placement=int(rng.integers(places)))
    if kind == "ball_shift":
        way = rng.standard_normal(3)
        return Part(kind, session_only=True, placement=int(rng.integers(places)),
                    direction=way / np.linalg.norm(way))
    if kind == "local_fault":
        if span[joint] < 0.35:
            raise Again
        return Part(kind, [joint], variant=str(rng.choice(["bump", "bump", "step", "kink"])),
                    centre=float(np.quantile(q[:, joint], rng.uniform(0.3, 0.7))),
                    width=float(rng.uniform(0.1, 0.3)))
    if kind == "cable_pull":
        near = [k for k in range(arm.n) if k != joint and abs(k - joint) <= 2
                and span[k] > 0.2 and not arm.slide[k]]
        if not near or span[joint] < 0.2:
            raise Again
        other = int(rng.choice(near))
        return Part(kind, [joint], from_index=other,
                    variant=str(rng.choice(["taut", "saddle", "hump"])),
                    centre=float(np.quantile(q[:, joint], rng.uniform(0.3, 0.7))),
                    width=float(span[joint] * rng.uniform(0.2, 0.4)),
                    centre_from=float(np.quantile(q[:, other], rng.uniform(0.3, 0.7))),
                    width_from=float(span[other] * rng.uniform(0.2, 0.4)))
    if kind == "thermal_link":
        return Part(kind, [joint], tau_s=float(rng.uniform(400, 2500)))
    if kind == "joint_slip":
        first = int(rng.integers(st.rank.size // 5, 4 * st.rank.size // 5))
        return Part(kind, [joint], session_only=True, first_row=first + 1)
    return Part(kind, [joint])


def angle_rms(part, st, about_mean=False):
    """Rms turn of a joint (the one that turns most) or of the base per unit of amplitude."""
    twist, base, _ = part.unit(st)
    if about_mean:
        twist, base = twist - twist.mean(axis=0), base - base.mean(axis=0)
    return max(np.sqrt((twist ** 2).sum(axis=2).mean(axis=0)).max(),
               np.sqrt((base ** 2).sum(axis=1).mean()))


def believable(part, st):
    """Largest amplitude of a cause."""
    if part.kind in outside.CAUSES:
        size = rms(displacement(part, st) - displacement(part, st).mean(axis=0))
        return 1.5e-3 / max(size, 1e-9)
    top = CAP[part.kind] * (0.2 if part.joints and st.arm.slide[part.joints[0]] else 1.0)
    if part.kind == "ball_shift":
        return top
    if part.kind == "thermal_link":
        return top
    size = angle_rms(part, st)
    if part.joints and st.arm.slide[part.joints[0]]:
        size = np.sqrt((part.angle(st, part.joints[0]) ** 2).mean())
    if size < 1e-12:
        raise Again
    top = min(top / size, {"joint_scale": 6e-3, "joint_coupling": 6e-3}.get(part.kind, 1e9))
    if part.kind == "backlash":                 # a gap; below its threshold it equals a spring
        top = min(top, 2 * CAP[part.kind])
    if part.kind == "joint_compliance":         # a small joint is not softer without end
        top = min(top, 5.0 * CAP[part.kind] / np.sqrt((st.hold ** 2).mean(axis=0)).max())
    if part.kind == "gear_harmonic" and part.set["order"] > 6:
        top = min(top, 7e-4, 0.25 / part.set["order"])
    return top


def imitators(part, st):
    """For a cause outside the catalogue: the ball's moves by catalogue effects that are like it."""
    if part.kind not in OUTSIDE:
        return None
    if part.kind in outside.CAUSES:
        return outside.imitators(part, st)
    j, near = part.joints[0], [k for k in range(st.arm.n) if abs(k - part.joints[0]) <= 1]
    lever = st.arm.lever(st.sweep)
    if part.kind == "thermal_link":
        warm = 1 - np.exp(-st.time / part.set["tau_s"])
        cols = [lever[:, k] * warm[:, None] for k in near]
    elif part.kind == "joint_slip":
        cols = [lever[:, j] * (st.place == p)[:, None] for p in np.unique(st.place)]
    else:
        x = st.q[:, j]
        cols = [lever[:, j] * f[:, None]
                for f in [st.q[:, k] for k in near] + [np.sin(x), np.cos(x)]]
    return np.stack(cols, axis=2)


def by_urdf_masses(part, st, see):
    """Factor of each joint's (or the base's) compliance that a URDF with its own masses finds: the
    displacement that shows, regressed on that by the loads of these masses."""
    arm = copy.copy(st.arm)
    arm.masses = arm.urdf_masses
    out, nominal = [], State(arm, st.q, st.time, st.place)
    for joints in [[j] for j in part.joints] or [[]]:
        one = Part(part.kind, joints, **part.set)
        true, said = (see(displacement(one, x)).ravel() for x in (st, nominal))
        out.append(float(true @ said / max(said @ said, 1e-30)))
    return out


def choose(kind, arm, rng, st, ses, places, aim, sigma, want=True):
    """Draw a cause of a kind whose visible part can reach the aim; amplitude set; its label."""
    geometry = arm.geometry(st.sweep)
    order = list(rng.permutation(arm.n))
    if kind in JOINTLESS:
        order = order[:1]
    best = None
    for joint in order:
        try:
            part = draw_part(kind, arm, rng, st, int(joint), places)
            top = believable(part, st)
        except Again:
            continue
        move = displacement(part, st)
        extra = imitators(part, st)
        seen = rms(unabsorbed(move, geometry, ses.group, extra))
        if seen < 1e-12:
            continue
        amplitude = min(top, aim * sigma / seen)
        total = amplitude * seen / sigma * np.sqrt(3 * ses.postures)
        if best is None or total > best[0]:
            best = (total, part, amplitude, move, seen)
        if total >= DETECTABLE * 1.05 or not want or rng.random() < 0.12:
            best = (total, part, amplitude, move, seen)
            break
    if best is None:
        raise Again
    total, part, amplitude, move, seen = best
    sign = 1.0 if kind in SIGNED or rng.random() < 0.5 else -1.0
    part.amplitude = sign * amplitude
    label = dict(effect=kind, amplitude=part.amplitude, visible_rms_m=amplitude * seen,
                 full_rms_m=amplitude * rms(move), snr=amplitude * seen / sigma)
    if kind not in ("ball_shift", "thermal_link"):      # of a slide: zero
        label["rms_rad"] = amplitude * angle_rms(part, st, about_mean=True)
    if part.joints:
        label["joints"] = [arm.joints[j] for j in part.joints]
        label["joint_index"] = part.joints[0]
    see = lambda move: unabsorbed(move, geometry, ses.group)  # noqa: E731
    if kind in SINGLE and hasattr(ses, "sockets"):
        alone = [Part(kind, [j], **part.set) for j in part.joints if len(part.joints) > 1]
        label["left_rms_m"] = [    # and of each joint of several
            amplitude * rms(calibrated(displacement(x, st), arm, st, ses, sigma))
            for x in [part] + alone]
    if kind in ("joint_compliance", "link_bending", "base_compliance"):
        label["by_urdf_masses"] = by_urdf_masses(part, st, see)
    if kind in OUTSIDE:
        slip = [[e, arm.joints[j]] for e in ("zero_jump", "joint_drift") for j in part.joints]
        slip += [["tool_motion", None]]         # what a socket sees of a slip
        label["near"] = (outside.near(part, arm.n) if kind in outside.CAUSES
                         else slip if kind == "joint_slip" else [])
    for key, value in part.set.items():
        label[key] = value.tolist() if isinstance(value, np.ndarray) else value
    return part, label


def move_tool(rng, ses, sigma, hard, creep=False):
    """A socket that moves in mid-recording: shift per row and its label."""
    place, socket = int(rng.integers(len(ses.sockets))), int(rng.integers(2))
    ix = ses.rows_of(place, socket)
    way = rng.standard_normal(3)
    size = sigma * np.exp(rng.uniform(np.log(8), np.log(28))) / np.sqrt(hard)
    shift = size * way / np.linalg.norm(way)
    after = int(rng.integers(4, len(ix) - 3))
    move = np.zeros((ses.rows, 3))
    if creep:
        move[ix] = np.linspace(0, 1, len(ix))[:, None] * shift
        after = 0
    else:
        move[ix[after:]] = shift
    return move, dict(effect="tool_motion", placement=place, socket=socket, after_row=after,
                      creep=creep, shift_m=shift.tolist(), first_row=int(ix[after]) + 1)


def calibration(arm, st, ses, sigma, spread=3e-3):
    """Rows of a calibration in units of their noise: samples, distances of the sockets, a prior of
    the geometry; and the function that makes the same rows of displacements (N,3,...)."""
    prior = np.full(arm.geometry(st.sweep).shape[2], spread)
    prior[-3:] = 10e-3
    mean = lambda c, p, k: c[ses.rows_of(p, k)].mean(axis=0)  # noqa: E731

    def rows(c):
        samples = centred(c, ses.group).reshape((-1,) + c.shape[2:]) / sigma
        pairs = [(s[1] - s[0]) / np.linalg.norm(s[1] - s[0])
                 @ (mean(c, p, 1) - mean(c, p, 0)) / 1e-4 for p, s in enumerate(ses.sockets)]
        return np.concatenate([samples, np.array(pairs)])
    return np.vstack([rows(arm.geometry(st.sweep)), np.diag(1 / prior)]), rows


def calibrated(move, arm, st, ses, sigma):
    """What a calibration leaves of a move of the ball, (N,3): one that knows the noise of a posture
    and the spread of the arm as built."""
    sigma = sigma * np.sqrt(ses.rows / ses.postures)
    a, rows = calibration(arm, st, ses, sigma, arm.spread)
    b = np.concatenate([rows(move), np.zeros(a.shape[1])])
    rest = b - a @ np.linalg.lstsq(a, b, rcond=None)[0]
    return sigma * rest[:move.size].reshape(-1, 3)


def distance_strength(arm, st, ses, which, sigma):
    """Whitened visible part of a 1 m change of the sockets' distance, geometry held by a prior."""
    a, _ = calibration(arm, st, ses, sigma)
    b = np.zeros(len(a))
    for p in range(len(ses.sockets)):
        b[3 * ses.rows + p] = 1e4 if which is None or which == p else 0.0
    return np.linalg.norm(b - a @ np.linalg.lstsq(a, b, rcond=None)[0])
