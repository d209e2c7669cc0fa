/* Noise sigma of maximal evidence. */
#include "diagnose/noise.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

/* Range of the search, m: from below any encoder to far above any arm. */
#define LEAST_NOISE 1e-6
#define MOST_NOISE 5e-2

/* Log evidence behind the best family from which one is negligible (3 million to 1), and
 * the share of a candidate's gain that may reduce this difference. */
#define NEGLIGIBLE 15.0
#define SHARE 0.25

/* Evidence as a function of the noise.  With K = 1 + D G D / sigma^2 = Q (1 + T / sigma^2) Q' and
 * the distances predicted from the samples, it depends on T, Q'D X'W y and Q'D d for each distance
 * row d; each value costs O(n).  Columns are excluded by the Schur complement of their block of
 * K^-1, which needs rows of Q: one reduction serves every cause in turn. */
typedef struct {
    mukca_evidence *evidence;
    const mukca_normal_equations *normal;
    mukca_left_out out;
    bool reduced;    /* T and B exist; else each value costs a factorisation */
    double *scratch; /* [n][k], [k][k] and two factors, k = 1 + n_pairs + out.count */
} along_noise;

/* Rounding errors of T are 1e-16 of its norm, which is at most its trace: 1 % of the identity. */
#define MOST_TRACE 1e14

/* Compute T and B of these normal equations and priors, unless they exist.  False: factorisations
 * are preferable (free frames of a pose log, many distances).  `least` is the smallest noise to be
 * evaluated. */
static bool reduce(mukca_normal_equations *normal, mukca_evidence *evidence,
                   const mukca_left_out *out, double least)
{
    const double *prior = evidence->prior;
    const int n = normal->n, size = n + 1, units = out->count ? out->from : n,
              k = 1 + normal->n_pairs + n - units;
    const size_t bytes = sizeof *prior * (size_t)n;
    double *A = evidence->factor, trace = 0;
    for (int i = 0; i < n; i++) trace += prior[i] * normal->gram[i * size + i] * prior[i];
    if (k > n || !(trace < MOST_TRACE * least * least)) return false;
    if (normal->reduced && normal->units <= units &&
        memcmp(normal->reduced_prior, prior, bytes) == 0)
        return true;
    memcpy(normal->reduced_prior, prior, bytes);
    normal->reduced = true;
    normal->units = units;
    for (int i = 0; i < n; i++) {
        double *B = normal->B + (size_t)i * (size_t)k;
        for (int j = i; j < n; j++) A[i * n + j] = prior[i] * normal->gram[i * size + j] * prior[j];
        B[0] = prior[i] * normal->gram[n * size + i];
        for (int p = 0; p < normal->n_pairs; p++)
            B[1 + p] = prior[i] * normal->distance[p * size + i];
        for (int u = units; u < n; u++) B[1 + normal->n_pairs + u - units] = u == i;
    }
    mukca_dense_tridiagonalise(A, n, normal->T, normal->B, k);
    return true;
}

/* Rows of Y := L^-1 B / sqrt(C), with L C L' = 1 + T / sigma^2: its Gram matrix is B'(1 + T /
 * sigma^2)^-1 B, for the relevant columns of B.  Returns log |C|, NaN: not positive. */
static double eliminate(double *Y, const along_noise *a, double precision)
{
    const mukca_normal_equations *normal = a->normal;
    const int n = normal->n, shared = 1 + normal->n_pairs, k = shared + a->out.count,
              ldb = shared + n - normal->units;
    const int skip = a->out.column - normal->units; /* columns of B before the excluded ones */
    const double *T = normal->T, *B = normal->B;
    double pivot = 1, log_det = 0, product = 1;
    for (int i = 0; i < n; i++, B += ldb, Y += k) {
        const double beside = i ? precision * T[n + i - 1] : 0, l = i ? beside / pivot : 0,
                     root = sqrt(pivot);
        pivot = 1 + precision * T[i] - beside * l;
        if (!(pivot > 0)) return NAN;
        const double inverse = 1 / sqrt(pivot);
        for (int c = 0; c < k; c++)
            Y[c] = (B[c < shared ? c : skip + c] - (i ? l * root * Y[c - k] : 0)) * inverse;
        product *= pivot; /* one logarithm for several factors */
        if (product > 1e100 || i + 1 == n) log_det += log(product), product = 1;
    }
    return log_det;
}

/* Eliminate the last `count` rows and columns of G[k][k] by their Schur complement.  Returns the
 * log determinant of their block, NaN: not positive. */
static double eliminate_last(double *G, double *scratch, int k, int count)
{
    const int rest = k - count;
    double *V = scratch, *T = V + count * count, log_det = 0;
    for (int i = 0; i < count; i++) {
        memcpy(V + i * count, G + (rest + i) * k + rest, sizeof *V * (size_t)count);
        memcpy(T + i * rest, G + (rest + i) * k, sizeof *T * (size_t)rest);
    }
    if (mukca_dense_cholesky(V, count)) return NAN;
    mukca_dense_forward(T, rest, V, count);
    for (int i = 0; i < count; i++) {
        log_det += 2 * log(V[i * count + i]);
        for (int a = 0; a < rest; a++)
            for (int b = 0; b < rest; b++) G[a * k + b] -= T[i * rest + a] * T[i * rest + b];
    }
    return log_det;
}

/* Evidence by a factorisation. */
static double evaluate(const along_noise *a, double sigma)
{
    double *prior = a->evidence->prior + a->out.column, kept[MUKCA_MAX_COLUMNS];
    const size_t bytes = sizeof *prior * (size_t)a->out.count;
    memcpy(kept, prior, bytes);
    memset(prior, 0, bytes); /* a prior sigma of 0 excludes them */
    const double value = mukca_evidence_evaluate(a->evidence, a->normal, sigma, NULL);
    memcpy(prior, kept, bytes);
    return value;
}

static double minus_evidence(void *context, double log_sigma)
{
    const along_noise *a = context;
    const mukca_normal_equations *normal = a->normal;
    const double sigma = exp(log_sigma), precision = 1 / (sigma * sigma),
                 known = normal->distance_sigma * normal->distance_sigma;
    const int n = normal->n, size = n + 1, pairs = normal->n_pairs, k = 1 + pairs + a->out.count;
    if (!a->reduced) return -evaluate(a, sigma);
    double *Y = a->scratch, *G = Y + n * k, *S = G + k * k, *r = S + k * k;
    double log_det = eliminate(Y, a, precision);
    memset(G, 0, sizeof *G * (size_t)(k * k));
    mukca_dense_syrk(G, k, Y, n, k);
    log_det += eliminate_last(G, S, k, a->out.count);
    double quadratic = precision * (normal->gram[size * size - 1] - precision * G[0]);
    for (int p = 0; p < pairs; p++) { /* residuals of the distances, given the samples */
        r[p] = normal->distance[p * size + n] - precision * G[1 + p];
        for (int q = 0; q <= p; q++) S[p * pairs + q] = G[(1 + p) * k + 1 + q];
        S[p * pairs + p] += known + sigma * sigma * normal->variance[p];
    }
    if (!isfinite(log_det) || mukca_dense_cholesky(S, pairs)) return HUGE_VAL;
    mukca_dense_forward(r, 1, S, pairs);
    for (int p = 0; p < pairs; p++) {
        quadratic += r[p] * r[p];
        log_det += 2 * log(S[p * pairs + p]);
    }
    return 0.5 * (quadratic + log_det) + normal->whitening.dof * log_sigma -
           normal->whitening.log_det;
}

double mukca_noise_choose(mukca_evidence *evidence, mukca_normal_equations *normal,
                          const mukca_left_out *out, double guess, double *value)
{
    const double tolerance = 0.01; /* a hundredth of sigma: far below its uncertainty */
    const mukca_left_out none = {0};
    if (!out) out = &none;
    along_noise context = {.evidence = evidence,
                           .normal = normal,
                           .out = *out,
                           .reduced = reduce(normal, evidence, out, guess / 2),
                           .scratch = evidence->marginal};
    double best, lo = log(guess / 2), hi = log(2 * guess);
    double x = mukca_stats_minimize(&best, minus_evidence, &context, lo, hi, tolerance);
    if (x < lo + 5 * tolerance ||
        x > hi - 5 * tolerance) { /* a bad guess: search the whole range */
        context.reduced = false;
        x = mukca_stats_minimize(&best, minus_evidence, &context, log(LEAST_NOISE), log(MOST_NOISE),
                                 tolerance);
    }
    if (value) *value = -best;
    return exp(x);
}

bool mukca_noise_counts(double behind, double gain)
{
    return behind <= NEGLIGIBLE + SHARE * fmax(gain, 0);
}

bool mukca_noise_contends(const mukca_evidence *evidence, int index, double best, double gain)
{
    /* the other coefficient may have gained as much as the best one has changed */
    const double approach = fabs(best - evidence->best);
    return mukca_noise_counts(evidence->normal[index].behind - approach, gain);
}
