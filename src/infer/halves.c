/* Normal equations of a part of the rows. */
#include "infer/halves.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

bool mukca_part_question(mukca_question *question, mukca_pool *pool, double *gram, int dof,
                         const mukca_part_layout *l)
{
    const int n = l->n, rest = 1 + l->n_columns, width = n + rest, wide = (rest + 7) & ~7,
              stride = ((l->n_columns + 7) | 8) & ~7;
    mukca_pool scratch = {0};
    double *L = MUKCA_TAKE(&scratch, double, n *n + 1),
           *T = MUKCA_TAKE(&scratch, double, n *wide + 1),
           *explained = MUKCA_TAKE(&scratch, double, wide *wide),
           *G = MUKCA_TAKE(pool, double, (l->n_columns + 1) * stride),
           *g = MUKCA_TAKE(pool, double, stride + 1);
    pool->failed |= scratch.failed;
    bool ok = !pool->failed;
    for (int i = 0; i < n && ok; i++) {
        memcpy(L + i * n, gram + i * width, sizeof *L * (size_t)n);
        L[i * n + i] += 1;
        memcpy(T + i * wide, gram + i * width + n, sizeof *T * (size_t)rest);
    }
    ok = ok && mukca_dense_cholesky(L, n);
    if (ok) {
        mukca_dense_forward8(T, wide, wide, L, n);
        mukca_dense_symmetric(explained, (mukca_columns){T, wide, wide},
                              (mukca_columns){T, wide, wide}, n);
    }
    for (int i = 0; i < rest && ok; i++) {
        const double *all = gram + (n + i) * width + n, *less = explained + i * wide;
        for (int k = 1; k < rest && i > 0; k++) G[(i - 1) * stride + k - 1] = all[k] - less[k];
        if (i > 0) g[i - 1] = all[0] - less[0];
    }
    *question =
        (mukca_question){.n_items = l->n_items,
                         .n_columns = l->n_columns,
                         .stride = stride,
                         .dof = dof,
                         .item = l->item,
                         .gram = G,
                         .g = g,
                         .residual = ok ? fmax(gram[n * width + n] - explained[0], 1e-9) : 0};
    mukca_pool_free(&scratch);
    return ok;
}
