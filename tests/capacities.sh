#!/bin/sh
# Every function of a public header links from C alone.  Those of headers with structures of a fixed
# size do not link into a program that was compiled with other capacities (MUKCA_MAX_*).
set -u
cd "$(dirname "$0")/.." || exit 1
nm "$BUILD/libmukca_core.a" 2>/dev/null | grep -q __asan_init && { echo "skip capacities: sanitizers"; exit 77; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cc="gcc -std=c11 -Wall -Wextra -Wpedantic -Werror -O1 -ffunction-sections -fdata-sections -Wl,--gc-sections -Iinclude"
functions=0 failed=0
fail() {
    echo "not ok $1"
    failed=1
}

links() { # FLAGS...: the function of $header links
    printf '#include "%s"\n%s\nint main(void) { return !function; }\n' "$header" \
        "void (*volatile function)(void) = (void (*)(void))$name;" >"$scratch/main.c"
    # shellcheck disable=SC2086
    $cc "$@" -o "$scratch/main" "$scratch/main.c" "$BUILD/libmukca_core.a" -lm 2>"$scratch/said"
}

for header in include/mukca/*.h; do
    gcc -std=c11 -Iinclude -fsyntax-only -aux-info "$scratch/declared" -include math.h -xc "$header"
    names=$(sed -n "s|^/\* $header:[0-9]*:NC \*/ extern .*\(mukca_[a-z0-9_]*\) (.*|\1|p" "$scratch/declared")
    sized=$(gcc -E -Iinclude "$header" | grep -c mukca_capacities)
    header=${header#include/}
    for name in $names; do
        functions=$((functions + 1))
        links || fail "$name of $header links: $(grep -m1 undefined "$scratch/said")"
        [ "$sized" -eq 0 ] && continue
        capacity=$(echo ELEMENTS JOINTS MASSES EFFECTS | cut -d ' ' -f $((functions % 4 + 1)))
        links -DMUKCA_MAX_"$capacity"=12 && fail "$name links with another MUKCA_MAX_$capacity"
        grep -q 'undefined.*mukca_capacities_' "$scratch/said" || fail "$name: $(cat "$scratch/said")"
    done
done
[ $functions -gt 50 ] || fail "only $functions functions in the public headers"
[ $failed -eq 0 ] && echo "ok $functions public functions link, with equal capacities only"
exit $failed
