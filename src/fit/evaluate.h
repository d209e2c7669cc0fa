/* Errors of a model on data: consistency and distance errors per placement. */
#ifndef MUKCA_FIT_EVALUATE_H
#define MUKCA_FIT_EVALUATE_H

#include "fit/fit.h"
#include "mukca/effect.h"

/* Folds of poses are blocks of consecutive ones, which are correlated: more leave more to the fit.
 */
enum { MUKCA_POSE_FOLDS = 10 };

/* Score of one placement, of all measured poses together, or the mean over those. */
typedef struct {
    int placement;    /* index; -1: samples of pose logs */
    int file, target; /* of one pose log (mukca_model.by_log), target -1: none named; else -1 */
    int rows;
    double mae; /* mean distance of a sample from its socket's mean, or from the measurement, m */
    double std; /* root of the mean squared distance, m */
    double distance_error; /* mean of ||mu_a - mu_b| - d| over the known pairs, m; NaN: none */
    double rotation_error; /* mean angle from the measured orientations, rad; NaN: none */
} mukca_score;

/* The model to score. */
typedef struct {
    const mukca_chain *chain;
    const double *theta;         /* [6 * n_elements]; NULL: nominal */
    const mukca_effect *effects; /* [n_effects], their placements those of the data; may be NULL */
    int n_effects;
    bool by_log; /* one score per pose log (a target in a file) instead of one for all */
} mukca_model;

/* A model on a dataset. */
typedef struct {
    mukca_frame *tips; /* [n_rows], those with a named target shifted to it: to the mean of its
                          measured positions in the tip's frame */
    double *error;     /* [n_rows] as of mukca_evaluate_rows */
    double (*mean)[3]; /* [n_sockets] of the predicted positions */
    int *count;        /* [n_sockets] samples */
} mukca_evaluation;

/* In memory of the pool.  False: out of memory. */
bool mukca_evaluation_make(mukca_evaluation *evaluation, mukca_pool *pool, const mukca_model *model,
                           const mukca_dataset *data);

/* What a sample is compared with: the mean of its socket, or the measured position; NULL: none. */
const double *mukca_evaluation_centre(const mukca_evaluation *evaluation, const mukca_dataset *data,
                                      int row);

/* error[n_rows], m: distance of each sample from its socket's mean, or from the measured position;
 * NaN: none.  False: out of memory. */
bool mukca_evaluate_rows(double *error, const mukca_model *model, const mukca_dataset *data);

/* Maximum number of scores of a dataset. */
static inline size_t mukca_evaluate_room(const mukca_dataset *data)
{
    return (size_t)data->n_placements + 1 + (size_t)data->n_files * ((size_t)data->n_targets + 1);
}

/* Scores of `data`.  scores[mukca_evaluate_room], or [n_placements + 1] without by_log, gets one
 * entry per placement with samples, then one for the poses, or one per log.  The position of a
 * named target on the tip is first estimated from these data.  `mean` (may be NULL) gets the mean
 * over the entries (rows: the sum).  Returns their number, -1: out of memory. */
int mukca_evaluate(mukca_score *scores, mukca_score *mean, const mukca_model *model,
                   const mukca_dataset *data);

/* ---- pairs of socket labels that were recorded in one socket ---- */

/* Move the known distances of pairs of labels that appear to have been recorded in one socket
 * behind the others, which data->n_distances then counts; apart[n_distances]: distances between the
 * centres of those moved, m.  Criterion: this distance is below the rms error of the samples about
 * the centres or below 8 % of the known distance, and that rms error is below a quarter of the
 * known distance: a model with so small an error does not misplace a socket by so much; and each
 * label has at least so many samples.  theta[6 * n_elements] (NULL: nominal) is the model.  Returns
 * their number, -1 when out of memory. */
int mukca_coincide_drop(double *apart, mukca_dataset *data, const mukca_chain *chain,
                        const double *theta, int least);

#endif
