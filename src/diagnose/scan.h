/* Score every candidate cause against the present model: log Bayes factors, all at once. */
#ifndef MUKCA_DIAGNOSE_SCAN_H
#define MUKCA_DIAGNOSE_SCAN_H

#include "diagnose/candidates.h"

typedef struct {
    int index;        /* of the hypothesis in the list; harmonics found by the scan follow it */
    double log_bayes; /* against the present model (or that without the cause left out) */
    double log_odds;  /* with its prior */
    double
        information; /* largest eigenvalue of its projected Gram matrix in units (bound), 1/rad^2 */
} gap_score;

enum {
    GAP_HARMONICS_KEPT = 8, /* best orders of a joint that one scan of all orders adds */
    GAP_HARMONICS_MOST = 24 /* orders of a joint that are scored as candidates */
};

enum { GAP_STEPS = 48 }; /* runs that are remembered; later ones count for the last */

/* How much of the list a run scores. */
typedef enum {
    GAP_SCAN_ALL,       /* everything, all orders of gear ripple included */
    GAP_SCAN_LISTED,    /* the list, and the orders that a scan of all has found worth it */
    GAP_SCAN_CONTENDERS /* what came near the front since the cause that is left out was accepted,
                            and its kin; of a single bad row only itself */
} gap_scan_extent;

typedef struct {
    gap_hypotheses *all;
    gap_hypothesis *harmonic; /* [n_joints * GAP_HARMONICS_MOST], in the order they were found */
    int n_harmonic;
    float *seen;      /* [GAP_STEPS][scores] log odds in each run against the whole model */
    int steps;        /* such runs so far */
    gap_score *score; /* [all->count + harmonics], unsorted */
    int n_scores;
    int rho; /* the best one's index in the last run, and the noise there */
    double sigma;
    unsigned char *wanted;       /* [scores] scratch: averaged over rho */
    double *value, *information; /* [scores] scratch: at one rho */
    double *memory;
    mukca_pool pool;
} gap_scan;

/* Room for scans over that list.  Errors: MUKCA_MEMORY. */
mukca_status gap_scan_create(gap_scan *scan, gap_hypotheses *all, const gap_model *m,
                             mukca_error *error);
void gap_scan_free(gap_scan *scan);

/* Hypothesis behind a score. */
const gap_hypothesis *gap_scan_hypothesis(const gap_scan *scan, int index);

/* Score all candidates against the fitted, linearised model; `without` >= 0 leaves that cause out
 * first, so that its score is what the data say of it. */
void gap_scan_run(gap_scan *scan, gap_model *m, int without, gap_scan_extent extent);

/* Largest canonical correlation of two hypotheses, after geometry and the other causes are
 * projected out, in the state of the last run with the same `without`; NaN where it cannot be told.
 */
double gap_scan_correlation(gap_scan *scan, gap_model *m, int without, const gap_hypothesis *a,
                            const gap_hypothesis *b);

#endif
