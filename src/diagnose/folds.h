/* Leave folds of rows out of the fit, predict them, and compare the errors. */
#ifndef MUKCA_DIAGNOSE_FOLDS_H
#define MUKCA_DIAGNOSE_FOLDS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

typedef struct {
    mukca_regression *m;
    int n_folds;
    int *fold;          /* [n_rows] */
    double *gram;       /* of one fold */
    double *white;      /* scratch: whitened rows of a few samples, and the mean of a socket */
    double *position;   /* [n_rows][3] predictions of the rows by the fits without their fold;
                           NaN: a row of no fold (fewer poses than folds) */
    double *error;      /* [n_rows], NaN: not measured */
    unsigned char *all; /* [n_rows] 1 */
    int *start, *row;   /* [n_sockets + 2], [n_rows] scratch: rows by socket */
    double surprise;    /* squared misfit of the left-out rows in units of what it should be */
    int freedom;        /* of the left-out rows: what `surprise` would be if nothing were missing */
} mukca_folds;

/* Memory for b->m from its pool (check pool.failed). */
void mukca_folds_create(mukca_folds *b);

/* Folds fold[n_rows]: placements, else (or by_socket) sockets, else blocks of a pose log.  Returns
 * their number. */
int mukca_folds_assign(int *fold, const mukca_regression *m, bool by_socket);

/* error[n_rows]: distance of each row's prediction position[n_rows][3] from its socket's mean (of
 * the rows that `of` marks; NaN for others), with `excuse` about each segment or the creep line
 * where a fault of the tool is known; or from its measurement, in the measurement's frame.  m. */
void mukca_folds_errors(double *error, const mukca_regression *m, const double *position,
                        const unsigned char *of, bool excuse);

/* mean[n_placements] of the finite errors of each placement's rows, NaN where there is none. */
void mukca_folds_by_placement(double *mean, const mukca_recording *recording, const double *error);

/* Mean of the finite ones among error[n], NaN where there is none. */
double mukca_folds_mean(const double *error, int n);

/* error[n_rows] of the kept rows while their fold (placement, or by_socket socket) is left out of
 * the linearised regression.  Fills surprise and freedom. */
void mukca_folds_run(double *error, mukca_folds *b, bool by_socket);

/* How far the mean error shrinks from before[n_rows] to after[n_rows], with a bootstrap interval.
 */
void mukca_folds_compare(mukca_shrink *shrink, const mukca_folds *b, const double *before,
                         const double *after);

#endif
