/* The built-in table of LCM message types, their fingerprints as lcm-gen computes them, and what
 * their fields mean. */
#include "lcm/type.h"

#include <string.h>

/* One struct each, in the language of .lcm files: the wire format is big-endian, the fingerprint
 * first, then the fields in order.  Drake's and bot_core's are public interfaces; the fields' names
 * and order make the fingerprint.  Ours are the same as in data/lcm. */
static const struct {
    const char *text;
    const char *channel;
    double effort_factor;
    const char *role[MUKCA_LCM_ROLES];
} builtin[MUKCA_LCM_BUILTIN_TYPES] = {
    [MUKCA_LCM_IIWA_STATUS] =
        {.text = "package drake; struct lcmt_iiwa_status { int64_t utime; int32_t num_joints;"
                 " double joint_position_measured[num_joints];"
                 " double joint_velocity_estimated[num_joints];"
                 " double joint_position_commanded[num_joints];"
                 " double joint_position_ipo[num_joints];"
                 " double joint_torque_measured[num_joints];"
                 " double joint_torque_commanded[num_joints];"
                 " double joint_torque_external[num_joints]; }",
         .channel = "IIWA_STATUS",
         .effort_factor = -1, /* KUKA reports what the load does to the joint */
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position_measured",
                  [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity_estimated",
                  [MUKCA_LCM_ROLE_EFFORT] = "joint_torque_measured",
                  [MUKCA_LCM_ROLE_COMMAND] = "joint_position_commanded"}},
    [MUKCA_LCM_PANDA_STATUS] =
        {.text =
             "package drake; struct lcmt_panda_status { int64_t utime; int32_t num_joints;"
             " double joint_position[num_joints]; double joint_position_desired[num_joints];"
             " double joint_velocity[num_joints]; double joint_velocity_desired[num_joints];"
             " double joint_acceleration_desired[num_joints]; double joint_torque[num_joints];"
             " double joint_torque_desired[num_joints]; double joint_torque_external[num_joints];"
             " double control_command_success_rate; int8_t robot_mode; int64_t robot_utime;"
             " int8_t control_mode; }",
         .channel = "PANDA_STATUS",
         .effort_factor = 1,
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                  [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                  [MUKCA_LCM_ROLE_EFFORT] = "joint_torque",
                  [MUKCA_LCM_ROLE_COMMAND] = "joint_position_desired",
                  [MUKCA_LCM_ROLE_MODE] = "robot_mode"}},
    [MUKCA_LCM_JACO_STATUS] =
        {.text = "package drake; struct lcmt_jaco_status { int64_t utime; int32_t num_joints;"
                 " double joint_position[num_joints]; double joint_velocity[num_joints];"
                 " double joint_torque[num_joints]; double joint_torque_external[num_joints];"
                 " double joint_current[num_joints]; int32_t num_fingers;"
                 " double finger_position[num_fingers]; double finger_velocity[num_fingers];"
                 " double finger_torque[num_fingers]; double finger_torque_external[num_fingers];"
                 " double finger_current[num_fingers]; }",
         .channel = "KINOVA_JACO_STATUS",
         .effort_factor = 1,
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                  [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                  [MUKCA_LCM_ROLE_EFFORT] = "joint_torque"}},
    [MUKCA_LCM_ROBOT_STATE] =
        {.text = "package drake; struct lcmt_robot_state { int64_t utime; int16_t num_joints;"
                 " string joint_name[num_joints]; float joint_position[num_joints]; }",
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_NAME] = "joint_name",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position"}},
    [MUKCA_LCM_JOINT_STATE] =
        {.text = "package bot_core; struct joint_state_t { int64_t utime; int16_t num_joints;"
                 " string joint_name[num_joints]; float joint_position[num_joints];"
                 " float joint_velocity[num_joints]; float joint_effort[num_joints]; }",
         .effort_factor = 1,
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_NAME] = "joint_name",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position",
                  [MUKCA_LCM_ROLE_VELOCITY] = "joint_velocity",
                  [MUKCA_LCM_ROLE_EFFORT] = "joint_effort"}},
    [MUKCA_LCM_JOINT_ANGLES] =
        {.text = "package bot_core; struct joint_angles_t { int64_t utime; string robot_name;"
                 " int32_t num_joints; string joint_name[num_joints];"
                 " double joint_position[num_joints]; }",
         .role = {[MUKCA_LCM_ROLE_TIME] = "utime",
                  [MUKCA_LCM_ROLE_NAME] = "joint_name",
                  [MUKCA_LCM_ROLE_POSITION] = "joint_position"}},
    [MUKCA_LCM_TRIGGER] = {.text = "package mukca; struct trigger { int64_t utime; int64_t id;"
                                   " string placement; string socket; }"},
    [MUKCA_LCM_COMMAND] = {.text = "package mukca; struct command { int64_t utime; int64_t id;"
                                   " string verb; int32_t n; string argument[n]; }"},
    [MUKCA_LCM_STATUS] = {.text = "package mukca; struct status { int64_t utime; string state;"
                                  " string text; string session; string placement; string socket;"
                                  " int32_t rows; int32_t rows_here; string channel; string type;"
                                  " string stream; double rate_hz; double age_s;"
                                  " int64_t received; int64_t refused; boolean still;"
                                  " double spread_m; double expected_m; boolean more_rows_help;"
                                  " int32_t n; string joint[n]; double position[n];"
                                  " double coverage[n]; }"},
    [MUKCA_LCM_SAMPLE] = {.text = "package mukca; struct sample { int64_t utime; int64_t id;"
                                  " boolean accepted; string text; string placement;"
                                  " string socket; int32_t row; int32_t n; string joint[n];"
                                  " double position[n]; double spread[n]; }"},
    [MUKCA_LCM_RESULT] = {.text = "package mukca; struct result { int64_t utime; int64_t id;"
                                  " string verb; int32_t code; string text; string robot;"
                                  " string urdf_sha256; string base; string tip; string stream;"
                                  " int32_t n; string joint[n]; string parameter[n];"
                                  " string unit[n]; double nominal[n]; double calibrated[n];"
                                  " double offset[n]; double sigma[n]; boolean identifiable[n];"
                                  " string json; }"},
    [MUKCA_LCM_POSE] = {.text = "package mukca; struct pose { int64_t utime; double position[3];"
                                " double quaternion[4]; }"},
};

mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error)
{
    types->n_types = types->n_fields = 0;
    for (int i = 0; i < MUKCA_LCM_BUILTIN_TYPES; i++) {
        mukca_status status = mukca_lcm_types_parse(types, builtin[i].text, strlen(builtin[i].text),
                                                    "the built-in table", error);
        for (int r = 0; r < MUKCA_LCM_ROLES && !status; r++)
            if (builtin[i].role[r])
                status =
                    mukca_lcm_type_set_role(types, i, (mukca_lcm_role)r, builtin[i].role[r], error);
        if (status) return status;
        types->type[i].channel = builtin[i].channel;
        types->type[i].effort_factor = builtin[i].effort_factor;
    }
    return MUKCA_OK;
}

/* ---- fingerprints: as lcm-gen's C backend computes them ---- */

static uint64_t hash_char(uint64_t hash, char c)
{
    /* lcm-gen shifts a signed number: the sign is drawn in */
    uint64_t high = hash >> 55 | (hash >> 63 ? ~(uint64_t)0 << 9 : 0);
    return (hash << 8 ^ high) + (uint64_t)(int64_t)c;
}

static uint64_t hash_text(uint64_t hash, const char *text)
{
    hash = hash_char(hash, (char)strlen(text));
    for (; *text; text++) hash = hash_char(hash, *text);
    return hash;
}

static const char *const primitive_name[] = {
#define PRIMITIVE_NAME(name, text, size) text,
    MUKCA_LCM_PRIMITIVE_LIST(PRIMITIVE_NAME)
#undef PRIMITIVE_NAME
};

/* Fingerprint of a type: its own fields' hash plus the fingerprints of the types nested in it, but
 * nothing for a type that contains itself, turned left by one bit. */
static uint64_t fingerprint(const mukca_lcm_types *types, int t, const int *parents, int depth,
                            int *budget)
{
    int chain[MUKCA_LCM_MAX_TYPES + 1];
    for (int i = 0; i < depth; i++)
        if ((chain[i] = parents[i]) == t) return 0;
    chain[depth] = t;
    const mukca_lcm_type *type = &types->type[t];
    uint64_t hash = 0x12345678, nested = 0;
    for (int i = 0; i < type->n_fields; i++) {
        const mukca_lcm_field *field = &types->field[type->first_field + i];
        if (--*budget < 0) return 0;
        hash = hash_text(hash, field->name);
        if (field->primitive != MUKCA_LCM_NESTED)
            hash = hash_text(hash, primitive_name[field->primitive]);
        else
            nested += fingerprint(types, field->nested, chain, depth + 1, budget);
        hash = hash_char(hash, (char)field->n_dimensions);
        for (int d = 0; d < field->n_dimensions; d++) {
            hash = hash_char(hash, field->dimension[d].field < 0 ? 0 : 1);
            hash = hash_text(hash, field->dimension[d].text);
        }
    }
    hash += nested;
    return hash << 1 | hash >> 63;
}

static int find_name(const mukca_lcm_types *types, const char *name)
{
    for (int t = types->n_types - 1; t >= 0; t--)
        if (strcmp(types->type[t].name, name) == 0) return t;
    return -1;
}

mukca_status mukca_lcm_types_link(mukca_lcm_types *types, int first, const char *file,
                                  mukca_error *error)
{
    for (int t = first; t < types->n_types; t++)
        for (int i = 0; i < types->type[t].n_fields; i++) {
            mukca_lcm_field *field = &types->field[types->type[t].first_field + i];
            if (field->primitive != MUKCA_LCM_NESTED) continue;
            field->nested = find_name(types, field->nested_name);
            if (field->nested < 0)
                return mukca_fail(error, MUKCA_INPUT,
                                  "%s: field %s of %s is a %s, which no --type file before or in "
                                  "this one describes: give its file first",
                                  file, field->name, types->type[t].name, field->nested_name);
        }
    for (int t = first; t < types->n_types; t++) {
        int budget = 100000;
        types->type[t].fingerprint = fingerprint(types, t, NULL, 0, &budget);
        if (budget < 0)
            return mukca_fail(error, MUKCA_INPUT, "%s: %s nests too many types", file,
                              types->type[t].name);
    }
    return MUKCA_OK;
}

int mukca_lcm_types_find(const mukca_lcm_types *types, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t hash = 0;
    if (size < 8) return -1;
    for (int i = 0; i < 8; i++) hash = hash << 8 | bytes[i];
    for (int t = types->n_types - 1; t >= 0; t--)
        if (types->type[t].fingerprint == hash) return t;
    return -1;
}

/* ---- roles ---- */

static int find_field(const mukca_lcm_types *types, int t, const char *name, size_t length)
{
    for (int i = 0; i < types->type[t].n_fields; i++) {
        const char *field = types->field[types->type[t].first_field + i].name;
        if (strncmp(field, name, length) == 0 && field[length] == '\0') return i;
    }
    return -1;
}

/* The fields of a type as one line of text, for messages. */
static void list_fields(char *text, size_t size, const mukca_lcm_types *types, int t)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < types->type[t].n_fields; i++) {
        const char *name = types->field[types->type[t].first_field + i].name;
        if (used + strlen(name) + 2 > size) return;
        if (i) text[used++] = ' ';
        memcpy(text + used, name, strlen(name) + 1);
        used += strlen(name);
    }
}

mukca_status mukca_lcm_type_set_role(mukca_lcm_types *types, int type, mukca_lcm_role role,
                                     const char *path, mukca_error *error)
{
    signed char found[MUKCA_LCM_MAX_DEPTH + 1];
    int t = type;
    for (int depth = 0; depth < MUKCA_LCM_MAX_DEPTH; depth++) {
        size_t length = strcspn(path, ".");
        int i = find_field(types, t, path, length);
        if (i < 0) {
            char names[120];
            list_fields(names, sizeof names, types, t);
            return mukca_fail(error, MUKCA_INPUT, "%s has no field \"%.*s\"; its fields: %s",
                              types->type[t].name, (int)(length < 60 ? length : 60), path, names);
        }
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
        if (types->type[type].effort_factor == 0) types->type[type].effort_factor = 1;
        return MUKCA_OK;
    }
    return mukca_fail(error, MUKCA_INPUT, "a field more than %d structs deep", MUKCA_LCM_MAX_DEPTH);
}
