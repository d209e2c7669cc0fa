#!/usr/bin/env python3
"""mukca fleet on the summaries of 10,000 arms: time, memory, and equal bytes from a tree of partial jobs.

usage: fleet.py [ARMS]
"""
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time

MUKCA = os.environ.get("MUKCA", "build/mukca")


def run(*words):
    done = subprocess.run([MUKCA, *words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"mukca {words[0]}: exit {done.returncode}: {done.stderr.strip()}")


def main():
    arms = int(sys.argv[1]) if len(sys.argv) > 1 else 10000
    rng = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        run("diagnose", "-q", "--urdf", "data/demo/arm.urdf", "data/demo/train.tsv", "--arm", "0", "--summary",
            f"{folder}/one")
        with open(f"{folder}/one") as f:
            one = json.load(f)
        n, information = len(one["vector"]), one["information"]
        files = []
        for i in range(arms):  # the same information, other coefficients: 20 urad/(N m) and a fifth of scatter
            truth = [20e-6 * (1 + 0.2 * rng.gauss(0, 1)) for _ in range(n)]
            row = lambda a, b: information[max(a, b) * (max(a, b) + 1) // 2 + min(a, b)]  # noqa: E731
            one["vector"] = [sum(row(a, b) * truth[b] for b in range(n)) + abs(row(a, a)) ** 0.5 * rng.gauss(0, 1)
                             for a in range(n)]
            one["arm"], one["recording"] = f"arm{i:05d}", f"{rng.getrandbits(64):016x}"
            files.append(f"{folder}/{i:05d}.json")
            with open(files[-1], "w") as f:
                json.dump(one, f, separators=(",", ":"))
                f.write("\n")
        os.chdir(folder)
        files = [os.path.basename(f) for f in files]
        started = time.monotonic()
        run("fleet", "-q", *files, "-o", "whole.tsv")
        took = time.monotonic() - started
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{arms} summaries of {os.path.getsize(files[0]) / 1e3:.0f} kB: {took:.2f} s "
              f"({used.ru_utime + used.ru_stime:.2f} s of processor with the diagnosis), {used.ru_maxrss / 1e3:.0f} MB")
        parts = []
        for k in range(10):
            parts.append(f"part{k}")
            run("fleet", "-q", "--partial", *files[k::10], "-o", parts[-1])
        run("fleet", "-q", "--partial", *parts[5:], "-o", "half")
        run("fleet", "-q", "half", *parts[:5], "-o", "tree.tsv")
        with open("whole.tsv") as a, open("tree.tsv") as b:
            same = a.read() == b.read()
        print("a tree of partial jobs gives", "the same bytes" if same else "OTHER BYTES")
        return 0 if same else 1


sys.exit(main())
