/* drake.lcmt_robot_state: any robot, joints by name. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_robot_state = {
    .description =
        "package drake; struct lcmt_robot_state {"
        " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
        " float joint_position[num_joints]; }",
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_NAME] = "joint_name",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position"},
};
