/* The cost with measured poses, its Gauss-Newton Hessian, and directions held near the
 * start. */
#ifndef MUKCA_FIT_COST_NORMAL_H
#define MUKCA_FIT_COST_NORMAL_H

#include "fit/cost.h"

/* As mukca_cost_init, with measured poses and memory for Hessian and solvers.  With
 * options->part, the cost of a representative part of the samples (part.h), Hessian and precision
 * are computed from that part, without a Jacobian of all samples. */
bool mukca_cost_setup(mukca_cost *cost, mukca_pool *pool, const mukca_chain *chain,
                      const mukca_parameters *parameters, const mukca_dataset *data,
                      const mukca_cost_options *options);

/* From here on regularise towards x[n] each direction v of the unregularised parameters that the
 * data determine less than lambda would: nearly identical samples would otherwise move the ball by
 * kilometres.  The term is lambda (v'(x - x0))^2, as for the regularised parameters. */
void mukca_cost_hold(mukca_cost *cost, const double *x);

/* Half the Gauss-Newton Hessian, H[n][n] = J'WJ + lambda I for the regularised or held directions;
 * without lambda if `data_only`.  Leaves the weighted Jacobian in cost->part->J. */
void mukca_cost_normal(double *H, mukca_cost *cost, const double *x, bool data_only);

#endif
