/* Prior scales of geometry and causes by evidence.
 *
 * A scale is the prior sigma of a few columns.  The other columns are integrated out once: their
 * Schur complement is a small system of normal equations for all values of the scale.  For the
 * causes these systems are blocks of one inverse, with a low-rank update after each choice.
 */
#include "diagnose/scales.h"

#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "math/dense.h"

/* Normal equations of the remaining columns order[size - 1], and of y after them. */
typedef struct {
    int size;
    const int *order;
    double *A;           /* [size][size], both triangles */
    double log_diagonal; /* of the factor of the columns integrated out */
} marginal;

/* All columns in the given order. */
MUKCA_CLONES static void gather(marginal *out, const mukca_normal_equations *normal, double sigma,
                                double *scratch)
{
    const int size = normal->n + 1;
    const double precision = 1 / (sigma * sigma),
                 known = normal->distance_sigma * normal->distance_sigma;
    out->size = size;
    out->log_diagonal = 0;
    for (int i = 0; i < size; i++) {
        const int at = i + 1 < size ? out->order[i] : i;
        const double *row = normal->gram + (size_t)at * (size_t)size;
        double *A = out->A + (size_t)i * (size_t)size;
        for (int j = 0; j + 1 < size; j++) A[j] = precision * row[out->order[j]];
        A[size - 1] = precision * row[size - 1];
    }
    for (int p = 0; p < normal->n_pairs; p++) {
        const double *distance = normal->distance + p * size,
                     variance = known + sigma * sigma * normal->variance[p];
        for (int j = 0; j < size; j++) scratch[j] = distance[j + 1 < size ? out->order[j] : j];
        for (int i = 0; i < size; i++) {
            const double w = scratch[i] / variance;
            double *A = out->A + (size_t)i * (size_t)size;
            for (int j = 0; j < size && w != 0; j++) A[j] += w * scratch[j];
        }
    }
}

/* Integrate out the first k columns under the priors prior[order[]]; out->A is scratch, too. False:
 * not positive definite. */
static bool integrate(marginal *out, const marginal *in, int k, const double *prior)
{
    const int size = in->size, rest = size - k;
    double *L = out->A + (size_t)rest * (size_t)rest, *T = L + (size_t)k * (size_t)k;
    for (int i = 0; i < k; i++) {
        const double own = prior[in->order[i]];
        const double *A = in->A + (size_t)i * (size_t)size;
        for (int j = 0; j <= i; j++) L[i * k + j] = own * A[j] * prior[in->order[j]];
        L[i * k + i] += 1;
        for (int j = 0; j < rest; j++) T[i * rest + j] = own * A[k + j];
    }
    if (mukca_dense_cholesky(L, k)) return false;
    mukca_dense_forward(T, rest, L, k);
    memset(out->A, 0, sizeof *out->A * (size_t)(rest * rest));
    mukca_dense_syrk(out->A, rest, T, k, rest);
    for (int i = 0; i < rest; i++)
        for (int j = 0; j < rest; j++)
            out->A[i * rest + j] =
                in->A[(size_t)(k + i) * (size_t)size + (size_t)(k + j)] - out->A[i * rest + j];
    out->size = rest;
    out->order = in->order + k;
    out->log_diagonal = in->log_diagonal;
    for (int i = 0; i < k; i++) out->log_diagonal += log(L[i * k + i]);
    return true;
}

/* Log evidence, up to a constant, with these priors of the remaining columns. */
static double finish(marginal *scratch, const marginal *in, const double *prior)
{
    if (!integrate(scratch, in, in->size - 1, prior)) return -HUGE_VAL;
    return -0.5 * scratch->A[0] - scratch->log_diagonal;
}

typedef struct {
    mukca_unknowns *u;
    mukca_evidence *evidence;
    const mukca_recording *recording;
    const mukca_normal_equations *normal;
    int *order;                    /* [n] */
    marginal all, some, few, none; /* successively fewer columns */
} choice;

/* prior[n] of the geometry's scales. */
static void set_geometry(const choice *s, double length, double angle)
{
    s->u->sigma_length = length, s->u->sigma_angle = angle;
    mukca_unknowns_set_geometry_prior(s->u, s->recording);
    mukca_unknowns_prior(s->evidence->prior, s->u);
}

/* Append the columns before `end` with the mark `as`; returns the new number of columns. */
static int append(int *order, int n, const unsigned char *mark, int end, unsigned char as)
{
    for (int i = 0; i < end; i++)
        if (mark[i] == as) order[n++] = i;
    return n;
}

static void choose_geometry(choice *s)
{
    /* Errors of published arms: links 0.5 to 4 mm, axes 1 to 10 mrad. */
    static const double lengths[] = {0.5e-3, 1e-3, 2e-3, 4e-3};
    static const double angles[] = {1e-3, 2.5e-3, 5e-3, 10e-3};
    enum { FIXED, LENGTH, ANGLE };
    const int n = s->normal->n;
    double *prior = s->evidence->prior, best = -HUGE_VAL, length = s->u->sigma_length,
           angle = s->u->sigma_angle;
    unsigned char *mark = s->evidence->mark;
    memset(mark, FIXED, (size_t)n);
    set_geometry(s, lengths[0], angles[0]);
    memcpy(s->evidence->work, prior, sizeof *prior * (size_t)n);
    set_geometry(s, lengths[1], angles[0]);
    for (int i = 0; i < n; i++)
        if (prior[i] != s->evidence->work[i]) mark[i] = LENGTH;
    set_geometry(s, lengths[0], angles[1]);
    for (int i = 0; i < n; i++)
        if (prior[i] != s->evidence->work[i]) mark[i] = ANGLE;
    const int fixed = append(s->order, 0, mark, n, FIXED);
    const int both = append(s->order, fixed, mark, n, LENGTH);
    append(s->order, both, mark, n, ANGLE);
    gather(&s->all, s->normal, s->u->sigma, s->evidence->work);
    if (!integrate(&s->some, &s->all, fixed, prior)) return;
    for (int a = 0; a < 4; a++) {
        set_geometry(s, lengths[a], angles[0]);
        if (!integrate(&s->few, &s->some, both - fixed, prior)) continue;
        for (int b = 0; b < 4; b++) {
            set_geometry(s, lengths[a], angles[b]);
            const double value = finish(&s->none, &s->few, prior);
            if (value > best) best = value, length = lengths[a], angle = angles[b];
        }
    }
    set_geometry(s, length, angle);
}

/* V[k][k], the covariance of the causes' coefficients in units of their prior sigmas D, and the
 * mean x at the end of each row: V = (1 + D S D)^-1, x = V D s, with S and s the normal equations
 * after integrating out the geometry.  L and T are scratch. */
static bool find_covariance(double *V, double *L, double *T, const marginal *left,
                            const double *prior)
{
    const int size = left->size, k = size - 1;
    memset(T, 0, sizeof *T * (size_t)(k * size));
    for (int i = 0; i < k; i++) {
        const double own = prior[left->order[i]], *A = left->A + i * size;
        for (int j = 0; j <= i; j++) L[i * k + j] = own * A[j] * prior[left->order[j]];
        L[i * k + i] += 1;
        T[i * size + i] = 1;
        T[i * size + k] = own * A[k];
    }
    if (mukca_dense_cholesky(L, k)) return false;
    mukca_dense_forward(T, size, L, k);
    memset(V, 0, sizeof *V * (size_t)(size * size));
    mukca_dense_syrk(V, size, T, k, size);
    return true;
}

/* L L' = K = f + (1 - f) B, where B is the block [at, at + n) of V[][size] and f the square of the
 * factor applied to the priors of these columns.  With all other columns integrated out, their
 * normal equations are B^-1 - 1 before and f (B^-1 - 1) after: 1 + f (B^-1 - 1) = B^-1 K. */
static bool factor_block(double *L, const double *V, int size, int at, int n, double f)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++)
            L[i * n + j] = (1 - f) * V[(at + i) * size + at + j] + (i == j ? f : 0);
    return mukca_dense_cholesky(L, n) == 0;
}

/* y := (L L')^-1 x for the means x of these columns. */
static void solve_block(double *y, const double *L, const double *V, int size, int at, int n)
{
    for (int i = 0; i < n; i++) y[i] = V[(at + i) * size + size - 1];
    mukca_dense_forward(y, 1, L, n);
    mukca_dense_backward(y, 1, L, n);
}

/* Update V and x for this factor: V -= (1 - f) V[][at] K^-1 V[at][] (Woodbury).  T is scratch. */
static void widen(double *V, double *T, double *L, int size, int at, int n, double f)
{
    double *lost = T + n * size;
    if (!factor_block(L, V, size, at, n, f)) return;
    memcpy(T, V + at * size, sizeof *T * (size_t)(n * size));
    mukca_dense_forward(T, size, L, n);
    memset(lost, 0, sizeof *lost * (size_t)(size * size));
    mukca_dense_syrk(lost, size, T, n, size);
    for (int i = 0; i < size * size; i++) V[i] -= (1 - f) * lost[i];
}

/* Choose the scale of a cause with columns of V from `at` on; T and L are scratch. */
static void choose_cause(mukca_accepted *cause, double *V, double *T, double *L, int size, int at)
{
    double y[MUKCA_MAX_COLUMNS], x[MUKCA_MAX_COLUMNS];
    double scales[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES], chosen = 1, best = -HUGE_VAL;
    const double own = cause->scale;
    const int n = cause->candidate.terms,
              n_scales = mukca_candidate_scales(scales, weight, &cause->candidate);
    if (!factor_block(L, V, size, at, n, 0)) return;
    solve_block(y, L, V, size, at, n);
    for (int i = 0; i < n_scales; i++) {
        const double f = scales[i] * scales[i] / (own * own);
        double value = weight[i];
        if (!factor_block(L, V, size, at, n, f)) continue;
        solve_block(x, L, V, size, at, n);
        for (int k = 0; k < n; k++) value += 0.5 * f * x[k] * y[k] - log(L[k * n + k]);
        if (value > best) best = value, chosen = f, cause->scale = scales[i];
    }
    if (chosen != 1) widen(V, T, L, size, at, n, chosen);
}

static void choose_causes(choice *s)
{
    mukca_unknowns *u = s->u;
    const int n = s->normal->n;
    double *V = s->none.A, *scratch = s->all.A;
    for (int i = 0; i < n; i++) s->order[i] = i;
    gather(&s->all, s->normal, s->u->sigma, s->evidence->work);
    if (!integrate(&s->few, &s->all, u->n_geometry, s->evidence->prior) ||
        !find_covariance(V, s->some.A, scratch, &s->few, s->evidence->prior))
        return;
    for (int c = 0, at = 0; c < u->n_causes; at += u->cause[c++].candidate.terms)
        if (!u->cause[c].known) choose_cause(&u->cause[c], V, scratch, s->some.A, s->few.size, at);
    mukca_unknowns_prior(s->evidence->prior, u);
}

void mukca_scales_choose(mukca_unknowns *u, mukca_evidence *evidence,
                         const mukca_recording *recording, const mukca_normal_equations *normal)
{
    const size_t square = (size_t)(normal->n + 1) * (size_t)(normal->n + 1);
    choice s = {.u = u, .evidence = evidence, .recording = recording, .normal = normal};
    double *A = evidence->marginal;
    s.order = evidence->order;
    s.all = (marginal){.order = s.order, .A = A};
    s.some.A = A + square;
    s.few.A = A + 2 * square;
    s.none.A = A + 3 * square;
    choose_geometry(&s);
    if (u->n_causes) choose_causes(&s);
}
