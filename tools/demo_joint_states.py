#!/usr/bin/env python3
"""Write data/demo/joint_states.csv: what `ros2 topic echo --csv /joint_states` prints while an operator holds the demo
arm still in eight postures of train.tsv, four in each socket of the placement `front`.

As on a real system: the names come in the order of the driver's hash table, with the gripper's among them; efforts are nan; the
gripper's own driver publishes on the same topic, without a frame, velocities or efforts; a notice about a lost message stands between
the lines.  Standard library only; the same bytes each time."""
import math
import os

DEMO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data", "demo")
PERIOD = 50000000  # ns
MOVING, STILL = 3, 22  # messages
ORDER = ["joint_2", "finger_joint_1", "joint_1", "joint_3", "joint_6", "joint_4", "finger_joint_2", "joint_5", "joint_7"]


def stamp(ns):
    return "%d,%d" % divmod(ns, 1000000000)


def main():
    with open(os.path.join(DEMO, "train.tsv")) as f:
        rows = [line.rstrip("\n").split("\t") for line in f if not line.startswith("#")]
    header = rows[0]
    names = [n for n in header if n.startswith("joint_") and "." not in n]
    front = [r for r in rows[1:] if r[0] == "front"]
    goals = [[float(r[header.index(n)]) for n in names] for r in front[:4] + front[30:34]]
    lines, ns, q = [], 1700000100000000000, goals[0]
    for goal in goals:
        for k in range(1, MOVING + STILL + 1):
            at = [a + (b - a) * min(k / MOVING, 1) for a, b in zip(q, goal)]
            value = {n: x + 2e-6 * math.sin(1.7 * len(lines) + j) for j, (n, x) in enumerate(zip(names, at))}
            value.update(finger_joint_1=0.0349, finger_joint_2=0.0349)
            lines.append(",".join([stamp(ns), "base_link", *ORDER, *(repr(value[n]) for n in ORDER),
                                   *["0.0"] * len(ORDER), *["nan"] * len(ORDER)]))
            if len(lines) == 40:
                lines.append("A message was lost!!!\n\ttotal count change:1\n\ttotal count: 1---")
            if k % 10 == 1:
                lines.append(stamp(ns + 7000000) + ",,finger_joint_1,finger_joint_2,0.0349,0.0349,,")
            ns += PERIOD
        q = goal
    with open(os.path.join(DEMO, "joint_states.csv"), "w") as f:
        f.write("\n".join(lines) + "\n")


main()
