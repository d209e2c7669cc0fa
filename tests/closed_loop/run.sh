#!/bin/sh
# Proof in the loop, the short version, and what controller and arm do when something fails: tools/closed_loop.
# Skipped (exit 77) without MuJoCo.
tools=$(dirname "$0")/../../tools/closed_loop
"$tools/run" --short && "$tools/run" failures.py
