/* Noise sigma of maximal evidence. */
#ifndef MUKCA_DIAGNOSE_NOISE_H
#define MUKCA_DIAGNOSE_NOISE_H

#include "diagnose/evidence.h"

/* Noise sigma that maximises the evidence, near `guess` or else globally; *value (may be NULL)
 * receives the evidence. */
double mukca_noise_choose(mukca_evidence *evidence, const mukca_normal_equations *normal,
                          double guess, double *value);

/* Can a family of the noise be relevant, given the last comparison of all families?  `best` is the
 * present log evidence of the best one. */
bool mukca_noise_contends(const mukca_evidence *evidence, int index, double best);

#endif
