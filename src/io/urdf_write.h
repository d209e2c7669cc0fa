/* A chain as a URDF. */
#ifndef MUKCA_IO_URDF_WRITE_H
#define MUKCA_IO_URDF_WRITE_H

#include <stdio.h>

#include "mukca/chain.h"

/* Print the chain's links and joints; masses and shapes are not part of a chain. */
void mukca_urdf_write(FILE *stream, const mukca_chain *chain);

#endif
