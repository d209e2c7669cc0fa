# Masses for arms whose URDF has none.
sed '/<inertial>/,/<\/inertial>/d' "$root/data/gen3.urdf" >bare.urdf
sed 's/"\([a-z0-9_]*_link\)"/"left_\1"/g' bare.urdf >left.urdf
"$MUKCA" simulate --urdf bare.urdf -o session.tsv -q
accept "no link masses; data/inertials .* for --inertials$" diagnose --urdf bare.urdf session.tsv
answer 'Nothing beyond the geometry' diagnose --urdf "$root/data/gen3.urdf" session.tsv
expect "an arm with masses gets no such note" sh -c "! grep -q inertials '$scratch/err'"
for file in "$root"/data/inertials/*.tsv; do
    expect "$(basename "$file") names source and licence" grep -qE '^# source: .*(BSD|MIT|Apache)' "$file"
    awk -F '\t' 'BEGIN { print "<robot name=\"x\"><link name=\"base\"/>"; last = "base" }
        /^#/ || $1 == "link" { next }
        { printf "<link name=\"%s\"/><joint name=\"j_%s\" type=\"revolute\"><parent link=\"%s\"/><child link=\"%s\"/>", $1, $1, last, $1
          printf "<limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"1\"/></joint>\n"; last = $1 }
        END { print "</robot>" }' "$file" >chain.urdf
    accept 'masses, SHA' export -v --urdf chain.urdf --inertials "$file"
done
accept '7 joints, 7 masses' export -v --urdf left.urdf --inertials "$root/data/inertials/gen3.tsv" # a prefix does no harm
sed 's/left_base_link/left_forearm_link_2_forearm_link/' left.urdf >twice.urdf
refuse 3 "are both a 'forearm_link'; write whole names" fk --urdf twice.urdf --inertials "$root/data/inertials/gen3.tsv" /dev/null
