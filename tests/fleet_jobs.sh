#!/bin/bash
# The commands of docs/fleet.md for Slurm, exactly as they stand, with an sbatch that does at once what Slurm
# does with their options and knows no others; those for GNU parallel run in tests/docs.
set -u
cd "$(dirname "$0")/.." || exit 1

# shellcheck source=tests/ok.bash
. tests/ok.bash

mkdir "$dir/bin" "$dir/jobs"
cat >"$dir/bin/sbatch" <<'SBATCH'
#!/bin/bash
# usage: sbatch OPTION...; a job that succeeded leaves its number in $JOBS
tasks= log= script=
while [ $# -gt 0 ]; do
    case $1 in
    --parsable | --time=[0-9]* | --mem=[0-9]*M) ;;
    --array=[0-9]*-[0-9]*) tasks=$(seq ${1//[!0-9]/ }) ;;
    --dependency=afterok:*) [ -e "$JOBS/${1##*:}" ] || { echo "sbatch: no job ${1##*:}" >&2; exit 1; } ;;
    -o) log=$2 && shift ;;
    --wrap) script=$2 && shift ;;
    *) echo "sbatch: $1 is no option of this one" >&2 && exit 1 ;;
    esac
    shift
done
job=$((1000 + $(find "$JOBS" -type f | wc -l))) good=1
for task in ${tasks:-none}; do
    SLURM_ARRAY_TASK_ID=$task sh -c "$script" >"${log//%a/$task}" 2>&1 || good=
done
[ -z "$good" ] || : >"$JOBS/$job"
echo $job
SBATCH
chmod +x "$dir/bin/sbatch"
cp -r data docs "$dir"
cd "$dir" || exit 1
export PATH="$dir/bin:${mukca%/*}:$PATH" JOBS="$dir/jobs"
block() { # KIND: the first one of docs/fleet.md
    awk -v fence="\`\`\`$1" '$0 == fence { n++; on = n == 1; next } /^```/ { on = 0 } on' docs/fleet.md
}
block sh >data.sh
block bash >jobs.sh
ok "the data of docs/fleet.md" bash -eu data.sh
ok "sbatch as in docs/fleet.md" bash -eu jobs.sh
ok "all jobs of the array and the one that depends on it" grep -q "^Departs arm7: joint compliance at joint_4" build/fleet/slurm-fleet.log
mukca fleet -q build/fleet/arm*/session.json -o once.tsv
ok "the same bytes as one process" cmp once.tsv build/fleet/heron7.traits.tsv
exit $failed
