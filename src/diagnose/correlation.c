/* Canonical correlation of two candidates. */
#include "diagnose/correlation.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

/* Copy a block of G[ld][ld]: rows from `row`, columns from `column`. */
static void copy_block(double *block, int rows, int columns, const double *G, int ld)
{
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) block[i * columns + j] = G[i * ld + j];
}

static void transpose(double *out, const double *in, int rows, int columns)
{
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) out[j * rows + i] = in[i * columns + j];
}

/* Factor a Gram block that may be singular to rounding. */
static bool factor(double *block, int n)
{
    for (int i = 0; i < n; i++) block[i * n + i] *= 1 + 1e-9;
    return mukca_dense_cholesky(block, n) == 0;
}

/* With projected Gram blocks A = L L', B = M M' and their cross block C, the canonical correlations
 * are the singular values of L^-1 C M'^-1 (Golub and Van Loan, Matrix Computations, 6.4.3). */
double mukca_correlation_canonical(mukca_projector *p, const mukca_candidate *a,
                                   const mukca_candidate *b)
{
    enum { MOST = MUKCA_MAX_COLUMNS };
    double G[MOST * MOST], g[MOST], A[MOST * MOST], B[MOST * MOST], C[MOST * MOST], s[MOST];
    const int k = a->terms + b->terms, ka = mukca_candidate_own_terms(a),
              kb = mukca_candidate_own_terms(b);
    const mukca_regression *m = p->m;
    if (k > MOST || a->kind == MUKCA_CANDIDATE_DISTANCE || b->kind == MUKCA_CANDIDATE_DISTANCE)
        return NAN;
    mukca_linearisation_columns(p->scratch.E, k, &m->linear, &m->recording, a);
    mukca_linearisation_columns(p->scratch.E + a->terms, k, &m->linear, &m->recording, b);
    mukca_projector_project(G, g, p, k, a);
    copy_block(A, ka, ka, G, k);
    copy_block(B, kb, kb, G + a->terms * k + a->terms, k);
    copy_block(C, ka, kb, G + a->terms, k);
    if (!factor(A, ka) || !factor(B, kb)) return NAN;
    mukca_dense_forward(C, kb, A, ka);
    transpose(G, C, ka, kb);
    mukca_dense_forward(G, ka, B, kb);
    if (ka > kb) { /* the transpose has the same singular values */
        transpose(C, G, kb, ka);
        memcpy(G, C, sizeof *G * (size_t)(ka * kb));
    }
    if (mukca_dense_svd(G, s, NULL, ka > kb ? ka : kb, ka > kb ? kb : ka)) return NAN;
    return fmin(s[0], 1);
}
