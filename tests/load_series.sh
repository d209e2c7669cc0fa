#!/bin/bash
# Several pose logs in one diagnosis: a load series of a simulated arm, each load with a tracker's
# frame and a target of its own; the same in other row orders, and each half.
set -u
cd "$(dirname "$0")/.." || exit 1
effect=joint_compliance:joint_2=7.2e-5

. tests/ok.bash

simulate() { # FILE SEED OPTION...
    local file=$1 seed=$2
    shift 2
    "$mukca" simulate -q --urdf data/demo/arm.urdf --poses 150 --noise 2e-4 --seed "$seed" "$@" |
        grep -v '^#' >"$file"
}

# Another tracker (turned by ANGLE about z, 40 mm higher), and a target SHIFT m along the tip's x.
remount() { # ANGLE SHIFT <LOG: positions only
    awk -F'\t' -v OFS='\t' -v a="$1" -v s="$2" '
        NR == 1 { for (i = 1; i <= NF; i++) c[$i] = i }
        NR > 1 {
            w = $c["qw"]; x = $c["qx"]; y = $c["qy"]; z = $c["qz"]
            px = $c["x_m"] + s * (1 - 2 * (y * y + z * z))
            py = $c["y_m"] + s * 2 * (x * y + w * z)
            pz = $c["z_m"] + s * 2 * (x * z - w * y)
            $c["x_m"] = cos(a) * px - sin(a) * py
            $c["y_m"] = sin(a) * px + cos(a) * py
            $c["z_m"] = pz + 0.04
        }
        { NF = c["qw"] - 1; print }'
}

diagnose() { # LOG...: with free frames, as compact JSON
    "$mukca" diagnose -q --urdf data/demo/arm.urdf --free-base --free-tool --json - "$@" |
        tr -d ' \n'
}

leads() { # FILES...: is compliance of joint 2 the first cause, 60 to 85 urad/(N m)?
    local json name joint size
    json=$(diagnose "$@")
    read -r name joint size < <(sed 's/.*"causes":\[{"effect":"\([a-z_]*\)","joint":"\([a-z_0-9]*\)"[^[]*"amplitude":\([-0-9.e+]*\),.*/\1 \2 \3/' <<<"${json%%\},\{\"effect\"*}")
    echo "$name $joint $size"
    [ "$name $joint" = "joint_compliance joint_2" ] &&
        awk -v x="$size" 'BEGIN { exit !(x > 60e-6 && x < 85e-6) }'
}

simulate "$dir/none.tsv" 1 --payload 0 --effect "$effect" --perturb 0.5,2 --truth "$dir/truth.tsv"
i=0
for kg in 1 3 6; do
    i=$((i + 1))
    simulate "$dir/same_$kg.tsv" $((10 + i)) --offsets "$dir/truth.tsv" --payload $kg
    remount "0.0$i" "0.00$i" <"$dir/same_$kg.tsv" >"$dir/moved_$kg.tsv"
    ok "load of $kg kg: joint 2 leads" leads "$dir/moved_$kg.tsv"
done
remount 0 0 <"$dir/none.tsv" >"$dir/moved_0.tsv"
logs=("$dir/moved_0.tsv" "$dir/moved_1.tsv" "$dir/moved_3.tsv" "$dir/moved_6.tsv")

frames() { # BASE TOOL LOG...: which frames are each log's own
    local base=$1 tool=$2
    shift 2
    diagnose "$@" | grep -q "\"base_per_log\":$base,\"tool_per_log\":$tool"
}
alone() { # is the first cause without ties?
    diagnose "$@" | grep -q '"causes":\[{"effect":"joint_compliance","joint":"joint_2"[^}]*"ties":\[\]'
}
ok "load series: joint 2 leads" leads "${logs[@]}"
ok "load series: joint 2 alone" alone "${logs[@]}"
ok "load series: own frames" frames true true "${logs[@]}"
ok "load series: shared frames" frames false false "$dir/none.tsv" "$dir"/same_[136].tsv

# one file with all loads; the loads from --payload instead of the column
cp "$dir/moved_0.tsv" "$dir/bare_0.tsv"
for kg in 1 3 6; do cut -f 1-8,10- "$dir/moved_$kg.tsv" >"$dir/bare_$kg.tsv"; done # the ninth is payload_kg
{ sed -n '1s/$/\tpayload_kg/p' "$dir/bare_0.tsv"
  for kg in 0 1 3 6; do sed "1d;s/\$/\t$kg/" "$dir/bare_$kg.tsv"; done; } >"$dir/pool.tsv"
ok "one file with all loads" leads "$dir/pool.tsv"
ok "--payload of each file" leads --payload 0,1,3,6 "$dir"/bare_[0136].tsv
bad_payload() {
    "$mukca" diagnose --urdf data/demo/arm.urdf --payload "$1" "${logs[@]}" 2>"$dir/err"
    [ $? = 2 ] && grep -q -- '--payload' "$dir/err"
}
ok "--payload of some files" bad_payload 0,1,3
ok "--payload without a number" bad_payload x

# a held-out part of each log is predicted with the frames of its log
for kg in 0 1 3 6; do
    sed -n '1p;2,111p' "$dir/moved_$kg.tsv" >"$dir/train_$kg.tsv"
    sed -n '1p;112,$p' "$dir/moved_$kg.tsv" >"$dir/test_$kg.tsv"
done
held_out() {
    local mm
    mm=$(diagnose "$dir"/train_[0136].tsv --test "$dir"/test_[0136].tsv |
        sed 's/.*"test":{[^}]*"explained_m":\([0-9.e-]*\).*/\1/')
    echo "$mm"
    awk -v x="$mm" 'BEGIN { exit !(x > 0 && x < 0.6e-3) }'
}
ok "test logs have the frames of their training logs" held_out

# order and halves
reorder() { (sed 1q "$1"; sed 1d "$1" | awk -v s="$2" 'BEGIN { srand(s) } { print rand() "\t" $0 }' | sort -g | cut -f2-); }
for seed in 1 2; do
    reorder "$dir/moved_3.tsv" $seed >"$dir/order_$seed.tsv"
    ok "another row order ($seed)" leads "$dir/order_$seed.tsv"
done
awk 'NR == 1 || NR % 2 == 0' "$dir/moved_3.tsv" >"$dir/half_1.tsv"
awk 'NR == 1 || NR % 2 == 1' "$dir/moved_3.tsv" >"$dir/half_2.tsv"
ok "one half of the rows" leads "$dir/half_1.tsv"
ok "the other half" leads "$dir/half_2.tsv"
exit $failed
