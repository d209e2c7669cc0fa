/* LCM message types: the built-in table, types read from .lcm descriptions, their fingerprints, and
 * the bounded decoder that both drive.
 *
 * One table (lcm_type.c) describes every message that carries joints, and our own; each entry is
 * written in the language of .lcm files and read by the same parser as `--type FILE.lcm`.
 */
#ifndef MUKCA_LCM_TYPE_H
#define MUKCA_LCM_TYPE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mukca/chain.h"
#include "mukca/status.h"

/* The primitives of .lcm files: name, bytes on the wire (0: varies). */
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

/* What a field of a message means to us; name as in `--position FIELD` and the like. */
#define MUKCA_LCM_ROLE_LIST(X) \
    X(TIME, "time")            \
    X(NAME, "name")            \
    X(POSITION, "position")    \
    X(VELOCITY, "velocity")    \
    X(EFFORT, "effort")        \
    X(COMMAND, "command")      \
    X(MODE, "mode")

typedef enum {
#define MUKCA_LCM_ROLE_ENUM(name, text) MUKCA_LCM_ROLE_##name,
    MUKCA_LCM_ROLE_LIST(MUKCA_LCM_ROLE_ENUM)
#undef MUKCA_LCM_ROLE_ENUM
        MUKCA_LCM_ROLES
} mukca_lcm_role;

/* Entries of the built-in table. */
typedef enum {
    MUKCA_LCM_IIWA_STATUS,
    MUKCA_LCM_PANDA_STATUS,
    MUKCA_LCM_JACO_STATUS,
    MUKCA_LCM_ROBOT_STATE,
    MUKCA_LCM_JOINT_STATE,
    MUKCA_LCM_JOINT_ANGLES,
    MUKCA_LCM_TRIGGER, /* ours, from here on: lcm_message.h */
    MUKCA_LCM_COMMAND,
    MUKCA_LCM_STATUS,
    MUKCA_LCM_SAMPLE,
    MUKCA_LCM_RESULT,
    MUKCA_LCM_POSE,
    MUKCA_LCM_BUILTIN_TYPES
} mukca_lcm_builtin;

enum {
    MUKCA_LCM_MAX_TYPES = 48,
    MUKCA_LCM_MAX_FIELDS = 768, /* of all types together */
    MUKCA_LCM_MAX_TYPE_FIELDS = 64,
    MUKCA_LCM_MAX_DIMENSIONS = 3,
    MUKCA_LCM_MAX_DEPTH = 8, /* of nested types */
    MUKCA_LCM_MAX_JOINTS = 64,
    MUKCA_LCM_NAME_SIZE = 96
};

typedef struct {
    char text[32]; /* as written: a number, or the name of an earlier integer field */
    int field;     /* of that name within the type, -1: constant */
    int count;     /* of a constant */
} mukca_lcm_dimension;

typedef struct {
    char name[MUKCA_NAME_SIZE];
    mukca_lcm_primitive primitive;
    char nested_name[MUKCA_LCM_NAME_SIZE]; /* of a NESTED field */
    int nested;                            /* its type's index */
    int n_dimensions;
    mukca_lcm_dimension dimension[MUKCA_LCM_MAX_DIMENSIONS];
} mukca_lcm_field;

typedef struct {
    char name[MUKCA_LCM_NAME_SIZE]; /* "package.name" */
    int first_field, n_fields;
    uint64_t fingerprint;
    /* Path of field indices for each role, ended by -1; [0] = -1 where the type has none. */
    signed char role[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_DEPTH + 1];
    double effort_factor; /* torque on the wire times this is the torque that holds the arm */
    const char *channel;  /* usual one, NULL where there is none */
} mukca_lcm_type;

typedef struct {
    int n_types, n_fields;
    mukca_lcm_type type[MUKCA_LCM_MAX_TYPES];
    mukca_lcm_field field[MUKCA_LCM_MAX_FIELDS];
} mukca_lcm_types;

/* One message of joint states, decoded. */
typedef struct {
    int64_t time; /* us, the sender's; 0 where the type has none */
    int mode;     /* robot_mode, -1 where the type has none */
    int n;        /* joints */
    bool has[MUKCA_LCM_ROLES];
    const char *name[MUKCA_LCM_MAX_JOINTS]; /* into the message */
    /* rad, rad/s, N m, rad; by role */
    double value[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_JOINTS];
} mukca_lcm_joints;

/* Robot mode of Franka's arms while somebody guides them by hand. */
enum { MUKCA_LCM_MODE_GUIDING = 3 };

/* Fill `types` with the built-in table.  Errors: none on a consistent table (a test checks it). */
mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error);

/* Add the structs of one .lcm description, text[length]; `file` is for messages.  All or none.
 * Errors: MUKCA_INPUT with file, line and column (syntax; enum; nested type that is nowhere
 * described; too many). */
mukca_status mukca_lcm_types_parse(mukca_lcm_types *types, const char *text, size_t length,
                                   const char *file, mukca_error *error);

/* The same from a file. */
mukca_status mukca_lcm_types_read(mukca_lcm_types *types, const char *path, mukca_error *error);

/* Resolve nested types and compute fingerprints of the types from index `first` on. */
mukca_status mukca_lcm_types_link(mukca_lcm_types *types, int first, const char *file,
                                  mukca_error *error);

/* Say what `path` ("head.q") of a type means.  Errors: MUKCA_INPUT (no such field, or one that is
 * no number where a number is needed). */
mukca_status mukca_lcm_type_set_role(mukca_lcm_types *types, int type, mukca_lcm_role role,
                                     const char *path, mukca_error *error);

/* Type of a message by its first eight bytes, -1 where unknown or shorter.  Later entries win. */
int mukca_lcm_types_find(const mukca_lcm_types *types, const void *data, size_t size);

/* Whether messages of that type carry joint positions. */
static inline bool mukca_lcm_type_has_joints(const mukca_lcm_types *types, int type)
{
    return type >= 0 && types->type[type].role[MUKCA_LCM_ROLE_POSITION][0] >= 0;
}

/* Decode a message of type `type` from data[size].  Reads nothing outside, takes time linear in
 * `size`, and allocates nothing.  Errors: MUKCA_INPUT (short, left-over bytes, counts that do not
 * fit or exceed 64 joints, unequal lengths, positions that are no numbers). */
mukca_status mukca_lcm_decode_joints(mukca_lcm_joints *joints, const mukca_lcm_types *types,
                                     int type, const void *data, size_t size, mukca_error *error);

#endif
