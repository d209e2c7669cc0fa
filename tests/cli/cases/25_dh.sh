# Denavit-Hartenberg tables: out, back as a URDF by tools/dh_to_urdf.py, the same tip.
. "$here/fixture.sh"
dh="$root/tools/dh_to_urdf.py"
rows 1 50 >fifty.csv
"$MUKCA" fk --urdf arm.urdf --pose fifty.csv >nominal.tsv
same() { # NAME: the arm of back.urdf is that of arm.urdf
    "$MUKCA" fk --urdf back.urdf --pose fifty.csv >back.tsv
    expect "$1" near 1e-9 7 nominal.tsv back.tsv
}
for format in dh mdh; do
    "$MUKCA" export --urdf arm.urdf -o "arm.$format"
    "${PYTHON:-python3}" "$dh" "arm.$format" >back.urdf
    same "export -f $format, read back, is the same arm"
done
sed -e 's/_m\>//; s/_rad\>//; s/_m\>//; s/_rad\>//' arm.dh | awk -F '\t' -v OFS='\t' '!/^#/ && $1 != "joint" {
    $3 *= 1000; $5 *= 1000; for (i = 4; i <= 8; i += i == 4 || i == 6 ? 2 : 1) if ($i != "") $i *= 45 / atan2(1, 1) }
    { print }' CONVFMT=%.17g OFMT=%.17g >degrees.dh
"${PYTHON:-python3}" "$dh" degrees.dh --units deg,mm >back.urdf
same "degrees and millimetres"

printf 'joint,a,alpha,d,theta\nj1,0.1,pi/2,0.2,-3*pi/4\nj2,0,-pi/4,0,0\n' >pi.csv
printf 'joint,a,alpha,d,theta\nj1,0.1,1.5707963267948966,0.2,-2.356194490192345\nj2,0,-0.7853981633974483,0,0\n' >numbers.csv
printf '\357\273\277joint;a;alpha;d;theta\r\nj1;100,0;90;200;-135\r\nj2;0;-45;0;0\r\n' >sheet.csv
for table in pi numbers; do
    "${PYTHON:-python3}" "$dh" $table.csv >$table.urdf
    echo 0.1,0.2 | "$MUKCA" fk --urdf $table.urdf --pose >$table.txt
done
expect "multiples of pi" equal pi.txt numbers.txt
"${PYTHON:-python3}" "$dh" sheet.csv --units deg,mm >sheet.urdf
echo 0.1,0.2 | "$MUKCA" fk --urdf sheet.urdf --pose >sheet.txt
expect "a spreadsheet with decimal commas" equal sheet.txt numbers.txt
