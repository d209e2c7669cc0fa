# Two models compared.
. "$here/fixture.sh"
sed 's/xyz="0.5 0 0"/xyz="0.502 0 0"/; s/name="small"/name="longer"/' arm.urdf >longer.urdf
sed 's/name="j3" type="revolute"/name="j3" type="fixed"/' arm.urdf >two.urdf
golden compare compare arm.urdf longer.urdf
run compare arm.urdf longer.urdf --json - --tip hand
expect "a longer link is 2 mm of axis distance at its joint alone" awk '
    /"joint": "j3"/ { j3 = distance } /"distance_m"/ { distance = $2 + 0; if (distance > 1e-9) n++ }
    /"distance_m"/ && distance > 1e-9 { d = distance }
    END { exit !(n == 1 && (d - 0.002) ^ 2 < 1e-18) }' "$scratch/out"
refuse 3 'has 3 joints .* has 2 ' compare arm.urdf two.urdf
refuse 3 'nix.urdf: cannot read' compare arm.urdf nix.urdf
refuse 2 'is an input of this command' compare arm.urdf longer.urdf --json arm.urdf --force
refuse 3 'no offsets table, or one of an older version' compare arm.urdf session.tsv
table_of arm.urdf 'j3\tx\tm\t0.5\t0.502\t0.002\t1e-5\t1\t-' >hand.tsv
accept "has no verdict" compare arm.urdf hand.tsv --urdf arm.urdf
expect "a table and the URDF that it makes are one model" sh -c "
    '$MUKCA' compare hand.tsv longer.urdf --urdf arm.urdf -q --json same.json &&
    awk '/\"max_m\"/ { n++; if (!(\$2 + 0 < 1e-12)) exit 1 } END { exit n != 2 }' same.json"
