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

#endif
