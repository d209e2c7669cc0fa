/* A dataset that grows row by row. */
#ifndef MUKCA_IO_DATASET_BUILD_H
#define MUKCA_IO_DATASET_BUILD_H

#include "io/rows.h"
#include "mukca/dataset.h"

typedef struct {
    mukca_dataset *data;
    const mukca_chain *chain;
    mukca_note_fn *note; /* may be NULL */
    void *context;
    mukca_error *error;
    int capacity;             /* rows allocated */
    mukca_rows_format format; /* of the files */
    double payload;           /* kg, for rows that have none of their own; NaN: unknown */
} mukca_dataset_builder;

/* All return MUKCA_MEMORY on failure; what they add is the last item of its list in the dataset. */
mukca_status mukca_build_file(mukca_dataset_builder *builder, const char *path);
mukca_status mukca_build_socket(mukca_dataset_builder *builder, int placement, const char *label);
mukca_status mukca_build_distance(mukca_dataset_builder *builder, int a, int b, double metres);

/* A placement of a name that no other has: `wanted`, else `qualified`, else with a number (noted).
 */
mukca_status mukca_build_placement(mukca_dataset_builder *builder, const char *wanted,
                                   const char *qualified);

/* Append a row of the last file; socket -1: of a pose log.  Values that are NaN allocate nothing.
 */
mukca_status mukca_build_row(mukca_dataset_builder *builder, const mukca_row *row, int socket,
                             int row_in_file);

/* Pose of a row that is there already; pose[7]: x y z qw qx qy qz. */
mukca_status mukca_build_pose(mukca_dataset_builder *builder, int row, const double pose[7]);

/* Read the controller's poses `path` (hole_N_pose.csv: x,y,z,qw,qx,qy,qz, without header) for the
 * rows [first, first + n).  Where the files differ in length, rows and poses are paired in order so
 * that the nominal forward kinematics fits best; superfluous ones are dropped, with a note. */
mukca_status mukca_pose_file_read(mukca_dataset_builder *builder, const char *path, int first,
                                  int n);

/* Any two sockets of a placement are `distance` (m) apart; refused for more than 4 sockets, which
 * no arrangement in space allows. */
mukca_status mukca_distances_set(mukca_dataset_builder *builder, double distance);

/* Distances from a table `socket_a socket_b distance_m`, for all placements that have both sockets;
 * every placement needs one. */
mukca_status mukca_distances_read(mukca_dataset_builder *builder, const char *path);

#endif
