/* LCM message types: fields, fingerprints, roles of fields.
 *
 * Every type is described in the .lcm language, both the built-in ones (state.c) and those of
 * `--type FILE.lcm`. */
#ifndef MUKCA_LCM_TYPE_H
#define MUKCA_LCM_TYPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mukca/chain.h"
#include "mukca/status.h"

/* The primitives of .lcm files: name, bytes on the wire (0: variable). */
#define MUKCA_LCM_PRIMITIVE_LIST(X) \
    X(INT8, "int8_t", 1)            \
    X(INT16, "int16_t", 2)          \
    X(INT32, "int32_t", 4)          \
    X(INT64, "int64_t", 8)          \
    X(BYTE, "byte", 1)              \
    X(BOOLEAN, "boolean", 1)        \
    X(FLOAT, "float", 4)            \
    X(DOUBLE, "double", 8)          \
    X(STRING, "string", 0)

typedef enum {
#define MUKCA_LCM_PRIMITIVE_ENUM(name, text, size) MUKCA_LCM_##name,
    MUKCA_LCM_PRIMITIVE_LIST(MUKCA_LCM_PRIMITIVE_ENUM)
#undef MUKCA_LCM_PRIMITIVE_ENUM
        MUKCA_LCM_NESTED
} mukca_lcm_primitive;

/* Name and size of each primitive. */
extern const char *const mukca_lcm_primitive_names[MUKCA_LCM_NESTED];
extern const unsigned char mukca_lcm_primitive_sizes[MUKCA_LCM_NESTED];

/* Roles of message fields. */
typedef enum {
    MUKCA_LCM_ROLE_TIME,
    MUKCA_LCM_ROLE_NAME,
    MUKCA_LCM_ROLE_POSITION,
    MUKCA_LCM_ROLE_VELOCITY,
    MUKCA_LCM_ROLE_EFFORT,
    MUKCA_LCM_ROLE_COMMAND,
    MUKCA_LCM_ROLES
} mukca_lcm_role;

enum { /* several times the requirements of public robot descriptions */
       MUKCA_LCM_MAX_TYPES = 48,
       MUKCA_LCM_MAX_FIELDS = 768, /* of all types */
       MUKCA_LCM_MAX_TYPE_FIELDS = 64,
       MUKCA_LCM_MAX_DIMENSIONS = 3,
       MUKCA_LCM_MAX_DEPTH = 8, /* of nesting */
       MUKCA_LCM_MAX_JOINTS = 64,
       MUKCA_LCM_NAME_SIZE = 96
};

typedef struct {
    char text[32]; /* as written: a number, or the name of a preceding integer field */
    int field;     /* index of that field in the type, -1: constant */
    int count;     /* value of a constant */
} mukca_lcm_dimension;

typedef struct {
    char name[MUKCA_NAME_SIZE];
    mukca_lcm_primitive primitive;
    char nested_name[MUKCA_LCM_NAME_SIZE]; /* of a NESTED field */
    int nested;                            /* index of its type */
    int n_dimensions;
    mukca_lcm_dimension dimension[MUKCA_LCM_MAX_DIMENSIONS];
} mukca_lcm_field;

typedef struct {
    char name[MUKCA_LCM_NAME_SIZE]; /* "package.name" */
    int first_field, n_fields;
    uint64_t fingerprint;
    /* path of field indices for each role, ended by -1; [0] = -1: none */
    signed char role[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_DEPTH + 1];
    double effort_factor; /* ratio of the torque that holds the arm to the message's torque */
} mukca_lcm_type;

typedef struct {
    int n_types, n_fields;
    mukca_lcm_type type[MUKCA_LCM_MAX_TYPES];
    mukca_lcm_field field[MUKCA_LCM_MAX_FIELDS];
} mukca_lcm_types;

/* Assign a role to a field; `path` as in "head.q".  Errors: MUKCA_INPUT (no such field; a text
 * instead of a number or vice versa). */
mukca_status mukca_lcm_type_set_role(mukca_lcm_types *types, int type, mukca_lcm_role role,
                                     const char *path, mukca_error *error);

/* Index of the type "package.name", -1: unknown.  Later types take precedence. */
int mukca_lcm_types_find_name(const mukca_lcm_types *types, const char *name);

/* Whether messages of that type contain joint positions. */
static inline bool mukca_lcm_type_has_joints(const mukca_lcm_types *types, int type)
{
    return type >= 0 && types->type[type].role[MUKCA_LCM_ROLE_POSITION][0] >= 0;
}

/* ---- descriptions (description.c) ---- */

/* Add the structs of one .lcm description, all or none; `file` is used in messages.
 * Errors: MUKCA_INPUT with file, line and column (syntax; enum; a nested type without description;
 * too many types or fields). */
mukca_status mukca_lcm_types_parse(mukca_lcm_types *types, const char *text, const char *file,
                                   mukca_error *error);

/* The same from a file. */
mukca_status mukca_lcm_types_read(mukca_lcm_types *types, const char *path, mukca_error *error);

/* ---- messages (decode.c) ---- */

/* Decoded joint states of one message. */
typedef struct {
    int64_t time; /* us, by the sender's clock; 0: the type has no time */
    int n;        /* number of joints */
    bool has[MUKCA_LCM_ROLES];
    const char *name[MUKCA_LCM_MAX_JOINTS]; /* points into the message */
    /* rad, rad/s, N m, rad; by role */
    double value[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_JOINTS];
} mukca_lcm_joints;

/* Index of the type of message data[size] by its fingerprint, -1: unknown.  Later types take
 * precedence. */
int mukca_lcm_types_find(const mukca_lcm_types *types, const void *data, size_t size);

/* Decode a message of type `type` from data[size].  Reads within data only, in time linear in
 * `size`, without allocation.  Errors: MUKCA_INPUT (truncated, excess bytes, counts that exceed the
 * message or 64 joints, unequal lengths, positions that are not finite). */
mukca_status mukca_lcm_decode_joints(mukca_lcm_joints *joints, const mukca_lcm_types *types,
                                     int type, const void *data, size_t size, mukca_error *error);

/* ---- built-in LCM types of joint states: one row here and one entry in state.c each ---- */

/* name, type, usual channel (for help), fingerprint by lcm-gen 1.3.1 (for tests) */
#define MUKCA_LCM_STATE_LIST(X)                                                        \
    X(iiwa_status, "drake.lcmt_iiwa_status", "IIWA_STATUS", 0xf16fb804284abca3)        \
    X(panda_status, "drake.lcmt_panda_status", "PANDA_STATUS", 0x19571cdf4d82fae6)     \
    X(jaco_status, "drake.lcmt_jaco_status", "KINOVA_JACO_STATUS", 0x9bc39ecbb8de40c8) \
    X(robot_state, "drake.lcmt_robot_state", "any channel", 0x84cfb1722d58bd59)        \
    X(joint_state, "bot_core.joint_state_t", "any channel", 0x3e377b4cebc593a4)        \
    X(joint_angles, "bot_core.joint_angles_t", "any channel", 0x3e7cd307b8f9e790)

/* Indices of the rows; types from MUKCA_LCM_STATES on are the user's. */
enum {
#define MUKCA_LCM_STATE_INDEX(name, type, channel, fingerprint) MUKCA_LCM_STATE_##name,
    MUKCA_LCM_STATE_LIST(MUKCA_LCM_STATE_INDEX)
#undef MUKCA_LCM_STATE_INDEX
        MUKCA_LCM_STATES
};

/* Initialise `types` with the rows in their order.  Errors: none for a consistent table
 * (tested). */
mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error);

#endif
