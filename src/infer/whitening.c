/* Whitening of rows whose noise is correlated. */
#include "infer/whitening.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

bool mukca_whitening_create(mukca_whitening *w, mukca_pool *pool, int samples, int blocks, int dim)
{
    const int square = dim * dim;
    *w = (mukca_whitening){.diagonal = MUKCA_TAKE(pool, double, samples),
                           .before = MUKCA_TAKE(pool, double, samples),
                           .common = MUKCA_TAKE(pool, double, samples),
                           .level = MUKCA_TAKE(pool, double, samples),
                           .one = MUKCA_TAKE(pool, double, samples *square),
                           .total = MUKCA_TAKE(pool, double, blocks *square)};
    return !pool->failed;
}

/* V^-1/2 of m readings of one posture is (1 - f 11') / sqrt(1 - s), with the eigenvalue 1 - s + s m
 * of V along 1. */
static double common_factor(double shared, int m)
{
    return m > 0 && shared > 0 ? (1 - sqrt((1 - shared) / (1 - shared + shared * m))) / m : 0;
}

enum { CHUNK = 64, MOST_ROWS = 6 }; /* columns at a time, rows of a sample */

/* Columns x[n_samples][dim][ld] that a factor of V^-1/2, or its transpose, multiplies. */
typedef struct {
    double *x;
    int n, ld;
    bool transpose;
    const mukca_whitening *whitening;
    const mukca_samples *samples;
} factored;

/* Readings of postures whose normalised sums z are white: replace each z by (z - rho z') / sqrt(1 -
 * rho^2) with that of the preceding posture of the block; transposed, of the following one. */
MUKCA_INLINE void correlate_postures(double *x, size_t step, int count, double rho,
                                     const factored *f, int b)
{
    const mukca_samples *s = f->samples;
    const mukca_block *block = &s->block[b];
    const double a = 1 / sqrt(1 - rho * rho);
    double other[CHUNK] = {0};
    for (int t = 0; t < block->count; t++) {
        const int i = block->start + (f->transpose ? block->count - 1 - t : t);
        if (!s->readings[i]) continue;
        const double root = sqrt(s->readings[i]), scale = i == block->start ? 1 : a;
        double z[CHUNK] = {0};
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++) z[j] += x[(size_t)k * step + (size_t)j] / root;
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++)
                x[(size_t)k * step + (size_t)j] += ((scale - 1) * z[j] - a * rho * other[j]) / root;
        for (int j = 0; j < count; j++) other[j] = z[j];
    }
}

/* Rows x[d][n] of a sample: multiplied by L^-1 or its transpose. */
MUKCA_INLINE void divide(double *x, int n, size_t ld, const double *L, int d, bool transpose)
{
    for (int t = 0; t < d; t++) {
        const int a = transpose ? d - 1 - t : t;
        double *row = x + (size_t)a * ld;
        for (int b = 0; b < a && !transpose; b++)
            for (int j = 0; j < n; j++) row[j] -= L[a * d + b] * (x + (size_t)b * ld)[j];
        const double scale = 1 / L[a * d + a];
        for (int j = 0; j < n; j++) row[j] *= scale;
        for (int b = 0; b < a && transpose; b++)
            for (int j = 0; j < n; j++) (x + (size_t)b * ld)[j] -= L[a * d + b] * row[j];
    }
}

/* The same for all samples, or the means of postures and the deviations from them. */
MUKCA_INLINE void divide_by_shape(const factored *f, int b)
{
    const mukca_whitening *w = f->whitening;
    const mukca_samples *s = f->samples;
    const mukca_block *block = &s->block[b];
    const bool transpose = f->transpose;
    const int d = s->dim, n = f->n, ld = f->ld;
    double *x = f->x;
    for (int i = block->start; i < block->start + block->count; i++) {
        const int m = w->family.shared > 0 ? s->readings[i] : 1;
        const size_t at = (size_t)i * (size_t)(d * d);
        if (m == 1)
            divide(x + (size_t)(i * d) * (size_t)ld, n, (size_t)ld, w->shape.mean + at, d,
                   transpose);
        for (int start = 0; m > 1 && start < n; start += CHUNK) {
            const int count = n - start < CHUNK ? n - start : CHUNK;
            double mean[MOST_ROWS * CHUNK] = {0}, turned[MOST_ROWS * CHUNK];
            for (int k = i; k >= 0; k = s->next[k])
                for (int c = 0; c < d; c++) {
                    const double *row = x + (size_t)(k * d + c) * (size_t)ld + start;
                    for (int j = 0; j < count; j++) mean[c * CHUNK + j] += row[j] / m;
                }
            memcpy(turned, mean, sizeof turned);
            divide(turned, count, CHUNK, w->shape.mean + at, d, transpose);
            for (int k = i; k >= 0; k = s->next[k]) {
                double *rows = x + (size_t)(k * d) * (size_t)ld + start;
                for (int c = 0; c < d; c++)
                    for (int j = 0; j < count; j++)
                        rows[(size_t)c * (size_t)ld + (size_t)j] -= mean[c * CHUNK + j];
                divide(rows, count, (size_t)ld, w->shape.deviation + at, d, transpose);
                for (int c = 0; c < d; c++)
                    for (int j = 0; j < count; j++)
                        rows[(size_t)c * (size_t)ld + (size_t)j] += turned[c * CHUNK + j];
            }
        }
    }
}

/* Subtract the common part of the postures of a block. */
MUKCA_INLINE void subtract_common(double *white, size_t step, int count, const mukca_whitening *w,
                                  const mukca_samples *s, const mukca_block *block)
{
    for (int i = block->start; i < block->start + block->count; i++) {
        if (!(w->common[i] > 0)) continue;
        double sum[CHUNK] = {0};
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++) sum[j] += white[(size_t)k * step + (size_t)j];
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++)
                white[(size_t)k * step + (size_t)j] -= w->common[i] * sum[j];
    }
}

/* Factors of postures; that of the readings of one posture is symmetric. */
MUKCA_INLINE void divide_by_shared(const factored *f, int b)
{
    const mukca_whitening *w = f->whitening;
    const mukca_samples *s = f->samples;
    const size_t step = (size_t)s->dim * (size_t)f->ld;
    const double rho = w->family.rho;
    for (int c = 0; c < s->dim; c++)
        for (int start = 0; start < f->n; start += CHUNK) {
            const int count = f->n - start < CHUNK ? f->n - start : CHUNK;
            double *at = f->x + c * f->ld + start;
            if (!f->transpose) subtract_common(at, step, count, w, s, &s->block[b]);
            if (rho > 0) correlate_postures(at, step, count, rho, f, b);
            if (f->transpose) subtract_common(at, step, count, w, s, &s->block[b]);
        }
}

/* x[n_samples][dim][ld] := V^-1/2 x for n columns. */
MUKCA_INLINE void whiten(double *x, int n, int ld, const mukca_whitening *w, const mukca_samples *s)
{
    const size_t step = (size_t)s->dim * (size_t)ld;
    const factored f = {x, n, ld, false, w, s};
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        if (w->shape.mean) divide_by_shape(&f, b);
        for (int i = block->start + block->count - 1; i >= block->start; i--) {
            const double scale = w->diagonal[i], before = w->before[i];
            if (scale == 1 && !(before > 0)) continue;
            for (int c = 0; c < s->dim; c++) {
                double *row = x + (size_t)i * step + (size_t)(c * ld);
                for (int k = 0; k < n; k++) row[k] *= scale;
                for (int k = 0; k < n && before > 0; k++) row[k] -= before * (row - step)[k];
            }
        }
        if (w->family.shared > 0) divide_by_shared(&f, b);
    }
}

/* Logarithm of the determinants of the shapes. */
static double log_det_of_shape(const mukca_whitening *w, const mukca_samples *s)
{
    const int d = s->dim;
    double sum = 0;
    for (int i = 0; i < s->n_samples && w->shape.mean; i++) {
        const int m = w->family.shared > 0 ? s->readings[i] : 1;
        for (int c = 0; c < d && m; c++) {
            const size_t at = (size_t)(i * d + c) * (size_t)d + (size_t)c;
            sum += log(w->shape.mean[at]);
            if (m > 1) sum += (m - 1) * log(w->shape.deviation[at]);
        }
    }
    return sum;
}

void mukca_whitening_set(mukca_whitening *w, const mukca_samples *s, mukca_noise_family family,
                         mukca_noise_shape shape, const double *weight)
{
    const int d = s->dim;
    const double shared = family.shared, rho = shared > 0 ? 0 : family.rho,
                 scale = 1 / sqrt((1 - rho * rho) * (1 - shared));
    w->family = family;
    w->shape = shape;
    w->log_det = -log_det_of_shape(w, s);
    w->dof = 0;
    memset(w->one, 0, sizeof *w->one * (size_t)s->n_samples * (size_t)(d * d));
    for (int i = 0; i < s->n_samples; i++)
        for (int c = 0; c < d; c++) w->one[(i * d + c) * d + c] = 1;
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        const int end = block->start + block->count;
        int postures = 0;
        for (int i = block->start; i < end; i++) {
            const double by = weight ? weight[i] : 1;
            const bool first = i == block->start;
            const int m = s->readings[i];
            postures += m > 0;
            w->diagonal[i] = by * (first && rho != 0 ? 1 : scale);
            w->before[i] = first ? 0 : by * rho * scale;
            w->common[i] = common_factor(shared, m);
            for (int k = i; k >= 0 && m; k = shared > 0 ? s->next[k] : -1)
                w->level[k] = 1 - w->common[i] * m;
            if (m > 0 && shared > 0)
                w->log_det -= 0.5 * d * ((m - 1) * log(1 - shared) + log(1 - shared + shared * m));
        }
        for (int i = block->start; i < end; i++)
            w->level[i] = w->diagonal[i] * (shared > 0 ? w->level[i] : 1);
        if (block->count)
            w->log_det -= 0.5 * d * (shared > 0 ? postures - 1 : block->count - 1) *
                          log(1 - family.rho * family.rho);
        w->dof += d * block->count;
    }
    whiten(w->one, d, d, w, s);
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        double *total = w->total + b * d * d;
        if (!block->free_mean || !block->count) continue;
        memset(total, 0, sizeof *total * (size_t)(d * d));
        mukca_dense_syrk(total, d, w->one + block->start * d * d, block->count * d, d);
        mukca_dense_cholesky(total, d);
        w->dof -= d;
        for (int c = 0; c < d; c++) w->log_det -= log(total[c * d + c]);
    }
}

void mukca_whitening_solve(double *x, const mukca_whitening *w, int block, int dim)
{
    const double *total = w->total + block * dim * dim;
    mukca_dense_forward(x, 1, total, dim);
    mukca_dense_backward(x, 1, total, dim);
}

/* Subtract the components along the free means of a block, and return these means[d][ld]. */
MUKCA_INLINE void centre(const mukca_whitened *x, int start, const mukca_whitening *w,
                         const mukca_samples *s, int b)
{
    const mukca_block *block = &s->block[b];
    const int d = s->dim, first = block->start * d, last = (block->start + block->count) * d,
              n = x->n - start < CHUNK ? x->n - start : CHUNK, ld = x->ld;
    double *white = x->white + start, *mean = x->mean ? x->mean + b * d * ld + start : NULL;
    double sum[MOST_ROWS * CHUNK] = {0};
    for (int i = first; i < last; i++)
        for (int c = 0; c < d; c++) {
            const double one = w->one[i * d + c], *row = white + (size_t)i * (size_t)ld;
            for (int j = 0; j < n && one != 0; j++) sum[c * n + j] += one * row[j];
        }
    mukca_dense_forward(sum, n, w->total + b * d * d, d);
    mukca_dense_backward(sum, n, w->total + b * d * d, d);
    for (int i = first; i < last; i++)
        for (int c = 0; c < d; c++) {
            const double one = w->one[i * d + c];
            double *row = white + (size_t)i * (size_t)ld;
            for (int j = 0; j < n && one != 0; j++) row[j] -= one * sum[c * n + j];
        }
    for (int c = 0; c < d && mean; c++)
        memcpy(mean + c * ld, sum + c * n, sizeof *mean * (size_t)n);
}

MUKCA_CLONES void mukca_whitening_apply(const mukca_whitened *x, const mukca_whitening *w,
                                        const mukca_samples *s)
{
    const size_t ld = (size_t)x->ld;
    for (int b = 0; b < s->n_blocks && x->white != x->x; b++) {
        const mukca_block *block = &s->block[b];
        for (int i = block->start * s->dim; i < (block->start + block->count) * s->dim; i++)
            memcpy(x->white + (size_t)i * ld, x->x + (size_t)i * ld,
                   sizeof *x->white * (size_t)x->n);
    }
    whiten(x->white, x->n, x->ld, w, s);
    for (int b = 0; b < s->n_blocks; b++)
        for (int start = 0; start < x->n && s->block[b].free_mean && s->block[b].count;
             start += CHUNK)
            centre(x, start, w, s, b);
}

MUKCA_CLONES void mukca_whitening_transpose(double *out, const double *x, int n, int ld,
                                            const mukca_whitening *w, const mukca_samples *s)
{
    const size_t step = (size_t)s->dim * (size_t)ld;
    const factored f = {out, n, ld, true, w, s};
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        const int end = block->start + block->count;
        for (int i = block->start; i < end; i++)
            for (int c = 0; c < s->dim; c++) {
                const size_t at = (size_t)i * step + (size_t)(c * ld);
                const double after = i + 1 < end ? w->before[i + 1] : 0;
                for (int k = 0; k < n; k++)
                    out[at + (size_t)k] = w->diagonal[i] * x[at + (size_t)k];
                for (int k = 0; k < n && after > 0; k++)
                    out[at + (size_t)k] -= after * x[at + step + (size_t)k];
            }
        if (w->family.shared > 0) divide_by_shared(&f, b);
    }
    for (int b = 0; b < s->n_blocks && w->shape.mean; b++) divide_by_shape(&f, b);
}
