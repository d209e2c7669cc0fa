/* Denavit-Hartenberg tables as files. */
#ifndef MUKCA_IO_DH_TABLE_H
#define MUKCA_IO_DH_TABLE_H

#include "model/dh.h"

/* Read a table: columns joint, a, alpha, d, theta (or a_m, alpha_rad, d_m, theta_rad), optional
 * type (default: revolute), lower and upper; m and rad.  The comment `# convention: NAME`, which
 * `mukca export` writes, sets the convention; *stated is whether it was there, else the table is
 * taken for a standard one.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_dh_read(mukca_dh *dh, bool *stated, const char *path, mukca_error *error);

#endif
