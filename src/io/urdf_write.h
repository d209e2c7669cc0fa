/* A chain as a URDF. */
#ifndef MUKCA_IO_URDF_WRITE_H
#define MUKCA_IO_URDF_WRITE_H

#include <stdio.h>

#include "mukca/chain.h"

/* Print the chain's links and joints; a chain has no masses or shapes to print. */
void mukca_urdf_write(FILE *stream, const mukca_chain *chain);

#endif
