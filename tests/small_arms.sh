#!/bin/sh
# Pure noise on arms with few axes has no cause: a short run of `make -f tools/Makefile verify-small-arms`.
set -eu
cd "$(dirname "$0")/.."
PYTHONDONTWRITEBYTECODE=1 ${PYTHON:-python3} tools/small_arms.py 2 | tail -n 1
