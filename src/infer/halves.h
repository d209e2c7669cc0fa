/* The question of a search among sets for a part of the rows: its normal equations, with the model
 * integrated out anew. */
#ifndef MUKCA_INFER_HALVES_H
#define MUKCA_INFER_HALVES_H

#include "infer/sets.h"

/* Columns of the whole, whitened, in units of the noise and of the prior sigmas: first those of the
 * model that is integrated out, then the value, then the items' at their places + n + 1. */
typedef struct {
    int n, n_items, n_columns; /* of the model; items, and their columns */
    const mukca_item *item;
} mukca_part_layout;

/* Question of the rows whose columns have the products gram[width][width], width = n + 1 +
 * n_columns.  gram is overwritten; other memory comes from `pool`.  False: no memory, or not
 * positive. */
bool mukca_part_question(mukca_question *question, mukca_pool *pool, double *gram, int dof,
                         const mukca_part_layout *layout);

#endif
