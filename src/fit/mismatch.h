/* Joint columns: those that determine less than they seem to, and the search for a
 * mix-up that explains data that do not fit the arm. */
#ifndef MUKCA_FIT_MISMATCH_H
#define MUKCA_FIT_MISMATCH_H

#include "base/text.h"
#include "fit/evaluate.h"

/* How the angles of the arm's joints follow from the columns; zeroed but for `from`: as recorded.
 */
typedef struct {
    mukca_frame base_frame;         /* with `base`: the arm's base in the frame of the poses */
    double shift[MUKCA_MAX_JOINTS]; /* added to the angle, rad */
    double equivalent_shift;        /* shift of the first joint that does the same, rad; 0: none */
    double error_m, square;         /* mean error of the nominal model, m; mean square */
    int from[MUKCA_MAX_JOINTS];     /* joint whose column a joint reads */
    int coupled[MUKCA_MAX_JOINTS]; /* k + 1, -(k + 1): the angle of joint k is added, subtracted, as
                                      where the controller counts from the horizontal; 0: none */
    unsigned reversed;             /* bit j: with the opposite sign */
    bool base;                     /* the poses are measured in another frame than the base's */
} mukca_mixup;

typedef struct {
    bool found;
    double before_m; /* mean error of the nominal model, as recorded */
    mukca_mixup mixup;
} mukca_mismatch;

/* Search for the fewest changes of the joint columns, and of the frame of measured poses, that
 * reduce the error of the nominal model to less than a fifth, and if several are needed to less
 * than 1 cm: reversed joints, exchanged columns, shifted zeros, angles that another joint's is part
 * of. Poses are first aligned with the free frames, those of several targets by the first one.  At
 * most some 100 samples, evenly spread, are used.  Errors: MUKCA_MEMORY. */
mukca_status mukca_mismatch_find(mukca_mismatch *mismatch, const mukca_chain *chain,
                                 const mukca_dataset *data, bool free_base, bool free_tool,
                                 mukca_error *error);

/* Note the joints that did not move, in all samples or in a run of them, and the columns that
 * repeat another one. */
void mukca_columns_note(mukca_notes notes, const mukca_chain *chain, const mukca_dataset *data);

#endif
