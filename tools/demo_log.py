#!/usr/bin/env python3
"""Write data/demo/guided.lcmlog: a guided session of the demo arm as lcm-logger would have kept it.

The arm's driver sends bot_core.joint_angles_t at 50 Hz; an operator moves it to every sixth row of
train.tsv, waits, and triggers; `start` and `calibrate` frame it, for `mukca serve`.  Standard library
only; the same bytes each time."""
import math
import os
import struct

DEMO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data", "demo")
PERIOD = 20000  # us
MOVING, STILL = 4, 13  # messages
# fingerprints as lcm-gen computes them
ANGLES, TRIGGER, COMMAND = 0x3e7cd307b8f9e790, 0x7e17a1d01fe0e2fb, 0x9ed4cb80fd4c8cd9


def text(s):
    return struct.pack(">i", len(s) + 1) + s.encode() + b"\0"


class Log:
    def __init__(self):
        self.bytes, self.number, self.time = b"", 0, 1700000000000000

    def event(self, channel, data):
        self.bytes += struct.pack(">Iqqii", 0xEDA1DA01, self.number, self.time, len(channel), len(data))
        self.bytes += channel.encode() + data
        self.number += 1

    def angles(self, names, q):
        noisy = [x + 2e-6 * math.sin(1.7 * self.number + j) for j, x in enumerate(q)]
        self.event("ARM_STATE", struct.pack(">Qq", ANGLES, self.time) + text("heron7") +
                   struct.pack(">i", len(q)) + b"".join(text(n) for n in names) +
                   struct.pack(">%dd" % len(q), *noisy))
        self.time += PERIOD

    def trigger(self, number, placement, socket):
        self.event("MUKCA_TRIGGER", struct.pack(">Qqq", TRIGGER, self.time, number) + text(placement) +
                   text(socket))

    def command(self, number, verb, *arguments):
        self.event("MUKCA_COMMAND", struct.pack(">Qqq", COMMAND, self.time, number) + text(verb) +
                   struct.pack(">i", len(arguments)) + b"".join(text(a) for a in arguments))


def main():
    with open(os.path.join(DEMO, "train.tsv")) as f:
        rows = [line.rstrip("\n").split("\t") for line in f if not line.startswith("#")]
    header, rows = rows[0], rows[1::6]
    columns = [i for i, name in enumerate(header) if name.startswith("joint_") and "." not in name]
    names = [header[i] for i in columns]
    log, q = Log(), None
    for i, row in enumerate(rows):
        goal = [float(row[c]) for c in columns]
        q = q or goal
        for k in range(1, MOVING + 1):
            log.angles(names, [a + (b - a) * k / MOVING for a, b in zip(q, goal)])
        if i == 0:
            log.command(1, "start", "guided")
        for _ in range(STILL):
            log.angles(names, goal)
        log.trigger(100 + i, row[header.index("placement")], row[header.index("socket")])
        q = goal
    log.command(2, "calibrate")
    log.angles(names, q)
    with open(os.path.join(DEMO, "guided.lcmlog"), "wb") as f:
        f.write(log.bytes)


main()
