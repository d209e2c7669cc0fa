# Two arms at the same sockets, and a camera on the flange: frames.
arm="--urdf $root/data/demo/arm.urdf"
turn=-1.5707963267948966
place="--place a=0.5,0.1,0.1 --place b=0.5,-0.1,0.3 --place c=0.4,0,0.45"
# the right base stands at (0.2, -0.5, 0), turned by 90 degrees about z
seen="--place a=0.6,-0.3,0.1,0,0,$turn --place b=0.4,-0.3,0.3,0,0,$turn --place c=0.5,-0.2,0.45,0,0,$turn"
"$MUKCA" simulate $arm $place --rows 8 --noise 1e-4 --seed 1 -q -o left.tsv
"$MUKCA" simulate $arm $seen --rows 8 --noise 1e-4 --seed 91 -q -o right.tsv
run align $arm left.tsv right.tsv --json align.json
expect "the pose of the right base" awk -v RS='[][{},: \n"]+' '
    /^(position_m|rpy_rad)$/ { getline a; getline b; getline c; p = $0 }
    p == "position_m" && (a - 0.2) ^ 2 + (b + 0.5) ^ 2 + c ^ 2 < 1e-6 { near = 1 }
    p == "rpy_rad" && a ^ 2 + b ^ 2 + (c - 1.5707963267948966) ^ 2 < 1e-5 { turned = 1 }
    END { exit !(near && turned) }' align.json
answer "^6 shared sockets" align $arm left.tsv right.tsv
"$MUKCA" simulate $arm --place other=0.5,0,0.2 --rows 4 -q -o other.tsv
refuse 3 "share no socket" align $arm left.tsv other.tsv
refuse 5 "the arms share 2 sockets; three are needed" align $arm other.tsv other.tsv
awk 'BEGIN { FS = OFS = "\t" } !/^[#p]/ || /^p[0-9]/ { $5 = 0.5 } 1' right.tsv >stands.tsv
refuse 1 "stands.tsv: the predictions of a socket scatter" align $arm left.tsv stands.tsv
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
