/* Construction of a dataset, sample by sample. */
#ifndef MUKCA_IO_DATASET_BUILD_H
#define MUKCA_IO_DATASET_BUILD_H

#include "io/rows.h"
#include "model/dataset.h"

typedef struct {
    mukca_dataset *data;
    const mukca_chain *chain;
    mukca_note_fn *note; /* may be NULL */
    void *context;
    mukca_error *error;
    int capacity;                  /* samples allocated */
    mukca_rows_format format;      /* format of the files */
    bool warned[MUKCA_MAX_JOINTS]; /* a note of exceeded limits was printed */
    double payload; /* default payload of samples without their own, kg; NaN: unknown */
} mukca_dataset_builder;

/* All return MUKCA_MEMORY on failure; each appends one item to its list in the dataset. */
mukca_status mukca_build_file(mukca_dataset_builder *builder, const char *path);
mukca_status mukca_build_socket(mukca_dataset_builder *builder, int placement, const char *label);
mukca_status mukca_build_distance(mukca_dataset_builder *builder, int a, int b, double metres);

/* Add a placement under an unused name: `wanted`, else `qualified`, else numbered, with a note. */
mukca_status mukca_build_placement(mukca_dataset_builder *builder, const char *wanted,
                                   const char *qualified);

/* Append a sample of the last file; socket -1: sample of a pose log.  NaN values allocate
 * nothing. */
mukca_status mukca_build_row(mukca_dataset_builder *builder, const mukca_row *row, int socket,
                             int row_in_file);

/* Set the pose of an existing sample; pose[7]: x y z qw qx qy qz. */
mukca_status mukca_build_pose(mukca_dataset_builder *builder, int row, const double pose[7]);

/* Read the controller's poses `path` (hole_N_pose.csv: x,y,z,qw,qx,qy,qz, without header) for the
 * samples [first, first + n).  If their numbers differ, samples and poses are paired in order for
 * the best fit of the nominal forward kinematics; those without partner are dropped with a note. */
mukca_status mukca_pose_file_read(mukca_dataset_builder *builder, const char *path, int first,
                                  int n);

/* Set the distance between any two sockets of a placement, m.  Refused for more than 4 sockets: no
 * more points in space have equal distances. */
mukca_status mukca_distances_set(mukca_dataset_builder *builder, double distance);

/* Read a table `socket_a socket_b distance_m`.  A row applies to all placements with both sockets;
 * every placement needs one. */
mukca_status mukca_distances_read(mukca_dataset_builder *builder, const char *path);

#endif
