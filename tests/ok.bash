# Sourced in the root of the project: the program, a scratch folder, one line for each command that is tested.
# shellcheck shell=bash disable=SC2034
mukca=${MUKCA:-$PWD/build/mukca}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
export SOURCE_DATE_EPOCH=1700000000
failed=0
ok() { # NAME COMMAND...
    local name=$1
    shift
    if "$@" >"$dir/out" 2>"$dir/err"; then
        echo "ok $name"
    else
        echo "not ok $name: $*"
        tail -n 5 "$dir/out" "$dir/err"
        failed=1
    fi
}
skip() { # WHY: the whole test
    echo "skip $1"
    exit 77
}
refuses() { # NAME CODE PATTERN COMMAND...: what it prints matches
    local code
    "${@:4}" >"$dir/out" 2>"$dir/err"
    code=$?
    if [ $code = "$2" ] && cat "$dir/out" "$dir/err" | grep -q -- "$3"; then
        echo "ok $1"
    else
        echo "not ok $1: exit $code, wanted $2 and '$3'"
        tail -n 3 "$dir/err"
        failed=1
    fi
}
less() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a ~ /^-?[.0-9]/ && a + 0 < b + 0) }'; } # nan and an empty text are no numbers
