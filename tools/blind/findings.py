"""Which findings are right: what a hidden cause varies with, and where it is on the chain."""
import re
from collections import namedtuple

FAMILY = {effect: family for family, effects in {
    "load": "joint_compliance link_bending base_compliance servo_sag",
    "load side": "backlash",
    "last move": "approach_hysteresis readback_lag",
    "joint angle": "joint_scale joint_coupling encoder_eccentricity gear_harmonic axis_wobble "
                   "local_fault",
    "time": "joint_drift",
    "placement": "tool_motion zero_jump ball_shift socket_distance"}.items()
    for effect in effects.split()}

# Causes outside the catalogue that are not at a joint of their own (outside.py): at the base, in the
# tool, or at every joint.
AT_BASE = {"room_cycle", "rocking_base", "soft_table"}
AT_TOOL = {"worn_socket", "oval_ball", "loose_tool"}
ANYWHERE = {"hose_pull"}

# family None: outside the catalogue; at: joint from 0, -1 the base, n the tool, None anywhere
Truth = namedtuple("Truth", "family effect at cause")


def truths(label, n):
    """Every place of every cause of a case whose arm has n joints; either of two is a place of its
    own where they are one thing (base and link before joint 1) or the data decide (coupling)."""
    out = []
    for cause in label.get("effects") or []:
        k = cause["effect"]
        joints = [int(re.findall(r"\d+", j)[-1]) - 1 for j in cause.get("joints") or []]
        for j in joints or [cause.get("joint_index", 0)]:
            if k == "base_compliance" or (k == "link_bending" and j == 0):
                places = [("base_compliance", -1), ("link_bending", 0)]
            elif k == "joint_coupling":         # the joint whose angle it is
                places = [(k, j - 1), (k, j + 1)]
            elif k in ("readback_lag", "tool_motion", "socket_distance") or k in ANYWHERE:
                places = [(k, None)]
            elif k in ("cable_pull", "belt_stretch"):       # moved by one joint, as another says
                places = [(k, j), (k, cause["from_index"])]
            elif k == "thermal_link":           # from a joint to the next
                places = [(k, j), (k, j + 1)]
            elif k == "linkage_gear":           # the second joint's gear, the third joint's angle
                places = [(k, 1), (k, 2)]
            elif k in AT_BASE or k in AT_TOOL:
                places = [(k, -1 if k in AT_BASE else n)]
            else:
                places = [(k, n if k == "ball_shift" else j)]
            out += [Truth(FAMILY.get(k), effect, at, cause) for effect, at in places]
    return out


def position(name, n):
    """Number of a position on the chain as written by the program."""
    ends = {"base": -1, "tool": n}
    return ends[name] if name in ends else int(re.findall(r"\d+", name)[-1]) - 1


def coarseness(finding, n):
    return (("effect", "family", "tie", "place").index(finding["kind"]),
            position(finding["to"], n) - position(finding["from"], n))


def right(finding, true, n, found=()):
    """Does a finding (keys of `diagnose --json`) say what one of these truths is?  Beside finer ones
    of those `found` with it, it speaks of a cause that none of them says, or of one at all joints."""
    if finding.get("beside_finer"):
        finer = [f for f in found if coarseness(f, n) < coarseness(finding, n)]
        true = [t for t in true if t.at is None or not any(right(f, [t], n) for f in finer)]
    low, high = position(finding["from"], n), position(finding["to"], n)
    for t in true:
        here = t.at is None or low <= t.at <= high
        if t.family is None:    # anything at its place, or the effect it is most like
            if here or any(finding["effect"] == m[0] for m in t.cause.get("near", [])):
                return True
        elif t.family == "placement" and finding["kind"] != "effect":
            if finding["varies_with"] == "placement" or (finding["kind"] == "place" and here):
                return True
        elif here and {"effect": finding["effect"] == t.effect,
                       "family": finding["varies_with"] == t.family,
                       "place": True}[finding["kind"]]:
            return True
    return False


def outside(true):
    """Is a cause among these that no catalogue holds?"""
    return any(t.family is None or t.effect == "local_fault" for t in true)


def exact(finding):
    """One effect at one position."""
    return finding["kind"] == "effect" and finding["from"] == finding["to"]


def joints_of(path):
    """Number of joint columns of a session file."""
    with open(path) as f:
        head = next(line for line in f if not line.startswith("#")).rstrip("\n").split("\t")
    return sum(bool(re.fullmatch(r"(joint_|j)\d+", h)) for h in head)
