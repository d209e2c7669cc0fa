# Denavit-Hartenberg tables: out, back as a URDF, the same tip.
. "$here/fixture.sh"
rows 1 50 >fifty.csv
"$MUKCA" fk --urdf arm.urdf --pose fifty.csv >nominal.tsv
for format in dh mdh; do
    "$MUKCA" export --urdf arm.urdf -o "arm.$format"
    run urdf --dh "arm.$format" -o "$format.urdf"
    expect "urdf writes a URDF of the table" test -s "$format.urdf"
    "$MUKCA" fk --urdf "$format.urdf" --pose fifty.csv >back.tsv
    paste nominal.tsv back.tsv >both.tsv
    expect "export -f $format, read back by urdf --dh, is the same arm" awk '
        NR > 1 { for (i = 1; i <= 7; i++) { d = $i - $(i + 7); if (!(d * d <= 1e-18)) exit 1 } }
        END { if (NR != 51) exit 1 }' both.tsv
done
refuse 2 'declares a modified table' urdf --dh arm.mdh --convention standard
refuse 2 'dh FILE is needed' urdf
refuse 2 'arm.dh is an input of this command' urdf --dh arm.dh -o arm.dh --force

sed -e 's/_m\>//; s/_rad\>//; s/_m\>//; s/_rad\>//' arm.dh | awk -F '\t' -v OFS='\t' '!/^#/ && $1 != "joint" {
    $3 *= 1000; $5 *= 1000; for (i = 4; i <= 8; i += i == 4 || i == 6 ? 2 : 1) if ($i != "") $i *= 45 / atan2(1, 1) }
    { print }' CONVFMT=%.17g OFMT=%.17g >degrees.dh
"$MUKCA" urdf --dh degrees.dh --units deg,mm -o degrees.urdf
"$MUKCA" fk --urdf degrees.urdf --pose fifty.csv >back.tsv
paste nominal.tsv back.tsv >both.tsv
expect "urdf --dh reads degrees and millimetres" awk '
    NR > 1 { for (i = 1; i <= 7; i++) { d = $i - $(i + 7); if (!(d * d <= 1e-18)) exit 1 } }
    END { if (NR != 51) exit 1 }' both.tsv

# a file's name that is no UTF-8, or long
for odd in "x$(printf 'é%.0s' $(seq 40))" "$(printf '\374n')"; do
    printf 'joint\ta\talpha\td\ttheta\nj1\t0.1\t0\t0.2\t0\n' >"$odd.tsv"
    "$MUKCA" urdf -q --dh "$odd.tsv" -o odd.urdf --force
    run export --urdf odd.urdf -f dh
    expect "a robot called after its file, whatever that is called" test $code -eq 0
done

printf 'joint,a,alpha [deg],d [mm],theta\nj1,0.1,pi/2,200,-3*pi/4\nj2,0,-45,0,0\n' >pi.csv
printf 'joint,a,alpha,d,theta\nj1,0.1,1.5707963267948966,0.2,-2.356194490192345\nj2,0,-0.7853981633974483,0,0\n' >numbers.csv
for table in pi numbers; do
    "$MUKCA" urdf -q --dh $table.csv -o $table.urdf
    echo 0.1,0.2 | "$MUKCA" fk --urdf $table.urdf --pose >$table.txt
done
expect "multiples of pi, and units in the header" cmp pi.txt numbers.txt

# bad tables: one line each
table() { printf "joint\ta\talpha\td\ttheta$1\n$2" >bad.tsv; }
wrong() { # COLUMNS ROWS PATTERN
    table "$1" "$2"
    refuse 3 "$3" urdf --dh bad.tsv
}
wrong '' 'j1\t0\t1.5\t0.2\t0\nj1\t0\t0\t0\t0\n' "bad.tsv:3: column 'joint': joint 'j1' has a row already"
wrong '' 'j1\t0\t90\t0.2\t0\n' "bad.tsv:2: column 'alpha': 90 is out of range; lengths are in m, angles in rad, or see --units"
table '' 'j1\t-425\t0\t162.5\t0\n'
refuse 3 "bad.tsv:2: column 'a': -425 is out of range; lengths are in m" urdf --dh bad.tsv --units deg
wrong '' 'j1\t0\tx\t0.2\t0\n' "bad.tsv:2: column 'alpha'"
wrong '\ttype' 'j1\t0\t0\t0.2\t0\tball\n' "bad.tsv:2: column 'type': unknown type"
wrong '\ttype' 'j1\t0\t0\t0.2\t0\tfixed\n' 'bad.tsv: no joint moves'
wrong '\tlower\tupper' 'j1\t0\t0\t0.2\t0\t1\t-1\n' "bad.tsv:2: column 'upper': is not above the lower limit"
wrong '\tbeta' 'j1\t0\t0\t0.2\t0\t0\n' "bad.tsv:1: column 'beta': unknown column"
printf 'joint\ta\talpha\td\nj1\t0\t0\t0\n' >bad.tsv
refuse 3 "bad.tsv:1: the header has no column 'theta'" urdf --dh bad.tsv
refuse 3 'nix.tsv: cannot read' urdf --dh nix.tsv
table '' 'j1\t0\t1.5\t0.2\t0\n'
accept 'taken for a standard one' urdf --dh bad.tsv
