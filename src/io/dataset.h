/* Datasets as files: folders of hole_N.csv, session files, pose logs, in any combination. */
#ifndef MUKCA_IO_DATASET_H
#define MUKCA_IO_DATASET_H

#include <stdio.h>

#include "base/text.h"
#include "io/rows.h"
#include "model/dataset.h"

typedef struct {
    double distance;       /* between any two sockets of a placement, m; 0: MUKCA_DISTANCE */
    const char *distances; /* table of distances by socket labels, replaces `distance`; or NULL */
    double distance_sigma; /* of each of these distances, m; 0: MUKCA_DISTANCE_SIGMA */
    const double *payload; /* [n_paths] for samples whose file has no payload, kg; or NULL */
    mukca_rows_format format; /* of the tables */
    int threads;              /* more than 1: large files are read ahead */
    bool partial; /* an unfinished session: sockets may be missing or have few samples */
    mukca_notes notes;
} mukca_dataset_options;

/* Read the files and folders (of a placement, or of such folders) paths[n_paths] in order into a
 * new dataset (free it with mukca_dataset_free).  Duplicate samples are removed (dataset_copies.c).
 * Sockets with fewer than 2 samples and placements with fewer than 2 sockets are dropped with a
 * note.  `options` may be NULL.  Errors: MUKCA_INPUT (file, line, column), MUKCA_MEMORY. */
mukca_status mukca_dataset_load(mukca_dataset *data, const mukca_chain *chain,
                                const char *const *paths, int n_paths,
                                const mukca_dataset_options *options, mukca_error *error);

/* ---- duplicate samples (dataset_copies.c) ---- */

/* A file given twice, its copy, rows pasted again: remove the samples of `data` that repeat a
 * sample of `reference`, or if that is NULL an earlier sample of `data`; then sockets and
 * placements without samples.  One note per file.  Samples are duplicates if all joint angles and
 * the label are equal and all values that both have (time, measured pose, effort and so on) agree;
 * names of files and placements are not compared.  With `reference` NULL, a socket that would keep
 * one sample keeps all.  Returns MUKCA_OK or MUKCA_MEMORY. */
mukca_status mukca_dataset_drop_copies(mukca_dataset *data, const mukca_dataset *reference,
                                       mukca_notes notes, mukca_error *error);

/* Keep the samples with keep[i] != 0, and the sockets and placements that have some.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_dataset_keep(mukca_dataset *data, const unsigned char *keep, mukca_error *error);

/* ---- as a session file or a pose log (dataset_write.c) ---- */

/* Separator of a new file: a comma if its name ends in .csv, else a tab. */
char mukca_dataset_separator(const char *path);

/* Write all samples in order under a header.  The dataset must have times; if it has sockets, every
 * sample must have one.  Other optional columns are written if present and must then be complete.
 * Angles and positions get 12 decimals.  The caller checks the stream. */
void mukca_dataset_write(FILE *stream, const mukca_dataset *data, const mukca_chain *chain,
                         char separator);

/* ---- construction, sample by sample (dataset_build.c, pose_files.c) ---- */

typedef struct {
    mukca_dataset *data;
    const mukca_chain *chain;
    const mukca_dataset_options *options;
    mukca_error *error;
    bool warned[MUKCA_MAX_JOINTS]; /* a note of exceeded limits was printed */
    double payload; /* default payload of samples without their own, kg; NaN: unknown */
} mukca_dataset_builder;

/* All return MUKCA_MEMORY on failure; each appends one item to its list in the dataset. */
mukca_status mukca_build_file(mukca_dataset_builder *builder, const char *path);
mukca_status mukca_build_socket(mukca_dataset_builder *builder, int placement, const char *label);

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
