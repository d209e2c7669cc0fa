/* bot_core.joint_state_t: any robot, joints by name, with efforts. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_joint_state = {
    .description =
        "package bot_core; struct joint_state_t {"
        " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
        " float joint_position[num_joints]; float joint_velocity[num_joints];"
        " float joint_effort[num_joints]; }",
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_NAME] = "joint_name",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position",
             [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
             [MUKCA_LCM_ROLE_EFFORT] = "joint_effort"},
};
