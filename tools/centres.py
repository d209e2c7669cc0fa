#!/usr/bin/env python3
"""Picture of README: predicted ball centres of the demo's test placement, nominal and calibrated (gnuplot)."""
import os
import subprocess
import sys
import tempfile

MUKCA = os.environ.get("MUKCA", "build/mukca")
ARM, TRAIN, TEST = ["--urdf", "data/demo/arm.urdf"], "data/demo/train.tsv", "data/demo/test.tsv"


def rows(text):
    lines = [line.split("\t") for line in text.splitlines() if line and line[0] != "#"]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def centres(sockets, *offsets):
    printed = subprocess.run([MUKCA, "fk", "-q", *ARM, *offsets, TEST], capture_output=True, text=True, check=True).stdout
    points = {}
    for socket, row in zip(sockets, rows(printed)):
        points.setdefault(socket, []).append([1e3 * float(row[k]) for k in ("x_m", "y_m", "z_m")])
    return points


def main(path):
    with open(TEST, encoding="utf-8") as file:
        sockets = [row["socket"] for row in rows(file.read())]
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "table.tsv")
        subprocess.run([MUKCA, "diagnose", "-q", *ARM, TRAIN, "-o", table], check=True)
        sets = {"nominal": centres(sockets), "calibrated": centres(sockets, "--offsets", table)}
    every = [p for points in sets["calibrated"].values() for p in points]
    middle = [sum(p[k] for p in every) / len(every) for k in range(3)]
    reach = 1.05 * max(abs(p[k] - middle[k]) for s in sets.values() for ps in s.values() for p in ps for k in range(3))
    script = ["set terminal pngcairo size 1920,740 linewidth 2.4 font 'sans,20'", f"set output '{path}'", "set border 3",
              "set tics nomirror out", "set grid lc 'gray' lw 0.4 dt 3", f"set xrange [-{reach}:{reach}]",
              f"set yrange [-{reach}:{reach}]", "set size ratio -1", "set key at graph 0, 1.1 left",
              "set multiplot layout 1,3 margins 0.07,0.985,0.17,0.9 spacing 0.075"]
    for name, points in sets.items():
        for n, socket in enumerate(sorted(points)):
            script += [f"${name}{n} << EOD"]
            script += [" ".join(f"{a - b:.4f}" for a, b in zip(p, middle)) for p in points[socket]] + ["EOD"]
    for panel, (u, v) in enumerate(("xy", "xz", "yz")):
        column = {axis: k + 1 for k, axis in enumerate("xyz")}
        drawn = []
        for name, colour, shapes, shown in (("nominal", "#d55e00", (6, 8), 0), ("calibrated", "#0072b2", (7, 9), 1)):
            for n, shape in enumerate(shapes):
                title = f"title '{name}'" if panel == shown and n == 0 else "notitle"
                drawn.append(f"${name}{n} using {column[u]}:{column[v]} with points lc rgb '{colour}' pt {shape} {title}")
        script += [f"set xlabel '{u}, mm'", f"set ylabel '{v}, mm' offset 1,0", "plot " + ", ".join(drawn)]
    subprocess.run(["gnuplot"], input="\n".join(script) + "\n", text=True, check=True)


main(sys.argv[1] if len(sys.argv) > 1 else "docs/centres.png")
