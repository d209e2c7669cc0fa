#!/bin/sh
# The deterministic figures of README and docs are those that the program prints (make figures).
cd "$(dirname "$0")/.." || exit 1
exec tools/figures.py --check
