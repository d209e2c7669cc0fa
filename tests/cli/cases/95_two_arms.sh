# Two arms at the same sockets, and a camera on the flange: frames.
arm="--urdf $root/data/demo/arm.urdf"
turn=-1.5707963267948966
place="--place a=0.5,0.1,0.1 --place b=0.5,-0.1,0.3 --place c=0.4,0,0.45"
# the right base stands at (0.2, -0.5, 0), turned by 90 degrees about z
seen="--place a=0.6,-0.3,0.1,0,0,$turn --place b=0.4,-0.3,0.3,0,0,$turn --place c=0.5,-0.2,0.45,0,0,$turn"
inside=0
for seed in 1 2 3 4 5; do
    "$MUKCA" simulate $arm $place --rows 8 --noise 1e-4 --seed $seed -q --force -o left.tsv
    "$MUKCA" simulate $arm $seen --rows 8 --noise 1e-4 --seed 9$seed -q --force -o right.tsv
    run align $arm left.tsv right.tsv --json align.json --force
    inside=$((inside + $(tr -d ' \n' <align.json | sed 's/[][{},:"]/ /g' | awk '
        function take(key, to, i) { for (i = 1; i <= NF; i++) if ($i == key) { to[1] = $(i + 1); to[2] = $(i + 2); to[3] = $(i + 3); return i } }
        { take("position_m", p); take("rpy_rad", r)
          for (i = 1; i <= NF; i++) if ($i == "width95") { for (k = 1; k <= 3; k++) w[k] = $(i + 1 + k); for (k = 1; k <= 3; k++) u[k] = $(i + 5 + k) }
          split("0.2 -0.5 0", t, " "); split("0 0 1.5707963267948966", s, " ")
          for (k = 1; k <= 3; k++) { n += (p[k] - t[k]) ^ 2 <= w[k] ^ 2; n += (r[k] - s[k]) ^ 2 <= 1.1 * u[1] ^ 2 + u[k] ^ 2
              if (!(w[k] < 1e-3 && u[k] < 1e-2)) n -= 99 } }
        END { print n }')))
done
# 30 numbers at 95 %: fewer than 26 have a probability of 0.2 %
expect "the pose of the right base lies in its intervals: $inside of 30" test "$inside" -ge 26
answer "^6 shared sockets" align $arm left.tsv right.tsv
"$MUKCA" simulate $arm --place other=0.5,0,0.2 --rows 4 -q -o other.tsv
refuse 3 "share no socket" align $arm left.tsv other.tsv
refuse 5 "the arms share 2 sockets; three are needed" align $arm other.tsv other.tsv
refuse 3 "nix.tsv" align $arm left.tsv nix.tsv
refuse 3 "two.urdf" align $arm --right-urdf two.urdf left.tsv right.tsv

# hand-eye: poses of a camera on the flange in the frame of a board
"$MUKCA" simulate $arm --poses 60 --noise 5e-5 --rotation-noise 1e-4 --seed 3 -q -o poses.tsv
run calibrate $arm poses.tsv --free-base --free-tool --json frames.json
expect "calibrate prints base and target" sh -c "tr '\n' ' ' <'$scratch/out' |
    grep -q 'Base    in the frame of the poses: xyz .* Target  in link .*: xyz .*quaternion'"
expect "and writes both frames as JSON" sh -c "tr -d ' \n' <frames.json | grep -q '\"frames\":{\"base\":{\"position_m\":.*\"target\":{\"position_m\":'"
run calibrate $arm "$root/data/demo/train.tsv" -q --json no_frames.json
expect "sockets have no frames" sh -c "tr -d ' \n' <no_frames.json | grep -q '\"frames\":{\"base\":null,\"target\":null}'"
