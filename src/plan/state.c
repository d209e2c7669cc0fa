/* Information of samples: gains of further ones, expected errors. */
#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"
#include "plan/choose.h"

/* Standard deviation of the distance between two sockets of the printed tool, m: a good printer. */
static const double distance_sigma = 5e-5;
/* Prior standard deviation of a cause relative to its stated size: wide, so that the data
 * dominate. */
static const double prior_cause = 30;

enum { WIDE = 8 }; /* row stride of three right-hand sides: solved as fast as two */

enum {
    SPOTS = 50,
    POSES = 12
}; /* points, and postures at each: enough for their mean within a few % */

static double size_of(const mukca_effect *effect)
{
    double size = 0;
    for (int t = 0; t < effect->terms; t++) size = hypot(size, effect->coefficient[t]);
    return size;
}

mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     const mukca_plan_options *options, mukca_error *error)
{
    memset(s, 0, sizeof *s);
    s->options = options;
    s->noise = options->noise > 0 ? options->noise : 1e-4;
    s->sockets = task->sockets;
    s->n_sockets = task->n_sockets;
    s->n_effects = options->n_effects;
    mukca_arm_point_init(&s->at, task->chain, task->theta);
    for (int e = 0; e < s->n_effects; e++) {
        s->effect[e] = options->effects[e];
        s->effect[e].terms = mukca_effect_terms(&s->effect[e]);
        s->first_term[e + 1] = s->first_term[e] + s->effect[e].terms;
    }
    s->n_terms = s->first_term[s->n_effects];
    s->n_geometry = s->at.parameters.n;
    s->n = s->n_geometry + s->n_terms;
    const int n = s->n;
    s->sigma = MUKCA_TAKE(&s->pool, double, n);
    s->gram = MUKCA_TAKE(&s->pool, double, n *n);
    s->L = MUKCA_TAKE(&s->pool, double, n *n);
    s->W = MUKCA_TAKE(&s->pool, double, n *n);
    s->work = MUKCA_TAKE(&s->pool, double, n *n);
    s->C = MUKCA_TAKE(&s->pool, double, s->n_terms * s->n_terms + 1);
    s->G = MUKCA_TAKE(&s->pool, double, WIDE *n);
    s->sum = MUKCA_TAKE(&s->pool, double, 3 * s->n_sockets * n + 1);
    s->count = MUKCA_TAKE(&s->pool, int, s->n_sockets + 1);
    if (s->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    mukca_posterior_prior(s->sigma, s->at.chain, &s->at.parameters);
    for (int e = 0; e < s->n_effects; e++)
        for (int t = s->first_term[e]; t < s->first_term[e + 1]; t++)
            s->sigma[s->n_geometry + t] = prior_cause * size_of(&s->effect[e]);
    mukca_plan_state_refresh(s);
    return MUKCA_OK;
}

void mukca_plan_design(double *H, mukca_plan_state *s, const double *q, int place,
                       const double *before)
{
    const mukca_chain *chain = s->at.chain;
    double move[MUKCA_MAX_JOINTS] = {0};
    mukca_arm_point_tip(H, s->n, NULL, &s->at, q);
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
                H[i * s->n + s->n_geometry + s->first_term[e] + t] =
                    (at[1][i] - at[0][i]) / (2 * step);
        }
    }
}

/* A += factor X'X for X[m][n]. */
static void add_square(double *A, const double *X, int m, int n, double factor)
{
    for (int k = 0; k < m; k++)
        for (int a = 0; a < n; a++) {
            const double f = factor * X[k * n + a];
            for (int b = 0; b < n; b++) A[a * n + b] += f * X[k * n + b];
        }
}

void mukca_plan_state_row(mukca_plan_state *s, const double *H, int socket, int sign)
{
    add_square(s->gram, H, 3, s->n, sign);
    for (int i = 0; i < 3 * s->n; i++) s->sum[3 * s->n * socket + i] += sign * H[i];
    s->count[socket] += sign;
}

/* Add the known distance between the means of two sockets to the Gram matrix. */
static void add_distance(mukca_plan_state *s, int a, int b)
{
    const double *x = s->sum + 3 * s->n * a, *y = s->sum + 3 * s->n * b;
    const double *from = s->sockets[a].centre, *to = s->sockets[b].centre;
    const double length = mukca_distance3(from, to), noise = s->noise * s->noise;
    double *row = s->G;
    if (!(length > 0) || !s->count[a] || !s->count[b]) return;
    memset(row, 0, (size_t)s->n * sizeof *row);
    for (int d = 0; d < 3; d++)
        for (int c = 0; c < s->n; c++)
            row[c] += (from[d] - to[d]) / length *
                      (x[d * s->n + c] / s->count[a] - y[d * s->n + c] / s->count[b]);
    const double variance =
        distance_sigma * distance_sigma + noise / s->count[a] + noise / s->count[b];
    add_square(s->work, row, 1, s->n, noise / variance);
}

/* The covariance of the causes.  They are the last unknowns: it needs their block of L alone. */
static void set_covariance(mukca_plan_state *s)
{
    const int n = s->n_terms;
    double *L = s->work;
    for (int i = 0; i < n; i++)
        memcpy(L + i * n, s->L + (s->n_geometry + i) * s->n + s->n_geometry, (size_t)n * sizeof *L);
    for (int i = 0; i < n * n; i++) s->C[i] = i % (n + 1) == 0;
    mukca_dense_forward(s->C, n, L, n);
    mukca_dense_backward(s->C, n, L, n);
}

void mukca_plan_state_refresh(mukca_plan_state *s)
{
    memcpy(s->work, s->gram, (size_t)(s->n * s->n) * sizeof *s->work);
    for (int a = 0; a < s->n_sockets; a++) {
        if (s->count[a] > 0)
            add_square(s->work, s->sum + 3 * s->n * a, 3, s->n, -1.0 / s->count[a]);
        for (int b = a + 1; b < s->n_sockets; b++)
            if (s->sockets[a].place == s->sockets[b].place) add_distance(s, a, b);
    }
    mukca_posterior_factor(s->L, s->work, s->sigma, s->noise, s->n);
    set_covariance(s);
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

/* Decrease of the weighted mean square error at the evaluation points, tr(W G S^-1 G'). */
static double accuracy_gain(const mukca_plan_state *s, const double S[9])
{
    double gain = 0;
    for (int r = 0; r < s->n; r++) {
        double g[3], wg[3] = {0};
        for (int c = 0; c < s->n; c++)
            for (int i = 0; i < 3; i++) wg[i] += s->W[r * s->n + c] * s->G[WIDE * c + i];
        solve(g, S, s->G + WIDE * r);
        gain += mukca_dot3(g, wg);
    }
    return gain;
}

/* The covariance of cause e, [terms][terms]; returns the number of terms. */
static int covariance_of(double *C, const mukca_plan_state *s, int e)
{
    const int m = s->effect[e].terms, first = s->first_term[e];
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) C[i * m + j] = s->C[(first + i) * s->n_terms + first + j];
    return m;
}

/* Sum over the causes of the decrease of their covariance's log determinant. */
static double cause_gain(const mukca_plan_state *s, const double S[9])
{
    double gain = 0;
    for (int e = 0; e < s->n_effects; e++) {
        double before[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], after[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS];
        const double *G = s->G + WIDE * (s->n_geometry + s->first_term[e]);
        const int m = covariance_of(before, s, e);
        for (int i = 0; i < m; i++) {
            double g[3];
            solve(g, S, G + WIDE * i);
            for (int j = 0; j < m; j++)
                after[i * m + j] = before[i * m + j] - mukca_dot3(g, G + WIDE * j);
        }
        gain += factor(before, m) - factor(after, m);
    }
    return gain;
}

double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket)
{
    const int n = s->n, count = s->count[socket];
    const double *sum = s->sum + 3 * n * socket;
    double S[9], *G = s->G;
    if (count == 0) return 0; /* determines the socket's position only */
    for (int c = 0; c < n; c++)
        for (int i = 0; i < 3; i++) G[WIDE * c + i] = H[i * n + c] - sum[i * n + c] / count;
    mukca_dense_forward(G, WIDE, s->L, n);
    const double noise = s->noise * s->noise * (1 + 1.0 / count); /* of a sample about the mean */
    for (int i = 0; i < 9; i++) {
        S[i] = i % 4 ? 0 : noise;
        for (int c = 0; c < n; c++) S[i] += G[WIDE * c + i / 3] * G[WIDE * c + i % 3];
    }
    const double log_det = factor(S, 3);
    if (!s->accuracy && s->n_effects == 0) return log_det - 3 * log(noise);
    mukca_dense_backward(G, WIDE, s->L, n);
    return s->accuracy ? accuracy_gain(s, S) : cause_gain(s, S);
}

void mukca_plan_look_elsewhere(mukca_plan_state *s, const mukca_plan_rules *rules, uint64_t seed)
{
    const int n = s->n;
    s->elsewhere = MUKCA_TAKE(&s->pool, double, SPOTS *POSES * 3 * n);
    mukca_random random;
    mukca_random_seed(&random, seed + 1);
    if (s->pool.failed) return;
    for (int spot = 0, tries = 0; spot < SPOTS && tries < 20 * SPOTS; tries++) {
        double q[MUKCA_MAX_JOINTS], centre[3], *H = s->elsewhere + 3 * n * s->n_elsewhere;
        int found = 0;
        if (!mukca_plan_draw_anywhere(q, centre, rules, &random)) continue;
        for (int t = 0; t < 3 * POSES && found < POSES; t++)
            if (mukca_plan_draw_pose(q, centre, rules, &random))
                mukca_plan_design(H + 3 * n * found++, s, q, 0, NULL);
        if (found < POSES / 2) continue;
        spot++;
        for (int k = 0; k < 3 * n; k++) {
            double mean = 0;
            for (int f = 0; f < found; f++) mean += H[3 * n * f + k] / found;
            for (int f = 0; f < found; f++)
                H[3 * n * f + k] = k % n < s->n_geometry ? H[3 * n * f + k] - mean : 0;
        }
        s->n_elsewhere += found;
    }
}

/* Rms error at evaluation posture e, m. */
static double error_at(const mukca_plan_state *s, int e)
{
    double sum = 0, J[MUKCA_MAX_FREE + MUKCA_PLAN_MAX_EFFECTS * MUKCA_MAX_TERMS];
    for (int d = 0; d < 3; d++) {
        memcpy(J, s->elsewhere + (3 * e + d) * s->n, (size_t)s->n * sizeof *J);
        sum += mukca_dense_variance(J, s->L, s->n);
    }
    return sqrt(sum);
}

double mukca_plan_expected(const mukca_plan_state *s)
{
    /* ratio of mean to root mean square length of an isotropic 3-vector */
    const double ratio = MUKCA_MEAN_NORM3 / sqrt(3);
    double sum = 0;
    for (int e = 0; e < s->n_elsewhere; e++) sum += error_at(s, e);
    return s->n_elsewhere > 0 ? ratio * sum / s->n_elsewhere : 0;
}

void mukca_plan_state_weigh(mukca_plan_state *s)
{
    memset(s->W, 0, (size_t)(s->n * s->n) * sizeof *s->W);
    for (int e = 0; e < s->n_elsewhere; e++)
        add_square(s->W, s->elsewhere + 3 * s->n * e, 3, s->n, 1 / (error_at(s, e) + 1e-9));
    s->accuracy = true;
}

double mukca_plan_strength(const mukca_plan_state *s)
{
    double least = NAN;
    for (int e = 0; e < s->n_effects; e++) {
        double L[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], c[MUKCA_MAX_TERMS];
        const int m = covariance_of(L, s, e);
        memcpy(c, s->effect[e].coefficient, (size_t)m * sizeof *c);
        if (!(factor(L, m) > -HUGE_VAL)) return NAN;
        const double strength = mukca_dense_variance(c, L, m);
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
