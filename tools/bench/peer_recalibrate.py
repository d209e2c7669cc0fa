#!/usr/bin/env python3
"""Both steps of the re-calibration by numpy.linalg.lstsq on one log, as a careful user would write them:
all rows at once, derivatives vectorised. Prints one line: rows, seconds without and with reading the
log, mean position error left (m), peak memory (KiB).

usage: peer_recalibrate.py URDF LOG
"""
import os
import resource
import sys
import time
import xml.etree.ElementTree as ElementTree

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

STARTED = time.process_time()


def chain_of(path):
    """[(fixed rotation, translation, axis or None)] from the root to the only leaf."""
    links = {}
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        origin, axis = joint.find("origin"), joint.find("axis")
        roll, pitch, yaw = (float(v) for v in origin.get("rpy", "0 0 0").split())
        cr, sr, cp, sp, cy, sy = (f(v) for v in (roll, pitch, yaw) for f in (np.cos, np.sin))
        R = (np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
             @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
             @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]))
        links[joint.find("parent").get("link")] = (
            joint.find("child").get("link"), R, np.array([float(v) for v in origin.get("xyz").split()]),
            None if joint.get("type") == "fixed" else np.array([float(v) for v in axis.get("xyz").split()]))
    link = next(iter(set(links) - {c[0] for c in links.values()}))
    chain = []
    while link in links:
        link, R, p, axis = links[link]
        chain.append((R, p, axis))
    return chain


def rotations(axis, q):
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(q)[:, None, None] * K + (1 - np.cos(q))[:, None, None] * (K @ K)


def kinematics(chain, q):
    R, p = np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3))
    parents, axes, column = [], [], 0
    for fixed, step, axis in chain:
        parents.append(R)
        p = p + R @ step
        R = R @ fixed
        if axis is not None:
            R = R @ rotations(axis, q[:, column])
            axes.append(R @ axis)
            column += 1
    return R, p, parents, axes


def main():
    chain = chain_of(sys.argv[1])
    rows = np.loadtxt(sys.argv[2], skiprows=1)
    n = rows.shape[1] - 7
    q, position, (w, x, y, z) = rows[:, :n].copy(), rows[:, n:n + 3], rows[:, n + 3:].T
    began = time.process_time()
    measured = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                         2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1).reshape(-1, 3, 3)
    R, _, _, axes = kinematics(chain, q)
    off = np.swapaxes(R, 1, 2) @ measured
    error = np.stack([off[:, 2, 1] - off[:, 1, 2], off[:, 0, 2] - off[:, 2, 0], off[:, 1, 0] - off[:, 0, 1]], 1) / 2
    J = np.swapaxes(R, 1, 2) @ np.stack(axes, 2)
    q += np.linalg.lstsq(J.reshape(-1, n), error.ravel(), rcond=None)[0]
    _, p, parents, _ = kinematics(chain, q)
    A = np.concatenate(parents, 2).reshape(3 * len(q), -1)
    b = (position - p).ravel()
    step = np.linalg.lstsq(A, b, rcond=1e-9)[0]
    left = np.linalg.norm((b - A @ step).reshape(-1, 3), axis=1).mean()
    now = time.process_time()
    print(len(rows), now - began, now - STARTED, left, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


main()
