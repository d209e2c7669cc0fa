#!/usr/bin/env python3
"""A session file from folders with hole_0.csv and hole_1.csv: tools/panda_session.py FOLDER... >SESSION

It wrote data/panda (see the README there).  Angles keep the value of the published number, at its shortest.
"""
import os
import sys

print("# mukca session\n# robot: panda\n# stream: raw\n# base: panda_link0\n# tip: ball_link")
print("\t".join(["placement", "socket"] + [f"panda_joint{i}" for i in range(1, 8)]))
for folder in sys.argv[1:]:
    for socket in "01":
        with open(os.path.join(folder, f"hole_{socket}.csv"), encoding="utf-8") as file:
            for line in file:
                print("\t".join([os.path.basename(folder), socket] + [repr(float(x)) for x in line.split(",")]))
