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
