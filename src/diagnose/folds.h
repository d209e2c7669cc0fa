/* Leave folds of rows out of the fit, predict them, and compare the errors. */
#ifndef MUKCA_DIAGNOSE_FOLDS_H
#define MUKCA_DIAGNOSE_FOLDS_H

#include "diagnose/diagnose.h"
#include "diagnose/model.h"

typedef struct {
    gap_model *m;
    int n_folds;
    int *fold;          /* [n_rows] */
    double *prior;      /* [capacity] */
    double *gram;       /* of one fold */
    double *distance;   /* the pack's, kept while a fold's rows are blanked */
    double *position;   /* [n_rows][3] predictions of the rows while they were left out, NaN: of a
                           row that no fold holds (fewer poses than folds beside sockets) */
    double *error;      /* [n_rows], NaN: not measured */
    unsigned char *all; /* [n_rows] 1 */
    double surprise;    /* squared misfit of the left-out rows in units of what it should be */
    int freedom;        /* of the left-out rows: what `surprise` would be if nothing were missing */
} gap_left_out;

/* Take memory for b->m from its pool (which tells where it failed). */
void gap_left_out_take(gap_left_out *b);

/* Folds fold[n_rows]: placements, else (or by_socket) sockets, else blocks of a pose log.  Returns
 * their number. */
int gap_left_out_folds(int *fold, const gap_model *m, bool by_socket);

/* Is it a fault of the recording, kept whatever is compared? */
bool gap_left_out_fault(const gap_hypothesis *h);

/* error[n_rows]: distance of each row's prediction position[n_rows][3] from its socket's mean (of
 * the rows that `of` marks; NaN for others), with `excuse` about each segment or the creep line
 * where a fault of the tool is known; or from its measurement.  m. */
void gap_left_out_errors(double *error, const gap_model *m, const double *position,
                         const unsigned char *of, bool excuse);

/* Mean of the finite ones among error[n], NaN where there is none. */
double gap_left_out_mean(const double *error, int n);

/* Normal equations at the model's own AR(1) coefficient, which must be linearised. */
gap_pack *gap_left_out_pack(gap_model *m);

/* error[n_rows] of the kept rows while their fold (placement, or by_socket socket) is left out,
 * with the causes that use[n_causes] marks, and all faults.  Fills surprise and freedom. */
void gap_left_out_run(double *error, gap_left_out *b, gap_pack *pack, const unsigned char *use,
                      bool by_socket);

/* How far the mean error shrinks from before[n_rows] to after[n_rows], with a bootstrap interval.
 */
void gap_left_out_compare(mukca_shrink *shrink, const gap_left_out *b, const double *before,
                          const double *after);

#endif
