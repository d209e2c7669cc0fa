#!/bin/sh
# Command-line tests: every file of cases/ is read in order, in an empty folder of its own.
#   golden NAME ARGS...            what `mukca ARGS` prints and returns is golden/NAME.txt
#                                  (UPDATE_GOLDEN=1, `make golden`, rewrites it)
#   refuse CODE PATTERN ARGS...    it says one line that matches, returns CODE, and leaves no file
#                                  new, changed or half-written
#   accept PATTERN ARGS...         it returns 0 and a note on standard error matches
#   answer PATTERN ARGS...         it returns 0, standard output matches, and standard error holds
#                                  nothing but notes
#   doubt PATTERN ARGS...          it returns 1, and what it prints matches
#   expect NAME COMMAND...         the command succeeds
#   interrupted ARGS...            it stops at an interrupt, and writes nothing
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
MUKCA=${MUKCA:-$root/build/mukca}
scratch=$(mktemp -d)
trap 'chmod -R u+w "$scratch"; rm -rf "$scratch"' EXIT
export SOURCE_DATE_EPOCH=1767225600 NO_COLOR=1
version=$("$MUKCA" --version)
failures=0

pass() { echo "ok $1"; }
fail() {
    echo "not ok $1"
    shift
    printf '    %s\n' "$@"
    failures=$((failures + 1))
}

run() {
    "$MUKCA" "$@" >"$scratch/out" 2>"$scratch/err" </dev/null
    code=$?
    # no message is cut, no length is 3e+02 mm, and no line begins with the unit of a number
    if awk '/[^.]\.\.\.$/ && !/SHA-256|^Usage/ || /[0-9]e\+[0-9]+ m?(m|rad)( |$)/ ||
            last ~ /[0-9]$/ && /^ *(mm|mrad|m|rad|s|%)([ ,;.)]|$)/ { print; bad = 1 }
            { last = $0 } END { exit !bad }' "$scratch/out" "$scratch/err" >"$scratch/bad"; then
        fail "whole messages: mukca $*" "$(cat "$scratch/bad")"
    fi
}

golden() {
    name=$1
    shift
    run "$@"
    {
        echo "\$ mukca $*"
        cat "$scratch/out"
        if [ -s "$scratch/err" ]; then
            echo "--- standard error"
            cat "$scratch/err"
        fi
        echo "--- exit $code"
    } | sed "s/$version/VERSION/" >"$scratch/text"
    if [ -n "${UPDATE_GOLDEN-}" ]; then
        cp "$scratch/text" "$here/golden/$name.txt"
    fi
    if diff -u "$here/golden/$name.txt" "$scratch/text" >"$scratch/diff" 2>&1; then
        pass "golden $name"
    else
        fail "golden $name" "$(cat "$scratch/diff")"
    fi
}

# two files have the same bytes, and some
equal() { test -s "$1" && cmp "$1" "$2"; }

# the first columns of two tables agree, row by row
near() { # WITHIN COLUMNS TABLE TABLE
    paste "$3" "$4" | awk -v most="$1" -v n="$2" '
        NF % 2 { exit 1 }
        NR > 1 { for (i = 1; i <= n; i++) { d = $i - $(i + NF / 2); if (!(d * d <= most * most)) exit 1 } }
        END { if (NR < 2) exit 1 }'
}

# an offsets table made by hand
table_of() { # URDF ROW...
    echo "# urdf_sha256: $(sha256sum "$1" | cut -d ' ' -f 1)"
    shift
    printf '%b\n' 'joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm' "$@"
}

files() { find . -type f -exec cksum {} + 2>/dev/null | sort; }

refuse() {
    wanted=$1 pattern=$2
    shift 2
    files >"$scratch/before"
    run "$@"
    files >"$scratch/after"
    said=$(grep -v '^mukca: note: ' "$scratch/err")
    name="refuses: mukca $*"
    if [ $code -ne "$wanted" ]; then
        fail "$name" "exit $code, not $wanted" "$said"
    elif [ "$(printf '%s\n' "$said" | wc -l)" -ne 1 ] || [ -z "$said" ]; then
        fail "$name" "not one line but: $said"
    elif ! printf '%s\n' "$said" | grep -q -- "$pattern"; then
        fail "$name" "'$said' lacks '$pattern'"
    elif ! cmp -s "$scratch/before" "$scratch/after"; then
        fail "$name" "files changed: $(diff "$scratch/before" "$scratch/after")"
    else
        pass "$name"
    fi
}

# code, file and pattern of what a command says; its arguments
says() {
    wanted=$1 where=$2 pattern=$3
    shift 3
    run "$@"
    if [ $code -ne "$wanted" ] || ! (cd "$scratch" && cat $where) | grep -q -- "$pattern"; then
        fail "says '$pattern': mukca $*" "exit $code: $(cat "$scratch/out" "$scratch/err")"
        return 1
    fi
}

accept() { ! says 0 err "$@" || pass "accepts: mukca $*"; }

answer() {
    if ! says 0 out "$@"; then
        return
    elif grep -v '^mukca: note: ' "$scratch/err" >"$scratch/said"; then
        fail "answers: mukca $*" "standard error: $(cat "$scratch/said")"
    else
        pass "answers: mukca $*"
    fi
}

doubt() { ! says 1 'out err' "$@" || pass "doubts: mukca $*"; }

# interrupted in the middle of a command that takes its time: exit 130, one line, no file
interrupted() {
    "$MUKCA" "$@" -q -o never.tsv 2>err &
    process=$!
    # until the program, not yet the shell before it, catches SIGINT, which is bit 1 of this mask
    until [ "$(readlink -f /proc/$process/exe)" = "$(readlink -f "$MUKCA")" ] || ! kill -0 $process; do sleep 0.02; done
    until grep -q '^SigCgt:.*[2367abef]$' /proc/$process/status || ! kill -0 $process; do sleep 0.02; done
    kill -s INT $process
    wait $process
    code=$?
    expect "interrupted: mukca $1: exit 130, one line, no file" test \
        "$code $(cat err) $(find . -name '*never*')" = "130 mukca $1: interrupted "
}

expect() {
    name=$1
    shift
    if "$@" >"$scratch/log" 2>&1; then
        pass "$name"
    else
        fail "$name" "$(tail -n 5 "$scratch/log")"
    fi
}

for case in "$here"/cases/*.sh; do
    folder=$scratch/$(basename "$case" .sh)
    mkdir "$folder" && cd "$folder" || exit 1
    # shellcheck disable=SC1090
    . "$case"
done
[ $failures -eq 0 ]
