/* The table of built-in types of joint states. */

#include <string.h>

#include "lcm/type.h"

typedef struct {
    const char *description;           /* the struct, in the language of .lcm files */
    const char *role[MUKCA_LCM_ROLES]; /* path of the field of each role; NULL: none */
    double effort_factor;              /* see mukca_lcm_type; 0: 1 */
    int guiding_mode;                  /* value of the mode field while the arm is guided by hand */
} mukca_lcm_state;

static const mukca_lcm_state states[MUKCA_LCM_STATES] = {
    [MUKCA_LCM_STATE_iiwa_status] =
        {
            .description =
                "package drake; struct lcmt_iiwa_status {"
                " int64_t utime; int32_t num_joints; double joint_position_measured[num_joints];"
                " double joint_velocity_estimated[num_joints];"
                " double joint_position_commanded[num_joints]; double "
                "joint_position_ipo[num_joints];"
                " double joint_torque_measured[num_joints];"
                " double joint_torque_commanded[num_joints];"
                " double joint_torque_external[num_joints]; }",
            .effort_factor = -1, /* KUKA reports the load's torque on the joint */
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position_measured",
                     [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity_estimated",
                     [MUKCA_LCM_ROLE_EFFORT] = "joint_torque_measured",
                     [MUKCA_LCM_ROLE_COMMAND] = "joint_position_commanded"},
        },
    [MUKCA_LCM_STATE_panda_status] =
        {
            .description =
                "package drake; struct lcmt_panda_status {"
                " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
                " double joint_position_desired[num_joints]; double joint_velocity[num_joints];"
                " double joint_velocity_desired[num_joints];"
                " double joint_acceleration_desired[num_joints]; double joint_torque[num_joints];"
                " double joint_torque_desired[num_joints]; double "
                "joint_torque_external[num_joints];"
                " double control_command_success_rate; int8_t robot_mode; int64_t robot_utime;"
                " int8_t control_mode; }",
            .guiding_mode = 3, /* franka::RobotMode::kGuiding */
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                     [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                     [MUKCA_LCM_ROLE_EFFORT] = "joint_torque",
                     [MUKCA_LCM_ROLE_COMMAND] = "joint_position_desired",
                     [MUKCA_LCM_ROLE_MODE] = "robot_mode"},
        },
    [MUKCA_LCM_STATE_jaco_status] =
        {
            .description =
                "package drake; struct lcmt_jaco_status {"
                " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
                " double joint_velocity[num_joints]; double joint_torque[num_joints];"
                " double joint_torque_external[num_joints]; double joint_current[num_joints];"
                " int32_t num_fingers; double finger_position[num_fingers];"
                " double finger_velocity[num_fingers]; double finger_torque[num_fingers];"
                " double finger_torque_external[num_fingers]; double finger_current[num_fingers]; "
                "}",
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                     [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                     [MUKCA_LCM_ROLE_EFFORT] = "joint_torque"},
        },
    [MUKCA_LCM_STATE_robot_state] =
        {
            .description = "package drake; struct lcmt_robot_state {"
                           " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
                           " float joint_position[num_joints]; }",
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_NAME] = "joint_name",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position"},
        },
    [MUKCA_LCM_STATE_joint_state] =
        {
            .description = "package bot_core; struct joint_state_t {"
                           " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
                           " float joint_position[num_joints]; float joint_velocity[num_joints];"
                           " float joint_effort[num_joints]; }",
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_NAME] = "joint_name",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                     [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                     [MUKCA_LCM_ROLE_EFFORT] = "joint_effort"},
        },
    [MUKCA_LCM_STATE_joint_angles] =
        {
            .description = "package bot_core; struct joint_angles_t {"
                           " int64_t utime; string robot_name; int32_t num_joints;"
                           " string joint_name[num_joints]; double joint_position[num_joints]; }",
            .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                     [MUKCA_LCM_ROLE_NAME] = "joint_name",
                     [MUKCA_LCM_ROLE_POSITION] = "joint_position"},
        },
};

mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error)
{
    types->n_types = types->n_fields = 0;
    for (int i = 0; i < MUKCA_LCM_STATES; i++) {
        const mukca_lcm_state *state = &states[i];
        mukca_status status = mukca_lcm_types_parse(
            types, state->description, strlen(state->description), "the built-in table", error);
        for (int r = 0; r < MUKCA_LCM_ROLES && !status; r++)
            if (state->role[r])
                status =
                    mukca_lcm_type_set_role(types, i, (mukca_lcm_role)r, state->role[r], error);
        if (status != MUKCA_OK) return status;
        if (state->effort_factor != 0) types->type[i].effort_factor = state->effort_factor;
        types->type[i].guiding_mode = state->guiding_mode;
    }
    return MUKCA_OK;
}
