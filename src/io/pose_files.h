/* hole_N_pose.csv beside hole_N.csv: the controller's poses, x,y,z,qw,qx,qy,qz, without header. */
#ifndef MUKCA_IO_POSE_FILES_H
#define MUKCA_IO_POSE_FILES_H

#include "io/dataset_build.h"

/* Read poses for the rows [first, first + n) of the dataset in the making.  Where the files differ
 * in length, rows and poses are paired in order so that the nominal forward kinematics fits best;
 * what is left over is dropped, with a note. */
mukca_status mukca_pose_file_read(mukca_dataset_builder *builder, const char *path, int first,
                                  int n);

#endif
