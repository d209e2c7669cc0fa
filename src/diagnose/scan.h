/* Score every candidate cause against the present model: log Bayes factors, all at once. */
#ifndef MUKCA_DIAGNOSE_SCAN_H
#define MUKCA_DIAGNOSE_SCAN_H

#include "diagnose/candidates.h"
#include "diagnose/projector.h"

typedef struct {
    int index;        /* of the candidate in the list; harmonics found by the scan follow it */
    double log_bayes; /* against the present model (or that without one cause) */
    double log_odds;  /* with its prior */
    double
        information; /* largest eigenvalue of its projected Gram matrix in units (bound), 1/rad^2 */
} mukca_score;

enum {
    MUKCA_RIPPLE_PROMISING = 64, /* orders that a scan of all orders scores exactly */
    MUKCA_RIPPLE_KEPT = 8,       /* best orders of a joint that one scan of all orders adds */
    MUKCA_RIPPLE_MOST = 24       /* orders of a joint that are scored as candidates */
};

enum { MUKCA_SCAN_STEPS = 64 }; /* runs that are remembered; later ones count for the last */

/* The part of the list that a run scores. */
typedef enum {
    MUKCA_SCAN_ALL,    /* everything, all orders of gear ripple included */
    MUKCA_SCAN_LISTED, /* the list, and the orders that a scan of all has found worth it */
    MUKCA_SCAN_RIPPLE, /* other orders of gear ripple; the rest keeps its scores of the last run,
                          which was of the same model */
    MUKCA_SCAN_CONTENDERS, /* what came near the front since the excluded cause was accepted, and
                            the same effect there; of a single bad row only itself */
    MUKCA_SCAN_RIVALS,     /* the same, and the causes that nobody listed */
    MUKCA_SCAN_UNLISTED    /* these alone */
} mukca_scan_extent;

typedef struct {
    mukca_candidates *all;
    mukca_candidate *harmonic; /* [n_joints * MUKCA_RIPPLE_MOST], in the order they were found */
    int n_harmonic;
    int capacity;   /* scores at most */
    float *history; /* [MUKCA_SCAN_STEPS][capacity] log odds in each run against the whole model */
    int steps;      /* such runs so far */
    mukca_score *score; /* [all->count + harmonics], unsorted */
    int n_scores;
    int rho; /* the best one's index in the last run, and the noise there */
    double sigma;
    double most;                          /* largest log Bayes factor in the last run */
    unsigned char *wanted;                /* [scores] scratch: averaged over rho */
    double *value, *information;          /* [scores] scratch: at one rho */
    mukca_products *products[MUKCA_RHOS]; /* [capacity] */
    mukca_products ripple;                /* of the promising orders of a joint */
    mukca_product_item *item;             /* [capacity] scratch */
    mukca_scored *scored;                 /* [capacity] scratch */
    mukca_projector projector;
    mukca_pool pool;
} mukca_scan;

/* Room for scans over that list.  Errors: MUKCA_MEMORY. */
mukca_status mukca_scan_create(mukca_scan *scan, mukca_candidates *all, mukca_regression *m,
                               mukca_error *error);
void mukca_scan_free(mukca_scan *scan);

/* Candidate of a score. */
const mukca_candidate *mukca_scan_candidate(const mukca_scan *scan, int index);

/* Score all candidates against the fitted, linearised model; `without` >= 0 leaves that cause out
 * first, so that its score is what the data say of it. */
void mukca_scan_run(mukca_scan *scan, mukca_regression *m, int without, mukca_scan_extent extent);

/* Noise and AR(1) coefficient of a run, without the run. */
void mukca_scan_weigh(mukca_scan *scan, mukca_regression *m, int without);

/* Log odds [scores] in the last run against the whole model. */
const float *mukca_scan_last_odds(const mukca_scan *scan);

/* Remember the first runs once more, after all others, for a search that starts behind them;
 * returns by how many steps they moved. */
int mukca_scan_repeat(mukca_scan *scan, int steps);

/* Largest canonical correlation of two candidates, after geometry and the other causes are
 * projected out, in the state of the last run with the same `without`; NaN where it is not defined.
 */
double mukca_scan_correlation(mukca_scan *scan, mukca_regression *m, int without,
                              const mukca_candidate *a, const mukca_candidate *b);

/* By how much the score of a candidate is too high in that state because the recorded angles hold
 * the noise of their own sample. */
double mukca_scan_noise_gain(mukca_scan *scan, mukca_regression *m, int without,
                             const mukca_candidate *candidate);

#endif
