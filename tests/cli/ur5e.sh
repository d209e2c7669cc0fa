# A UR5e of the published DH table with Universal Robots' names, and a factory file; sourced by
# cases.  Makes ur5e.urdf and factory.yaml.
half=1.5707963267948966
joint() { # NAME PARENT CHILD TYPE XYZ RPY
    printf '  <link name="%s"/>\n  <joint name="%s" type="%s">\n    <parent link="%s"/><child link="%s"/>\n' \
        "$3" "$1" "$4" "$2" "$3"
    printf '    <origin xyz="%s" rpy="%s"/><axis xyz="0 0 1"/>\n' "$5" "$6"
    printf '    <limit lower="-3" upper="3" effort="150" velocity="3"/>\n  </joint>\n'
}
{
    echo '<robot name="ur5e">'
    echo '  <link name="base_link"/>'
    joint base_link-base_link_inertia base_link base_link_inertia fixed '0 0 0' '0 0 0'
    joint shoulder_pan_joint base_link_inertia shoulder_link revolute '0 0 0.1625' '0 0 0'
    joint shoulder_lift_joint shoulder_link upper_arm_link revolute '0 0 0' "$half 0 0"
    joint elbow_joint upper_arm_link forearm_link revolute '-0.425 0 0' '0 0 0'
    joint wrist_1_joint forearm_link wrist_1_link revolute '-0.3922 0 0.1333' '0 0 0'
    joint wrist_2_joint wrist_1_link wrist_2_link revolute '0 -0.0997 0' "$half 0 0"
    joint wrist_3_joint wrist_2_link wrist_3_link revolute '0 0.0996 0' "$half 3.141592653589793 3.141592653589793"
    joint ball wrist_3_link ball_link fixed '0.03 0.01 0.08' '0 0 0'
    echo '</robot>'
} >ur5e.urdf
entry() { # NAME X Y Z ROLL PITCH YAW
    printf '  %s:\n    x: %s\n    y: %s\n    z: %s\n    roll: %s\n    pitch: %s\n    yaw: %s\n' "$@"
}
{
    echo 'kinematics:'
    entry shoulder 0 0 0.16246016649196839 -0 0 -1.17e-04
    entry upper_arm 0.00013693066835674709 0 0 1.5705887548757873 0 1.029e-04
    entry forearm -0.42542032535287599 0 0 0.00086180224484494103 0.0021886127482178132 -1.979e-05
    entry wrist_1 -0.39260562769873419 -7.2989153671478886e-06 0.13388369108414155 5.4516836971052413e-05 -0.001205676433986502 -3.556e-05
    entry wrist_2 9.1961927830986801e-05 -0.099676956423467064 0.00014115972125381174 1.5693801556761988 0 1.1516874805772574e-06
    entry wrist_3 4.2288555675900251e-05 0.099577471762275743 7.9056043482053824e-05 1.5715902415777612 3.1415926535897931 -3.1415926244038093
    echo '  hash: calib_12345678901234567890'
} >factory.yaml
