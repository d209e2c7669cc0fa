#!/bin/sh
# The program's protection by compiler and linker; skipped (exit 77) without readelf or in a build of other flags.
set -u
command -v readelf >/dev/null || { echo "skip hardening: no readelf"; exit 77; }
if readelf -Ws "$MUKCA" | grep -q __asan_init || ! readelf -Ws "$MUKCA" | grep -q __stack_chk_fail; then
    echo "skip hardening: built with other flags"
    exit 77
fi
failed=0
check() {
    if eval "$2"; then echo "ok $1"; else echo "not ok $1"; failed=1; fi
}
check "position-independent program" 'readelf -h "$MUKCA" | grep -q "Type: *DYN"'
check "relocations are read-only" 'readelf -lW "$MUKCA" | grep -q GNU_RELRO'
check "symbols are bound at the start" 'readelf -dW "$MUKCA" | grep -q "BIND_NOW\|Flags:.*NOW"'
check "no executable stack" 'readelf -lW "$MUKCA" | grep GNU_STACK | grep -vq RWE'
check "checked copies" 'readelf -Ws "$MUKCA" | grep -q __snprintf_chk'
unit=$(dirname "$0")/../data/systemd/mukca.service
if command -v systemd-analyze >/dev/null; then
    sed "s|^ExecStart=[^ ]*|ExecStart=$MUKCA|" "$unit" >"$BUILD/mukca.service"
    said=$(systemd-analyze verify "$BUILD/mukca.service" 2>&1 | grep "mukca.service:" | grep -v "not executable\|Command .man ")
    check "systemd accepts the unit: $said" '[ -z "$said" ]'
fi
exit $failed
