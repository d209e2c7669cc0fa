/* Denavit-Hartenberg tables from files. */
#ifndef MUKCA_IO_DH_TABLE_H
#define MUKCA_IO_DH_TABLE_H

#include "io/rows.h"
#include "model/dh.h"

/* Read a table: columns joint, a, alpha, d, theta, optional type (default: revolute), lower and
 * upper, in the units of `format` (NULL: m and rad); or a_m, alpha_rad, d_m, theta_rad.  The
 * comment `# convention: NAME`, which `mukca export` writes, states the convention.  Without it,
 * *stated is false and the standard convention is assumed.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_dh_read(mukca_dh *dh, bool *stated, const char *path,
                           const mukca_rows_format *format, mukca_error *error);

#endif
