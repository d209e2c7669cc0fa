#!/bin/sh
# Each layer of src/ may include only the layers above it (ARCHITECTURE.md), and public headers only
# public headers; C++ and the libraries stay where they belong.
set -u
cd "$(dirname "$0")/.." || exit 1
bad=0
above=
for layer in base math model fit study io cli; do
    above="$above$layer "
    for file in $(find src/$layer -name '*.[ch]' -o -name '*.cc' -path "src/$layer/*" | sort); do
        for include in $(sed -n 's/^[ \t]*#[ \t]*include[ \t]*"\([^"]*\)".*/\1/p' "$file"); do
            case $include in
            mukca/*) [ -f "include/$include" ] || { echo "not ok $file includes $include, which does not exist"; bad=1; } ;;
            */*)
                case " $above" in
                *" ${include%%/*} "*) ;;
                *) echo "not ok $file (layer $layer) includes $include"; bad=1 ;;
                esac ;;
            esac
        done
    done
done
# The core needs libm and nothing else.
core=$(find src/base src/math src/model src/fit src/study -name '*.[ch]' ! -name 'nlopt_adapter*' 2>/dev/null)
for pattern in nlopt lcm/ jansson libxml urdf console_bridge unistd.h sys/; do
    # shellcheck disable=SC2086
    hit=$(grep -ln "#[ \t]*include[ \t]*<$pattern" $core include/mukca/*.h 2>/dev/null)
    [ -z "$hit" ] || { echo "not ok the core includes <$pattern...>: $hit"; bad=1; }
done
hit=$(find src -name '*.cc' ! -path 'src/io/urdf_load.cc')
[ -z "$hit" ] || { echo "not ok C++ outside the URDF loader: $hit"; bad=1; }
hit=$(grep -rnE 'TODO|FIXME|XXX|not implemented' src include)
[ -z "$hit" ] || { echo "not ok unfinished: $hit"; bad=1; }
hit=$(find src include -size +40k -name '*.[ch]*')
[ -z "$hit" ] || { echo "not ok grown past one job: $hit"; bad=1; }
[ $bad -eq 0 ] && echo "ok layers"
exit $bad
