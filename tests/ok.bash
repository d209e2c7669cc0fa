# One line for each command that is tested; sourced, with `dir` a folder and `failed` 0.
# shellcheck shell=bash disable=SC2034,SC2154
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
