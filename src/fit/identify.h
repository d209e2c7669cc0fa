/* Which parameters the data identify, and how well: rank, null space, standard errors.
 *
 * All of it is of the data alone: the regularisation (lambda) hides what is not observable, it
 * does not make it known.
 */
#ifndef MUKCA_FIT_IDENTIFY_H
#define MUKCA_FIT_IDENTIFY_H

#include "fit/cost.h"

typedef struct {
    int rank;
    int determined;       /* directions in which the data weigh more than the regularisation */
    double noise;         /* standard deviation of one coordinate of a row, m; from the residuals */
    double observability; /* (s_1 ... s_rank)^(1/rank) of the weighted Jacobian (index O1 of Borm
                             and Menq over the observable directions): m per m or rad */
    double sigma[MUKCA_MAX_FREE]; /* standard error of each free parameter; infinite where
                                     unidentifiable */
    unsigned char identifiable[MUKCA_MAX_FREE];
} mukca_identification;

/* Directions whose effect on the data is below this share of the strongest one are
 * taken as zero. */
#define MUKCA_RANK_TOLERANCE 1e-7

/* A parameter is identifiable where every motion of the arm that the data do not show, of unit
 * size, changes it by less than this: 10 mm or mrad of such a motion are 10 um or urad of the
 * parameter. */
#define MUKCA_HIDDEN_SHARE 1e-3

/* Doubles of `work` for n free parameters. */
#define MUKCA_IDENTIFY_WORK(n) (3 * (size_t)((n) + 3) * (size_t)((n) + 3) + 32 * (size_t)((n) + 3))

/* Analyse at x[n].  null_space[n][n] (may be NULL) gets n - rank rows that span the directions that
 * change nothing, reduced so that each has a parameter of its own with coefficient 1.
 * Errors: MUKCA_INPUT (the Jacobian is not finite). */
mukca_status mukca_identify(mukca_identification *identification, double *null_space,
                            mukca_cost *cost, const double *x, double *work, mukca_error *error);

#endif
