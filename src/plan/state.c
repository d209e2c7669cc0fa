/* Posterior covariance of the unknowns: updates by samples, information gains, expected errors. */
#include "plan/state.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/four.h"
#include "math/stats.h"

/* Prior standard deviation of a socket's position on the table, m: it is positioned by eye. */
static const double prior_socket = 5e-2;
/* Standard deviation of the distance between two sockets of the printed tool, m: a good printer. */
static const double distance_sigma = 5e-5;
/* Prior standard deviation of a cause relative to its stated size: wide, so that the data
 * dominate. */
static const double prior_cause = 30;

static double size_of(const mukca_effect *effect)
{
    double size = 0;
    for (int t = 0; t < effect->terms; t++) size = hypot(size, effect->coefficient[t]);
    return size;
}

/* Set C to the diagonal prior covariance. */
static void set_prior(mukca_plan_state *s)
{
    double sigma[MUKCA_MAX_FREE];
    memset(s->C, 0, (size_t)s->n * (size_t)s->n * sizeof *s->C);
    mukca_posterior_prior(sigma, &s->at);
    for (int i = 0; i < s->n_geometry; i++) s->C[i * s->n + i] = sigma[i] * sigma[i];
    for (int e = 0; e < s->n_effects; e++)
        for (int t = s->first_term[e]; t < s->first_term[e + 1]; t++)
            s->C[(s->n_geometry + t) * (s->n + 1)] = pow(prior_cause * size_of(&s->effect[e]), 2);
    for (int i = s->n_known; i < s->n; i++) s->C[i * s->n + i] = prior_socket * prior_socket;
}

mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     int n_sockets, const mukca_plan_options *options,
                                     mukca_error *error)
{
    memset(s, 0, sizeof *s);
    s->options = options;
    s->noise = options->noise > 0 ? options->noise : 1e-4;
    s->n_sockets = n_sockets;
    s->n_effects = options->n_effects;
    mukca_status status = mukca_linearisation_init(&s->at, task->chain, task->theta, error);
    if (status != MUKCA_OK) return status;
    for (int e = 0; e < s->n_effects; e++) {
        s->effect[e] = options->effects[e];
        s->effect[e].terms = mukca_effect_terms(&s->effect[e]);
        s->first_term[e + 1] = s->first_term[e] + s->effect[e].terms;
    }
    s->n_terms = s->first_term[s->n_effects];
    s->n_geometry = s->at.parameters.n;
    s->n_known = s->n_geometry + s->n_terms;
    s->n = s->n_known + 3 * n_sockets;
    s->C = MUKCA_TAKE(&s->pool, double, s->n * s->n);
    s->P = MUKCA_TAKE(&s->pool, double, s->n_geometry * s->n_geometry);
    s->W = MUKCA_TAKE(&s->pool, double, s->n_geometry * s->n_geometry);
    s->G = MUKCA_TAKE(&s->pool, double, 3 * s->n);
    if (s->pool.failed) {
        mukca_plan_state_free(s);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    }
    set_prior(s);
    return MUKCA_OK;
}

void mukca_plan_state_free(mukca_plan_state *s)
{
    mukca_pool_free(&s->pool);
    memset(s, 0, sizeof *s);
}

void mukca_plan_design(double *H, mukca_plan_state *s, const double *q, int place,
                       const double *before)
{
    const mukca_chain *chain = s->at.chain;
    double move[MUKCA_MAX_JOINTS] = {0};
    mukca_linearisation_tip(H, s->n_known, NULL, &s->at, q);
    for (int j = 0; j < chain->n_joints && before; j++) move[j] = q[j] - before[j];
    for (int e = 0; e < s->n_effects; e++) {
        const mukca_joint_state state = {
            .q = q, .move = move, .placement = place, .payload_kg = s->payload};
        for (int t = 0; t < s->effect[e].terms; t++) {
            /* Central difference: the displacement is linear in the coefficient, the position
             * nearly so. */
            const double step = size_of(&s->effect[e]);
            double at[2][3];
            for (int side = 0; side < 2; side++) {
                mukca_effect one = s->effect[e];
                mukca_displacement displacement = {0};
                memset(one.coefficient, 0, sizeof one.coefficient);
                one.coefficient[t] = side ? step : -step;
                mukca_effects_displacement(&displacement, &one, 1, chain, &s->at.geometry, q,
                                           &state);
                mukca_fk_position(at[side], &s->at.geometry, q, &displacement);
            }
            for (int i = 0; i < 3; i++)
                H[i * s->n_known + s->n_geometry + s->first_term[e] + t] =
                    (at[1][i] - at[0][i]) / (2 * step);
        }
    }
}

/* out[i] = x' (row i of H[3][n]). */
MUKCA_INLINE void dot_rows(double out[3], const double *x, const double *H, int n)
{
    const int n4 = n & ~3;
    four a = {0}, b = {0}, c = {0};
    for (int i = 0; i < n4; i += 4) {
        const four v = LOAD4(x + i);
        a += v * LOAD4(H + i);
        b += v * LOAD4(H + n + i);
        c += v * LOAD4(H + 2 * (long)n + i);
    }
    out[0] = (a[0] + a[1]) + (a[2] + a[3]);
    out[1] = (b[0] + b[1]) + (b[2] + b[3]);
    out[2] = (c[0] + c[1]) + (c[2] + c[3]);
    for (int i = n4; i < n; i++)
        for (int k = 0; k < 3; k++) out[k] += x[i] * H[k * n + i];
}

/* G = C [H, -I at the socket]' for rows [0, n) of C, and S = sign [H, -I] G + noise^2 (3 x 3). */
MUKCA_CLONES static void project(double S[9], mukca_plan_state *s, int n, const double *H,
                                 int socket, int sign)
{
    const int k = s->n_known, mean = k + 3 * socket;
    for (int r = 0; r < s->n; r++) {
        if (r >= n && (r < mean || r >= mean + 3)) continue;
        const double *row = s->C + r * s->n;
        dot_rows(s->G + 3 * r, row, H, k);
        for (int i = 0; i < 3; i++) s->G[3 * r + i] -= row[mean + i];
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = -s->G[3 * (mean + i) + j];
            for (int c = 0; c < k; c++) sum += H[i * k + c] * s->G[3 * c + j];
            S[3 * i + j] = sign * sum + (i == j ? s->noise * s->noise : 0);
        }
}

/* Cholesky factor L of a small symmetric A[m][m] = L L', in place; returns the log determinant,
 * -HUGE_VAL if A is not positive definite. */
static double factor(double *A, int m)
{
    double sum = 0;
    if (mukca_dense_cholesky(A, m) != 0) return -HUGE_VAL;
    for (int i = 0; i < m; i++) sum += 2 * log(A[i * m + i]);
    return sum;
}

/* g = S^-1 G_r; S holds its Cholesky factor. */
static void solve(double g[3], const double S[9], const double *G_r)
{
    memcpy(g, G_r, 3 * sizeof *g);
    mukca_dense_forward(g, 1, S, 3);
    mukca_dense_backward(g, 1, S, 3);
}

void mukca_plan_state_row(mukca_plan_state *s, const double *H, int socket, int sign)
{
    double S[9], g[3];
    project(S, s, s->n, H, socket, sign); /* sign -1: a sample of negative variance */
    if (!(factor(S, 3) > -HUGE_VAL)) return;
    for (int r = 0; r < s->n; r++) {
        solve(g, S, s->G + 3 * r);
        double *row = s->C + r * s->n;
        for (int c = 0; c < s->n; c++) row[c] -= sign * mukca_dot3(g, s->G + 3 * c);
    }
}

void mukca_plan_state_distance(mukca_plan_state *s, int a, int b, const double *centre_a,
                               const double *centre_b)
{
    double u[3], S = distance_sigma * distance_sigma;
    const double length = mukca_distance3(centre_a, centre_b);
    if (!(length > 0)) return;
    for (int i = 0; i < 3; i++) u[i] = (centre_a[i] - centre_b[i]) / length;
    const int at = s->n_known + 3 * a, to = s->n_known + 3 * b;
    for (int r = 0; r < s->n; r++)
        s->G[r] = mukca_dot3(s->C + r * s->n + at, u) - mukca_dot3(s->C + r * s->n + to, u);
    for (int i = 0; i < 3; i++) S += u[i] * (s->G[at + i] - s->G[to + i]);
    for (int r = 0; r < s->n; r++)
        for (int c = 0; c < s->n; c++) s->C[r * s->n + c] -= s->G[r] * s->G[c] / S;
}

void mukca_plan_state_refresh(mukca_plan_state *s)
{
    const int p = s->n_geometry;
    if (s->n_effects > 0) return;
    for (int i = 0; i < p; i++) memcpy(s->P + i * p, s->C + i * s->n, (size_t)p * sizeof *s->P);
    mukca_dense_cholesky(s->P, p);
}

/* Decrease of the weighted mean square error at the evaluation points, tr(W G S^-1 G'). */
static double accuracy_gain(const mukca_plan_state *s, const double S[9])
{
    const int p = s->n_geometry;
    double gain = 0;
    for (int r = 0; r < p; r++) {
        double g[3], wg[3] = {0};
        for (int c = 0; c < p; c++)
            for (int i = 0; i < 3; i++) wg[i] += s->W[r * p + c] * s->G[3 * c + i];
        solve(g, S, s->G + 3 * r);
        gain += mukca_dot3(g, wg);
    }
    return gain;
}

/* The covariance of cause e, [terms][terms]; returns the number of terms. */
static int covariance_of(double *C, const mukca_plan_state *s, int e)
{
    const int m = s->effect[e].terms, first = s->n_geometry + s->first_term[e];
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) C[i * m + j] = s->C[(first + i) * s->n + first + j];
    return m;
}

/* Sum over the causes of the decrease of their covariance's log determinant. */
static double cause_gain(const mukca_plan_state *s, const double S[9])
{
    double gain = 0;
    for (int e = 0; e < s->n_effects; e++) {
        double before[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], after[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS];
        const double *G = s->G + 3 * (s->n_geometry + s->first_term[e]);
        const int m = covariance_of(before, s, e);
        for (int i = 0; i < m; i++) {
            double g[3];
            solve(g, S, G + 3 * i);
            for (int j = 0; j < m; j++)
                after[i * m + j] = before[i * m + j] - mukca_dot3(g, G + 3 * j);
        }
        gain += factor(before, m) - factor(after, m);
    }
    return gain;
}

double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket)
{
    double S[9], rest[9];
    const int p = s->n_geometry;
    project(S, s, s->n_known, H, socket, 1);
    memcpy(rest, S, sizeof rest);
    const double log_det = factor(S, 3);
    if ((s->accuracy || s->n_effects > 0) && !(log_det > -HUGE_VAL)) return 0;
    if (s->accuracy) return accuracy_gain(s, S);
    if (s->n_effects > 0) return cause_gain(s, S);
    /* |C_gg - G S^-1 G'| = |C_gg| |S - G' C_gg^-1 G| / |S|; P is the Cholesky factor of C_gg. */
    mukca_dense_forward(s->G, 3, s->P, p);
    for (int r = 0; r < p; r++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) rest[3 * i + j] -= s->G[3 * r + i] * s->G[3 * r + j];
    return log_det - factor(rest, 3);
}

/* Mean square error at one evaluation posture with Jacobian J[3][n_geometry], m^2. */
static double error_square(const mukca_plan_state *s, const double *J)
{
    const int p = s->n_geometry;
    double sum = 0;
    for (int d = 0; d < 3; d++)
        for (int i = 0; i < p; i++) {
            double row = 0;
            for (int j = 0; j < p; j++) row += s->C[i * s->n + j] * J[d * p + j];
            sum += row * J[d * p + i];
        }
    return fmax(sum, 0);
}

double mukca_plan_expected(const mukca_plan_state *s)
{
    /* ratio of mean to root mean square length of an isotropic 3-vector */
    const double ratio = MUKCA_MEAN_NORM3 / sqrt(3);
    double sum = 0;
    for (int e = 0; e < s->n_elsewhere; e++)
        sum += sqrt(error_square(s, s->elsewhere + 3 * s->n_geometry * e));
    return s->n_elsewhere > 0 ? ratio * sum / s->n_elsewhere : 0;
}

void mukca_plan_state_weigh(mukca_plan_state *s)
{
    const int p = s->n_geometry;
    memset(s->W, 0, (size_t)(p * p) * sizeof *s->W);
    for (int e = 0; e < s->n_elsewhere; e++) {
        const double *J = s->elsewhere + 3 * p * e;
        const double weight = 1 / (sqrt(error_square(s, J)) + 1e-9);
        for (int d = 0; d < 3; d++)
            for (int a = 0; a < p; a++)
                for (int b = 0; b < p; b++) s->W[a * p + b] += weight * J[d * p + a] * J[d * p + b];
    }
    s->accuracy = true;
}

double mukca_plan_strength(const mukca_plan_state *s)
{
    double least = NAN;
    for (int e = 0; e < s->n_effects; e++) {
        double L[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], c[MUKCA_MAX_TERMS], strength = 0;
        const int m = covariance_of(L, s, e);
        memcpy(c, s->effect[e].coefficient, (size_t)m * sizeof *c);
        if (!(factor(L, m) > -HUGE_VAL)) return NAN;
        mukca_dense_forward(c, 1, L, m);
        for (int i = 0; i < m; i++) strength += c[i] * c[i];
        least = isnan(least) ? strength : fmin(least, strength);
    }
    return least;
}

double mukca_plan_evidence(double strength)
{
    /* Gain in log likelihood, less the Occam penalty of a coefficient whose prior standard
     * deviation equals its size. */
    return 0.5 * (strength - log1p(strength));
}
