/* Identifiability of the parameters: rank, null space, standard errors.
 *
 * All results are of the data alone: regularisation (lambda) hides unobservable directions, it does
 * not add information.
 */
#ifndef MUKCA_FIT_IDENTIFY_H
#define MUKCA_FIT_IDENTIFY_H

#include "fit/cost.h"

typedef struct {
    int rank;
    double noise;         /* standard deviation of a sample's coordinate, m; from the residuals */
    double observability; /* (s_1 ... s_rank)^(1/rank) of the weighted Jacobian (index O1 of Borm
                             and Menq over the observable directions): m per m or rad */
    double sigma[MUKCA_MAX_FREE]; /* standard error of each free parameter; infinite if
                                     unidentifiable */
    unsigned char identifiable[MUKCA_MAX_FREE];
} mukca_identification;

/* Relative tolerance of the rank: smaller singular values, relative to the largest, count as
 * zero. */
#define MUKCA_RANK_TOLERANCE 1e-7

/* A parameter is identifiable if its component in every unit vector of the null space is below
 * this: moving 10 mm or mrad along the null space changes the parameter by less than 10 um or
 * urad. */
#define MUKCA_HIDDEN_SHARE 1e-3

/* Doubles of `work` for n free parameters. */
#define MUKCA_IDENTIFY_WORK(n) (3 * (size_t)((n) + 3) * (size_t)((n) + 3) + 32 * (size_t)((n) + 3))

/* Analyse at x[n].  null_space[n][n] (may be NULL) gets n - rank rows that span the null space, in
 * reduced form: each has a parameter of its own with coefficient 1.  Errors: MUKCA_INPUT (the
 * Jacobian is not finite). */
mukca_status mukca_identify(mukca_identification *identification, double *null_space,
                            mukca_cost *cost, const double *x, double *work, mukca_error *error);

#endif
