#!/bin/sh
# Proof in the loop, the short version: tools/closed_loop.  Skipped (exit 77) without MuJoCo.
exec "$(dirname "$0")/../../tools/closed_loop/run" --short
