/* Residuals of the positions: one interface for sockets and measured poses.
 *
 * Residuals, in metres (docs/method.md, 3): 3 per sample, prediction minus the mean of its socket's
 * predictions, or minus the measured position; and one per pair of sockets.  Samples without a
 * measurement have the residual zero, with weight zero.
 */
#ifndef MUKCA_FIT_OBSERVE_H
#define MUKCA_FIT_OBSERVE_H

#include "fit/parameters.h"
#include "fit/sweep.h"
#include "model/dataset.h"

/* A known distance between two sockets, m. */
typedef struct {
    int a, b;
    double distance, residual;
    double direction[3]; /* unit, from b to a */
} mukca_observed_pair;

typedef struct {
    mukca_sweep sweep;
    const mukca_parameters *parameters; /* free ones, of gradient and Jacobian */
    mukca_gradient kind;                /* method of an element's derivative */
    const double *theta;                /* of the last prediction */
    int n_rows, n_sockets, n_pairs;
    int n_groups;          /* placements with samples, plus one if there are measured poses */
    int n_residuals;       /* rows of the Jacobian */
    int n_measured;        /* scalar measurements less one mean per socket */
    int *socket;           /* [n_rows] -1: a pose */
    double *row_weight;    /* [n_rows] weight of the squared residual: 1 / samples of group, or 0 */
    double *count;         /* [n_sockets] samples of each */
    double *socket_weight; /* [n_sockets] `row_weight` of their samples */
    double *mean;          /* [n_sockets][3] of the predictions in use */
    mukca_observed_pair *pair; /* [n_pairs] */
    double *residual;          /* [windows][3][padded] */
    double *socket_adjoint;    /* [n_sockets][3] of the pairs, for each sample of a socket */
    double *mean_rows;         /* [n_sockets][3][n] means of the Jacobian */
    /* of mukca_poses_add; NULL: no measured poses */
    const double *target, *aim; /* positions and quaternions of the dataset */
    double *turn_weight;        /* [n_rows] as `row_weight` */
    double *turn_residual;      /* [windows][3][padded] */
} mukca_observations;

/* Allocate from the pool and load the samples of sockets; false: out of memory.  The dataset may be
 * freed afterwards.  Needs data->n_rows >= 1. */
bool mukca_observe_setup(mukca_observations *observations, mukca_pool *pool,
                         const mukca_chain *chain, const mukca_dataset *data);

/* Residuals of the open window, [3][padded]. */
static inline double *mukca_observe_window(double *residual, const mukca_sweep *sweep)
{
    return residual + 3L * sweep->from;
}

/* Compute the residuals at theta[6 * n_elements], which the gradient refers to; stored in
 * `observations`. */
void mukca_observe_predict(mukca_observations *observations, const double *theta);

/* Sum of squares of residuals [windows][3][padded], weighted by weight[n_rows] (NULL: not). */
double mukca_observe_sum(mukca_observations *observations, double *residual, const double *weight);

/* Sum of the squares, m^2, of the samples, weighted or not, and of the pairs (NULL: not wanted). */
double mukca_observe_squares(double *pairs, mukca_observations *observations, bool weighted);

/* Add the adjoints of residuals [windows][3][padded] in the open window: 2 factor weight[row] times
 * each, plus of_socket[n_sockets][3] (NULL: nothing). */
void mukca_observe_adjoint(mukca_adjoint *adjoint, mukca_observations *observations,
                           double *residual, const double *weight, double factor,
                           const double *of_socket);

/* gradient[n] of the weighted sum with respect to the free parameters. */
void mukca_observe_gradient(double *gradient, mukca_observations *observations);

#endif
