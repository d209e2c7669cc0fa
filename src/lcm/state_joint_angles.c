/* bot_core.joint_angles_t: any robot, joints by name. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_joint_angles = {
    .description =
        "package bot_core; struct joint_angles_t {"
        " int64_t utime; string robot_name; int32_t num_joints;"
        " string joint_name[num_joints]; double joint_position[num_joints]; }",
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_NAME] = "joint_name",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position"},
};
