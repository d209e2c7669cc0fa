/* drake.lcmt_panda_status: a Franka arm, by drake-franka-driver. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_panda_status = {
    .description =
        "package drake; struct lcmt_panda_status {"
        " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
        " double joint_position_desired[num_joints]; double joint_velocity[num_joints];"
        " double joint_velocity_desired[num_joints];"
        " double joint_acceleration_desired[num_joints]; double joint_torque[num_joints];"
        " double joint_torque_desired[num_joints]; double joint_torque_external[num_joints];"
        " double control_command_success_rate; int8_t robot_mode; int64_t robot_utime;"
        " int8_t control_mode; }",
    .guiding_mode = 3, /* franka::RobotMode::kGuiding */
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position",
             [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
             [MUKCA_LCM_ROLE_EFFORT] = "joint_torque",
             [MUKCA_LCM_ROLE_COMMAND] = "joint_position_desired",
             [MUKCA_LCM_ROLE_MODE] = "robot_mode"},
};
