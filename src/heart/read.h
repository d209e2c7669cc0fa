/* Inputs of the heart: an arm as one line per joint, folders of joint angles. */
#ifndef MUKCA_HEART_READ_H
#define MUKCA_HEART_READ_H

#include "model/dataset.h"

/* Read an arm from the lines `# element:` of an offsets table, one per joint from base to tip:
 * name, child link, type, axis, xyz, rpy, limits.  Errors: MUKCA_INPUT. */
mukca_status mukca_heart_arm(mukca_chain *chain, const char *path, mukca_error *error);

/* Read placements folder[n], each with hole_0.csv, hole_1.csv, ...: joint angles, one sample per
 * line, of sockets MUKCA_DISTANCE apart.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_heart_data(mukca_dataset *data, const mukca_chain *chain, char *const *folder,
                              int n, mukca_error *error);

#endif
