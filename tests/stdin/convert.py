#!/usr/bin/env python3
"""The messages of data/demo/joint_states.csv (what `ros2 topic echo --csv` printed) in other forms, to compare what mukca
records from each.  usage: convert.py INPUT FOLDER"""
import json
import os
import struct
import sys

ANGLES, TRIGGER = 0x3e7cd307b8f9e790, 0x7e17a1d01fe0e2fb  # fingerprints by lcm-gen


def messages(path):
    """(us, names, positions) of each message with the arm's joints; (None, line) for notices."""
    for line in open(path):
        cell = line.rstrip("\n").split(",")
        names = [c for c in cell[3:] if "joint" in c]
        if not names:
            continue
        n = len(names)
        yield (int(cell[0]) * 1000000 + int(cell[1]) // 1000, cell[2], names,
               [float(x) for x in cell[3 + n:3 + 2 * n]])


def text(s):
    return struct.pack(">i", len(s) + 1) + s.encode() + b"\0"


class Log:
    """An LCM event log."""

    def __init__(self):
        self.bytes, self.number = b"", 0

    def event(self, us, channel, data):
        self.bytes += struct.pack(">Iqqii", 0xEDA1DA01, self.number, us, len(channel), len(data))
        self.bytes += channel.encode() + data
        self.number += 1

    def joints(self, us, names, q):
        self.event(us, "ARM", struct.pack(">Qq", ANGLES, us) + text("r") + struct.pack(">i", len(q)) +
                   b"".join(map(text, names)) + struct.pack(">%dd" % len(q), *q))


def main():
    source, folder = sys.argv[1:]
    arm = [m for m in messages(source) if len(m[2]) > 2]
    log, triggered = Log(), Log()
    files = {name: open(os.path.join(folder, name), "w") for name in
             ("header.csv", "header.tsv", "arrays.json", "members.json", "triggers.json", "ros.csv", "empty.csv")}
    order = sorted(arm[0][2])
    files["header.csv"].write("time_s," + ",".join(order) + "\n")
    files["header.tsv"].write("# a comment\n" + "\t".join(order) + "\tjoint_1.effort\tutime\n")
    for i, (us, frame, names, q) in enumerate(arm):
        value = dict(zip(names, q))
        log.joints(us, names, q)
        triggered.joints(us, names, q)
        files["header.csv"].write("%d.%06d,%s\n" % (*divmod(us, 1000000), ",".join(repr(value[n]) for n in order)))
        files["header.tsv"].write("\t".join(repr(value[n]) for n in order) + "\tnan\t%d\n" % us)
        stamp = {"sec": us // 1000000, "nanosec": us % 1000000 * 1000}
        message = {"header": {"stamp": stamp, "frame_id": frame}, "name": names, "position": q,
                   "velocity": [], "effort": [float("nan")] * len(q)}
        # a ROS bridge wraps it
        files["arrays.json"].write(json.dumps({"op": "publish", "msg": message} if i % 2 else message) + "\n")
        files["members.json"].write(json.dumps({"utime": us, "robot": "r", **value, "joint_2.velocity": 0}) + "\n")
        files["triggers.json"].write(json.dumps(message) + "\n")
        # names in another order each time; empty velocities and efforts; or all nan
        turned = names[i % 9:] + names[:i % 9]
        line = [*map(str, divmod(us, 1000000)), "", *turned, *(repr(value[n]) for n in turned)]
        line[1] += "000"
        files["ros.csv"].write(",".join(line + ["nan"] * 18) + "\r\n")
        files["empty.csv"].write(",".join(line + ["", ""]) + "\n")
        if i % 25 == 20:
            place = "front" if i < 100 else "back"
            triggered.event(us + 1000, "MUKCA_TRIGGER",
                            struct.pack(">Qqq", TRIGGER, us, i) + text(place) + text(str(i // 25 % 2)))
            files["triggers.json"].write(json.dumps({"trigger": i, "placement": place, "socket": str(i // 25 % 2)}) + "\n")
    for name, l in (("still.lcmlog", log), ("triggers.lcmlog", triggered)):
        with open(os.path.join(folder, name), "wb") as f:
            f.write(l.bytes)


main()
