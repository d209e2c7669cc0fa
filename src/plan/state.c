/* Unknowns of a plan, the derivatives of the tip by them, and the information of samples: gains of
 * further ones, expected errors. */
#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "math/dense.h"
#include "math/stats.h"
#include "model/prior.h"
#include "plan/choose.h"

enum { WIDE = 8 }; /* row stride of three right-hand sides: solved as fast as two */

/* Points, and postures at each: enough for their mean within a few %. */
enum { SPOTS = 50, POSES = 12 };

/* ---- unknowns and derivatives ---- */

/* Prior standard deviation of a cause relative to its stated size: wide, so that the data
 * dominate. */
static const double prior_cause = 30;

static void set_unknowns(mukca_plan_state *s, const mukca_plan_task *task)
{
    const mukca_chain *chain = s->chain = task->chain;
    const int tool = mukca_chain_tip_element(chain);
    mukca_parameters_set(&s->parameters, chain, NULL, false);
    for (; s->n < s->parameters.n; s->n++) {
        const int k = s->parameters.index[s->n];
        s->sigma[s->n] = mukca_prior_sigma(&mukca_prior_expected, k % MUKCA_PARAMETERS,
                                           k / MUKCA_PARAMETERS == tool);
    }
    mukca_chain_theta(s->theta, chain);
    if (task->theta)
        memcpy(s->theta, task->theta,
               (size_t)(MUKCA_PARAMETERS * chain->n_elements) * sizeof *s->theta);
    mukca_geometry_set(&s->geometry, chain, s->theta);
    for (; s->n_effects < s->options->n_effects; s->n_effects++) {
        mukca_effect *e = &s->effects[s->n_effects];
        double size = 0;
        *e = s->options->effects[s->n_effects];
        e->terms = mukca_effect_terms(e);
        for (int t = 0; t < e->terms; t++) size = hypot(size, e->coefficient[t]);
        for (int t = 0; t < e->terms; t++) s->sigma[s->n++] = prior_cause * size;
    }
}

/* Columns of the coefficients: the displacement by a small part of each sigma. */
static void add_effects(double *H, const mukca_plan_state *s, const mukca_joint_state *state,
                        const double position[3])
{
    const double part = 1.0 / 32;
    for (int e = 0, c = s->parameters.n; e < s->n_effects; e++) {
        mukca_effect one = s->effects[e];
        memset(one.coefficient, 0, sizeof one.coefficient);
        for (int t = 0; t < one.terms; t++, c++) {
            mukca_frame tip;
            one.coefficient[t] = part * s->sigma[c];
            mukca_tip_pose(&tip, &one, 1, s->chain, &s->geometry, state);
            one.coefficient[t] = 0;
            for (int a = 0; a < 3; a++) H[a * (s->n + 1) + c] = (tip.p[a] - position[a]) / part;
        }
    }
}

void mukca_plan_design(double *H, const mukca_plan_state *s, const double *q, int place,
                       const double *before)
{
    double move[MUKCA_MAX_JOINTS] = {0};
    const mukca_joint_state state = {
        .q = q, .move = move, .placement = place, .payload_kg = s->payload};
    double J[3 * MUKCA_MAX_FREE], position[3];
    const int all = MUKCA_PARAMETERS * s->chain->n_elements, size = s->n + 1;
    for (int j = 0; j < s->chain->n_joints && before; j++) move[j] = q[j] - before[j];
    mukca_fk_parameter_jacobian(J, position, &s->geometry, s->theta, q);
    for (int a = 0; a < 3; a++) {
        for (int i = 0; i < s->parameters.n; i++)
            H[a * size + i] = J[a * all + s->parameters.index[i]] * s->sigma[i];
        H[a * size + s->n] = -position[a];
    }
    add_effects(H, s, &state, position);
}

/* ---- information ---- */

/* The known distances: only their directions matter here.  An artefact is known by the labels of
 * its sockets. */
static void set_pairs(mukca_plan_state *s, const mukca_plan_task *task)
{
    const mukca_plan_socket *sockets = task->sockets;
    const double sigma = s->options->distance_sigma;
    mukca_group_pair *pair = s->groups.pair;
    int n = 0;
    for (int a = 0; a < task->n_sockets; a++)
        for (int b = a + 1; b < task->n_sockets; b++) {
            if (sockets[a].place != sockets[b].place) continue;
            int same = 0;
            while (same < n && (strcmp(sockets[pair[same].a].label, sockets[a].label) ||
                                strcmp(sockets[pair[same].b].label, sockets[b].label)))
                same++;
            pair[n] = (mukca_group_pair){.a = a,
                                         .b = b,
                                         .artefact = same < n ? pair[same].artefact : n,
                                         .sigma = sigma > 0 ? sigma : MUKCA_DISTANCE_SIGMA};
            n++;
        }
    s->groups.n_pairs = n;
}

mukca_status mukca_plan_state_create(mukca_plan_state *s, const mukca_plan_task *task,
                                     const mukca_plan_options *options, mukca_error *error)
{
    memset(s, 0, sizeof *s);
    s->options = options;
    s->sockets = task->sockets;
    set_unknowns(s, task);
    const int n = s->n, terms = n - s->parameters.n, sockets = task->n_sockets;
    mukca_grouped_create(&s->groups, &s->pool, n, sockets, sockets * (sockets - 1) / 2);
    s->W = MUKCA_TAKE(&s->pool, double, n *n);
    s->C = MUKCA_TAKE(&s->pool, double, terms *terms + 1);
    s->G = MUKCA_TAKE(&s->pool, double, WIDE *n);
    if (s->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    s->groups.noise = options->noise > 0 ? options->noise : 1e-4;
    set_pairs(s, task);
    mukca_plan_state_refresh(s);
    return MUKCA_OK;
}

void mukca_plan_state_row(mukca_plan_state *s, double *H, int socket, int sign)
{
    for (int a = 0; a < 3; a++) H[(a + 1) * s->groups.size - 1] = -s->sockets[socket].centre[a];
    mukca_grouped_add(&s->groups, H, socket, sign);
}

void mukca_plan_state_refresh(mukca_plan_state *s)
{
    const int n = s->n, first = s->parameters.n, terms = n - first;
    double L[MUKCA_PLAN_MAX_EFFECTS * MUKCA_MAX_TERMS * MUKCA_PLAN_MAX_EFFECTS * MUKCA_MAX_TERMS];
    mukca_grouped_solve(&s->groups);
    for (int i = 0; i < terms * terms; i++) { /* the last unknowns need their block of L alone */
        L[i] = s->groups.posterior.factor[(first + i / terms) * n + first + i % terms];
        s->C[i] = i % (terms + 1) == 0;
    }
    mukca_dense_forward(s->C, terms, L, terms);
    mukca_dense_backward(s->C, terms, L, terms);
}

/* Cholesky factor L of a small symmetric A[m][m] = L L', in place; returns the log determinant,
 * -HUGE_VAL if A is not positive definite. */
static double factor(double *A, int m)
{
    double sum = 0;
    if (!mukca_dense_cholesky(A, m)) return -HUGE_VAL;
    for (int i = 0; i < m; i++) sum += 2 * log(A[i * m + i]);
    return sum;
}

/* Decrease of the weighted mean square error at the evaluation points, tr(W G G'). */
static double accuracy_gain(const mukca_plan_state *s)
{
    double gain = 0;
    const int n = s->n;
    for (int r = 0; r < n; r++) {
        double wg[3] = {0};
        for (int c = 0; c < n; c++)
            for (int i = 0; i < 3; i++) wg[i] += s->W[r * n + c] * s->G[WIDE * c + i];
        gain += mukca_dot3(s->G + WIDE * r, wg);
    }
    return gain;
}

/* The covariance of the cause from term `first` on, C[m][m]. */
static void covariance_of(double *C, const mukca_plan_state *s, int first, int m)
{
    const int terms = s->n - s->parameters.n;
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) C[i * m + j] = s->C[(first + i) * terms + first + j];
}

/* Sum over the causes of the decrease of their covariance's log determinant. */
static double cause_gain(const mukca_plan_state *s)
{
    double gain = 0;
    for (int e = 0, first = 0; e < s->n_effects; first += s->effects[e++].terms) {
        double before[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], after[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS];
        const double *G = s->G + WIDE * (s->parameters.n + first);
        const int m = s->effects[e].terms;
        covariance_of(before, s, first, m);
        for (int i = 0; i < m * m; i++)
            after[i] = before[i] - mukca_dot3(G + WIDE * (i / m), G + WIDE * (i % m));
        gain += factor(before, m) - factor(after, m);
    }
    return gain;
}

double mukca_plan_gain(mukca_plan_state *s, const double *H, int socket)
{
    const mukca_grouped *g = &s->groups;
    const int n = s->n;
    const double *sum = g->sum + socket * 3 * g->size, count = g->count[socket];
    double S[9], *G = s->G;
    if (!(count > 0)) return 0; /* determines the socket's position only */
    for (int c = 0; c < n; c++)
        for (int i = 0; i < 3; i++) {
            const int at = i * g->size + c;
            G[WIDE * c + i] = H[at] - sum[at] / count;
        }
    mukca_dense_forward(G, WIDE, g->posterior.factor, n);
    const double noise = g->noise * g->noise * (1 + 1 / count); /* of a sample about the mean */
    for (int i = 0; i < 9; i++) {
        S[i] = i % 4 ? 0 : noise;
        for (int c = 0; c < n; c++) S[i] += G[WIDE * c + i / 3] * G[WIDE * c + i % 3];
    }
    const double log_det = factor(S, 3);
    if (!s->accuracy && s->n_effects == 0) return log_det - 3 * log(noise);
    mukca_dense_backward(G, WIDE, g->posterior.factor, n);
    for (int c = 0; c < n; c++) mukca_dense_forward(G + WIDE * c, 1, S, 3);
    return s->accuracy ? accuracy_gain(s) : cause_gain(s);
}

void mukca_plan_look_elsewhere(mukca_plan_state *s, const mukca_plan_rules *rules, uint64_t seed)
{
    const int w = s->groups.size;
    s->elsewhere = MUKCA_TAKE(&s->pool, double, SPOTS *POSES * 3 * w);
    mukca_random random = mukca_random_seeded(seed + 1);
    if (s->pool.failed) return;
    for (int spot = 0, tries = 0; spot < SPOTS && tries < 20 * SPOTS; tries++) {
        double q[MUKCA_MAX_JOINTS], centre[3], *H = s->elsewhere + 3 * w * s->n_elsewhere;
        int found = 0;
        if (!mukca_plan_draw_anywhere(q, centre, rules, &random)) continue;
        for (int t = 0; t < 3 * POSES && found < POSES; t++)
            if (mukca_plan_draw_pose(q, centre, rules, &random))
                mukca_plan_design(H + 3 * w * found++, s, q, 0, NULL);
        if (found < POSES / 2) continue;
        spot++;
        for (int k = 0; k < 3 * w; k++) {
            const bool geometry = k % w < s->parameters.n;
            double mean = 0;
            for (int f = 0; f < found; f++) mean += H[3 * w * f + k] / found;
            for (int f = 0; f < found; f++)
                H[3 * w * f + k] = geometry ? H[3 * w * f + k] - mean : 0;
        }
        s->n_elsewhere += found;
    }
}

/* Rms error at evaluation posture e, m. */
static double error_at(const mukca_plan_state *s, int e)
{
    double sum = 0, J[MUKCA_PLAN_MOST_UNKNOWNS];
    for (int d = 0; d < 3; d++) {
        memcpy(J, s->elsewhere + (3 * e + d) * s->groups.size, (size_t)s->n * sizeof *J);
        sum += mukca_posterior_variance(J, &s->groups.posterior);
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
    const int n = s->n;
    memset(s->W, 0, (size_t)(n * n) * sizeof *s->W);
    for (int e = 0; e < s->n_elsewhere; e++) {
        const double by = 1 / (error_at(s, e) + 1e-9);
        for (int d = 0; d < 3; d++) {
            const double *J = s->elsewhere + (3 * e + d) * s->groups.size;
            for (int a = 0; a < n; a++)
                for (int b = 0; b < n; b++) s->W[a * n + b] += by * J[a] * J[b];
        }
    }
    s->accuracy = true;
}

double mukca_plan_strength(const mukca_plan_state *s)
{
    double least = NAN;
    for (int e = 0, first = 0; e < s->n_effects; first += s->effects[e++].terms) {
        double L[MUKCA_MAX_TERMS * MUKCA_MAX_TERMS], c[MUKCA_MAX_TERMS];
        const int m = s->effects[e].terms;
        covariance_of(L, s, first, m);
        for (int t = 0; t < m; t++)
            c[t] = s->options->effects[e].coefficient[t] / s->sigma[s->parameters.n + first];
        if (!(factor(L, m) > -HUGE_VAL)) return NAN;
        const double strength = mukca_dense_variance(c, L, m);
        least = isnan(least) ? strength : fmin(least, strength);
    }
    return least;
}
