#!/usr/bin/env python3
"""The same cost by Gauss-Newton in numpy: what a careful user would write. Prints one line:
J, iterations, median solve time in s, and the seconds since the process began.

usage: peer.py URDF TIP REPEATS FOLDER...
"""
import os
import sys
import time

BEGAN = time.process_time()
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import xml.etree.ElementTree as ElementTree  # noqa: E402

import numpy as np  # noqa: E402

LAMBDA, DISTANCE = 1e-4, 0.05


def chain_of(path, tip):
    joints = {}
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        origin, axis = joint.find("origin"), joint.find("axis")

        def numbers(node, key, default):
            return np.array([float(v) for v in (node.get(key, default) if node is not None else default).split()])

        joints[joint.find("child").get("link")] = (
            joint.find("parent").get("link"), joint.get("type"),
            np.concatenate([numbers(origin, "xyz", "0 0 0"), numbers(origin, "rpy", "0 0 0")]),
            numbers(axis, "xyz", "1 0 0"))
    chain = []
    while tip in joints:
        chain.append(joints[tip][1:])
        tip = joints[tip][0]
    return chain[::-1]


def rpy_matrices(rpy):
    """R and its derivatives by roll, pitch, yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    X, Y, Z = (np.array(m) for m in ([[1, 0, 0], [0, cr, -sr], [0, sr, cr]],
                                     [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]],
                                     [[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]))
    dX, dY, dZ = (np.array(m) for m in ([[0, 0, 0], [0, -sr, -cr], [0, cr, -sr]],
                                        [[-sp, 0, cp], [0, 0, 0], [-cp, 0, -sp]],
                                        [[-sy, -cy, 0], [cy, -sy, 0], [0, 0, 0]]))
    return Z @ Y @ X, (Z @ Y @ dX, Z @ dY @ X, dZ @ Y @ X)


def turns_of(chain, q):
    """R(axis, q) of every joint and row; constants of the fit."""
    turns, column = [], 0
    for kind, _, axis in chain:
        if kind == "fixed":
            turns.append(None)
            continue
        a = axis / np.linalg.norm(axis)
        K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
        s, c = np.sin(q[:, column]), np.cos(q[:, column])
        turns.append(np.eye(3) + s[:, None, None] * K + (1 - c)[:, None, None] * (K @ K))
        column += 1
    return turns


def predict(chain, theta, turns, free, rows):
    """Positions (rows, 3) and their Jacobian (rows, 3, parameters)."""
    n = len(chain)
    after = [None] * n  # the tip as each element sees it, joint turned
    tip = np.zeros((rows, 3))
    parts = [rpy_matrices(theta[k, 3:]) for k in range(n)]
    for k in reversed(range(n)):
        after[k] = tip if turns[k] is None else np.einsum("nij,nj->ni", turns[k], tip)
        tip = after[k] @ parts[k][0].T + theta[k, :3]
    J = np.empty((rows, 3, 6 * len(free)))
    before, column = np.broadcast_to(np.eye(3), (rows, 3, 3)), 0
    for k in range(n):
        R, derivatives = parts[k]
        if k in free:
            J[:, :, column:column + 3] = before
            columns = np.stack([after[k] @ d.T for d in derivatives], axis=2)
            J[:, :, column + 3:column + 6] = before @ columns
            column += 6
        before = before @ R
        if turns[k] is not None:
            before = before @ turns[k]
    return tip, J


def residuals(chain, theta, nominal, turns, free, sockets, placements):
    rows = len(sockets)
    x, J = predict(chain, theta, turns, free, rows)
    r, D = [], []
    for p in placements:
        means = []
        scale = 1 / np.sqrt(sum(np.count_nonzero(sockets == s) for s in p))
        for s in p:
            mine = sockets == s
            mean, mean_J = x[mine].mean(0), J[mine].mean(0)
            means.append((mean, mean_J))
            r.append(scale * (x[mine] - mean).ravel())
            D.append(scale * (J[mine] - mean_J).reshape(-1, J.shape[2]))
        gap = means[1][0] - means[0][0]
        length = np.linalg.norm(gap)
        r.append(np.array([length - DISTANCE]))
        D.append((gap / length @ (means[1][1] - means[0][1]))[None])
    weight = np.full((len(free), 6), np.sqrt(LAMBDA * len(placements)))
    weight[-1] = 0  # the last fixed joint is not regularised
    r.append((weight * (theta - nominal)[free]).ravel())
    D.append(np.diag(weight.ravel()))
    return np.concatenate(r), np.vstack(D)


def solve(chain, q, sockets, placements):
    turns = turns_of(chain, q)
    nominal = np.array([element[1] for element in chain])
    free = [k for k, element in enumerate(chain) if element[0] != "fixed"] + [len(chain) - 1]
    theta, cost = nominal.copy(), np.inf
    for iteration in range(1, 50):
        r, J = residuals(chain, theta, nominal, turns, free, sockets, placements)
        last, cost = cost, r @ r
        if last - cost <= 1e-9 * cost:
            break
        H = J.T @ J
        H[np.diag_indices_from(H)] += 1e-12 * H.diagonal().max()
        theta[free] -= np.linalg.solve(H, J.T @ r).reshape(-1, 6)
    return cost, iteration


def main():
    urdf, tip, repeats, folders = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4:]
    chain = chain_of(urdf, tip)
    q, sockets, placements = [], [], []
    for folder in folders:
        placements.append([])
        for hole in range(2):
            rows = np.loadtxt(os.path.join(folder, f"hole_{hole}.csv"), delimiter=",")
            placements[-1].append(2 * len(placements) + hole)
            sockets += [placements[-1][-1]] * len(rows)
            q.append(rows)
    q, sockets = np.vstack(q), np.array(sockets)
    times = []
    for _ in range(repeats):
        start = time.process_time()
        cost, iterations = solve(chain, q, sockets, placements)
        times.append(time.process_time() - start)
    print(f"{cost:.17g} {iterations} {np.median(times):.6g} {time.process_time() - BEGAN:.6g}")


if __name__ == "__main__":
    main()
