#!/bin/sh
# make -f tools/Makefile verify-outside: rules that any honest diagnosis satisfies, on public measurements of others.
# The cases and their scorer are not part of the project: MUKCA_OUTSIDE or ../shared/outside.
set -eu
cases=${MUKCA_OUTSIDE:-../shared/outside}
program=${MUKCA:-build/mukca}
if [ ! -e "$cases/score.py" ]; then
    echo "verify-outside: SKIPPED, there is no $cases/score.py (set MUKCA_OUTSIDE)" >&2
    exit 0
fi
for python in ${PYTHON:-python3 /usr/bin/python3}; do
    if "$python" -c 'import numpy, scipy' 2>/dev/null; then
        export PYTHONDONTWRITEBYTECODE=1
        "$python" "$cases/score.py" "$program" "$cases/cases"
        exit $?
    fi
done
echo "verify-outside: no python with numpy and scipy (Debian: python3-scipy); set PYTHON" >&2
exit 1
