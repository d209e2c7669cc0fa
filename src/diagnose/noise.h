/* The noise that makes the evidence largest. */
#ifndef MUKCA_DIAGNOSE_NOISE_H
#define MUKCA_DIAGNOSE_NOISE_H

#include "diagnose/evidence.h"

/* Noise sigma that maximises the evidence, near `guess` or anywhere; *value (may be NULL) gets the
 * evidence. */
double mukca_noise_choose(mukca_evidence *evidence, mukca_normal_equations *normal, double guess,
                          double *value);

#endif
