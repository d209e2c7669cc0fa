/* Noise sigma of maximal evidence. */
#ifndef MUKCA_DIAGNOSE_NOISE_H
#define MUKCA_DIAGNOSE_NOISE_H

#include "diagnose/evidence.h"

/* Columns excluded from the evidence; columns before `from` never are. */
typedef struct {
    int column, count, from;
} mukca_left_out;

/* Noise sigma that maximises the evidence, near `guess` or else globally; *value (may be NULL)
 * receives the evidence.  `out` may be NULL. */
double mukca_noise_choose(mukca_evidence *evidence, mukca_normal_equations *normal,
                          const mukca_left_out *out, double guess, double *value);

/* Is a family of the noise relevant whose log evidence is `behind` that of the best one?  A
 * candidate with a log Bayes factor of `gain` may reverse their order. */
bool mukca_noise_counts(double behind, double gain);

/* Can it be relevant, given the last comparison of all families?  `best` is the present log
 * evidence of the best one. */
bool mukca_noise_contends(const mukca_evidence *evidence, int index, double best, double gain);

#endif
