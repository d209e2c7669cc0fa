/* drake.lcmt_iiwa_status: a KUKA iiwa, by drake-iiwa-driver. */
#include "lcm/state.h"

const mukca_lcm_state mukca_lcm_state_iiwa_status = {
    .description =
        "package drake; struct lcmt_iiwa_status {"
        " int64_t utime; int32_t num_joints; double joint_position_measured[num_joints];"
        " double joint_velocity_estimated[num_joints];"
        " double joint_position_commanded[num_joints]; double joint_position_ipo[num_joints];"
        " double joint_torque_measured[num_joints];"
        " double joint_torque_commanded[num_joints];"
        " double joint_torque_external[num_joints]; }",
    .effort_factor = -1, /* KUKA reports the load's torque on the joint */
    .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
             [MUKCA_LCM_ROLE_POSITION] = "joint_position_measured",
             [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity_estimated",
             [MUKCA_LCM_ROLE_EFFORT] = "joint_torque_measured",
             [MUKCA_LCM_ROLE_COMMAND] = "joint_position_commanded"},
};
