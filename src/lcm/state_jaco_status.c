/* drake.lcmt_jaco_status: a Kinova Jaco. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_jaco_status = {
    .description =
        "package drake; struct lcmt_jaco_status {"
        " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
        " double joint_velocity[num_joints]; double joint_torque[num_joints];"
        " double joint_torque_external[num_joints]; double joint_current[num_joints];"
        " int32_t num_fingers; double finger_position[num_fingers];"
        " double finger_velocity[num_fingers]; double finger_torque[num_fingers];"
        " double finger_torque_external[num_fingers]; double finger_current[num_fingers]; }",
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position",
             [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
             [MUKCA_LCM_ROLE_EFFORT] = "joint_torque"},
};
