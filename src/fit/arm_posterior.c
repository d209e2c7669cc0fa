/* Posterior of an arm given samples. */
#include "fit/arm_posterior.h"

#include <math.h>
#include <string.h>

#include "fit/align.h"
#include "math/dense.h"
#include "math/stats.h"
#include "model/dataset_subset.h"

/* Gauss-Newton steps; in each: weights, noise and scale; the same from a posterior on. */
enum { STEPS = 4, WEIGHINGS = 5, WEIGHINGS_AGAIN = 2 };

/* Weight of the noise's prior in measurements, as while recording; weight of the prior's
 * own scale in parameters, and its largest value. */
static const double noise_weight = 10, scale_weight = 10, most_scale = 4;

/* An error of the nominal arm's distance, m, that is that of a label, as in diagnose; an error
 * beyond any arm and noise; a ratio to the noise of which the weight is below 0.07. */
static const double wrong_label = 0.02, gross_error = 0.1, outlier = 10;

/* Of the logarithm of the ratio of the residuals' variances across and along the axis of a joint:
 * 1 % of 1200 joints that moved, in 200 recordings, are beyond twice this. */
static const double spread = 0.8;

/* Relative change of noise and scale with which a weighing is the last one: a tenth of what 5000
 * rows know of them. */
static const double settled = 1e-3;

/* One observation for each posture of each group. */
static void list_observations(mukca_arm_posterior *p)
{
    const mukca_dataset *d = &p->data;
    int *posture = MUKCA_TAKE(&p->pool, int, d->n_rows),
        *last = MUKCA_TAKE(&p->pool, int, d->n_rows),     /* observation of a posture, -1: none */
            *next = MUKCA_TAKE(&p->pool, int, d->n_rows); /* of the same posture */
    p->of_row = MUKCA_TAKE(&p->pool, int, d->n_rows);
    p->list = MUKCA_TAKE(&p->pool, mukca_observation, d->n_rows);
    p->readings = MUKCA_TAKE(&p->pool, int, d->n_rows);
    p->outlier = MUKCA_TAKE(&p->pool, bool, d->n_rows);
    if (p->pool.failed) return;
    p->postures = d->n_rows - mukca_postures_find(posture, &p->pool, d);
    for (int row = 0; row < d->n_rows; row++) {
        const int first = posture[row], target = mukca_dataset_target(d, row) + 1;
        const int group = d->socket[row] >= 0 ? d->socket[row]
                          : d->position && isfinite(d->position[3 * (size_t)row])
                              ? d->n_sockets + d->file[row] * (d->n_targets + 1) + target
                              : -1;
        int o = first == row ? -1 : last[first];
        if (first == row) last[row] = -1;
        p->of_row[row] = -1;
        if (group < 0) continue;
        while (o >= 0 && p->list[o].group != group) o = next[o];
        if (o < 0) {
            o = p->n_list++;
            p->list[o] = (mukca_observation){.group = group, .weight = 1};
            next[o] = last[first];
            last[first] = o;
        }
        p->readings[o]++;
        p->of_row[row] = o;
    }
}

/* Take memory for all unknowns. */
static mukca_status take(mukca_arm_posterior *p, mukca_error *error)
{
    const int n = p->at.n;
    mukca_grouped_create(&p->groups, &p->pool, n,
                         p->data.n_sockets + p->data.n_files * (p->data.n_targets + 1),
                         p->data.n_distances);
    p->mean = MUKCA_TAKE(&p->pool, double, n + 1);
    p->inverse = MUKCA_TAKE(&p->pool, double, n *n + 1);
    for (int i = 0; i < p->n_list; i++)
        p->list[i].x = MUKCA_TAKE(&p->pool, double, 3 * p->groups.width);
    return p->pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}

/* Unknown coefficients of an effect. */
static void add_effect(mukca_arm_point *at, const mukca_effect *effect, double least_sigma)
{
    mukca_effect *e = &at->effects[at->n_effects++];
    *e = *effect;
    for (int t = 0; t < e->terms; t++) {
        at->sigma[at->n++] = fmax(3 * fabs(e->coefficient[t]), least_sigma);
        e->coefficient[t] = 0;
    }
}

/* Choose the unknowns. */
static mukca_status set_up(mukca_arm_posterior *p, mukca_error *error)
{
    const mukca_tip_change_task *task = p->task;
    mukca_arm_point *at = &p->at;
    const int last = MUKCA_PARAMETERS * (p->chain.n_elements - 1);
    mukca_effect placed[MUKCA_MAX_EFFECTS];
    if (p->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_arm_point_init(at, &p->chain, NULL);
    if (task->tool_frame) { /* the last parameters are of the target */
        memcpy(at->theta + last, p->to + last, MUKCA_PARAMETERS * sizeof *at->theta);
        at->n = at->parameters.n -= MUKCA_PARAMETERS;
    }
    memcpy(p->nominal, at->theta, sizeof p->nominal);
    p->extended = MUKCA_MOST_UNKNOWNS;
    if (task->to) mukca_offsets_place_effects(placed, task->to, &p->data);
    for (int e = 0; task->to && e < task->to->n_effects; e++) add_effect(at, &placed[e], 1e-12);
    const mukca_status status = take(p, error);
    p->groups.noise = MUKCA_PRIOR_NOISE;
    for (int k = 0; k < p->data.n_distances && status == MUKCA_OK; k++) {
        const mukca_distance *d = &p->data.distances[k];
        p->groups.pair[k] = (mukca_group_pair){.a = d->a,
                                               .b = d->b,
                                               .artefact = d->artefact,
                                               .distance = d->distance,
                                               .sigma = mukca_distance_sigma(d)};
    }
    return status;
}

static mukca_status create(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                           mukca_error *error)
{
    memset(p, 0, sizeof *p);
    p->task = task;
    p->scale = p->extended_scale = 1;
    p->tracker = (mukca_frame){.R = MUKCA_IDENTITY};
    p->chain = *task->chain;
    p->to = task->to ? task->to->theta : NULL;
    if (task->base_frame) { /* the frame of the measurement before the arm */
        mukca_chain_remove_first(&p->chain);
        p->to += MUKCA_PARAMETERS;
    }
    mukca_status status = mukca_part_take(&p->data, task->data, MUKCA_MOST_SAMPLES, error);
    if (status != MUKCA_OK) return status;
    list_observations(p);
    for (int i = 0; i < p->n_list; i++) p->poses |= p->list[i].group >= p->data.n_sockets;
    if (task->base_frame || task->free_base || !p->poses) p->own = MUKCA_OWN_SHIFT | MUKCA_OWN_TURN;
    if (task->tool_frame || p->data.n_targets > 0) p->own |= MUKCA_OWN_TARGET;
    return set_up(p, error);
}

void mukca_arm_posterior_free(mukca_arm_posterior *p)
{
    mukca_dataset_free(&p->data);
    mukca_pool_free(&p->pool);
}

/* Add the rows of the groups first..last - 1 with this theta. */
static void add_rows(mukca_arm_posterior *p, const double *theta, int first, int last)
{
    mukca_geometry geometry;
    mukca_row_state rows;
    mukca_geometry_set(&geometry, &p->chain, theta);
    for (int row = 0; row < p->data.n_rows; row++) {
        const mukca_joint_state *state = mukca_dataset_state(&rows, &p->data, row);
        mukca_observation *o = p->of_row[row] < 0 ? NULL : &p->list[p->of_row[row]];
        if (!o || o->group < first || o->group >= last) continue;
        const bool pose = o->group >= p->data.n_sockets;
        mukca_arm_point_rows(o->x, &p->at, &geometry, theta, state,
                             pose ? p->own : MUKCA_OWN_SHIFT);
        if (!pose) continue;
        double m[3], at[3];
        for (int a = 0; a < 3; a++)
            m[a] = p->data.position[3 * (size_t)row + (size_t)a] - p->tracker.p[a];
        mukca_mat3_tvec(at, p->tracker.R, m);
        for (int a = 0; a < 3; a++) o->x[(a + 1) * p->groups.width - 1] += at[a];
    }
}

/* Align the frames of one group of poses. */
static bool align(double *theta, mukca_arm_posterior *p, int group, unsigned char *keep)
{
    mukca_geometry geometry;
    mukca_alignment found;
    const mukca_chain *chain = &p->chain;
    const int tip = chain->n_elements - 1;
    for (int row = 0; row < p->data.n_rows; row++)
        keep[row] = p->of_row[row] >= 0 && p->list[p->of_row[row]].group == group;
    const mukca_align_options options = {
        .tracker = p->own & MUKCA_OWN_SHIFT, .target = p->task->tool_frame, .keep = keep};
    mukca_geometry_set(&geometry, chain, theta);
    if (!mukca_align(&found, &geometry, &p->data, &options)) return false;
    p->tracker = found.tracker;
    if (p->task->tool_frame)
        mukca_frame_multiply(&geometry.origin[tip], &geometry.origin[tip], &found.target);
    mukca_geometry_theta(theta, chain, &geometry);
    return true;
}

/* Linearise at the present unknowns. */
static bool linearise(mukca_arm_posterior *p)
{
    const bool framed = (p->own & MUKCA_OWN_SHIFT) || p->task->tool_frame;
    unsigned char *keep = MUKCA_TAKE(&p->pool, unsigned char, p->data.n_rows);
    double theta[MUKCA_MAX_THETA];
    if (!keep) return false;
    for (int i = 0; i < p->n_list; i++)
        memset(p->list[i].x, 0, 3 * (size_t)p->groups.width * sizeof *p->list[i].x);
    add_rows(p, p->at.theta, 0, framed ? p->data.n_sockets : p->groups.n_groups);
    for (int g = p->data.n_sockets; g < p->groups.n_groups && framed; g++) {
        memcpy(theta, p->at.theta, sizeof theta);
        if (!align(theta, p, g, keep)) return false;
        add_rows(p, theta, g, g + 1);
    }
    for (int i = 0; i < p->n_list; i++)
        for (int k = 0; k < 3 * p->groups.width; k++) p->list[i].x[k] /= p->readings[i];
    return true;
}

/* Leave out the distances that the nominal arm misses by a wrong label, unless no other is left:
 * the arm would shrink. */
static void choose_distances(mukca_arm_posterior *p)
{
    double variance;
    int kept = 0;
    for (int k = 0; k < p->groups.n_pairs; k++)
        if (mukca_grouped_pair(p->groups.row, &variance, &p->groups, k) &&
            fabs(p->groups.row[p->at.n]) < wrong_label)
            p->groups.pair[k].used = true, kept++;
    for (int k = 0; k < p->groups.n_pairs && !kept; k++) p->groups.pair[k].used = true;
}

/* The tool has a prior of its own, of one scale; so has an effect. */
static bool is_scaled(const mukca_arm_posterior *p, int i)
{
    return i < p->at.parameters.n &&
           p->at.parameters.index[i] / MUKCA_PARAMETERS != mukca_chain_tip_element(&p->chain);
}

void mukca_arm_posterior_solve(mukca_arm_posterior *p)
{
    for (int i = 0; i < p->at.n; i++)
        p->groups.posterior.prior[i] = is_scaled(p, i)    ? p->scale
                                       : i >= p->extended ? p->extended_scale
                                                          : 1;
    mukca_grouped_clear(&p->groups);
    mukca_grouped_add_all(&p->groups, p->list, p->n_list);
    mukca_grouped_solve(&p->groups, p->mean);
}

/* Weights, noise and scale of the prior from the last solution: one step of expectation and
 * maximisation, and of the evidence (MacKay 1992). */
static void weigh(mukca_arm_posterior *p)
{
    mukca_grouped *g = &p->groups;
    const int n = p->at.n, count = 3 * p->n_list - g->n_own;
    double v[3], squares = 0, known = 0, of_arm = 0, deviation = 0, of_more = 0, size = 0;
    p->gross = 0;
    p->worst_m = g->misfit = 0;
    memset(p->inverse, 0, (size_t)(n * n) * sizeof *p->inverse);
    for (int i = 0; i < n; i++) p->inverse[i * n + i] = 1;
    mukca_dense_forward(p->inverse, n, g->posterior.factor, n);
    for (int i = 0; i < n; i++) {
        double gain = 1;
        for (int k = i; k < n; k++) gain -= p->inverse[k * n + i] * p->inverse[k * n + i];
        known += gain;
        if (i >= p->extended) of_more += gain, size += pow(g->mean[i] - p->mean[i], 2);
        if (!is_scaled(p, i)) continue;
        of_arm += gain;
        deviation += (g->mean[i] - p->mean[i]) * (g->mean[i] - p->mean[i]);
    }
    for (int i = 0; i < p->n_list; i++) {
        mukca_observation *o = &p->list[i];
        const double e = mukca_grouped_residual(v, g, o->x, o->group), z = e / g->noise;
        o->weight = (MUKCA_STUDENT_FREEDOM + 3) / (MUKCA_STUDENT_FREEDOM + z * z);
        squares += o->weight * e * e;
        p->outlier[i] = z > outlier;
        if (o->group < p->data.n_sockets) g->misfit += o->weight * e * e;
        p->gross += e > gross_error;
        p->worst_m = fmax(p->worst_m, e);
    }
    g->noise = sqrt((noise_weight * MUKCA_PRIOR_NOISE * MUKCA_PRIOR_NOISE + squares) /
                    (noise_weight + fmax(count - known, 0)));
    g->misfit /= g->noise * g->noise;
    p->extended_scale = sqrt((1 + size) / (1 + of_more));
    p->scale = fmin(sqrt((scale_weight + deviation) / (scale_weight + of_arm)), most_scale);
}

bool mukca_arm_posterior_turns(const mukca_arm_posterior *p, int joint)
{
    mukca_frame frame[MUKCA_MAX_ELEMENTS];
    double e[3], axis[3], across = 0, along = 0;
    const int element = p->chain.joint_element[joint];
    if (p->chain.element[element].type == MUKCA_PRISMATIC) return false;
    for (int row = 0; row < p->data.n_rows; row++) {
        const mukca_observation *o = p->of_row[row] < 0 ? NULL : &p->list[p->of_row[row]];
        if (!o) continue;
        mukca_fk_frames(frame, NULL, &p->at.geometry, p->data.q + row * p->data.n_joints, NULL);
        mukca_mat3_vec(axis, frame[element].R, p->chain.element[element].axis);
        const double all = mukca_grouped_residual(e, &p->groups, o->x, o->group),
                     part = mukca_dot3(axis, e);
        along += o->weight * part * part;
        across += o->weight * (all * all - part * part) / 2;
    }
    return log(across / along) > 2 * sqrt(spread * spread + 3.0 / p->postures);
}

/* Set the unknowns to the posterior mean. */
static void advance(mukca_arm_posterior *p)
{
    const double *step = p->groups.mean, *sigma = p->at.sigma;
    int c = p->at.parameters.n;
    for (int i = 0; i < c; i++) p->at.theta[p->at.parameters.index[i]] += step[i] * sigma[i];
    for (int e = 0; e < p->at.n_effects; e++)
        for (int t = 0; t < p->at.effects[e].terms; t++, c++)
            p->at.effects[e].coefficient[t] += step[c] * sigma[c];
    for (int i = 0; i < p->at.n; i++) p->mean[i] -= step[i];
    mukca_arm_point_move(&p->at, p->at.theta);
}

/* One step of Gauss-Newton; `first`: chooses the distances. */
static bool improve(mukca_arm_posterior *p, bool first, int weighings)
{
    if (!linearise(p)) return false;
    if (first) { /* without distances, for the means of the sockets */
        mukca_arm_posterior_solve(p);
        choose_distances(p);
    }
    for (int i = 0; i < weighings; i++) {
        const double noise = p->groups.noise, scale = p->scale;
        mukca_arm_posterior_solve(p);
        weigh(p);
        if (fabs(p->groups.noise / noise - 1) + fabs(p->scale / scale - 1) < settled) break;
    }
    mukca_arm_posterior_solve(p);
    advance(p);
    return true;
}

mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                     mukca_error *error)
{
    const mukca_status status = create(p, task, error);
    for (int step = 0; step < STEPS && status == MUKCA_OK; step++)
        if (!improve(p, step == 0, WEIGHINGS))
            return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    return status;
}

mukca_status mukca_arm_posterior_extend(double *gain, mukca_arm_posterior *p,
                                        const mukca_effect *effects, int n, mukca_error *error)
{
    const mukca_grouped from = p->groups;
    const double *mean = p->mean;
    p->extended = p->at.n;
    for (int i = 0; i < n; i++) add_effect(&p->at, &effects[i], 0);
    const mukca_status status = take(p, error);
    if (status != MUKCA_OK) return status;
    for (int i = 0; i < p->extended; i++) p->mean[i] = mean[i];
    p->groups.pair = from.pair;
    p->groups.noise = from.noise;
    p->groups.misfit = from.misfit;
    if (!improve(p, false, WEIGHINGS_AGAIN))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const double ratio = from.noise / p->groups.noise;
    const int count = 3 * p->n_list - from.n_own, more = p->at.n - p->extended;
    *gain = more > 0 ? count * (ratio * ratio - 1) / sqrt(2.0 * more) : 0;
    return MUKCA_OK;
}

void mukca_arm_posterior_probe(double *X, int ld, double *q, const mukca_arm_posterior *p,
                               const mukca_chain *range, int n, mukca_random *random)
{
    const int w = p->groups.width;
    double x[3 * (MUKCA_OWN + MUKCA_MOST_UNKNOWNS + 1)];
    mukca_random_seed(random, 1);
    for (int i = 0; i < n; i++, q += p->chain.n_joints) {
        const mukca_joint_state state = {.q = q, .placement = -1};
        mukca_posture_draw(q, range, random);
        memset(x, 0, sizeof x);
        mukca_arm_point_rows(x, &p->at, &p->at.geometry, p->at.theta, &state, p->own);
        for (int a = 0; a < 3; a++) memcpy(X + (3 * i + a) * ld, x + a * w, (size_t)w * sizeof *x);
    }
}
