#!/usr/bin/env python3
"""Forward kinematics of an arm as C code of CasADi, as the method's published program uses it.

usage: casadi_fk.py URDF TIP OUT.c

position(q); jacobian(q, theta): position and its derivative by x y z roll pitch yaw of every element;
jacobian_constant(q): the same at the nominal parameters, which are folded into the code.
"""
import os
import sys

import casadi as ca
import numpy as np

sys.dont_write_bytecode = True
from peer import chain_of  # noqa: E402


def turn(axis, angle):
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return ca.DM.eye(3) + ca.sin(angle) * ca.DM(K) + (1 - ca.cos(angle)) * ca.DM(K @ K)


def position(chain, q, theta):
    tip, column = ca.SX.zeros(3), q.numel()
    for k in reversed(range(len(chain))):
        kind, _, axis = chain[k]
        if kind != "fixed":
            column -= 1
            tip = ca.mtimes(turn(axis, q[column]), tip)
        x, y, z, roll, pitch, yaw = (theta[6 * k + i] for i in range(6))
        for angle, about in ((roll, (1, 0, 0)), (pitch, (0, 1, 0)), (yaw, (0, 0, 1))):
            tip = ca.mtimes(turn(np.array(about, float), angle), tip)
        tip = tip + ca.vertcat(x, y, z)
    return tip


def main():
    urdf, tip, out = sys.argv[1:]
    chain = chain_of(urdf, tip)
    nominal = np.concatenate([element[1] for element in chain])
    nominal[np.abs(nominal) < 1e-16] = 0
    q = ca.SX.sym("q", sum(kind != "fixed" for kind, _, _ in chain))
    theta = ca.SX.sym("theta", len(nominal))
    free = position(chain, q, theta)
    # row by row in memory: CasADi stores columns
    J = ca.densify(ca.jacobian(free, theta).T)
    at = ca.substitute([free, J], [theta], [ca.DM(nominal)])
    generator = ca.CodeGenerator(os.path.basename(out))
    for name, arguments, results in (
            ("position", [q], [ca.densify(position(chain, q, ca.SX(ca.DM(nominal))))]),
            ("jacobian", [q, theta], [ca.densify(free), J]),
            ("jacobian_constant", [q], [ca.densify(at[0]), ca.densify(at[1])])):
        generator.add(ca.Function(name, arguments, results, {"cse": True}))
    generator.generate(os.path.join(os.path.dirname(out), ""))


if __name__ == "__main__":
    main()
