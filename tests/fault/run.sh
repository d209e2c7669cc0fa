#!/bin/sh
# Failing allocations, writes, syncs and renames of every command.  Skipped (exit 77) where a library
# cannot be preloaded so.  MUKCA_LONG=1: every call.
set -u
here=$(cd "$(dirname "$0")" && pwd)
skip() {
    echo "skip tests/fault: $1"
    exit 77
}
grep -q __asan_init "$MUKCA" && skip "a sanitizer has the memory functions"
export FAULT_SHIM="$BUILD/tests/fault.so"
mkdir -p "$BUILD/tests"
${CC:-cc} -O1 -Wall -Wextra -shared -fPIC -o "$FAULT_SHIM" "$here/fault.c" -ldl 2>"$BUILD/tests/fault.log" ||
    skip "the library is for Linux on x86-64 with glibc (see $BUILD/tests/fault.log)"
FAULT_TRAP=1 FAULT=write:0 LD_PRELOAD=$FAULT_SHIM "$MUKCA" --version >/dev/null || skip "no filter of system calls"
exec "${PYTHON:-python3}" "$here/test_outputs.py"
