/* The population of a fleet's coefficients. */
#include "fleet/population.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

enum { T = MUKCA_FLEET_TERMS, ROUNDS = 60 };

/* Initial spread and its lower bound, rad/(N m): springs of 10 urad/(N m) that differ by a
 * tenth. */
#define FIRST_SPREAD 20e-6
#define LEAST_SPREAD 1e-6
/* Prior of the spread, with the weight of so many arms: gears of one type scatter by a fifth (data
 * sheets of strain wave gears state a minimum stiffness of 80 % of the mean), and two arms cannot
 * determine it. */
#define SPREAD_ARMS 2.0
#define USUAL_SCATTER 0.2
#define USUAL_SPREAD 4e-6 /* rad/(N m): a fifth of 20 urad/(N m), a typical spring */
/* Relative change at which the fit stops: far below the uncertainty with a thousand arms. */
#define SETTLED 1e-3
/* Prior sigma of a mean, rad/(N m): the largest size of mukca_sizes_spring. */
#define MOST_MEAN 300e-6

void mukca_population_arm(mukca_arm_evidence *a, const mukca_population *p, const mukca_fleet *f,
                          int arm)
{
    const double *packed = f->arm[arm].information;
    for (int i = 0; i < p->n; i++) {
        a->e[i] = f->arm[arm].vector[p->term[i]];
        for (int j = 0; j <= i; j++)
            a->L[i * p->n + j] = a->L[j * p->n + i] =
                packed[mukca_fleet_packed(p->term[i]) + p->term[j]];
    }
}

/* inverse := A^-1 for a symmetric A[n][n] (destroyed); false: not positive definite. */
static bool invert(double *inverse, double *A, int n)
{
    if (mukca_dense_cholesky(A, n)) return false;
    memset(inverse, 0, sizeof *inverse * (size_t)(n * n));
    for (int i = 0; i < n; i++) inverse[i * n + i] = 1;
    mukca_dense_forward(inverse, n, A, n);
    mukca_dense_backward(inverse, n, A, n);
    return true;
}

/* W = L - L C L, w = e - L C e with C = (L + V^-1)^-1, V^-1 = P. */
static bool scatter(mukca_arm_evidence *out, const mukca_arm_evidence *a, const double *P, int n)
{
    double A[T * T], C[T * T], CL[T * T], Ce[T];
    for (int i = 0; i < n * n; i++) A[i] = a->L[i] + P[i];
    if (!invert(C, A, n)) return false;
    for (int i = 0; i < n; i++) {
        Ce[i] = 0;
        for (int k = 0; k < n; k++) Ce[i] += C[i * n + k] * a->e[k];
        for (int j = 0; j < n; j++) {
            CL[i * n + j] = 0;
            for (int k = 0; k < n; k++) CL[i * n + j] += C[i * n + k] * a->L[k * n + j];
        }
    }
    for (int i = 0; i < n; i++) {
        out->e[i] = a->e[i];
        for (int k = 0; k < n; k++) out->e[i] -= a->L[i * n + k] * Ce[k];
        for (int j = 0; j <= i; j++) {
            double sum = a->L[i * n + j];
            for (int k = 0; k < n; k++) sum -= a->L[i * n + k] * CL[k * n + j];
            out->L[i * n + j] = out->L[j * n + i] = sum;
        }
    }
    return true;
}

bool mukca_population_scatter(mukca_arm_evidence *out, const mukca_arm_evidence *arm,
                              const double *V, int n)
{
    double A[T * T], P[T * T];
    memcpy(A, V, sizeof *A * (size_t)(n * n));
    return invert(P, A, n) && scatter(out, arm, P, n);
}

/* Select the coefficients on which at least one arm has information. */
static void choose_terms(mukca_population *p, const mukca_fleet *f)
{
    p->n = 0;
    for (int t = 0; t < f->n_terms; t++) {
        int arms = 0;
        for (int a = 0; a < f->n_arms; a++)
            arms += f->arm[a].information[mukca_fleet_packed(t) + t] > 0;
        if (!arms) continue;
        p->arms[p->n] = arms;
        p->term[p->n++] = t;
    }
}

/* Best non-negative mean: repeatedly fix the most negative coefficient at zero. */
static void solve_mean(mukca_population *p)
{
    const int n = p->n;
    bool held[T] = {false};
    double A[T * T], b[T];
    for (int round = 0; round <= n; round++) {
        int worst = -1;
        for (int i = 0; i < n; i++) {
            b[i] = held[i] ? 0 : p->vector[i];
            for (int j = 0; j <= i; j++)
                A[i * n + j] = i == j               ? (held[i] ? 1 : p->information[i * n + i])
                               : held[i] || held[j] ? 0
                                                    : p->information[i * n + j];
        }
        if (mukca_dense_cholesky(A, n)) return;
        mukca_dense_forward(b, 1, A, n);
        mukca_dense_backward(b, 1, A, n);
        for (int i = 0; i < n; i++)
            if (b[i] < 0 && (worst < 0 || b[i] < b[worst])) worst = i;
        if (worst < 0) break;
        held[worst] = true;
    }
    for (int i = 0; i < n; i++) p->mean[i] = fmax(b[i], 0);
}

/* Scatter of the arms about the mean: residual^2 and information on the diagonal. */
static void sum_arms(mukca_population *p, double *square, double *diagonal, const mukca_fleet *f,
                     int without)
{
    const int n = p->n;
    double P[T * T] = {0};
    mukca_arm_evidence arm = {0}, w = {0};
    for (int i = 0; i < n; i++) {
        P[i * n + i] = 1 / (p->spread[i] * p->spread[i]);
        square[i] = diagonal[i] = p->vector[i] = 0;
    }
    memset(p->information, 0, sizeof *p->information * (size_t)(n * n));
    p->n_arms = 0;
    for (int a = 0; a < f->n_arms; a++) {
        if (a == without || f->arm[a].departs) continue;
        mukca_population_arm(&arm, p, f, a);
        if (!scatter(&w, &arm, P, n)) continue;
        p->n_arms++;
        for (int i = 0; i < n; i++) {
            double r = w.e[i];
            for (int k = 0; k < n; k++) r -= w.L[i * n + k] * p->mean[k];
            square[i] += r * r;
            diagonal[i] += w.L[i * n + i];
            p->vector[i] += w.e[i];
        }
        for (int i = 0; i < n * n; i++) p->information[i] += w.L[i];
    }
    /* Coefficients identifiable only in combination are bounded by the size of springs. */
    for (int i = 0; i < n; i++) p->information[i * n + i] += 1 / (MOST_MEAN * MOST_MEAN);
}

/* Multiplicative steps for the spread (H. Zhou et al., MM algorithms for variance components
 * models, J. Comput. Graph. Stat. 28, 2019); each raises the restricted likelihood times the prior.
 */
static double step_spread(mukca_population *p, const double *square, const double *diagonal)
{
    double most = 0;
    for (int i = 0; i < p->n; i++) {
        const double usual = fmax(USUAL_SCATTER * p->mean[i], USUAL_SPREAD),
                     v = pow(p->spread[i], 2);
        /* correction for the fitted mean of n arms */
        const double lost = p->n_arms > 1 ? (double)p->n_arms / (p->n_arms - 1) : 1;
        const double next = sqrt((lost * square[i] * v * v + SPREAD_ARMS * usual * usual) /
                                 (diagonal[i] + SPREAD_ARMS / v));
        const double spread = fmax(sqrt(next), LEAST_SPREAD);
        const double change = fabs(spread / p->spread[i] - 1);
        if (change > most) most = change; /* fmax crashes gcc 12 for aarch64 */
        p->spread[i] = spread;
    }
    return most;
}

bool mukca_population_fit(mukca_population *p, const mukca_fleet *f, int without, bool warm)
{
    double square[T], diagonal[T], A[T * T];
    if (!warm) {
        choose_terms(p, f);
        for (int i = 0; i < p->n; i++) p->mean[i] = 0, p->spread[i] = FIRST_SPREAD;
    }
    for (int round = 0; round < ROUNDS; round++) {
        sum_arms(p, square, diagonal, f, without);
        solve_mean(p);
        if (round == 0) sum_arms(p, square, diagonal, f, without); /* residuals about that mean */
        if (step_spread(p, square, diagonal) < SETTLED) break;
    }
    sum_arms(p, square, diagonal, f, without);
    solve_mean(p);
    memcpy(A, p->information, sizeof *A * (size_t)(p->n * p->n));
    if (!invert(p->covariance, A, p->n)) p->n = 0;
    return mukca_population_average(p);
}
