#!/bin/sh
# Every function of a public header links from C alone.  Those with a structure whose size depends on
# the capacities (MUKCA_MAX_*) do not link into a program that was compiled with others.
set -u
cd "$(dirname "$0")/.." || exit 1
nm "$BUILD/libmukca_core.a" 2>/dev/null | grep -q __asan_init && { echo "skip capacities: sanitizers"; exit 77; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for header in include/mukca/*.h; do echo "#include \"${header#include/}\""; done >"$scratch/all.h"
cc="gcc -std=c11 -Wall -Wextra -Wpedantic -Werror -ffunction-sections -fdata-sections -Wl,--gc-sections -Iinclude -include $scratch/all.h"
functions=0 sized=0 failed=0
fail() {
    echo "not ok $1"
    failed=1
}

# the structures with another size in a program of other capacities
types=$(sed -n 's/^} \(mukca_[a-z_0-9]*\);.*/\1/p' include/mukca/*.h)
for type in $types; do printf 'printf("%%zu %s\\n", sizeof(%s));\n' "$type" "$type"; done >"$scratch/sizes.h"
printf '#include <stdio.h>\nint main(void) {\n#include "sizes.h"\nreturn 0; }\n' >"$scratch/sizes.c"
$cc -o "$scratch/usual" "$scratch/sizes.c" && "$scratch/usual" >"$scratch/usual.txt"
for capacity in ELEMENTS JOINTS MASSES EFFECTS; do
    $cc -DMUKCA_MAX_$capacity=12 -o "$scratch/other" "$scratch/sizes.c" && "$scratch/other" |
        diff "$scratch/usual.txt" - | sed -n "s/^> [0-9]* \(.*\)/$capacity \1/p"
done >"$scratch/sized.txt"

gcc -std=c11 -Iinclude -fsyntax-only -aux-info "$scratch/all.txt" -xc "$scratch/all.h"
grep '^/\* include/mukca/[a-z_]*.h:[0-9]*:NC \*/ extern ' "$scratch/all.txt" >"$scratch/declared.txt"
while read -r declaration; do
    name=$(expr "$declaration" : '.*[ *]\(mukca_[a-z0-9_]*\) (')
    functions=$((functions + 1))
    echo "void (*volatile f)(void) = (void (*)(void))$name; int main(void) { return !f; }" >"$scratch/main.c"
    $cc -o "$scratch/main" "$scratch/main.c" "$BUILD/libmukca_core.a" -lm 2>"$scratch/said" ||
        fail "$name: $(cat "$scratch/said")"
    while read -r capacity type; do
        case $declaration in *"$type "*"("* | *"("*"$type "*) ;; *) continue ;; esac
        sized=$((sized + 1))
        $cc "-DMUKCA_MAX_$capacity=12" -o "$scratch/main" "$scratch/main.c" "$BUILD/libmukca_core.a" -lm 2>"$scratch/said" &&
            fail "$name links with another MUKCA_MAX_$capacity (mukca/capacities.h)"
        grep -q "undefined reference to .${name}_" "$scratch/said" || fail "$name: $(cat "$scratch/said")"
    done <"$scratch/sized.txt"
done <"$scratch/declared.txt"
[ $functions -gt 50 ] && [ $sized -gt 50 ] || fail "only $functions functions, $sized with sizes"
[ $failed -eq 0 ] && echo "ok $functions public functions link, with equal capacities only"
exit $failed
