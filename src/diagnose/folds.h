/* Folds: fits without part of the rows, predictions of that part, and comparison of the errors. */
#ifndef MUKCA_DIAGNOSE_FOLDS_H
#define MUKCA_DIAGNOSE_FOLDS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

typedef struct {
    mukca_regression *m;
    int n_folds;
    int *fold;        /* [n_rows] */
    double *gram;     /* sum of products of one fold */
    double *position; /* [n_rows][3] prediction of each row without its fold; NaN: a row in no fold
                         (fewer poses than folds) */
    double *error;    /* [n_rows]; NaN: not measured */
    unsigned char *all; /* [n_rows] all 1 */
    int *start, *row;   /* [n_sockets + 2], [n_rows] scratch: rows by socket */
    double surprise;    /* squared held-out errors in units of their predicted variance */
    int freedom;        /* its expected value: degrees of freedom of the held-out rows */
} mukca_folds;

/* Allocate from b->m's pool (check pool.failed). */
void mukca_folds_create(mukca_folds *b);

/* fold[n_rows] by placement, else (or by_socket) by socket, else by block of a pose log.  Returns
 * the number of folds. */
int mukca_folds_assign(int *fold, const mukca_regression *m, bool by_socket);

/* error[n_rows], m: distance of each row's prediction position[n_rows][3] from its socket's mean,
 * over the rows marked in `of` (others: NaN); with `excuse` from the mean of each segment or the
 * creep line of a known fault of the tool.  For poses the distance from the measurement, in its
 * frame. */
void mukca_folds_errors(double *error, const mukca_regression *m, const double *position,
                        const unsigned char *of, bool excuse);

/* mean[n_placements] of the finite errors of each placement's rows; NaN: none. */
void mukca_folds_by_placement(double *mean, const mukca_recording *recording, const double *error);

/* Mean of the finite values of error[n]; NaN: none. */
double mukca_folds_mean(const double *error, int n);

/* error[n_rows] of the kept rows, each predicted without its fold (placement, or by_socket socket)
 * by the linearised regression.  Sets surprise and freedom. */
void mukca_folds_run(double *error, mukca_folds *b, bool by_socket);

/* Reduction of the mean error from before[n_rows] to after[n_rows], with a bootstrap interval. */
void mukca_folds_compare(mukca_shrink *shrink, const mukca_folds *b, const double *before,
                         const double *after);

#endif
