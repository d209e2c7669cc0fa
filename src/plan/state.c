/* What is known, as a covariance that rows reduce: updates, gains, expectations. */
#include "plan/state.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

/* Prior standard deviations: of a robot as it comes (DESIGN: 1 to 8 mm and mrad were seen), of a
 * tool that was mounted by hand, and of a socket's place on the table. */
static const double prior_length = 3e-3, prior_angle = 3e-3, prior_tip = 2e-2, prior_socket = 5e-2;
/* Of the distance between two sockets of the printed tool, m. */
static const double distance_sigma = 5e-5;
/* A cause is thought to be this many times as large as asked for, or less. */
static const double prior_cause = 30;

/* C = 0 but for the prior variances. */
static void set_prior(plan_state *s)
{
    const int tip = mukca_chain_tip_element(s->chain);
    memset(s->C, 0, (size_t)s->n * (size_t)s->n * sizeof *s->C);
    for (int i = 0; i < s->n; i++) {
        double sigma = prior_socket;
        if (i < s->n_geometry) {
            const int index = s->parameters.index[i];
            sigma = index % MUKCA_PARAMETERS < 3 ? prior_length : prior_angle;
            if (index / MUKCA_PARAMETERS == tip) sigma = prior_tip;
        } else if (i < s->n_known) {
            const int term = i - s->n_geometry;
            for (int e = 0; e < s->n_effects; e++)
                if (term >= s->first_term[e] && term < s->first_term[e + 1]) {
                    double size = 0;
                    for (int t = 0; t < s->effect[e].terms; t++)
                        size = hypot(size, s->effect[e].coefficient[t]);
                    sigma = prior_cause * size;
                }
        }
        s->C[i * s->n + i] = sigma * sigma;
    }
}

mukca_status plan_state_create(plan_state *s, const mukca_chain *chain, const double *theta,
                               int n_sockets, const mukca_plan_options *options, mukca_error *error)
{
    const mukca_selection selection = {0};
    memset(s, 0, sizeof *s);
    s->chain = chain;
    s->options = options;
    s->noise = options->noise > 0 ? options->noise : 1e-4;
    s->n_sockets = n_sockets;
    s->n_effects = options->n_effects;
    const mukca_status status = mukca_parameters_select(&s->parameters, chain, &selection, error);
    if (status != MUKCA_OK) return status;
    if (theta)
        memcpy(s->theta, theta, (size_t)(MUKCA_PARAMETERS * chain->n_elements) * sizeof *theta);
    else
        mukca_chain_theta(s->theta, chain);
    mukca_geometry_set(&s->geometry, chain, s->theta);
    for (int e = 0; e < s->n_effects; e++) {
        s->effect[e] = options->effects[e];
        s->effect[e].terms = mukca_effect_terms(s->effect[e].kind, s->effect[e].variant);
        s->first_term[e + 1] = s->first_term[e] + s->effect[e].terms;
    }
    s->n_terms = s->first_term[s->n_effects];
    s->n_geometry = s->parameters.n;
    s->n_known = s->n_geometry + s->n_terms;
    s->n = s->n_known + 3 * n_sockets;
    s->C = MUKCA_TAKE(&s->pool, double, s->n * s->n);
    s->P = MUKCA_TAKE(&s->pool, double, s->n_geometry * s->n_geometry);
    s->W = MUKCA_TAKE(&s->pool, double, s->n_geometry * s->n_geometry);
    s->G = MUKCA_TAKE(&s->pool, double, 3 * s->n);
    s->work = MUKCA_TAKE(&s->pool, double, 3 * MUKCA_PARAMETERS * chain->n_elements);
    if (s->pool.failed) {
        plan_state_free(s);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    }
    set_prior(s);
    return MUKCA_OK;
}

void plan_state_free(plan_state *s)
{
    mukca_pool_free(&s->pool);
    memset(s, 0, sizeof *s);
}

void plan_design(double *H, plan_state *s, const double *q, int place, const double *before)
{
    const int columns = MUKCA_PARAMETERS * s->chain->n_elements;
    double position[3], move[MUKCA_MAX_JOINTS] = {0};
    mukca_fk_parameter_jacobian(s->work, position, &s->geometry, s->theta, q);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < s->n_geometry; c++)
            H[i * s->n_known + c] = s->work[i * columns + s->parameters.index[c]];
    for (int j = 0; j < s->chain->n_joints && before; j++) move[j] = q[j] - before[j];
    for (int e = 0; e < s->n_effects; e++) {
        const mukca_joint_state state = {.q = q, .move = move, .placement = place};
        for (int t = 0; t < s->effect[e].terms; t++) {
            /* The displacement is linear in the coefficient, the position nearly so. */
            const double *size = s->effect[e].coefficient;
            double step = 0, at[2][3];
            for (int k = 0; k < s->effect[e].terms; k++) step = hypot(step, size[k]);
            for (int side = 0; side < 2; side++) {
                mukca_effect one = s->effect[e];
                mukca_displacement displacement = {0};
                memset(one.coefficient, 0, sizeof one.coefficient);
                one.coefficient[t] = side ? step : -step;
                mukca_effects_displacement(&displacement, &one, 1, s->chain, &s->geometry, q,
                                           &state);
                mukca_fk_position(at[side], &s->geometry, q, &displacement);
            }
            for (int i = 0; i < 3; i++)
                H[i * s->n_known + s->n_geometry + s->first_term[e] + t] =
                    (at[1][i] - at[0][i]) / (2 * step);
        }
    }
}

/* G = C [H, -I at the socket]' for rows [0, n) of C, and S = [H, -I] G (3 x 3). */
static void project(double S[9], plan_state *s, int n, const double *H, int socket)
{
    const int k = s->n_known, mean = k + 3 * socket;
    for (int r = 0; r < s->n; r++) {
        if (r >= n && (r < mean || r >= mean + 3)) continue;
        const double *row = s->C + r * s->n;
        for (int i = 0; i < 3; i++) {
            double sum = -row[mean + i];
            for (int c = 0; c < k; c++) sum += row[c] * H[i * k + c];
            s->G[3 * r + i] = sum;
        }
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = -s->G[3 * (mean + i) + j];
            for (int c = 0; c < k; c++) sum += H[i * k + c] * s->G[3 * c + j];
            S[3 * i + j] = sum;
        }
}

/* L with L L' = A for a small symmetric A[m][m], in place; the log determinant, -HUGE_VAL where it
 * is not positive. */
static double factor(double *A, int m)
{
    double sum = 0;
    if (mukca_dense_cholesky(A, m) != 0) return -HUGE_VAL;
    for (int i = 0; i < m; i++) sum += 2 * log(A[i * m + i]);
    return sum;
}

void plan_state_row(plan_state *s, const double *H, int socket, int sign)
{
    double S[9], g[3];
    project(S, s, s->n, H, socket);
    /* Forgetting is a row of negative variance. */
    for (int i = 0; i < 9; i++) S[i] = sign * S[i];
    for (int i = 0; i < 3; i++) S[4 * i] += s->noise * s->noise;
    if (!(factor(S, 3) > -HUGE_VAL)) return;
    for (int r = 0; r < s->n; r++) {
        memcpy(g, s->G + 3 * r, sizeof g);
        mukca_dense_forward(g, 1, S, 3);
        mukca_dense_backward(g, 1, S, 3);
        double *row = s->C + r * s->n;
        for (int c = 0; c < s->n; c++) row[c] -= sign * mukca_dot3(g, s->G + 3 * c);
    }
}

void plan_state_distance(plan_state *s, int a, int b, const double *centre_a,
                         const double *centre_b)
{
    double u[3], length = 0, S = distance_sigma * distance_sigma;
    for (int i = 0; i < 3; i++) u[i] = centre_a[i] - centre_b[i];
    length = sqrt(mukca_dot3(u, u));
    if (!(length > 0)) return;
    for (int i = 0; i < 3; i++) u[i] /= length;
    const int at = s->n_known + 3 * a, to = s->n_known + 3 * b;
    for (int r = 0; r < s->n; r++)
        s->G[r] = mukca_dot3(s->C + r * s->n + at, u) - mukca_dot3(s->C + r * s->n + to, u);
    for (int i = 0; i < 3; i++) S += u[i] * (s->G[at + i] - s->G[to + i]);
    for (int r = 0; r < s->n; r++)
        for (int c = 0; c < s->n; c++) s->C[r * s->n + c] -= s->G[r] * s->G[c] / S;
}

void plan_state_refresh(plan_state *s)
{
    const int p = s->n_geometry;
    if (s->n_effects > 0) return;
    for (int i = 0; i < p; i++) memcpy(s->P + i * p, s->C + i * s->n, (size_t)p * sizeof *s->P);
    mukca_dense_cholesky(s->P, p);
}

double plan_gain(plan_state *s, const double *H, int socket)
{
    double S[9], gain = 0;
    const int p = s->n_geometry;
    project(S, s, s->n_known, H, socket);
    for (int i = 0; i < 3; i++) S[4 * i] += s->noise * s->noise;
    if (s->accuracy) {
        /* tr(W G S^-1 G') */
        if (!(factor(S, 3) > -HUGE_VAL)) return 0;
        for (int r = 0; r < p; r++) {
            double g[3], wg[3] = {0};
            for (int c = 0; c < p; c++)
                for (int i = 0; i < 3; i++) wg[i] += s->W[r * p + c] * s->G[3 * c + i];
            memcpy(g, s->G + 3 * r, sizeof g);
            mukca_dense_forward(g, 1, S, 3);
            mukca_dense_backward(g, 1, S, 3);
            gain += mukca_dot3(g, wg);
        }
        return gain;
    }
    if (s->n_effects == 0) {
        /* |C_gg - G S^-1 G'| = |C_gg| |S - G' C_gg^-1 G| / |S|; P holds the factor of C_gg. */
        double rest[9];
        mukca_dense_forward(s->G, 3, s->P, p);
        memcpy(rest, S, sizeof rest);
        for (int r = 0; r < p; r++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++) rest[3 * i + j] -= s->G[3 * r + i] * s->G[3 * r + j];
        return factor(S, 3) - factor(rest, 3);
    }
    if (!(factor(S, 3) > -HUGE_VAL)) return 0;
    for (int e = 0; e < s->n_effects; e++) {
        const int m = s->effect[e].terms, first = p + s->first_term[e];
        double before[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], after[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS];
        for (int i = 0; i < m; i++) {
            double g[3];
            memcpy(g, s->G + 3 * (first + i), sizeof g);
            mukca_dense_forward(g, 1, S, 3);
            mukca_dense_backward(g, 1, S, 3);
            for (int j = 0; j < m; j++) {
                before[i * m + j] = s->C[(first + i) * s->n + first + j];
                after[i * m + j] = before[i * m + j] - mukca_dot3(g, s->G + 3 * (first + j));
            }
        }
        gain += factor(before, m) - factor(after, m);
    }
    return gain;
}

/* Mean square of one move elsewhere, m^2. */
static double error_square(const plan_state *s, const double *J)
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

double plan_expected(const plan_state *s)
{
    /* the mean length of a 3-vector over its root mean square, if it is isotropic */
    const double ratio = MUKCA_MEAN_NORM3 / sqrt(3);
    double sum = 0;
    for (int e = 0; e < s->n_elsewhere; e++)
        sum += sqrt(error_square(s, s->elsewhere + 3 * s->n_geometry * e));
    return s->n_elsewhere > 0 ? ratio * sum / s->n_elsewhere : 0;
}

void plan_state_weigh(plan_state *s)
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

double plan_strength(const plan_state *s)
{
    double least = NAN;
    for (int e = 0; e < s->n_effects; e++) {
        const int m = s->effect[e].terms, first = s->n_geometry + s->first_term[e];
        double L[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], c[MUKCA_MAX_TERMS], strength = 0;
        for (int i = 0; i < m; i++) {
            c[i] = s->effect[e].coefficient[i];
            for (int j = 0; j < m; j++) L[i * m + j] = s->C[(first + i) * s->n + first + j];
        }
        if (!(factor(L, m) > -HUGE_VAL)) return NAN;
        mukca_dense_forward(c, 1, L, m);
        for (int i = 0; i < m; i++) strength += c[i] * c[i];
        least = isnan(least) ? strength : fmin(least, strength);
    }
    return least;
}

double plan_evidence(double strength)
{
    /* What a fit gains, less the price of a coefficient whose prior is as wide as the cause is
     * large. */
    return 0.5 * (strength - log1p(strength));
}
