#!/bin/bash
# The documents say what the program does: every option is in man page and completion, every
# `--option` that a document mentions exists, every effect, JSON key and column is described, and
# every example of help, README, docs and man page runs, in a scratch copy of the source folder.
# UPDATE_GOLDEN=1 (`make golden`) rewrites the COMMANDS of mukca.1.
set -u
cd "$(dirname "$0")/../.." || exit 1
root=$PWD
MUKCA=${MUKCA:-$root/build/mukca}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export NO_COLOR=1 MUKCA
failures=0
number=0
# Pages with examples, in the order in which they run: later ones use files of earlier ones.
pages="README.md docs/guide.md docs/data.md docs/ros.md docs/diagnosis.md docs/method.md docs/comparison.md docs/fleet.md docs/motion.md"

check() { # NAME TEXT: passes where TEXT is empty
    if [ -z "$2" ]; then
        echo "ok $1"
    else
        echo "not ok $1"
        printf '%s\n' "$2" | head -n 40 | sed 's/^/    /'
        failures=$((failures + 1))
    fi
}

runs() { # NAME OUTPUT COMMAND...: passes where the command does
    "${@:3}" >"$2" 2>&1 </dev/null
    code=$?
    check "$1" "$([ $code -eq 0 ] || { echo "exit $code"; tail -n 8 "$2"; })"
}

# ---- tables and documents agree
"$MUKCA" help options | tail -n +2 >"$scratch/options"
"${PYTHON:-python3}" tools/man.py >"$scratch/commands"
if [ -n "${UPDATE_GOLDEN-}" ]; then
    { sed '/^\.SH COMMANDS/,$d' mukca.1; cat "$scratch/commands"
      sed '1,/^\.SH COMMANDS/d' mukca.1 | sed -n '/^\.SH/,$p'; } >"$scratch/page" && cp "$scratch/page" mukca.1
fi
sed -n '/^\.SH COMMANDS/,$p' mukca.1 | sed '2,$ { /^\.SH/,$d }' >"$scratch/page"
check "the commands of mukca.1 are those of the program (else: make golden)" \
    "$(diff "$scratch/page" "$scratch/commands")"
check "the man pages name the version" \
    "$(grep -L "^.TH .* \"$("$MUKCA" --version)\" " mukca.1 mukca-formats.5)"
check "options that documents mention exist" "$(
    for page in $pages ARCHITECTURE.md CONTRIBUTING.md mukca.1 mukca-formats.5; do
        sed 's/\\-/-/g' "$page" | grep -oE '(^|[^-a-z])--[a-z][a-z-]+' | grep -oE -- '--[a-z-]+' | sort -u |
            grep -vxF -e --version -e --help -e --dev -e --array -e --cpus-per-task -e --mem -e --time \
                -e --joblog -e --resume -e --parsable -e --wrap -e --dependency -e --csv -e --full-length -e --hide-type -e "$(cut -f 2 "$scratch/options")" | sed "s|^|$page: |"
    done)"
check "make targets that documents mention exist" "$(
    grep -ohE '(`|^)make (-f tools/Makefile )?[a-z][a-z0-9-]+' $pages CONTRIBUTING.md ARCHITECTURE.md CHANGELOG.md mukca.1 | sort -u |
        sed 's/.*make -f \([^ ]*\) /\1 /; s/.*make /Makefile /' |
        while read -r file target; do grep -qE "^$target:" "$file" Makefile || echo "$target in $file"; done)"
check "files and headings that documents link to exist" "$(
    "${PYTHON:-python3}" - $pages CONTRIBUTING.md ARCHITECTURE.md CHANGELOG.md <<'PY'
import os, re, sys
def anchors(page):
    heads = re.findall(r"^#+ (.*)$", open(page).read(), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
for page in sys.argv[1:]:
    for target, anchor in re.findall(r"\]\(([^)#]*)(?:#([^)]*))?\)", open(page).read()):
        file = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
        if target.startswith("https:"):
            continue
        if not os.path.exists(file):
            print(f"{page}: {target}")
        elif anchor and anchor not in anchors(file):
            print(f"{page}: {target}#{anchor}")
PY
)"
check "functions that documents name exist in the file beside them" "$(
    grep -ohE '`[a-z_]+\(\)`( in \[[^]]*\])?' ARCHITECTURE.md CONTRIBUTING.md $pages | sort -u | while read -r found; do
        name=${found#?} name=${name%%\(*}
        file=$(echo "$found" | sed -n 's/.*\[\(.*\)\]/\1/p')
        grep -rqF "$name(" ${file:-src include} || echo "$found"
    done)"
for page in docs/diagnosis.md mukca-formats.5; do
    check "$page describes every effect" "$(
        "$MUKCA" help effects | sed -n 's/^\([a-z_]*\) (.*/\1/p' | while read -r effect; do
            sed 's/\\-/-/g' $page | grep -q "$effect" || echo "$effect"; done)"
done
check "mukca-formats.5 describes every export format" "$(
    "$MUKCA" help export | sed -n 's/^  \([a-z]*\) (\..*/\1/p' | grep . | while read -r format; do
        grep -A1 '^\.TP' mukca-formats.5 | grep -qx ".B $format" || echo "$format"; done)"
check "mukca-formats.5 describes every column of recordings" "$(
    sed -n '/define MUKCA_COLUMN_LIST/,/^$/p' src/model/dataset.h | grep -o '"[^"]*"' | tr -d '"' | grep . |
        while read -r column; do grep -qwF -- "$column" mukca-formats.5 || echo "$column"; done)"
for page in mukca.1 mukca-formats.5; do
    check "man reads $page without a complaint" "$(groff -man -Tutf8 -ww -z $page 2>&1)"
    check "$page fits 80 columns" \
        "$(if command -v groff >/dev/null; then groff -man -Tascii -P-cbou -rLL=78n $page 2>/dev/null | grep -E '.{81}'; fi)"
done

# ---- examples run: a copy of what a clone holds, `mukca` in the path
cp -r data tools docs include src Makefile README.md "$scratch"
mkdir -p "$scratch/build/demo"
ln -s "$MUKCA" "$scratch/build/mukca"
cd "$scratch" || exit 1
export PATH="${MUKCA%/*}:$PATH" BUILD=$scratch/build

# Blocks of ```sh one after the other in one shell, each output kept; a ```text block after one must
# be found in its output, line by line, whatever the numbers.
for page in $pages; do
    awk -v page="$(basename "$page" .md)" -v first=$((++number)) '/^```/ {
            if (open) { open = 0; close(file) } else { open = 1; n++; kind = substr($0, 4)
            file = sprintf("block-%d-%s-%02d.%s", first, page, n, kind); printf "" >file } next }
        open { print >file }' "$page"
done
loose() { tr -s ' ' | sed -E 's/[0-9]+(\.[0-9]+)?/#/g; s/^ //'; }
previous='' without=''
for block in block-*; do
    case $block in
    *.sh)
        previous=
        page=${block#block-?-} page=${page%-*}
        name="example of $page: $(head -n 1 "$block" | cut -c 1-60)"
        # what follows on a page may need its results
        grep -q '^parallel ' "$block" && ! command -v parallel >/dev/null && without=$page
        if [ "$page" = "$without" ]; then
            echo "skip $name (no GNU parallel)"
            continue
        fi
        runs "$name" "$block.out" bash -eu "$block"
        previous=$block.out ;;
    *.text)
        [ -n "$previous" ] || continue
        loose <"$previous" >said
        check "$page shows what its example prints" \
            "$(loose <"$block" | while IFS= read -r line; do grep -qxF -- "$line" said || echo "$line"; done)"
        previous= ;;
    esac
done

# Examples of the man page, between .EX and .EE.
for page in mukca.1 mukca-formats.5; do
    sed -n '/^\.EX/,/^\.EE/ { /^\.E[XE]/d; s/\\-/-/g; s/\\e/\\/g; p }' "$root/$page" >page.sh
    grep -q . page.sh || continue
    runs "examples of $page" page.out bash -eu page.sh
done

# Examples of help; `mukca send` needs a daemon, tests/lcm gives it one.
# shellcheck disable=SC2162 # a backslash continues a line
while read example; do
    case $example in "mukca send "*) continue ;; esac
    runs "help example: $example" example.out bash -euc "$example"
done < <("$MUKCA" help options | tail -n +2 | cut -f 1 | uniq | while read -r command; do
    "$MUKCA" help "$command" | sed '1,/^Example:/d'; done)

# ---- every JSON key and column of what the examples wrote is described
sed 's/\\-/-/g; s/\\f.//g' "$root/mukca-formats.5" >formats.txt
a="--urdf data/demo/arm.urdf" d="data/demo/train.tsv --test data/demo/test.tsv"
{
    mukca calibrate $a $d --json calibrate.json
    mukca evaluate $a $d --json evaluate.json -o evaluate.tsv
    mukca diagnose $a $d --json diagnose.json
    mukca fleet build/demo/arm_1.json build/demo/arm_2.json --json fleet.json
    mukca diagnose $a $d --traits build/demo/heron7.traits.tsv --json traits.json
    mukca recalibrate --urdf data/gen3.urdf build/guide/poses.tsv --json recalibrate.json
    mukca plan $a data/demo/train.tsv --rows 2 --json plan.json -o plan.tsv
    mukca simulate $a --effort --command --seed 1 --rows 3 -o simulate.tsv
    grep -v '^#' data/demo/test.tsv | mukca compensate $a --offsets build/guide/arm.tsv --json compensate.json -o compensate.tsv
} >json.out 2>&1
check "every JSON key is in mukca-formats.5" "$("${PYTHON:-python3}" - *.json <<'PY'
import json, re, sys
text = open("formats.txt").read()
words = set(re.findall(r"[A-Za-z_0-9]+", text))
arms = {"front", "left", "right", "held_out_1"} | {"joint_%d" % i for i in range(1, 8)}
def walk(value, file):
    if isinstance(value, dict):
        for key, inner in value.items():
            for word in re.findall(r"[A-Za-z_0-9]+", key):
                if word not in words and word not in arms:
                    print(file + ": " + key)
            walk(inner, file)
    elif isinstance(value, list):
        for inner in value:
            walk(inner, file)
for file in sys.argv[1:]:
    walk(json.load(open(file)), file)
if len(sys.argv) < 8:
    print("only " + " ".join(sys.argv[1:]))
PY
)"
check "every column is in mukca-formats.5" "$(
    for table in *.tsv build/guide/*.tsv build/demo/*.tsv; do
        grep -v '^#' "$table" | head -n 1 | tr '\t' '\n' | sed -E 's/^joint_[0-9]\.?//; s/^(front|left|right)_//' |
            grep . | sort -u | while read -r column; do
            grep -qw -- "$column" formats.txt || echo "$table: $column"; done
    done)"
[ $failures -eq 0 ]
