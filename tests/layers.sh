#!/bin/sh
# Each module of src/ may use only the modules before it in this list (ARCHITECTURE.md), by include and
# by symbol; files of one module never use each other in a circle; C++ and the libraries stay where
# they belong.
set -u
cd "$(dirname "$0")/.." || exit 1
modules='base math model dynamics effect arm infer fit recalibrate plan simulate diagnose accept capture motion fleet io lcm report record cli heart'
core='base math model dynamics effect arm infer fit recalibrate plan simulate diagnose accept capture motion fleet'
build=${BUILD:-build}
bad=0
fail() {
    echo "not ok $1"
    bad=1
}

for file in $(find src -name '*.[ch]' -o -name '*.cc' | sort); do
    module=${file#src/}
    module=${module%%/*}
    case " $modules " in *" $module "*) ;; *) fail "$file: src/$module is no module of this list" ;; esac
    above=" $modules " above="${above%%" $module "*} $module "
    for include in $(sed -n 's/^[ \t]*#[ \t]*include[ \t]*"\([^"]*\)".*/\1/p' "$file"); do
        case $include in
        mukca/*) [ -f "include/$include" ] || fail "$file includes $include, which does not exist" ;;
        */*) case $above in *" ${include%%/*} "*) ;; *) fail "$file includes $include" ;; esac ;;
        esac
    done
done

# Who uses whose symbols: one line "user owner" per pair of object files, as module/file.
uses=$(mktemp)
trap 'rm -f "$uses"' EXIT
find "$build/obj/src" -name '*.o' ! -path '*/heart/*' -exec nm -A -P {} + 2>/dev/null | awk '
    { sub(/:$/, "", $1); sub(/.*\/obj\/src\//, "", $1); sub(/\.o$/, "", $1) }
    $3 ~ /^[TDBRVW]$/ { owner[$2] = $1 }
    $3 == "U" { user[++n] = $1; symbol[n] = $2 }
    END { for (i = 1; i <= n; i++) if (symbol[i] in owner && owner[symbol[i]] != user[i])
              print user[i], owner[symbol[i]] }' | sort -u >"$uses"
[ -s "$uses" ] || fail "no object files below $build/obj/src: build the program first"
while read -r user owner; do
    above=" $modules " above="${above%%" ${user%%/*} "*} ${user%%/*} "
    case $above in *" ${owner%%/*} "*) ;; *) fail "src/$user.c calls src/$owner.c, a later module" ;; esac
done <"$uses"
for module in $modules; do
    circle=$(grep "^$module/.* $module/" "$uses" | tsort 2>&1 >/dev/null | grep -o "$module/.*" | tr '\n' ' ')
    [ -z "$circle" ] || fail "files that use each other in a circle: $circle"
done

# What depends on an effect is a member of its definition: no other file names one.
names=$(sed -n 's/^ *X(\([A-Z_]*\), [a-z_]*).*/\1/p' include/mukca/effect.h | paste -sd '|')
hit=$(grep -rnwE "MUKCA_EFFECT_($names)" src | grep -v '^src/effect/')
[ -n "$names" ] && [ -z "$hit" ] || fail "an effect is named outside src/effect: $hit"

# The core needs libm and nothing else.
sources=$(for module in $core; do find "src/$module" -name '*.[ch]' ! -name 'nlopt_*'; done)
for pattern in nlopt lcm/ jansson libxml urdf console_bridge unistd.h sys/; do
    hit=$(grep -ln "#[ \t]*include[ \t]*<$pattern" $sources include/mukca/*.h 2>/dev/null)
    [ -z "$hit" ] || fail "the core includes <$pattern...>: $hit"
done
foreign=$(nm -g --defined-only "$build/libmukca_core.a" | awk 'NF == 3 && $3 !~ /^(__odr_asan[.])?mukca_/ { print $3 }')
[ -z "$foreign" ] || fail "the core library exports names that are not mukca_*: $(echo "$foreign" | tr '\n' ' ')"

# The library for control loops is freestanding but for libm: no stdio, no allocation, no clock, no
# locale, and no memory of its own, so that threads cannot disturb each other.
math='atan2 copysign cos expm1 fabs floor fmax fmin hypot scalbn rint round sin sincos sqrt tanh'
string='memcmp memcpy memmove memset strchr strcmp strcspn strlen strncmp strspn'
compiler='_GLOBAL_OFFSET_TABLE_ __cpu_features2 __cpu_indicator_init __cpu_model __stack_chk_fail __(u?div|u?mod)[dt]i[34] __(asan|ubsan|sanitizer|gcov)_.*'
rt=$build/libmukca_rt.a
needed=$(nm -g "$rt" | awk 'NF == 3 { have[$3] = 1 } NF == 2 { want[$2] = 1 }
    END { for (name in want) if (!(name in have)) print name }' |
    grep -vxE "$(echo "$math $string $compiler" | tr ' ' '|')" | sort | tr '\n' ' ')
[ -z "$needed" ] || fail "libmukca_rt.a needs $needed"
[ -n "$(nm -g --defined-only "$rt" 2>/dev/null)" ] || fail "there is no $rt"
owned=$(size -A "$rt" | awk '$1 ~ /^\.t?(data|bss)/ && $1 !~ /\.rel\.ro/ && $1 !~ /asan/ && $2 > 0 { print $1 }' | sort -u)
case $(nm "$rt" 2>/dev/null) in *__asan_*) owned= ;; esac # sanitizers move constants
[ -z "$owned" ] || fail "libmukca_rt.a has variables: $owned"

# A stack frame has at most 16 kB (gcc's -fstack-usage).
frames=$(find "$build/obj/src" -name '*.su' -exec awk -F '\t' '$2 > 16384 { print $1 " " $2 }' {} +)
case $(nm "$rt" 2>/dev/null) in *__asan_*) frames= ;; esac # sanitizers widen them
[ -z "$frames" ] || fail "stack frames of more than 16 kB: $frames"

hit=$(find src -name '*.cc' ! -path 'src/io/urdf_load.cc')
[ -z "$hit" ] || fail "C++ outside the URDF loader: $hit"
hit=$(grep -rnE 'TODO|FIXME|XXX|not implemented' src include)
[ -z "$hit" ] || fail "unfinished: $hit"
hit=$(find src include -size +40k -name '*.[ch]*')
[ -z "$hit" ] || fail "grown past one job: $hit"
[ $bad -eq 0 ] && echo "ok layers"
exit $bad
