/* Pairs of socket labels that were recorded in one socket. */
#ifndef MUKCA_FIT_COINCIDE_H
#define MUKCA_FIT_COINCIDE_H

#include "model/dataset.h"

/* apart[n_distances]: distance between the centres of two sockets, m, if both labels appear to have
 * been recorded in one socket, else NaN.  Criterion: the distance is below the rms error of the
 * samples about the centres or below 8 % of the known distance, and that rms error is below a
 * quarter of the known distance: a model with so small an error does not misplace a socket by so
 * much.  theta[6 * n_elements] (NULL: nominal) is the model.  Returns their number, -1 when out of
 * memory. */
int mukca_coincide_find(double *apart, const mukca_chain *chain, const double *theta,
                        const mukca_dataset *data);

#endif
