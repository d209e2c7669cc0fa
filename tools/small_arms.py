#!/usr/bin/env python3
"""False causes on pure noise, for arms with few axes: make -f tools/Makefile verify-small-arms.

usage: small_arms.py [RUNS]

Simulates RUNS (40) sessions each of arms with two to seven revolute axes, a SCARA, a gantry and a
six-axis arm with a spherical wrist: other origins and noise, but no effect.  Every cause that
`diagnose` names is false.  Exit code 1 if more than 2 % of all sessions have one, or if an
amplitude has the sign that physics excludes.  MUKCA names the program (build/mukca).
"""
import collections
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

PROGRAM = os.path.abspath(os.environ.get("MUKCA", "build/mukca"))
MOST_FALSE = 0.02
POSITIVE = {"joint_compliance", "link_bending", "base_compliance", "backlash", "readback_lag",
            "approach_hysteresis"}

# type, axis, and origin x y z roll of each joint; lengths in m
REVOLUTE = [("revolute", "0 0 1", "0 0 0.3 0"), ("revolute", "0 1 0", "0 0.05 0.1 0"),
            ("revolute", "0 1 0", "0 -0.05 0.35 0"), ("revolute", "1 0 0", "0.15 0 0.05 0"),
            ("revolute", "0 1 0", "0.2 0 0 0"), ("revolute", "1 0 0", "0.08 0 0.02 0"),
            ("revolute", "0 1 0", "0.06 0.02 0 0")]
ARMS = {
    **{f"{n}R": REVOLUTE[:n] for n in range(2, 8)},
    "scara": [("revolute", "0 0 1", "0 0 0.4 0"), ("revolute", "0 0 1", "0.3 0 0 0"),
              ("prismatic", "0 0 1", "0.25 0 0 0"), ("revolute", "0 0 1", "0 0 -0.1 0")],
    "gantry": [("prismatic", axis, origin) for axis, origin in
               (("1 0 0", "0 0 0.5 0"), ("0 1 0", "0 0 0 0"), ("0 0 1", "0 0 0 0"))],
    "6R wrist": [("revolute", "0 0 1", "0 0 0.33 0"), ("revolute", "0 1 0", "0.05 0 0 0"),
                 ("revolute", "0 1 0", "0 0 0.33 0"), ("revolute", "1 0 0", "0.1 0 0.04 0"),
                 ("revolute", "0 1 0", "0.23 0 0 0"), ("revolute", "1 0 0", "0 0 0 0")],
}


def urdf(name, joints):
    """The arm as URDF text, with masses, and the ball on its last link."""
    text = [f'<robot name="{name}"><link name="l0"/>']
    for i, (kind, axis, origin) in enumerate(joints):
        *xyz, roll = origin.split()
        half = 0.4 if kind == "prismatic" else 2.5
        text.append(
            f'<joint name="q{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{" ".join(xyz)}" rpy="{roll} 0 0"/><axis xyz="{axis}"/>'
            f'<limit lower="-{half}" upper="{half}" effort="100" velocity="2"/></joint>'
            f'<link name="l{i + 1}"><inertial><origin xyz="0.05 0.01 0.05"/>'
            f'<mass value="{max(0.5, 3 - 0.4 * i)}"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
            'ixy="0" ixz="0" iyz="0"/></inertial></link>')
    text.append(f'<joint name="ball" type="fixed"><parent link="l{len(joints)}"/>'
                '<child link="ball_link"/><origin xyz="0.1 0.03 0.08"/></joint>'
                '<link name="ball_link"/></robot>')
    return "".join(text)


def run(folder, name, seed):
    """Causes named on pure noise; None where the arm cannot reach the sockets."""
    arm = os.path.join(folder, name + ".urdf")
    session = os.path.join(folder, f"{name}_{seed}.tsv")
    simulate = [PROGRAM, "simulate", "-q", "--urdf", arm, "--seed", str(seed), "--noise", "1e-4",
                "--perturb", "1,2", "-o", session]
    poses = ["--free-base"] if len(ARMS[name]) < 3 else []  # two axes reach no socket in space
    simulate += (["--poses", "60", "--position-only"] if poses
                 else ["--rows", "12", "--placements", "3"])
    if subprocess.run(simulate, capture_output=True).returncode:
        return None
    p = subprocess.run([PROGRAM, "diagnose", "-q", "--urdf", arm, session, "--json", "-", *poses],
                       capture_output=True, text=True, timeout=300)
    if p.returncode not in (0, 1):
        sys.exit(f"{name}, seed {seed}: exit {p.returncode}: {p.stderr.strip()}")
    return json.loads(p.stdout)


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    sessions = false = wrong_sign = 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        for name, joints in ARMS.items():
            with open(os.path.join(folder, name + ".urdf"), "w") as f:
                f.write(urdf(name, joints))
            answers = [a for a in pool.map(lambda s: run(folder, name, 100 + s), range(runs)) if a]
            named = [a for a in answers if a["causes"]]
            causes = [c for a in named for c in a["causes"]]
            said = collections.Counter(f'{c["effect"]} {c["joint"] or ""}'.strip() for c in causes)
            verdicts = collections.Counter(a["verdict"] for a in answers)
            sessions += len(answers)
            false += len(named)
            wrong_sign += sum(c["effect"] in POSITIVE and not c["amplitude"] >= 0 for c in causes)
            print(f"{name:9s} {len(answers):3d} sessions:",
                  ", ".join(f"{n} {v}" for v, n in sorted(verdicts.items())),
                  "; ".join(f"{n} x {v}" for v, n in said.items()), flush=True)
    bad = false > MOST_FALSE * sessions or wrong_sign > 0 or not sessions
    print(f"{'not ok' if bad else 'ok'} small arms: false causes in {false} of {sessions} sessions, "
          f"{wrong_sign} of the wrong sign")
    return bad


if __name__ == "__main__":
    sys.exit(main())
