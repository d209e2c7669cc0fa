/* Data that do not fit the arm: the mix-up of joint columns that would explain it. */
#ifndef MUKCA_FIT_MISMATCH_H
#define MUKCA_FIT_MISMATCH_H

#include "fit/evaluate.h"

typedef struct {
    bool found;
    unsigned reversed;        /* bit j: joint j counts in the other direction */
    int exchanged[2];         /* joints whose columns are exchanged; -1: none */
    int shifted;              /* the joint whose zero lies elsewhere; -1: none */
    double shift;             /* by which its angles would have to change, rad */
    double before_m, after_m; /* error of the nominal model (mean; median of poses with free
                                 frames), as recorded and after the change */
} mukca_mismatch;

/* Look for one change of the joints' columns that brings the error of the nominal model below a
 * fifth: reversed joints, two exchanged columns, a zero that lies a quarter or half a turn off.  Of
 * several, the simplest that is not twice as bad as another.  Poses are aligned first by the frames
 * that are free.  At most 500 samples, evenly spread, are used.  Errors: MUKCA_MEMORY. */
mukca_status mukca_mismatch_find(mukca_mismatch *mismatch, const mukca_chain *chain,
                                 const mukca_dataset *data, bool free_base, bool free_tool,
                                 mukca_error *error);

#endif
