#!/usr/bin/env python3
"""make bench: decoding of LCM messages, and the latency of `serve --publish-pose` over UDP."""
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
BUILD = os.environ.get("BUILD", "build")
MUKCA = os.environ.get("MUKCA", os.path.join(BUILD, "mukca"))
DEMO = os.path.join(HERE, "..", "..", "data", "demo")
PROGRAM = os.path.join(BUILD, "bench", "bench_lcm")

# In a network namespace of its own: the server, then the client that asks it for poses.
POSES = """ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo
"$MUKCA" serve -q --urdf "$1" --channel IIWA_STATUS --map order --state "$2" --publish-pose &
server=$!
sleep 2
"$3" pose 1000 20000
kill $server; wait $server"""


def output(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {command[0]}: {done.stderr.strip()}")
    return done.stdout


def main():
    urdf = os.path.join(DEMO, "arm.urdf")
    print("\nLCM")
    for line in output(PROGRAM, "decode").splitlines():
        name, size, seconds = line.split()
        print(f"  {'decode ' + name:34}{1e6 * float(seconds):10.3f} us   {1e-6 / float(seconds):.1f} million "
              f"messages of {size} bytes a second")
    with tempfile.TemporaryDirectory() as state:
        os.mkdir(os.path.join(state, "results"))
        output(MUKCA, "calibrate", "-q", "--urdf", urdf, os.path.join(DEMO, "train.tsv"), "-o",
               os.path.join(state, "results", "demo.offsets.tsv"))
        with open(os.path.join(state, "state.tsv"), "w") as f:
            f.write("model\tdemo.offsets.tsv\nmodel_stream\traw\n")
        done = subprocess.run(["unshare", "-rn", "sh", "-c", POSES, "sh", urdf, state, PROGRAM],
                              capture_output=True, text=True, env=dict(os.environ, MUKCA=MUKCA))
    if done.returncode != 0 or not done.stdout:
        print(f"SKIPPED latency of poses: {done.stderr.strip() or 'no network namespace'}")
        return
    good, lost, *quantiles = done.stdout.split()
    print(f"  joint state to pose and back over UDP, 1 kHz: {good} poses, {lost} lost")
    for name, seconds in zip(("median", "99 %", "99.9 %", "longest"), quantiles):
        print(f"  {name:34}{1e6 * float(seconds):10.1f} us")


main()
