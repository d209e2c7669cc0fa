# A small arm and good data for it; sourced by cases.  Makes arm.urdf, good/ and session.tsv.

cat >arm.urdf <<'URDF'
<?xml version="1.0"?>
<robot name="small">
  <!-- three joints and a ball -->
  <link name="base"/>
  <link name="upper"/>
  <link name="fore"/>
  <link name="hand"/>
  <link name="ball"/>
  <joint name="j1" type="revolute">
    <origin xyz="0 0 0.25" rpy="0 0 0"/>
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="9" velocity="2"/>
  </joint>
  <joint name="j2" type="revolute">
    <parent link="upper"/><child link="fore"/>
    <axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="9" velocity="2"/>
  </joint>
  <joint name="j3" type="revolute">
    <origin xyz="0.5 0 0" rpy="0 0 0"/>
    <parent link="fore"/><child link="hand"/>
    <axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="9" velocity="2"/>
  </joint>
  <joint name="tool" type="fixed">
    <origin xyz="0.25 0 0.125"/>
    <parent link="hand"/><child link="ball"/>
  </joint>
</robot>
URDF

# rows FIRST COUNT: joint angles that mean nothing in particular
rows() {
    awk -v first="$1" -v count="$2" 'BEGIN { for (i = first; i < first + count; i++)
        printf "%.6f,%.6f,%.6f\n", 0.3 * sin(1.3 * i), 0.4 * cos(2.1 * i), 0.9 + 0.3 * sin(0.7 * i) }'
}
mkdir good
rows 1 12 >good/hole_0.csv
rows 20 12 >good/hole_1.csv
{
    printf 'placement\tsocket\tj1\tj2\tj3\n'
    rows 1 12 | awk -F, '{ printf "p\t%d\t%s\t%s\t%s\n", NR % 2, $1, $2, $3 }'
} >session.tsv
