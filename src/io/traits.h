/* Traits of an arm model as a table (TSV). */
#ifndef MUKCA_IO_TRAITS_H
#define MUKCA_IO_TRAITS_H

#include <stdio.h>

#include "fleet/fleet.h"

void mukca_traits_write(FILE *stream, const mukca_traits *traits);

/* Read a traits table for a chain.  Errors: MUKCA_INPUT (file, line, column; another model),
 * MUKCA_MEMORY. */
mukca_status mukca_traits_read(mukca_traits *traits, const char *path, const mukca_chain *chain,
                               mukca_error *error);

#endif
