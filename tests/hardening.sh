#!/bin/bash
# The program's protection by compiler and linker; skipped (exit 77) without readelf or in a build of other flags.
set -u
cd "$(dirname "$0")/.." || exit 1
. tests/ok.bash
command -v readelf >/dev/null || skip "hardening: no readelf"
if readelf -Ws "$MUKCA" | grep -q __asan_init || ! readelf -Ws "$MUKCA" | grep -q __stack_chk_fail; then
    skip "hardening: built with other flags"
fi
ok "position-independent program" sh -c 'readelf -h "$MUKCA" | grep -q "Type: *DYN"'
ok "relocations are read-only" sh -c 'readelf -lW "$MUKCA" | grep -q GNU_RELRO'
ok "symbols are bound at the start" sh -c 'readelf -dW "$MUKCA" | grep -q "BIND_NOW\|Flags:.*NOW"'
ok "no executable stack" sh -c 'readelf -lW "$MUKCA" | grep GNU_STACK | grep -vq RWE'
ok "checked copies" sh -c 'readelf -Ws "$MUKCA" | grep -q __snprintf_chk'
unit=data/systemd/mukca.service
if command -v systemd-analyze >/dev/null; then
    sed "s|^ExecStart=[^ ]*|ExecStart=$MUKCA|" "$unit" >"$BUILD/mukca.service"
    said=$(systemd-analyze verify "$BUILD/mukca.service" 2>&1 | grep "mukca.service:" | grep -v "not executable\|Command .man ")
    ok "systemd accepts the unit: $said" test -z "$said"
fi
exit $failed
