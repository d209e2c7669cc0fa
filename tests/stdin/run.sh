#!/bin/bash
# `capture --stdin`: joint states as lines become the session that LCM gives; bad lines get one clear line.
set -u
cd "$(dirname "$0")/../.." || exit 1
recorded=data/demo/joint_states.csv

. tests/ok.bash

"${PYTHON:-python3}" tests/stdin/convert.py $recorded "$dir" || exit 1
capture() { "$mukca" capture --urdf data/demo/arm.urdf "$@"; }
rows() { grep -v '^#' "$1"; }
same() { # LINES SESSION OPTION...: the session of these lines is that one
    capture --stdin -o "$dir/lines.tsv" --force "${@:3}" <"$1" && diff <(rows "$dir/lines.tsv") <(rows "$2")
}
capture --lcm-url "file://$dir/still.lcmlog" --still -o "$dir/still.tsv" 2>"$dir/said" || cat "$dir/said"
ok "eight samples over LCM" test "$(rows "$dir/still.tsv" | wc -l)" -eq 9
ok "what ros2 topic echo printed" same $recorded "$dir/still.tsv" --still
ok "names in any order, nan" same "$dir/ros.csv" "$dir/still.tsv" --still
ok "empty velocities, efforts and frame" same "$dir/empty.csv" "$dir/still.tsv" --still
ok "CSV with a header" same "$dir/header.csv" "$dir/still.tsv" --still
ok "TSV with utime" same "$dir/header.tsv" "$dir/still.tsv" --still
ok "JSON lines with arrays, of a bridge too" same "$dir/arrays.json" "$dir/still.tsv" --still
ok "JSON lines with members" same "$dir/members.json" "$dir/still.tsv" --still
before=1700000101.0 # a clock that begins within the recording: times below 0, 0 and above
awk -F, -v OFS=, -v t=$before 'NR > 1 { $1 = sprintf("%.6f", $1 - t) } { print }' "$dir/header.csv" >"$dir/zero.csv"
capture --stdin --still -o "$dir/zero.tsv" <"$dir/zero.csv" >"$dir/said" 2>&1
ok "times below 0" diff <(rows "$dir/zero.tsv" | cut -f 1,2) <(rows "$dir/still.tsv" | cut -f 1,2)
ok "and the first sample is there" grep -q "^placement_1\s0\s-0.05" "$dir/zero.tsv"
ok "a pipe" bash -c "cat $recorded | '$mukca' capture --urdf data/demo/arm.urdf --stdin --still -o '$dir/pipe.tsv' 2>'$dir/said'"
ok "and it has the samples" test "$(rows "$dir/pipe.tsv" | wc -l)" -eq 9
ok "messages of the gripper alone are said" grep -q 'without all joints of the arm' "$dir/said"
ok "and lost messages" grep -q "standard input:41: no joint state: 'A message was lost!!!': ignored" "$dir/said"

# a recording of several placements, with rests elsewhere: by stillness, nobody presses n
"$mukca" simulate --urdf data/demo/arm.urdf --placements 3 --rows 4 --perturb 1,2 --seed 3 | grep -v '^#' |
    awk -v OFS='\t' '{ print } NR == 6 || NR == 9 { print "rest", 0, 0, 0, -NR / 12, 0, -1, 0, 1, 0 }' >"$dir/true.tsv"
awk -F'\t' -v OFS=, 'NR == 1 { $1 = "time_s"; for (j = 4; j <= NF; j++) $1 = $1 OFS $j; print $1; next }
    { for (i = 0; i < 30; i++) { line = sprintf("%.2f", 2 * NR + i / 20); for (j = 4; j <= NF; j++) line = line OFS $j; print line } }' \
    "$dir/true.tsv" >"$dir/placements.csv"
capture --stdin --still -o "$dir/placements.tsv" --placement p1,p2,p3 <"$dir/placements.csv" >"$dir/said" 2>&1
ok "placements of a recording, with rests among them" diff <(grep -v rest "$dir/true.tsv" | cut -f 1,2) <(rows "$dir/placements.tsv" | cut -f 1,2)

capture --lcm-url "file://$dir/triggers.lcmlog" --trigger -o "$dir/triggers.tsv" 2>"$dir/said" || cat "$dir/said"
ok "triggers over LCM" test "$(rows "$dir/triggers.tsv" | wc -l)" -eq 9
ok "triggers as lines" same "$dir/triggers.json" "$dir/triggers.tsv"
sed 's/"socket": *"\([0-9]*\)"/"socket": \1/' "$dir/triggers.json" >"$dir/numbers.json"
ok "sockets as numbers" same "$dir/numbers.json" "$dir/triggers.tsv"
long=$(printf 'h\303\266he %070d' 1)
sed "s/\"socket\": *\"1\"/\"Socket\": \"1\"/; 0,/\"socket\"/! s/\"placement\": *\"[^\"]*\"/\"placement\": \"$long\"/" \
    "$dir/triggers.json" >"$dir/misspelt.json"
capture --stdin -o "$dir/misspelt.tsv" <"$dir/misspelt.json" >"$dir/out" 2>"$dir/said"
ok "a misspelt member of a trigger" grep -q 'standard input:[0-9]*: Socket: a trigger has the members' "$dir/said"
ok "a label that is too long is not cut" grep -q "not recorded: \"h.*cannot be a name (1 to 63" "$dir/said"
ok "and neither is recorded" test "$(rows "$dir/misspelt.tsv" | wc -l)" -eq 2

sed 's/\("position": \[[^,]*,[^,]*,[^,]*, \)[^,]*/\10.5/; s/"placement": "[^"]*"/"placement": "front"/' "$dir/triggers.json" >"$dir/stuck.json"
capture --stdin -o "$dir/stuck.tsv" <"$dir/stuck.json" >"$dir/said" 2>&1
ok "a joint that did not move" grep -q '^Check *did not move: joint_3$' "$dir/said"
ok "and samples of a socket far apart" grep -q '^Check *the consistency error of a socket is [0-9]* mm, more' "$dir/said"

# the command that capture names next works, also for a session that is not finished
next_of() { sed -n 's/^Next    //p' "$dir/answer"; }
capture --stdin --still -o "$dir/more.tsv" --tip ball_link <"$dir/empty.csv" >"$dir/answer" 2>"$dir/said"
tail -n 1 "$dir/more.tsv" | awk -F'\t' -v OFS='\t' '{ $1 = "placement_2"; $3 += 9; $4 += 0.1; print }' >"$dir/last"
cat "$dir/last" >>"$dir/more.tsv"
next=$(next_of)
ok "next: calibrate, with the options that name the arm" grep -q -- '--tip ball_link' <<<"$next"
$mukca ${next#mukca } --force -o "$dir/offsets.tsv" >"$dir/answer" 2>"$dir/said"
ok "and it works: the unfinished placement is not used" grep -q "placement 'placement_2', socket .*; the placement is not used" "$dir/said"
awk -F'"' '/<link/ { name = "" } /<joint/ { name = $2 } /<origin/ && name { split($2 " " $4, at, " ")
    printf "%s: {x: %s, y: %s, z: %s, roll: %s, pitch: %s, yaw: %s}\n", name, at[1], at[2], at[3], at[4], at[5], at[6] }' \
    data/demo/arm.urdf >"$dir/factory.yaml"
capture --stdin --still -o "$dir/more.tsv" --force --kinematics "$dir/factory.yaml" --gravity 0,0,9.8 --distance 0.0501 \
    <"$dir/empty.csv" >"$dir/answer" 2>"$dir/said"
ok "the factory file, gravity and distance among them" grep -q -- \
    "--kinematics $dir/factory.yaml --gravity 0,0,9.8 --distance 0.0501 " <<<"$(next_of)"
head -n 100 "$dir/empty.csv" | capture --stdin --still -o "$dir/half.tsv" >"$dir/answer" 2>"$dir/said"
ok "one socket: recording goes on" grep -q '^Next    --resume continues: no placement has two sockets' "$dir/answer"
ok "and it works" capture --stdin --still --resume -o "$dir/half.tsv" <"$dir/empty.csv"
awk -F'\t' -v OFS='\t' '$1 !~ /^#/ && $1 != "placement" { $4 = 3.1 } { print }' "$dir/half.tsv" >"$dir/wide.tsv"
capture --stdin --still -o "$dir/wide.tsv" --resume <"$dir/empty.csv" >"$dir/answer" 2>"$dir/said"
ok "resumed with a note about its rows" grep -q "wide.tsv:[0-9]*: joint .* beyond its limits" "$dir/said"
ok "and goes on" grep -q "samples in" "$dir/answer"

# one clear line; recording goes on where there was a stream
bad() { # NAME CODE PATTERN TEXT OPTION...
    printf "$4" >"$dir/text"
    refuses "$1" "$2" "$3" capture --stdin --still -o "$dir/bad.tsv" --force "${@:5}" <"$dir/text"
}
bad "nothing" 4 'no joint state on standard input: does the program before it run' ''
bad "another language" 3 "standard input:1: no joint state: 'header:'; use ros2 topic echo --csv" 'header:\n  stamp:\n'
bad "cut message" 3 'standard input:1: neither a row under a header of names nor a whole message' \
    '12,0,base,joint_1,joint_2,0.1\n'
bad "row of another width" 3 'standard input:2: 2 columns, but 3 in the header' 'time_s,joint_1,joint_2\n1,2\n'
bad "other joints" 3 'names no joint "joint_1" (its first is "a")' 'time_s,a,b\n1,2,3\n'
bad "broken JSON" 3 'standard input:1: column [0-9]*: ' '{"position": [1, 2\n'
bad "JSON without positions" 3 'standard input:1: no joint state: "position" must be' '{"position": []}\n'
joints=joint_1,joint_2,joint_3,joint_4,joint_5,joint_6,joint_7
bad "text for an angle" 3 'joint_2 reads nan: no angle' "time_s,$joints\n1,0,x,0,0,0,0,0\n"
cp "$dir/still.tsv" "$dir/old.tsv"
ln -s old.tsv "$dir/link.tsv"
printf "time_s,$joints\n1,0,0,0,0,0,0,0\n" >"$dir/still.csv"
refuses "nothing recorded, --force" 1 '^0 samples; 1 joint states' capture --stdin --still -o "$dir/link.tsv" --force <"$dir/still.csv"
ok "and the old session stays" diff "$dir/still.tsv" "$dir/link.tsv"
refuses "standard input is not overwritten" 2 'is an input of this command' capture --stdin --still -o "$dir/still.csv" --force \
    <"$dir/still.csv"
rm -f "$dir/bad.tsv"
bad "degrees" 3 'joint_1 reads 90: no angle in rad; convert degrees' "time_s,$joints\n1,90,0,0,0,0,0,0\n"
ok "degrees: no file is left" test ! -e "$dir/bad.tsv"
bad "degrees under a header that says so" 1 'now    1.5708 rad' "time_s,joint_1 [deg],${joints#*,}\n1,90,0,0,0,0,0,0\n"
bad "degrees after a posture at zero" 1 'no sample was recorded' "time_s,$joints\n1,0,0,0,0,0,0,0\n2,90,0,0,0,0,0,0\n"
ok "degrees later on: no file is left, either" test ! -e "$dir/bad.tsv"
bad "no names" 2 'sends no joint names.*--map order' '{"time": 1, "position": [0, 0, 0, 0, 0, 0, 0]}\n'
bad "order confirmed" 1 'no sample was recorded' '{"time": 1, "position": [0, 0, 0, 0, 0, 0, 0]}\n' --map order
bad "names of a second arm" 1 'reading  1  left_joint_1  *->  joint_1 ' "time_s,left_${joints//,/,left_}\n1,0,0,0,0,0,0,0\n"
bad "an order that contradicts the names" 3 'contradicts the names: reading 1 of standard input is "joint_2", joint 1 of the arm is "joint_1"' \
    "time_s,joint_2,joint_1,${joints#*,*,}\n1,0,0,0,0,0,0,0\n" --map order
head -c 200000 /dev/zero | tr '\0' 1 >"$dir/text"
refuses "a line without an end" 3 'standard input:1: a line of more than 65536 bytes' capture --stdin --still -o "$dir/bad.tsv" <"$dir/text"
refuses "a log that is none" 3 'text: not a log of LCM messages' capture --lcm-url "file://$dir/text" --still -o "$dir/bad.tsv"
refuses "triggers beyond --rows" 0 '^1 sample in .*received, 0' capture --lcm-url "file://$dir/triggers.lcmlog" --trigger --rows 1 -o "$dir/bad.tsv"
rm -f "$dir/bad.tsv"
bad "LCM's options" 2 '--channel and --type belong to LCM' '' --channel X
printf "$joints\n0,0,0,0,0,0,0\n" >"$dir/timeless.csv"
refuses "a file without time stamps" 3 'standard input:2: no time stamp; a recorded stream needs one' \
    capture --stdin --still -o "$dir/bad.tsv" --force <"$dir/timeless.csv"
refuses "capture FILE is refused" 2 . capture states.csv -o "$dir/bad.tsv"
exit $failed
