/* The noise that makes the evidence largest. */
#ifndef MUKCA_DIAGNOSE_NOISE_H
#define MUKCA_DIAGNOSE_NOISE_H

#include "diagnose/evidence.h"

/* Columns without which the evidence is wanted.  Columns before `from` never are. */
typedef struct {
    int column, count, from;
} mukca_left_out;

/* Noise sigma that maximises the evidence, near `guess` or anywhere; *value (may be NULL) gets the
 * evidence.  `out` may be NULL. */
double mukca_noise_choose(mukca_evidence *evidence, mukca_normal_equations *normal,
                          const mukca_left_out *out, double guess, double *value);

/* Does an AR(1) coefficient count whose log evidence is so much behind that of the best one?  A
 * candidate with a log Bayes factor of `gain` may turn their order. */
bool mukca_noise_counts(double behind, double gain);

/* May it count, by what is known from the last comparison of all coefficients?  `best` is the log
 * evidence of the best one now. */
bool mukca_noise_contends(const mukca_evidence *evidence, int index, double best, double gain);

#endif
