/* Recorded samples: joint angles with a socket label or a measured tip pose, and optional readings.
 */
#ifndef MUKCA_MODEL_DATASET_H
#define MUKCA_MODEL_DATASET_H

#include <stdbool.h>

#include "mukca/chain.h"

/* One ball seat of one placement of the tool.  Samples of a socket are in recording order. */
typedef struct {
    int placement;
    char label[MUKCA_NAME_SIZE];
} mukca_socket;

typedef struct {
    char name[MUKCA_NAME_SIZE];
} mukca_placement;

/* Known distance between two sockets of one placement (indices into `sockets`), m. */
typedef struct {
    int a, b;
    double distance, sigma; /* sigma: standard deviation, m; 0: MUKCA_DISTANCE_SIGMA */
    int artefact; /* the pairs with this number are two sockets of one part: one error for all */
} mukca_distance;
#define MUKCA_DISTANCE 0.05 /* the usual one, m: the printed tool of the MUKCa paper */

/* The columns of numbers in recordings: constant; member; numbers per sample, 0: one per joint;
 * what they are (mukca_unit; j: angle or length, by the joint); decimals written; names in files,
 * or what follows a joint's. mukca_column_table (dataset_subset.h) has them. */
#define MUKCA_COLUMN_LIST(X)                                                                   \
    X(TIME, time, 1, 't', 3, "time_s")                                                         \
    X(Q, q, 0, 'j', 12, "")                                /* always present */                \
    X(EFFORT, effort, 0, 'N', 6, ".effort")                /* N m */                           \
    X(COMMAND, command, 0, 'j', 12, ".command")            /* commanded angle */               \
    X(VELOCITY, velocity, 0, 'r', 9, ".velocity")          /* per second */                    \
    X(PAYLOAD, payload, 1, 'm', 6, "payload_kg")           /* at the tip beyond the model */   \
    X(POSITION, position, 3, 'l', 12, "x_m", "y_m", "z_m") /* of the tip, NaN: not measured */ \
    X(QUATERNION, quaternion, 4, 0, 14, "qw", "qx", "qy", "qz") /* of the tip, likewise */

enum {
#define MUKCA_COLUMN_ENUM(constant, ...) MUKCA_COLUMN_##constant,
    MUKCA_COLUMN_LIST(MUKCA_COLUMN_ENUM)
#undef MUKCA_COLUMN_ENUM
        MUKCA_COLUMNS
};

/* All arrays are owned by the dataset (mukca_dataset_free); an optional one is NULL if no file has
 * the column, and NaN in the samples of files without it. */
typedef struct {
    int n_rows, n_joints, n_sockets, n_placements, n_distances, n_files;
    union {
        struct {
#define MUKCA_COLUMN_MEMBER(constant, member, ...) double *member; /* [n_rows][numbers] */
            MUKCA_COLUMN_LIST(MUKCA_COLUMN_MEMBER)
#undef MUKCA_COLUMN_MEMBER
        };
        double *column[MUKCA_COLUMNS]; /* the same */
    };
    double *reading; /* [n_rows][n_joints] angles read, where q are commands; or NULL */
    bool by_command; /* q are commanded angles */
    int *socket;     /* [n_rows] index into sockets, -1: sample of a pose log */
    int *row;        /* [n_rows] 1-based number of the data row in its file */
    int *file;       /* [n_rows] index into files */
    int *target;     /* [n_rows] index into targets, -1: none named; or NULL */
    mukca_socket *sockets;
    mukca_placement *placements;
    mukca_distance *distances; /* every pair of sockets of a placement with a known distance */
    char (*files)[512];
    int n_targets; /* of pose logs: each a different point on the tool */
    char (*targets)[MUKCA_NAME_SIZE];
} mukca_dataset;

/* Allocate an empty dataset of that shape: row = 1.., file = 0, socket = -1; optional arrays NULL.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_dataset_create(mukca_dataset *data, int n_rows, int n_joints, int n_sockets,
                                  int n_placements, mukca_error *error);

/* Free all arrays and zero the structure; a zeroed one is allowed. */
void mukca_dataset_free(mukca_dataset *data);

/* Target of a sample, -1: none named. */
static inline int mukca_dataset_target(const mukca_dataset *data, int row)
{
    return data->target ? data->target[row] : -1;
}

/* Placement of a sample, -1: sample of a pose log. */
static inline int mukca_dataset_placement(const mukca_dataset *data, int row)
{
    return data->socket[row] < 0 ? -1 : data->sockets[data->socket[row]].placement;
}

#endif
