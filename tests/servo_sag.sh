#!/bin/bash
# Servo sag of an arm recorded by command: tied with compliance without readings, seen directly and
# kept out of the geometry with them.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/ok.bash

arm() { "$mukca" "$1" -q --urdf data/demo/arm.urdf "${@:2}"; }
simulate() { arm simulate --seed 5 --noise 1e-4 --perturb 1,2 "$@"; }
causes() { arm diagnose --json - "$@" | tr -d ' \n'; }
# EFFECT JOINT PATTERN OPTION...: the first cause, and what its ties must match
first() {
    local json
    json=$(causes "${@:4}" | sed 's/"suspected".*//')
    echo "${json:0:400}"
    grep -q "\"causes\":\[{\"effect\":\"$1\",\"joint\":\"$2\"" <<<"$json" && grep -q "$3" <<<"$json"
}

sag=servo_sag:joint_2=3e-4
simulate --effect $sag -o "$dir/commands.tsv"
simulate --effect $sag,joint_compliance:joint_4=5e-5 --command -o "$dir/both.tsv"
simulate --effect joint_compliance:joint_4=5e-5 --command -o "$dir/none.tsv"
simulate --effect servo_sag:joint_3=4e-3 -o "$dir/soft.tsv"
sed 's/joint_[0-9]/&.command/g' "$dir/commands.tsv" >"$dir/only.tsv"

tied='"ties":\[{"effect":"\(joint_compliance\|servo_sag\)","joint":"joint_2"'
ok "commands alone: tied with compliance" first '\(servo_sag\|joint_compliance\)' joint_2 "$tied" \
    --angles command "$dir/commands.tsv"
ok "a file without readings is by command" first '\(servo_sag\|joint_compliance\)' joint_2 "$tied" \
    "$dir/only.tsv"
ok "no gear is that soft" first servo_sag joint_3 '"ties":\[\]' --angles command "$dir/soft.tsv"
ok "withheld: compliance" first joint_compliance joint_2 . --without servo_sag --angles command \
    "$dir/commands.tsv"
ok "readings: the arm's own compliance" first joint_compliance joint_4 . "$dir/both.tsv"
ok "both streams, fitted to commands" first servo_sag joint_2 '"ties":\[\]' --angles command \
    "$dir/both.tsv"
sag_of() { # FILE LOW HIGH: what the streams themselves show at joint 2
    local sag
    sag=$(causes "$1" | sed 's/.*"streams"://; s/.*"joint":"joint_2"[^}]*"servo_sag":\([-0-9.e]*\).*/\1/')
    echo "$sag"
    awk -v x="$sag" -v a="$2" -v b="$3" 'BEGIN { exit !(x > a && x < b) }'
}
ok "sag from the streams" sag_of "$dir/both.tsv" 2.9e-4 3.1e-4
ok "no sag from the streams" sag_of "$dir/none.tsv" -1e-6 1e-6
better() { # the stream that describes the arm leaves less
    causes "$1" | sed 's/.*"sigma_reading_m":\([0-9.e-]*\),"sigma_command_m":\([0-9.e-]*\).*/\1 \2/' |
        awk '{ exit !($1 > 0 && $1 < 0.5 * $2) }'
}
ok "geometry of both streams" better "$dir/both.tsv"
exit $failed
