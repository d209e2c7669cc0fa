/* The table of built-in types of joint states. */
#include <string.h>

#include "lcm/type.h"

typedef struct {
    const char *description; /* the struct, in the language of .lcm files */
    /* paths of the fields by role: time, names, positions, velocities, efforts, commands, mode */
    const char *role[MUKCA_LCM_ROLES];
    double effort_factor; /* see mukca_lcm_type; 0: 1 */
    int guiding_mode;     /* value of the mode field while the arm is guided by hand */
} mukca_lcm_state;

static const mukca_lcm_state iiwa_status = {
    .description =
        "package drake; struct lcmt_iiwa_status {"
        " int64_t utime; int32_t num_joints; double joint_position_measured[num_joints];"
        " double joint_velocity_estimated[num_joints]; double joint_position_commanded[num_joints];"
        " double joint_position_ipo[num_joints]; double joint_torque_measured[num_joints];"
        " double joint_torque_commanded[num_joints]; double joint_torque_external[num_joints]; }",
    .role = {"utime", NULL, "joint_position_measured", "joint_velocity_estimated",
             "joint_torque_measured", "joint_position_commanded"},
    .effort_factor = -1, /* KUKA reports the load's torque on the joint */
};

static const mukca_lcm_state panda_status = {
    .description =
        "package drake; struct lcmt_panda_status {"
        " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
        " double joint_position_desired[num_joints]; double joint_velocity[num_joints];"
        " double joint_velocity_desired[num_joints]; double joint_acceleration_desired[num_joints];"
        " double joint_torque[num_joints]; double joint_torque_desired[num_joints];"
        " double joint_torque_external[num_joints]; double control_command_success_rate;"
        " int8_t robot_mode; int64_t robot_utime; int8_t control_mode; }",
    .role = {"utime", NULL, "joint_position", "joint_velocity", "joint_torque",
             "joint_position_desired", "robot_mode"},
    .guiding_mode = 3, /* franka::RobotMode::kGuiding */
};

static const mukca_lcm_state jaco_status = {
    .description =
        "package drake; struct lcmt_jaco_status {"
        " int64_t utime; int32_t num_joints; double joint_position[num_joints];"
        " double joint_velocity[num_joints]; double joint_torque[num_joints];"
        " double joint_torque_external[num_joints]; double joint_current[num_joints];"
        " int32_t num_fingers; double finger_position[num_fingers];"
        " double finger_velocity[num_fingers]; double finger_torque[num_fingers];"
        " double finger_torque_external[num_fingers]; double finger_current[num_fingers]; }",
    .role = {"utime", NULL, "joint_position", "joint_velocity", "joint_torque"},
};

static const mukca_lcm_state robot_state = {
    .description =
        "package drake; struct lcmt_robot_state {"
        " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
        " float joint_position[num_joints]; }",
    .role = {"utime", "joint_name", "joint_position"},
};

static const mukca_lcm_state joint_state = {
    .description =
        "package bot_core; struct joint_state_t {"
        " int64_t utime; int16_t num_joints; string joint_name[num_joints];"
        " float joint_position[num_joints]; float joint_velocity[num_joints];"
        " float joint_effort[num_joints]; }",
    .role = {"utime", "joint_name", "joint_position", "joint_velocity", "joint_effort"},
};

static const mukca_lcm_state joint_angles = {
    .description =
        "package bot_core; struct joint_angles_t {"
        " int64_t utime; string robot_name; int32_t num_joints; string joint_name[num_joints];"
        " double joint_position[num_joints]; }",
    .role = {"utime", "joint_name", "joint_position"},
};

static const mukca_lcm_state *const states[MUKCA_LCM_STATES] = {
#define STATE(name, type, channel, fingerprint) &name,
    MUKCA_LCM_STATE_LIST(STATE)
#undef STATE
};

mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error)
{
    types->n_types = types->n_fields = 0;
    for (int i = 0; i < MUKCA_LCM_STATES; i++) {
        const mukca_lcm_state *state = states[i];
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
