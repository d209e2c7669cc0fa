/* Joint columns: those that determine less than they seem to, and the search for a
 * mix-up that explains data that do not fit the arm. */
#ifndef MUKCA_FIT_MISMATCH_H
#define MUKCA_FIT_MISMATCH_H

#include "base/text.h"
#include "fit/evaluate.h"

typedef struct {
    bool found;
    unsigned reversed;        /* bit j: joint j is reversed */
    int exchanged[2];         /* joints whose columns are exchanged; -1: none */
    int shifted;              /* joint with a shifted zero; -1: none */
    double shift;             /* correction of its angles, rad */
    int coupled, with, sign;  /* joint that needs `sign` times the angle of `with` added, as where
                                 the controller counts it from the horizontal; -1: none */
    double before_m, after_m; /* mean error of the nominal model, as recorded and changed */
} mukca_mismatch;

/* Search for one change of the joint columns that reduces the error of the nominal model to less
 * than a fifth: reversed joints, two exchanged columns, a zero shifted by a quarter or half a turn,
 * an angle that another joint's is part of.
 * Of several, the simplest whose error is not twice that of another.  Poses are first aligned with
 * the free frames.  At most 500 samples, evenly spread, are used.  Errors: MUKCA_MEMORY. */
mukca_status mukca_mismatch_find(mukca_mismatch *mismatch, const mukca_chain *chain,
                                 const mukca_dataset *data, bool free_base, bool free_tool,
                                 mukca_error *error);

/* Note the joints that did not move, in all samples or in a run of them, and the columns that
 * repeat another one. */
void mukca_columns_note(mukca_note_fn *note, void *context, const mukca_chain *chain,
                        const mukca_dataset *data);

#endif
