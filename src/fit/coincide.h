/* Labels of two sockets that were recorded in one. */
#ifndef MUKCA_FIT_COINCIDE_H
#define MUKCA_FIT_COINCIDE_H

#include "mukca/dataset.h"

/* apart[n_distances]: distance of the centres of two sockets, m, where both labels seem to have
 * been recorded in one socket; NaN for the others.  That is where the centres are nearer to each
 * other than samples scatter about them (rms) or than 8 % of the known distance, and samples
 * scatter by less than a quarter of it: a model that places samples so well does not place a socket
 * that wrong.  theta[6 * n_elements] (NULL: nominal) is the model.  Returns their number, -1 when
 * out of memory. */
int mukca_coincide_find(double *apart, const mukca_chain *chain, const double *theta,
                        const mukca_dataset *data);

#endif
