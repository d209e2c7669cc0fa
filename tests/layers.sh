#!/bin/sh
# Each room of src/ may use only the rooms before it in this list (ARCHITECTURE.md), by include and
# by symbol; files of one room never use each other in a circle; C++ and the libraries stay where
# they belong.
set -u
cd "$(dirname "$0")/.." || exit 1
rooms='base math model effect arm fit recalibrate capture plan simulate diagnose io lcm report record cli'
core='base math model effect arm fit recalibrate capture plan simulate diagnose'
build=${BUILD:-build}
bad=0
fail() {
    echo "not ok $1"
    bad=1
}

for file in $(find src -name '*.[ch]' -o -name '*.cc' | sort); do
    room=${file#src/}
    room=${room%%/*}
    case " $rooms " in *" $room "*) ;; *) fail "$file: src/$room is no room of this list" ;; esac
    above=" ${rooms%%"$room"*}$room "
    for include in $(sed -n 's/^[ \t]*#[ \t]*include[ \t]*"\([^"]*\)".*/\1/p' "$file"); do
        case $include in
        mukca/*) [ -f "include/$include" ] || fail "$file includes $include, which does not exist" ;;
        */*) case $above in *" ${include%%/*} "*) ;; *) fail "$file includes $include" ;; esac ;;
        esac
    done
done

# Who uses whose symbols: one line "user owner" per pair of object files, as room/file.
uses=$(mktemp)
trap 'rm -f "$uses"' EXIT
find "$build/obj/src" -name '*.o' -exec nm -A -P {} + 2>/dev/null | awk '
    { sub(/:$/, "", $1); sub(/.*\/obj\/src\//, "", $1); sub(/\.o$/, "", $1) }
    $3 ~ /^[TDBRVW]$/ { owner[$2] = $1 }
    $3 == "U" { user[++n] = $1; symbol[n] = $2 }
    END { for (i = 1; i <= n; i++) if (symbol[i] in owner && owner[symbol[i]] != user[i])
              print user[i], owner[symbol[i]] }' | sort -u >"$uses"
[ -s "$uses" ] || fail "no object files below $build/obj/src: build the program first"
while read -r user owner; do
    above=" ${rooms%%"${user%%/*}"*}${user%%/*} "
    case $above in *" ${owner%%/*} "*) ;; *) fail "src/$user.c calls src/$owner.c, a later room" ;; esac
done <"$uses"
for room in $rooms; do
    circle=$(grep "^$room/.* $room/" "$uses" | tsort 2>&1 >/dev/null | grep -o "$room/.*" | tr '\n' ' ')
    [ -z "$circle" ] || fail "files that use each other in a circle: $circle"
done

# The core needs libm and nothing else.
sources=$(for room in $core; do find "src/$room" -name '*.[ch]' ! -name 'nlopt_adapter*'; done)
for pattern in nlopt lcm/ jansson libxml urdf console_bridge unistd.h sys/; do
    # shellcheck disable=SC2086
    hit=$(grep -ln "#[ \t]*include[ \t]*<$pattern" $sources include/mukca/*.h 2>/dev/null)
    [ -z "$hit" ] || fail "the core includes <$pattern...>: $hit"
done
foreign=$(nm -g --defined-only "$build/libmukca_core.a" | awk 'NF == 3 && $3 !~ /^mukca_/ { print $3 }')
[ -z "$foreign" ] || fail "the core library exports names that are not mukca_*: $(echo "$foreign" | tr '\n' ' ')"

hit=$(find src -name '*.cc' ! -path 'src/io/urdf_load.cc')
[ -z "$hit" ] || fail "C++ outside the URDF loader: $hit"
hit=$(grep -rnE 'TODO|FIXME|XXX|not implemented' src include)
[ -z "$hit" ] || fail "unfinished: $hit"
hit=$(find src include -size +40k -name '*.[ch]*')
[ -z "$hit" ] || fail "grown past one job: $hit"
[ $bad -eq 0 ] && echo "ok layers"
exit $bad
