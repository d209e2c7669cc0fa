#!/usr/bin/env python3
"""The re-calibration's part of make bench: rows per second without and with text, memory, and numpy's
lstsq on the same rows. usage: recalibrate.py PYTHON_WITH_NUMPY
"""
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
BUILD = os.environ.get("BUILD", "build")
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
URDF = os.path.join(HERE, "..", "..", "data", "gen3.urdf")
BENCH = os.path.join(BUILD, "bench", "bench_recalibrate")
ROWS = int(os.environ.get("BENCH_ROWS", "1000000"))


def output(*command):
    return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True).stdout


def line(what, rows, seconds, mib, remark):
    memory = f"{mib:9.1f} MiB" if mib else " " * 13
    print(f"  {what:34}{seconds:10.3f} s  {rows / seconds:10.0f} rows/s {memory}   {remark}")


def main():
    log = os.path.join(BUILD, "bench", "poses.tsv")
    print(f"\nRe-calibration of a 7-axis arm, {ROWS} poses, 31 unknowns, seconds of one core")
    rows, passes, seconds, _ = output(BENCH, URDF, ROWS).split()
    line("without text", int(rows), float(seconds), None, f"{passes} passes over the rows")
    for count in (ROWS // 10, ROWS):
        with open(log, "w") as f:
            subprocess.run([BENCH, URDF, str(count), "-"], check=True, stdout=f)
        _, kib, seconds = output(os.path.join(BUILD, "bench", "bench_process"), 1, MUKCA, "recalibrate",
                                 "--urdf", URDF, log).split()
        line("with text, whole process", count, float(seconds), int(kib) / 1024, f"{count} rows")
    count, seconds, whole, left, kib = output(sys.argv[1], os.path.join(HERE, "peer_recalibrate.py"),
                                              URDF, log).split()
    line("numpy.linalg.lstsq without text", int(count), float(seconds), int(kib) / 1024,
         f"{1e3 * float(left):.4f} mm left")
    line("the same with numpy.loadtxt", int(count), float(whole), int(kib) / 1024, "whole process")
    os.remove(log)


main()
