/* Scan: log Bayes factors of all candidate causes against the present model. */
#ifndef MUKCA_DIAGNOSE_SCAN_H
#define MUKCA_DIAGNOSE_SCAN_H

#include "diagnose/candidates.h"
#include "diagnose/projector.h"

typedef struct {
    int index;          /* of the candidate in the list, followed by harmonics from the scan */
    double log_bayes;   /* against the present model, or the model without one cause */
    double log_odds;    /* with its prior */
    double information; /* largest diagonal of its projected Gram matrix in units, 1/rad^2 */
} mukca_score;

enum {
    MUKCA_RIPPLE_PROMISING = 64, /* orders with exact scores in a scan of all orders */
    MUKCA_RIPPLE_KEPT = 8,       /* best orders of a joint that a scan of all orders adds */
    MUKCA_RIPPLE_MOST = 24       /* most orders of a joint among the candidates */
};

enum { MUKCA_SCAN_STEPS = 64 }; /* runs in the history; later ones overwrite the last */

/* Candidates scored by a run. */
typedef enum {
    MUKCA_SCAN_ALL,    /* all, including every order of ripple */
    MUKCA_SCAN_LISTED, /* the list, and the orders added by earlier scans */
    MUKCA_SCAN_RIPPLE, /* other orders of ripple; the rest keeps the scores of the last run, of the
                          same model */
    MUKCA_SCAN_CONTENDERS, /* those with considerable odds since the excluded cause was accepted,
                              and the same effect at its joint; of an outlier itself only */
    MUKCA_SCAN_RIVALS,     /* the same, and the unlisted causes */
    MUKCA_SCAN_UNLISTED    /* unlisted causes alone */
} mukca_scan_extent;

typedef struct {
    mukca_candidates *all;
    mukca_candidate *harmonic; /* [n_joints * MUKCA_RIPPLE_MOST], in order of discovery */
    int n_harmonic;
    int capacity;   /* largest number of scores */
    float *history; /* [MUKCA_SCAN_STEPS][capacity] log odds in each run against the whole model */
    int steps;      /* number of these runs */
    mukca_score *score; /* [all->count + n_harmonic], unsorted */
    int n_scores;
    int rho; /* index of the best AR(1) coefficient in the last run, and its noise */
    double sigma;
    double most;                          /* largest log Bayes factor in the last run */
    unsigned char *wanted;                /* [scores] scratch: candidates still averaged over rho */
    double *value, *information;          /* [scores] scratch: values at one rho */
    mukca_products *products[MUKCA_RHOS]; /* [capacity] */
    mukca_products ripple;                /* of a joint's promising orders */
    mukca_product_item *item;             /* [capacity] scratch */
    mukca_scored *scored;                 /* [capacity] scratch */
    mukca_projector projector;
    mukca_pool pool;
} mukca_scan;

/* Allocate for scans over that list.  Errors: MUKCA_MEMORY. */
mukca_status mukca_scan_create(mukca_scan *scan, mukca_candidates *all, mukca_regression *m,
                               mukca_error *error);
void mukca_scan_free(mukca_scan *scan);

/* Candidate of a score. */
const mukca_candidate *mukca_scan_candidate(const mukca_scan *scan, int index);

/* Score the candidates against the fitted, linearised model; `without` >= 0 excludes that cause
 * first, for its own evidence. */
void mukca_scan_run(mukca_scan *scan, mukca_regression *m, int without, mukca_scan_extent extent);

/* Choose noise and AR(1) coefficient as a run does, without scores. */
void mukca_scan_weigh(mukca_scan *scan, mukca_regression *m, int without);

/* Log odds [scores] in the last run against the whole model. */
const float *mukca_scan_last_odds(const mukca_scan *scan);

/* Append the first runs to the history once more, for a search that restarts after them; returns
 * the number of steps by which they moved. */
int mukca_scan_repeat(mukca_scan *scan, int steps);

/* Largest canonical correlation of two candidates, with geometry and the other causes projected
 * out, in the state of the last run with the same `without`; NaN: undefined. */
double mukca_scan_correlation(mukca_scan *scan, mukca_regression *m, int without,
                              const mukca_candidate *a, const mukca_candidate *b);

/* Upward bias of a candidate's score in that state, from noise of the recorded angles in its own
 * columns. */
double mukca_scan_noise_gain(mukca_scan *scan, mukca_regression *m, int without,
                             const mukca_candidate *candidate);

#endif
