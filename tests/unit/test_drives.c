/* Friction and armature of joints: the robot's own, and those of MuJoCo's default classes. */
#include "io/drives.h"

#include "arms.h"
#include "scratch.h"

static mukca_drives drives; /* of joints j1, j2 */

static void read_drives(const char *text)
{
    mukca_chain chain;
    make_chain(&chain, "RR", NULL, "j", 3);
    assert_ok(mukca_drives_read(&drives, scratch_file("model.xml", text), &chain, &error));
}

/* Joints of <transmission> and <ros2_control> have the same names, and no <dynamics>. */
TEST(joints_of_a_robot)
{
    read_drives(
        "<robot name='a'><joint name='j1' type='revolute'><dynamics damping='2' "
        "friction='3'/></joint><joint name='other'><dynamics damping='9'/></joint>"
        "<transmission><joint name='j1'><dynamics damping='8'/></joint></transmission>"
        "<ros2_control><joint name='j1'/></ros2_control></robot>");
    assert_close(drives.viscous[0], 2, 0);
    assert_close(drives.coulomb[0], 3, 0);
    assert_close(drives.viscous[1], 0, 0);
}

/* A door's hinge is none of the arm's; a class holds where it is named, or for a body's children,
 * and begins with the values of that around it. */
TEST(classes_of_a_model)
{
    read_drives(
        "<mujoco><default><joint armature='0.1' damping='1'/><default class='stiff'>"
        "<joint damping='5'/></default><default class='wheel'><joint damping='7'/>"
        "</default></default><worldbody><joint name='door' damping='50' frictionloss='20'/>"
        "<body childclass='stiff'><joint name='j1'/><body><joint class='wheel' name='free' "
        "frictionloss='4'/></body></body><body><joint name='j2' frictionloss='0.5'/></body>"
        "</worldbody></mujoco>");
    assert_close(drives.viscous[0], 5, 0);
    assert_close(drives.armature[0], 0.1, 0);
    assert_close(drives.coulomb[0], 0, 0);
    assert_close(drives.viscous[1], 1, 0);
    assert_close(drives.coulomb[1], 0.5, 0);
    read_drives("<mujoco></mujoco></mujoco></body><joint name='j1' damping='3'/></mujoco>");
}

TEST_MAIN(scratch_setup, scratch_teardown)
