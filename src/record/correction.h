/* Joint angles of an elastic arm corrected to those of a rigid one, by the traits of its fleet. */
#ifndef MUKCA_RECORD_CORRECTION_H
#define MUKCA_RECORD_CORRECTION_H

#include "mukca/effect.h"

typedef struct {
    const mukca_chain *chain;
    int n_arms, n_effects;
    mukca_effect effects[2 * MUKCA_MAX_JOINTS]; /* mean elasticity of the fleet */
} mukca_correction;

/* Read a traits table for `chain`, which must outlive the correction.  Errors: as
 * mukca_traits_read. */
mukca_status mukca_correction_read(mukca_correction *correction, const char *path,
                                   const mukca_chain *chain, mukca_error *error);

/* Correct q[n_joints] of an arm at rest by a fraction of the mean elasticity; `correction` is a
 * mukca_correction. */
void mukca_correction_apply(void *correction, double share, double *q);

#endif
