#!/bin/sh
# Tests of LCM with a foreign client, over UDP multicast in a network namespace of their own.
# Skipped (exit 77) where namespaces, lcm-gen or Python's lcm cannot be had.  MUKCA_LONG=1: in full.
set -u
here=$(cd "$(dirname "$0")" && pwd)
skip() {
    echo "skip tests/lcm: $1"
    exit 77
}
out=$BUILD/lcm
mkdir -p "$out/types" "$out/work"
command -v lcm-gen >/dev/null || skip "no lcm-gen (Debian's liblcm-bin)"
unshare -rnm true 2>/dev/null || skip "no network namespaces (unshare -rnm)"
command -v ip >/dev/null || skip "no ip (Debian's iproute2)"
python=${PYTHON:-python3}
if ! "$python" -c 'import lcm' 2>/dev/null; then
    python=$out/venv/bin/python
    if ! "$python" -c 'import lcm' 2>/dev/null; then
        "${PYTHON:-python3}" -m venv "$out/venv" >"$out/venv.log" 2>&1 &&
            "$python" -m pip install -q lcm >>"$out/venv.log" 2>&1 ||
            skip "no Python lcm (pip install lcm failed, see $out/venv.log)"
    fi
fi
lcm-gen -p --ppath "$out/types" "$here"/types/*.lcm "$here"/../../data/lcm/*.lcm || exit 1
# Each has a network of its own, so some can run at a time; they mostly wait.
printf '%s\n' ${LCM_TESTS:-"$here"/test_*.py} | xargs -P 3 -I '{}' sh -c '
    name=$(basename "$2" .py)
    unshare -rnm sh -c "ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo; exec \"\$@\"" \
        sh timeout 900 "$1" "$2" >"$3/$name.log" 2>&1 || echo "not ok $name" >>"$3/$name.log"
' sh "$python" '{}' "$out"
failed=0
for test in ${LCM_TESTS:-"$here"/test_*.py}; do
    log=$out/$(basename "$test" .py).log
    cat "$log"
    ! grep -q '^not ok' "$log" || failed=1
done
exit $failed
