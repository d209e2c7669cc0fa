/* Posterior of an arm given samples. */
#include "fit/posterior.h"

#include <math.h>
#include <string.h>

#include "fit/align.h"
#include "math/dense.h"
#include "model/dataset_subset.h"

/* Gauss-Newton steps; in each: weights, noise and scale. */
enum { STEPS = 4, WEIGHINGS = 5 };

/* Weight of the noise's prior in measurements, as while recording; weight of the prior's
 * own scale in parameters, and its largest value; degrees of freedom of the noise (Student). */
static const double noise_weight = 10, scale_weight = 10, most_scale = 4, freedom = 4;

/* Standard deviation of a socket distance, m; an error of the nominal arm's distance that is that
 * of a label, as in diagnose; an error beyond any arm and noise; a ratio to the noise of which the
 * weight is below 0.07. */
static const double distance_sigma = 1e-4, wrong_label = 0.02, gross_error = 0.1, outlier = 10;

/* Of the logarithm of the ratio of the residuals' variances across and along the axis of a joint:
 * 1 % of 1200 joints that moved, in 200 recordings, are beyond twice this. */
static const double spread = 0.8;

double *mukca_arm_posterior_coefficient(mukca_arm_posterior *p, int c)
{
    int e = 0;
    for (; c >= p->effects[e].terms; e++) c -= p->effects[e].terms;
    return &p->effects[e].coefficient[c];
}

void mukca_arm_posterior_add(double *x, mukca_arm_posterior *p, const mukca_geometry *geometry,
                             const double *theta, const mukca_joint_state *state, bool poses)
{
    double J[3 * MUKCA_MAX_THETA], at[3];
    const int all = MUKCA_PARAMETERS * p->chain.n_elements, w = p->width;
    mukca_frame rigid, tip, other;
    mukca_fk_parameter_jacobian(J, at, geometry, theta, state->q);
    mukca_fk_pose(&rigid, geometry, state->q, NULL); /* as the derivatives */
    mukca_tip_pose(&tip, p->effects, p->task->to->n_effects, &p->chain, geometry, state);
    for (int a = 0; a < 3; a++) {
        double *row = x + a * w, *to = row + MUKCA_NUISANCE;
        if (!poses || p->base) row[a] += 1;
        if (poses && p->base) {
            row[3 + (a + 1) % 3] += rigid.p[(a + 2) % 3];
            row[3 + (a + 2) % 3] -= rigid.p[(a + 1) % 3];
        }
        for (int k = 0; k < 3 && poses && p->tool; k++) row[6 + k] += rigid.R[3 * a + k];
        for (int i = 0; i < p->n_geometry; i++)
            to[i] += J[a * all + p->parameters.index[i]] * p->sigma[i];
        to[p->n] += tip.p[a];
    }
    for (int c = p->n_geometry; c < p->n; c++) {
        double *value = mukca_arm_posterior_coefficient(p, c - p->n_geometry), kept = *value;
        *value += p->sigma[c];
        mukca_tip_pose(&other, p->effects, p->task->to->n_effects, &p->chain, geometry, state);
        *value = kept;
        for (int a = 0; a < 3; a++) x[a * w + MUKCA_NUISANCE + c] += other.p[a] - tip.p[a];
    }
}

/* Add the rows of the groups first..last - 1 with this theta. */
static void add_rows(mukca_arm_posterior *p, const double *theta, int first, int last)
{
    mukca_geometry geometry;
    mukca_row_state rows;
    mukca_geometry_set(&geometry, &p->chain, theta);
    for (int row = 0; row < p->data.n_rows; row++) {
        const mukca_joint_state *state = mukca_dataset_state(&rows, &p->data, row);
        mukca_arm_observation *o = p->of_row[row] < 0 ? NULL : &p->list[p->of_row[row]];
        if (!o || o->group < first || o->group >= last) continue;
        const bool pose = o->group >= p->data.n_sockets;
        mukca_arm_posterior_add(o->x, p, &geometry, theta, state, pose);
        if (!pose) continue;
        double m[3], at[3];
        for (int a = 0; a < 3; a++)
            m[a] = p->data.position[3 * (size_t)row + (size_t)a] - p->tracker.p[a];
        mukca_mat3_tvec(at, p->tracker.R, m);
        for (int a = 0; a < 3; a++) o->x[(a + 1) * p->width - 1] -= at[a];
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
        .tracker = p->base, .target = p->task->tool_frame, .keep = keep};
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
    const bool framed = p->base || p->task->tool_frame;
    unsigned char *keep = MUKCA_TAKE(&p->pool, unsigned char, p->data.n_rows);
    double theta[MUKCA_MAX_THETA];
    if (!keep) return false;
    for (int i = 0; i < p->n_list; i++)
        memset(p->list[i].x, 0, 3 * (size_t)p->width * sizeof *p->list[i].x);
    add_rows(p, p->theta, 0, framed ? p->data.n_sockets : p->n_groups);
    for (int g = p->data.n_sockets; g < p->n_groups && framed; g++) {
        memcpy(theta, p->theta, sizeof theta);
        if (!align(theta, p, g, keep)) return false;
        add_rows(p, theta, g, g + 1);
    }
    for (int i = 0; i < p->n_list; i++)
        for (int k = 0; k < 3 * p->width; k++) p->list[i].x[k] /= p->list[i].rows;
    return true;
}

/* Eliminate the nuisance of a group: precision and right-hand side of the unknowns. */
static void add_group(mukca_arm_posterior *p, int group, double *right)
{
    const int w = p->width, n = p->n;
    double *G = p->gram, total = 0;
    memset(G, 0, (size_t)(w * w) * sizeof *G);
    for (int i = 0; i < p->n_list; i++) {
        const mukca_arm_observation *o = &p->list[i];
        if (o->group != group) continue;
        total += o->weight;
        for (int a = 0; a < 3; a++)
            for (int r = 0; r < w; r++) {
                const double f = o->weight * o->x[a * w + r];
                for (int c = r; c < w && f != 0; c++) G[r * w + c] += f * o->x[a * w + c];
            }
    }
    p->group_weight[group] = total;
    for (int b = 0; b < MUKCA_NUISANCE; b++) {
        const double pivot = G[b * w + b];
        if (!(pivot > 1e-9 * total)) continue;
        for (int r = b + 1; r < w; r++) {
            const double f = G[b * w + r] / pivot;
            for (int c = r; c < w && f != 0; c++) G[r * w + c] -= f * G[b * w + c];
        }
    }
    memcpy(p->reduced + MUKCA_NUISANCE * group * w, G, (size_t)(MUKCA_NUISANCE * w) * sizeof *G);
    for (int r = 0; r < n; r++) {
        const double *row = G + (MUKCA_NUISANCE + r) * w + MUKCA_NUISANCE;
        for (int c = r; c < n; c++) p->L[c * n + r] += row[c] / (p->noise * p->noise);
        right[r] -= row[n] / (p->noise * p->noise);
    }
}

/* Derivatives row[n] of the distance of a pair of sockets and its residual before the step;
 * variance: of the residual.  False: one has no sample. */
static bool distance_row(double *row, double *excess, double *variance,
                         const mukca_arm_posterior *p, const mukca_distance *d)
{
    const int w = p->width;
    const double *a = p->reduced + MUKCA_NUISANCE * d->a * w;
    const double *b = p->reduced + MUKCA_NUISANCE * d->b * w;
    const double of_a = 1 / p->group_weight[d->a], of_b = 1 / p->group_weight[d->b];
    double u[3];
    if (!isfinite(of_a + of_b)) return false;
    for (int i = 0, y = w - 1; i < 3; i++, y += w) u[i] = a[y] * of_a - b[y] * of_b;
    const double length = mukca_norm3(u);
    for (int c = 0; c < p->n; c++) {
        row[c] = 0;
        for (int i = 0, x = MUKCA_NUISANCE + c; i < 3; i++, x += w)
            row[c] += u[i] / length * (a[x] * of_a - b[x] * of_b);
    }
    *excess = length - d->distance;
    *variance = distance_sigma * distance_sigma + p->noise * p->noise * (of_a + of_b);
    return length > 1e-6;
}

/* A smaller arm has smaller residuals from the same noise: their sum of squares over the variance,
 * p->misfit, times the logarithm of the scale is added to the likelihood. */
static void add_distances(mukca_arm_posterior *p, double *right)
{
    const int n = p->n;
    double *row = p->gram, excess, variance, pairs = 0;
    for (int k = 0; k < p->data.n_distances; k++) pairs += p->distance_weight[k];
    for (int k = 0; k < p->data.n_distances; k++) {
        if (!distance_row(row, &excess, &variance, p, &p->data.distances[k])) continue;
        const double weight = p->distance_weight[k] / variance,
                     share = p->distance_weight[k] / fmax(pairs, 1) * p->misfit,
                     pull = weight * excess - share / (excess + p->data.distances[k].distance);
        for (int r = 0; r < n; r++) {
            for (int c = r; c < n; c++) p->L[c * n + r] += weight * row[r] * row[c];
            right[r] -= row[r] * pull;
        }
    }
}

/* Leave out the distances that the nominal arm misses by a wrong label, unless no other is left:
 * the arm would shrink. */
static void choose_distances(mukca_arm_posterior *p)
{
    double excess, variance;
    int kept = 0;
    for (int k = 0; k < p->data.n_distances; k++)
        if (distance_row(p->gram, &excess, &variance, p, &p->data.distances[k]) &&
            fabs(excess) < wrong_label)
            p->distance_weight[k] = 1, kept++;
    for (int k = 0; k < p->data.n_distances && !kept; k++) p->distance_weight[k] = 1;
}

/* The tool has a prior of its own, of one scale; that of an effect is nearly flat. */
static bool is_scaled(const mukca_arm_posterior *p, int i)
{
    return i < p->n_geometry &&
           p->parameters.index[i] / MUKCA_PARAMETERS != mukca_chain_tip_element(&p->chain);
}

static double scale_of(const mukca_arm_posterior *p, int i)
{
    return is_scaled(p, i) ? p->scale : 1;
}

void mukca_arm_posterior_solve(mukca_arm_posterior *p)
{
    const int n = p->n;
    memset(p->L, 0, (size_t)(n * n) * sizeof *p->L);
    for (int i = 0; i < n; i++) {
        const double s = scale_of(p, i);
        p->L[i * n + i] = 1 / (s * s);
        p->step[i] = p->mean[i] / (s * s);
    }
    for (int g = 0; g < p->n_groups; g++) add_group(p, g, p->step);
    add_distances(p, p->step);
    mukca_dense_solve(p->step, 1, p->L, n); /* positive definite: every unknown has a prior */
}

/* Residual e of an observation after the last step; b[MUKCA_NUISANCE] of its group. */
static double residual(double e[3], const mukca_arm_posterior *p, const mukca_arm_observation *o,
                       const double *b)
{
    for (int a = 0; a < 3; a++) {
        const double *x = o->x + a * p->width;
        e[a] = x[p->width - 1];
        for (int k = 0; k < MUKCA_NUISANCE; k++) e[a] += x[k] * b[k];
        for (int i = 0; i < p->n; i++) e[a] += x[MUKCA_NUISANCE + i] * p->step[i];
    }
    return mukca_norm3(e);
}

/* Nuisance of a group after the last step; returns their number. */
static int nuisance(double *b, const mukca_arm_posterior *p, int group)
{
    const int w = p->width;
    int count = 0;
    for (int k = MUKCA_NUISANCE - 1; k >= 0; k--) {
        const double *row = p->reduced + (MUKCA_NUISANCE * group + k) * w;
        double sum = row[w - 1];
        b[k] = 0;
        if (!(row[k] > 1e-9 * p->group_weight[group])) continue;
        for (int j = k + 1; j < MUKCA_NUISANCE; j++) sum += row[j] * b[j];
        for (int i = 0; i < p->n; i++) sum += row[MUKCA_NUISANCE + i] * p->step[i];
        b[k] = -sum / row[k];
        count++;
    }
    return count;
}

/* Weights, noise and scale of the prior from the last solution: one step of expectation and
 * maximisation, and of the evidence (MacKay 1992). */
static void weigh(mukca_arm_posterior *p)
{
    const int n = p->n;
    double b[MUKCA_NUISANCE], v[3], squares = 0, known = 0, of_arm = 0, deviation = 0;
    int count = 0;
    p->outliers = p->gross = 0;
    p->worst_m = p->misfit = 0;
    memset(p->inverse, 0, (size_t)(n * n) * sizeof *p->inverse);
    for (int i = 0; i < n; i++) p->inverse[i * n + i] = 1;
    mukca_dense_forward(p->inverse, n, p->L, n);
    for (int i = 0; i < n; i++) {
        const double s = scale_of(p, i);
        double variance = 0;
        for (int k = i; k < n; k++) variance += p->inverse[k * n + i] * p->inverse[k * n + i];
        const double gain = 1 - variance / (s * s);
        known += gain;
        if (!is_scaled(p, i)) continue;
        of_arm += gain;
        deviation += (p->step[i] - p->mean[i]) * (p->step[i] - p->mean[i]);
    }
    for (int g = 0; g < p->n_groups; g++) {
        if (!(p->group_weight[g] > 0)) continue;
        count -= nuisance(b, p, g);
        for (int i = 0; i < p->n_list; i++) {
            mukca_arm_observation *o = &p->list[i];
            if (o->group != g) continue;
            const double e = residual(v, p, o, b), z = e / p->noise;
            o->weight = (freedom + 3) / (freedom + z * z);
            squares += o->weight * e * e;
            p->outliers += z > outlier;
            if (g < p->data.n_sockets) p->misfit += o->weight * e * e;
            p->gross += e > gross_error;
            p->worst_m = fmax(p->worst_m, e);
            count += 3;
        }
    }
    p->noise = sqrt((noise_weight * MUKCA_PRIOR_NOISE * MUKCA_PRIOR_NOISE + squares) /
                    (noise_weight + fmax(count - known, 0)));
    p->misfit /= p->noise * p->noise;
    p->scale = fmin(sqrt((scale_weight + deviation) / (scale_weight + of_arm)), most_scale);
}

bool mukca_arm_posterior_turns(const mukca_arm_posterior *p, int joint)
{
    mukca_geometry geometry;
    mukca_frame frame[MUKCA_MAX_ELEMENTS];
    double b[MUKCA_NUISANCE], e[3], axis[3], across = 0, along = 0;
    const int element = p->chain.joint_element[joint];
    if (p->chain.element[element].type == MUKCA_PRISMATIC) return false;
    mukca_geometry_set(&geometry, &p->chain, p->theta);
    for (int row = 0; row < p->data.n_rows; row++) {
        const mukca_arm_observation *o = p->of_row[row] < 0 ? NULL : &p->list[p->of_row[row]];
        if (!o) continue;
        nuisance(b, p, o->group);
        mukca_fk_frames(frame, NULL, &geometry, p->data.q + row * p->data.n_joints, NULL);
        mukca_mat3_vec(axis, frame[element].R, p->chain.element[element].axis);
        const double all = residual(e, p, o, b), part = mukca_dot3(axis, e);
        along += o->weight * part * part;
        across += o->weight * (all * all - part * part) / 2;
    }
    return log(across / along) > 2 * sqrt(spread * spread + 3.0 / p->postures);
}

mukca_status mukca_arm_posterior_fit(mukca_arm_posterior *p, mukca_error *error)
{
    for (int step = 0; step < STEPS; step++) {
        if (!linearise(p)) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
        if (step == 0) { /* without distances, for the means of the sockets */
            mukca_arm_posterior_solve(p);
            choose_distances(p);
        }
        for (int i = 0; i < WEIGHINGS; i++) {
            mukca_arm_posterior_solve(p);
            weigh(p);
        }
        mukca_arm_posterior_solve(p);
        for (int i = 0; i < p->n; i++) {
            const double move = p->step[i] * p->sigma[i];
            if (i < p->n_geometry)
                p->theta[p->parameters.index[i]] += move;
            else
                *mukca_arm_posterior_coefficient(p, i - p->n_geometry) += move;
            p->mean[i] -= p->step[i];
        }
    }
    return MUKCA_OK;
}
