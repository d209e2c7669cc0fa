/* Resampling of the recording: what another recording of this arm would say.
 *
 * The products of columns with residuals are sums over postures.  Each draw adds the terms of a
 * posture or subtracts them: to first order a fit to postures drawn anew (Kline and Santos, Journal
 * of Econometric Methods 1, 2012). */
#include "diagnose/scan.h"

#include <math.h>

#include "base/hash.h"
#include "math/dense.h"

enum { CHUNK = 256 }; /* rows processed together */

/* Bits of the draws, shared by the readings of a posture, whatever the order of the rows. */
static void draw(uint64_t *bits, const mukca_recording *r)
{
    const mukca_samples *samples = &r->samples;
    const int n = r->chain->n_joints;
    for (int i = 0; i < r->n_samples; i++) {
        if (!samples->readings[i]) continue;
        uint64_t sum = 0;
        for (int k = i; k >= 0; k = samples->next[k]) {
            int64_t q[MUKCA_MAX_JOINTS] = {
                0}; /* in microradians: units of the file do not matter */
            for (int j = 0; j < n; j++) q[j] = llround(1e6 * r->data->q[r->order[k] * n + j]);
            sum += mukca_hash(MUKCA_HASH_START, q, sizeof *q * (size_t)n);
        }
        sum = mukca_hash(MUKCA_HASH_START, &sum, sizeof sum);
        sum = mukca_hash(sum ^ sum >> 32, &sum, sizeof sum);
        for (int k = i; k >= 0; k = samples->next[k]) bits[k] = sum;
    }
}

double *mukca_scan_resample(mukca_pool *pool, const mukca_scan *s, const mukca_question *question,
                            const double *mean)
{
    const mukca_recording *r = &s->m->recording;
    const mukca_linearisation *linear = &s->m->linear;
    const int n = s->n, stride = question->stride, dim = r->dim, rows = r->n_samples * dim,
              ld = linear->stride, projected = question->n_rows - n;
    const double *T = question->E + (size_t)projected * (size_t)stride, root = sqrt(s->precision);
    uint64_t *bits = MUKCA_TAKE(pool, uint64_t, r->n_samples);
    double *delta = MUKCA_TAKE(pool, double, (stride + 1) * (int)MUKCA_DRAWS),
           *U = MUKCA_TAKE(pool, double, CHUNK *(int)MUKCA_DRAWS),
           *X = MUKCA_TAKE(pool, double, CHUNK *(n + 1)),
           *H = MUKCA_TAKE(pool, double, (n + 1) * MUKCA_DRAWS),
           *geometry = MUKCA_TAKE(pool, double, n + 1);
    if (pool->failed) return NULL;
    draw(bits, r);
    for (int t = 0; t < n; t++) {
        geometry[t] = s->z[t];
        for (int k = 0; k < stride; k++) geometry[t] -= T[t * stride + k] * mean[k];
    }
    mukca_dense_backward(geometry, 1, s->m->evidence.posterior.factor, n);
    for (int first = 0; first < rows; first += CHUNK) {
        const int count = rows - first < CHUNK ? rows - first : CHUNK;
        for (int i = 0; i < count; i++) {
            const double *x = s->white + (size_t)(first + i) * (size_t)ld,
                         *e = question->E + (size_t)(first + i) * (size_t)stride;
            double rest = root * x[linear->y]; /* of the row, in units of the noise */
            for (int t = 0; t < n; t++) {
                X[i * n + t] = root * s->prior[t] * x[t];
                rest -= X[i * n + t] * geometry[t];
            }
            for (int k = 0; k < stride; k++) rest -= e[k] * mean[k];
            for (int b = 0; b < MUKCA_DRAWS; b++)
                U[i * MUKCA_DRAWS + b] = bits[(first + i) / dim] >> b & 1 ? rest : -rest;
        }
        const mukca_columns u = {U, MUKCA_DRAWS, MUKCA_DRAWS};
        mukca_dense_xty(H, (mukca_columns){X, n, n}, u, count);
        mukca_dense_xty(
            delta, (mukca_columns){&question->E[(size_t)first * (size_t)stride], stride, stride}, u,
            count);
    }
    mukca_dense_forward8(H, MUKCA_DRAWS, MUKCA_DRAWS, s->m->evidence.posterior.factor, n);
    for (int t = 0; t < n * MUKCA_DRAWS; t++) H[t] = -H[t];
    mukca_dense_xty(delta, (mukca_columns){T, stride, stride},
                    (mukca_columns){H, MUKCA_DRAWS, MUKCA_DRAWS}, n);
    return delta;
}
