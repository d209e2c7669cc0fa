/* Whitening of rows whose noise is correlated. */
#include "infer/whitening.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

bool mukca_whitening_create(mukca_whitening *w, mukca_pool *pool, int samples, int blocks)
{
    *w = (mukca_whitening){.own = MUKCA_TAKE(pool, double, samples),
                           .before = MUKCA_TAKE(pool, double, samples),
                           .common = MUKCA_TAKE(pool, double, samples),
                           .one = MUKCA_TAKE(pool, double, samples),
                           .total = MUKCA_TAKE(pool, double, blocks)};
    return !pool->failed;
}

/* V^-1/2 of m readings of one posture is (1 - f 11') / sqrt(1 - s), with the eigenvalue 1 - s + s m
 * of V along 1. */
static double common_factor(double shared, int m)
{
    return m > 0 && shared > 0 ? (1 - sqrt((1 - shared) / (1 - shared + shared * m))) / m : 0;
}

enum { CHUNK = 64, MOST_ROWS = 6 }; /* columns at a time, rows of a sample */

/* Readings of postures whose normalised sums z are white: replace each z by (z - rho z') / sqrt(1 -
 * rho^2) with that of the preceding posture of the block. */
MUKCA_INLINE void correlate_postures(double *x, size_t step, int count, double rho,
                                     const mukca_samples *s, const mukca_block *block)
{
    const double a = 1 / sqrt(1 - rho * rho);
    double before[CHUNK] = {0};
    for (int i = block->start; i < block->start + block->count; i++) {
        if (!s->readings[i]) continue;
        const double root = sqrt(s->readings[i]), own = i == block->start ? 1 : a;
        double z[CHUNK] = {0};
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++) z[j] += x[(size_t)k * step + (size_t)j] / root;
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++)
                x[(size_t)k * step + (size_t)j] +=
                    ((own - 1) * z[j] - (i == block->start ? 0 : a * rho * before[j])) / root;
        for (int j = 0; j < count; j++) before[j] = z[j];
    }
}

/* The transpose of that. */
MUKCA_INLINE void correlate_back(double *x, size_t step, int count, double rho,
                                 const mukca_samples *s, const mukca_block *block)
{
    const double a = 1 / sqrt(1 - rho * rho);
    double after[CHUNK] = {0};
    for (int i = block->start + block->count - 1; i >= block->start; i--) {
        if (!s->readings[i]) continue;
        const double root = sqrt(s->readings[i]), own = i == block->start ? 1 : a;
        double z[CHUNK] = {0};
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++) z[j] += x[(size_t)k * step + (size_t)j] / root;
        for (int k = i; k >= 0; k = s->next[k])
            for (int j = 0; j < count; j++)
                x[(size_t)k * step + (size_t)j] += ((own - 1) * z[j] - a * rho * after[j]) / root;
        for (int j = 0; j < count; j++) after[j] = z[j];
    }
}

void mukca_whitening_set(mukca_whitening *w, const mukca_samples *s, mukca_noise_family family,
                         const double *weight, const double *shape)
{
    const double shared = family.shared, rho = shared > 0 ? 0 : family.rho,
                 scale = 1 / sqrt((1 - rho * rho) * (1 - shared));
    w->family = family;
    w->shape = shared > 0 ? shape : NULL;
    w->log_det = 0;
    w->dof = 0;
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        const int end = block->start + block->count;
        double total = 0;
        int postures = 0;
        for (int i = block->start; i < end; i++) {
            const double by = weight ? weight[i] : 1;
            const bool first = i == block->start;
            const int m = s->readings[i];
            postures += m > 0;
            w->own[i] = by * (first && rho != 0 ? 1 : scale);
            w->before[i] = first ? 0 : by * rho * scale;
            w->common[i] = common_factor(shared, m);
            w->one[i] = w->own[i] - w->before[i];
            if (m > 0 && shared > 0)
                w->log_det -=
                    0.5 * s->dim * ((m - 1) * log(1 - shared) + log(1 - shared + shared * m));
            for (int c = 0; c < s->dim && m > 1 && w->shape; c++)
                w->log_det -= (m - 1) * log(w->shape[(i * s->dim + c) * s->dim + c]);
        }
        for (int i = block->start; i < end; i++)
            for (int k = i; k >= 0 && w->common[i] > 0; k = s->next[k])
                w->one[k] -= w->common[i] * s->readings[i] * w->own[k];
        if (shared > 0 && family.rho > 0) correlate_postures(w->one, 1, 1, family.rho, s, block);
        for (int i = block->start; i < end; i++) total += w->one[i] * w->one[i];
        w->total[b] = total;
        if (!block->count) continue;
        w->log_det -= 0.5 * s->dim * (shared > 0 ? postures - 1 : block->count - 1) *
                      log(1 - family.rho * family.rho);
        w->dof += s->dim * block->count;
        if (!block->free_mean) continue;
        w->dof -= s->dim;
        w->log_det -= 0.5 * s->dim * log(total);
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

/* Multiply the deviations from the mean of each posture by L^-1, or by its transpose. */
static void divide_by_shape(double *x, int n, int ld, bool transpose, const mukca_whitening *w,
                            const mukca_samples *s)
{
    const int d = s->dim;
    for (int i = 0; i < s->n_samples; i++)
        for (int start = 0; start < n && s->readings[i] > 1; start += CHUNK) {
            const int count = n - start < CHUNK ? n - start : CHUNK;
            const double *L = w->shape + (size_t)i * (size_t)(d * d);
            double mean[MOST_ROWS * CHUNK] = {0}, deviation[MOST_ROWS * CHUNK];
            for (int k = i; k >= 0; k = s->next[k])
                for (int c = 0; c < d; c++) {
                    const double *row = x + (size_t)(k * d + c) * (size_t)ld + start;
                    for (int j = 0; j < count; j++) mean[c * count + j] += row[j] / s->readings[i];
                }
            for (int k = i; k >= 0; k = s->next[k]) {
                double *rows = x + (size_t)(k * d) * (size_t)ld + start;
                for (int c = 0; c < d; c++)
                    for (int j = 0; j < count; j++)
                        deviation[c * count + j] = rows[c * ld + j] - mean[c * count + j];
                (transpose ? mukca_dense_backward : mukca_dense_forward)(deviation, count, L, d);
                for (int c = 0; c < d; c++)
                    for (int j = 0; j < count; j++)
                        rows[c * ld + j] = mean[c * count + j] + deviation[c * count + j];
            }
        }
}

/* Subtract the component along the free mean of a block. */
MUKCA_INLINE void centre(double *white, double *mean, size_t step, int count,
                         const mukca_whitening *w, const mukca_block *block, int b)
{
    double sum[CHUNK] = {0};
    for (int i = block->start; i < block->start + block->count; i++)
        for (int j = 0; j < count; j++) sum[j] += w->one[i] * white[(size_t)i * step + (size_t)j];
    for (int j = 0; j < count; j++) sum[j] /= w->total[b];
    for (int i = block->start; i < block->start + block->count; i++)
        for (int j = 0; j < count; j++) white[(size_t)i * step + (size_t)j] -= w->one[i] * sum[j];
    if (mean) memcpy(mean, sum, sizeof *mean * (size_t)count);
}

MUKCA_CLONES void mukca_whitening_apply(const mukca_whitened *x, const mukca_whitening *w,
                                        const mukca_samples *s)
{
    const size_t ld = (size_t)x->ld, step = (size_t)s->dim * ld;
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        for (int i = block->start; i < block->start + block->count; i++) {
            const double own = w->own[i], before = w->before[i];
            for (int c = 0; c < s->dim; c++) {
                const double *in = x->x + (size_t)i * step + (size_t)c * ld;
                double *out = x->white + (size_t)i * step + (size_t)c * ld;
                for (int k = 0; k < x->n; k++) out[k] = own * in[k];
                for (int k = 0; k < x->n && before > 0; k++) out[k] -= before * (in - step)[k];
            }
        }
        for (int c = 0; c < s->dim && block->count; c++)
            for (int start = 0; start < x->n; start += CHUNK) {
                const int count = x->n - start < CHUNK ? x->n - start : CHUNK;
                const size_t at = (size_t)c * ld + (size_t)start;
                if (w->family.shared > 0) subtract_common(x->white + at, step, count, w, s, block);
                if (w->family.shared > 0 && w->family.rho > 0)
                    correlate_postures(x->white + at, step, count, w->family.rho, s, block);
                if (block->free_mean)
                    centre(x->white + at, x->mean ? x->mean + (size_t)b * step + at : NULL, step,
                           count, w, block, b);
            }
    }
    if (w->shape) divide_by_shape(x->white, x->n, x->ld, false, w, s);
}

MUKCA_CLONES void mukca_whitening_transpose(double *out, const double *x, int n, int ld,
                                            const mukca_whitening *w, const mukca_samples *s)
{
    const size_t step = (size_t)s->dim * (size_t)ld;
    for (int b = 0; b < s->n_blocks; b++) {
        const mukca_block *block = &s->block[b];
        const int end = block->start + block->count;
        for (int i = block->start; i < end; i++)
            for (int c = 0; c < s->dim; c++) {
                const size_t at = (size_t)i * step + (size_t)(c * ld);
                const double after = i + 1 < end ? w->before[i + 1] : 0;
                for (int k = 0; k < n; k++) out[at + (size_t)k] = w->own[i] * x[at + (size_t)k];
                for (int k = 0; k < n && after > 0; k++)
                    out[at + (size_t)k] -= after * x[at + step + (size_t)k];
            }
        /* the factor of readings of one posture is symmetric */
        for (int c = 0; c < s->dim && w->family.shared > 0; c++)
            for (int start = 0; start < n; start += CHUNK) {
                const int count = n - start < CHUNK ? n - start : CHUNK;
                if (w->family.rho > 0)
                    correlate_back(out + c * ld + start, step, count, w->family.rho, s, block);
                subtract_common(out + c * ld + start, step, count, w, s, block);
            }
    }
    if (w->shape) divide_by_shape(out, n, ld, true, w, s);
}
