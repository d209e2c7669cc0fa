/* Summaries of recordings as files: JSON (mukca.summary/1), one per line; files can be
 * concatenated. */
#ifndef MUKCA_IO_SUMMARY_H
#define MUKCA_IO_SUMMARY_H

#include <stdio.h>

#include "fleet/fleet.h"

/* Write one line.  Errors: MUKCA_MEMORY. */
mukca_status mukca_summary_write(FILE *stream, const mukca_summary *summary, mukca_error *error);

/* Add all summaries of the file `path`, which must outlive the fleet.  Errors: MUKCA_INPUT (file
 * and line), MUKCA_MEMORY, and those of mukca_fleet_take. */
mukca_status mukca_summary_read(mukca_fleet *fleet, const char *path, mukca_error *error);

/* ---- traits of an arm model as a table (TSV) ---- */

void mukca_traits_write(FILE *stream, const mukca_traits *traits);

/* Read a traits table for a chain.  Errors: MUKCA_INPUT (file, line, column; another model),
 * MUKCA_MEMORY. */
mukca_status mukca_traits_read(mukca_traits *traits, const char *path, const mukca_chain *chain,
                               mukca_error *error);

#endif
