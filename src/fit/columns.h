/* Joint columns that determine less than they seem to: said before a fit. */
#ifndef MUKCA_FIT_COLUMNS_H
#define MUKCA_FIT_COLUMNS_H

#include "base/note.h"
#include "model/dataset.h"

/* Note the joints that did not move, in all samples or in a run of them, and the columns that
 * repeat another one. */
void mukca_columns_note(mukca_note_fn *note, void *context, const mukca_chain *chain,
                        const mukca_dataset *data);

#endif
