/* Roles of the fields of a type; the table of built-in types of joint states. */
#include <string.h>

#include "base/text.h"
#include "lcm/type.h"

static int find_field(const mukca_lcm_types *types, int t, const char *name, size_t length)
{
    for (int i = 0; i < types->type[t].n_fields; i++) {
        const char *field = types->field[types->type[t].first_field + i].name;
        if (strncmp(field, name, length) == 0 && field[length] == '\0') return i;
    }
    return -1;
}

/* Fail for an unknown field; the error lists the known ones. */
static mukca_status no_field(const mukca_lcm_types *types, int t, const char *name,
                             mukca_error *error)
{
    char fields[120] = "";
    mukca_text list = MUKCA_TEXT(fields);
    const mukca_lcm_type *type = &types->type[t];
    for (int i = 0; i < type->n_fields; i++)
        mukca_text_put(&list, " %s", types->field[type->first_field + i].name);
    return mukca_fail(error, MUKCA_INPUT, "%s has no field \"%.*s\"; its fields:%s", type->name,
                      (int)strcspn(name, "."), name, fields);
}

mukca_status mukca_lcm_type_set_role(mukca_lcm_types *types, int type, mukca_lcm_role role,
                                     const char *path, mukca_error *error)
{
    signed char found[MUKCA_LCM_MAX_DEPTH + 1];
    int t = type;
    for (int depth = 0; depth < MUKCA_LCM_MAX_DEPTH; depth++) {
        size_t length = strcspn(path, ".");
        int i = find_field(types, t, path, length);
        if (i < 0) return no_field(types, t, path, error);
        const mukca_lcm_field *field = &types->field[types->type[t].first_field + i];
        found[depth] = (signed char)i;
        if (path[length] == '.' && field->primitive == MUKCA_LCM_NESTED) {
            t = field->nested;
            path += length + 1;
            continue;
        }
        bool text = field->primitive == MUKCA_LCM_STRING;
        if (path[length] == '.' || field->primitive == MUKCA_LCM_NESTED ||
            text != (role == MUKCA_LCM_ROLE_NAME))
            return mukca_fail(
                error, MUKCA_INPUT, "field %s of %s is %s", field->name, types->type[t].name,
                field->primitive == MUKCA_LCM_NESTED ? "a struct: name a field of it, as in head.q"
                : text                               ? "a text, not a number"
                                                     : "a number, not a text or a struct");
        found[depth + 1] = -1;
        memcpy(types->type[type].role[role], found, (size_t)depth + 2);
        return MUKCA_OK;
    }
    return mukca_fail(error, MUKCA_INPUT, "a field more than %d structs deep", MUKCA_LCM_MAX_DEPTH);
}

/* ---- the table ---- */

typedef struct {
    const char *description; /* the struct, in the language of .lcm files */
    /* paths of the fields by role: time, names, positions, velocities, efforts, commands */
    const char *role[MUKCA_LCM_ROLES];
    double effort_factor; /* see mukca_lcm_type; 0: 1 */
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
             "joint_position_desired"},
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
#define STATE(name, type, channel, fingerprint) &(name),
    MUKCA_LCM_STATE_LIST(STATE)
#undef STATE
};

mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error)
{
    types->n_types = types->n_fields = 0;
    for (int i = 0; i < MUKCA_LCM_STATES; i++) {
        const mukca_lcm_state *state = states[i];
        MUKCA_TRY(mukca_lcm_types_parse(types, state->description, "the built-in table", error));
        for (int r = 0; r < MUKCA_LCM_ROLES; r++)
            if (state->role[r])
                MUKCA_TRY(
                    mukca_lcm_type_set_role(types, i, (mukca_lcm_role)r, state->role[r], error));
        if (state->effort_factor != 0) types->type[i].effort_factor = state->effort_factor;
    }
    return MUKCA_OK;
}
