/* Alignment of measured poses to the arm: closed form, then robust Gauss-Newton; of two arms. */
#include "fit/align.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/pool.h"
#include "math/dense.h"
#include "math/stats.h"

/* Scale of the nominal model's errors (prior of the geometry: some millimetres), m; also the
 * rotation, rad, that displaces the tip by as much at an arm's length of 1 m. */
#define MODEL_ERROR 5e-3
/* A target is mounted within a hand's reach of the flange, m: matters only in directions that the
 * postures do not determine. */
#define TARGET_REACH 0.3
enum { MOST_STEPS = 30 };

typedef struct {
    mukca_meeting_point *points; /* [n] prediction and measurement, with robust weights */
    double (*measured)[9];       /* [n] orientation; [0] NaN: none */
    double *length;              /* [n] scratch */
    int n;
    int steps;
    bool tracker, target, turned;
    mukca_pool pool;
} problem;

/* Orientation of the target: the relative rotations of the measurements are those of the tip in
 * target coordinates; their axes differ by the target's rotation (Park and Martin 1994). */
static void turn_target(mukca_alignment *a, const problem *p)
{
    double H[9] = {0};
    int used = 0;
    for (int step = 1; step <= p->n / 2 && step <= 8; step++)
        for (int i = 0; i + step < p->n; i++) {
            double tip[9], measured[9], u[3], v[3];
            if (isnan(p->measured[i][0]) || isnan(p->measured[i + step][0])) continue;
            mukca_mat3_tmul(tip, p->points[i].from.R, p->points[i + step].from.R);
            mukca_mat3_tmul(measured, p->measured[i], p->measured[i + step]);
            mukca_rotation_log(u, tip);
            mukca_rotation_log(v, measured);
            /* near half a turn the axis may flip; a faulty sample has another angle */
            const double tu = mukca_norm3(u), tv = mukca_norm3(v);
            if (tu > 3.0 || fabs(tu - tv) > 0.05) continue;
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++) H[3 * r + c] += v[r] * u[c];
            used++;
        }
    if (used >= 2) mukca_rotation_nearest(a->target.R, H);
}

/* Orientation of the tracker from the measured orientations; that of the target is known. */
static void turn_tracker(mukca_alignment *a, const problem *p)
{
    double H[9] = {0};
    for (int i = 0; i < p->n; i++) {
        double R[9];
        if (isnan(p->measured[i][0])) continue;
        mukca_mat3_mul(R, p->points[i].from.R, a->target.R);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++)
                    H[3 * r + c] += R[3 * r + k] * p->measured[i][3 * c + k];
    }
    mukca_rotation_nearest(a->tracker.R, H);
}

/* Position of the target in the tip's frame from positions alone: tracker' (measured - offset) =
 * tip.p + tip.R target is linear in the nine elements of tracker', the rotated offset and the
 * target. */
static void place_target(mukca_alignment *a, const problem *p)
{
    enum { N = 15, SIZE = N + 1 };
    double R[N * SIZE] = {0}, x[N];
    for (int i = 0; i < p->n; i++)
        for (int r = 0; r < 3; r++) {
            double row[SIZE] = {0};
            const mukca_meeting_point *e = &p->points[i];
            for (int c = 0; c < 3; c++) {
                row[3 * r + c] = e->to[c] / MODEL_ERROR;
                row[12 + c] = -e->from.R[3 * r + c] / MODEL_ERROR;
            }
            row[9 + r] = 1 / MODEL_ERROR;
            row[N] = e->from.p[r] / MODEL_ERROR;
            mukca_dense_qr_absorb(R, NULL, row, 1, N, 1);
        }
    for (int c = 0; c < 3; c++) {
        double row[SIZE] = {0};
        row[12 + c] = 1 / TARGET_REACH;
        mukca_dense_qr_absorb(R, NULL, row, 1, N, 1);
    }
    mukca_dense_qr_solve(x, R, N);
    memcpy(a->target.p, x + 12, sizeof a->target.p);
}

/* Set `at` of the points to the target by the model, without the tracker. */
static void place(const mukca_alignment *a, const problem *p)
{
    for (int i = 0; i < p->n; i++) {
        mukca_meeting_point *e = &p->points[i];
        mukca_mat3_vec(e->at, e->from.R, a->target.p);
        for (int c = 0; c < 3; c++) e->at[c] += e->from.p[c];
    }
}

/* Robust weights from the residuals of the alignment, with the heavy-tailed weighting of the
 * screening; sets median and mean distance, m. */
static void weigh(mukca_alignment *a, problem *p)
{
    a->mean_m = 0;
    place(a, p);
    for (int i = 0; i < p->n; i++) {
        double x[3];
        mukca_mat3_vec(x, a->tracker.R, p->points[i].at);
        for (int c = 0; c < 3; c++) x[c] += a->tracker.p[c];
        p->length[i] = p->points[i].weight = mukca_distance3(x, p->points[i].to);
        a->mean_m += p->length[i] / p->n;
    }
    a->median_m = mukca_stats_median(p->length, p->n);
    const double c = fmax(3 * a->median_m, 1e-6);
    for (int i = 0; i < p->n; i++) {
        const double x = p->points[i].weight / c;
        p->points[i].weight = 1 / (1 + x * x);
    }
}

/* Closed form, then Gauss-Newton of the free positions and of the tracker's rotation (the target's
 * is determined by the orientations); with `guess` the target starts at the solution of the linear
 * system. */
static void solve(mukca_alignment *a, problem *p, bool guess)
{
    const mukca_meeting meeting = {.points = p->points,
                                   .n = p->n,
                                   .base = p->tracker,
                                   .tool = p->target,
                                   .pull = MODEL_ERROR / TARGET_REACH};
    double R[MUKCA_MEETING_FACTOR];
    for (int i = 0; i < p->n; i++) p->points[i].weight = 1;
    if (p->turned && p->target) turn_target(a, p);
    if (guess) place_target(a, p);
    if (p->tracker) { /* Horn; the target's position is known */
        place(a, p);
        mukca_frame_nearest(&a->tracker, p->points->to, p->points->at,
                            sizeof *p->points / sizeof(double), p->n);
        if (p->turned) turn_tracker(a, p);
    }
    for (int pass = 0; pass < p->steps; pass++) {
        const double step = mukca_frame_refine(R, &a->tracker, a->target.p, &meeting);
        weigh(a, p);
        if (step < 1e-9) break; /* 1 nm, 1 nrad */
    }
}

static void collect(problem *p, const mukca_geometry *geometry, const mukca_dataset *data,
                    const unsigned char *keep)
{
    for (int row = 0; row < data->n_rows; row++) {
        const double *x = data->position + 3 * (size_t)row;
        if (data->socket[row] >= 0 || !isfinite(x[0]) || (keep && !keep[row])) continue;
        mukca_meeting_point *e = &p->points[p->n];
        double *R = p->measured[p->n++];
        mukca_fk_pose(&e->from, geometry, data->q + (size_t)row * (size_t)data->n_joints, NULL);
        memcpy(e->to, x, sizeof e->to);
        const double *quaternion = data->quaternion ? data->quaternion + 4 * (size_t)row : NULL;
        R[0] = NAN;
        if (!quaternion || !isfinite(quaternion[0])) continue;
        mukca_rotation_from_quaternion(R, quaternion);
        p->turned = true;
    }
}

bool mukca_align(mukca_alignment *out, const mukca_geometry *geometry, const mukca_dataset *data,
                 const mukca_align_options *options)
{
    const mukca_alignment start = {
        .tracker.R = MUKCA_IDENTITY, .target.R = MUKCA_IDENTITY, .median_m = NAN, .mean_m = NAN};
    problem p = {.tracker = options->tracker,
                 .target = options->target,
                 .steps = options->steps ? options->steps : MOST_STEPS};
    *out = start;
    if (!data->position || data->n_rows < 3 || (!p.tracker && !p.target)) return true;
    p.points = MUKCA_TAKE(&p.pool, mukca_meeting_point, data->n_rows);
    p.measured = MUKCA_TAKE(&p.pool, double[9], data->n_rows);
    p.length = MUKCA_TAKE(&p.pool, double, data->n_rows);
    const bool failed = p.pool.failed;
    if (!failed) collect(&p, geometry, data, options->keep);
    for (int guess = 0; p.n >= 3 && guess < 1 + p.target; guess++) {
        mukca_alignment a = start;
        solve(&a, &p, guess);
        if (!(a.median_m >= out->median_m)) *out = a;
    }
    mukca_pool_free(&p.pool);
    return !failed;
}

/* ---- frames as elements of the chain ---- */

static void fixed_element(mukca_element *element, const char *name, const char *child)
{
    memset(element, 0, sizeof *element);
    snprintf(element->name, sizeof element->name, "%s", name);
    snprintf(element->child, sizeof element->child, "%s", child);
    element->type = MUKCA_FIXED;
    element->joint = -1;
    element->axis[2] = 1;
}

mukca_status mukca_chain_with_frames(mukca_chain *out, const mukca_chain *chain, bool base,
                                     bool tool, mukca_error *error)
{
    tool = tool && mukca_chain_tip_element(chain) < 0;
    const int n = chain->n_elements + base + tool;
    if (n > MUKCA_MAX_ELEMENTS)
        return mukca_fail(error, MUKCA_INPUT, "the chain has %d elements, at most %d are supported",
                          n, (int)MUKCA_MAX_ELEMENTS);
    if (out != chain) *out = *chain;
    if (base) {
        memmove(out->element + 1, out->element, (size_t)out->n_elements * sizeof *out->element);
        fixed_element(&out->element[0], MUKCA_BASE_FRAME, chain->base);
        for (int m = 0; m < out->n_masses; m++) out->mass[m].element++;
        for (int j = 0; j < out->n_joints; j++) out->joint_element[j]++;
    }
    if (tool) fixed_element(&out->element[n - 1], MUKCA_TOOL_FRAME, chain->tip);
    out->n_elements = n;
    return MUKCA_OK;
}

mukca_status mukca_frames_start(double *theta, const mukca_chain *chain, const mukca_dataset *data,
                                bool base, bool tool, mukca_error *error)
{
    unsigned char *keep = NULL;
    const int tip = mukca_chain_tip_element(chain);
    mukca_geometry geometry;
    mukca_alignment found;
    mukca_chain_theta(theta, chain);
    if (!base && !tool) return MUKCA_OK;
    mukca_geometry_set(&geometry, chain, NULL);
    if (data->n_targets > 1) { /* align with the samples of the first target */
        keep = malloc((size_t)data->n_rows);
        for (int i = 0; i < data->n_rows && keep; i++) keep[i] = data->target[i] == data->target[0];
    }
    const mukca_align_options options = {.tracker = base, .target = tool, .keep = keep};
    const bool aligned =
        (keep || data->n_targets < 2) && mukca_align(&found, &geometry, data, &options);
    free(keep);
    if (!aligned) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    if (base) geometry.origin[0] = found.tracker;
    if (tool) mukca_frame_multiply(&geometry.origin[tip], &geometry.origin[tip], &found.target);
    mukca_geometry_theta(theta, chain, &geometry);
    return MUKCA_OK;
}

/* ---- two arms: weighted absolute orientation (Horn 1987) ---- */

enum { FREE = 6, SIZE = MUKCA_MEETING + 1 };

/* (1 um)^2: lower bound, for simulated arms without noise. */
static const double least_variance = 1e-12;
/* Sockets on one line do not determine the rotation about it.  Smallest ratio of a column's
 * component orthogonal to the others and its length: a lever arm of 1 mm in 1 m. */
static const double least_share = 1e-3;

static double variance_of(const mukca_shared_socket *s)
{
    return fmax(s->variance[0] + s->variance[1], least_variance);
}

static bool determined(const double *R)
{
    for (int c = 0; c < FREE; c++) {
        double length = 0;
        for (int i = 0; i <= c; i++) length = hypot(length, R[i * SIZE + c]);
        if (!(fabs(R[c * SIZE + c]) > least_share * length)) return false;
    }
    return true;
}

/* 97.5 % quantile of Student's t (Abramowitz and Stegun 26.7.5), to 1 % from 3 degrees of freedom
 * on. */
static double student(int freedom)
{
    const double z = MUKCA_SIGMAS_95, z2 = z * z, f = freedom;
    return z * (1 + (z2 + 1) / (4 * f) + ((5 * z2 + 16) * z2 + 3) / (96 * f * f) +
                (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * f * f * f));
}

/* Standard errors and intervals of the pose from the factor R of the last step. */
static void judge(mukca_two_arms *out, double *R, const mukca_shared_socket *s, int n)
{
    double chi2 = 0, squares = 0, noise = 0;
    for (int i = 0; i < n; i++) {
        double r[3], at[3];
        mukca_mat3_vec(at, out->pose.R, s[i].at[1]);
        for (int a = 0; a < 3; a++) r[a] = s[i].at[0][a] - out->pose.p[a] - at[a];
        chi2 += mukca_dot3(r, r) / variance_of(&s[i]);
        squares += mukca_dot3(r, r);
        noise += 3 * variance_of(&s[i]);
    }
    out->freedom = 3 * n - FREE;
    out->residual_m = sqrt(squares / n);
    out->expected_m = sqrt(noise / n * out->freedom / (3 * n));
    out->scale = fmax(1, sqrt(chi2 / out->freedom));
    memset(out->sigma, 0, sizeof out->sigma);
    for (int k = 0; k < FREE; k++) { /* columns of R^-1 */
        double x[MUKCA_MEETING];
        for (int i = 0; i < MUKCA_MEETING; i++) R[i * SIZE + MUKCA_MEETING] = i == k;
        mukca_dense_qr_solve(x, R, MUKCA_MEETING);
        for (int i = 0; i < FREE; i++) out->sigma[i] = hypot(out->sigma[i], x[i]);
    }
    for (int i = 0; i < FREE; i++) {
        out->sigma[i] *= out->scale;
        out->width95[i] =
            (out->scale > 1 ? student(out->freedom) : student(1000000)) * out->sigma[i];
    }
}

mukca_status mukca_two_arms_align(mukca_two_arms *out, const mukca_shared_socket *s, int n,
                                  mukca_error *error)
{
    double R[MUKCA_MEETING_FACTOR], none[3] = {0};
    if (n < 3)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "the arms share %d sockets; three are needed, not on one line: record "
                          "two placements with both arms",
                          n);
    mukca_pool pool = {0};
    mukca_meeting_point *points = MUKCA_TAKE(&pool, mukca_meeting_point, n);
    if (!points) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_meeting meeting = {.points = points, .n = n, .base = true};
    for (int i = 0; i < n; i++) {
        points[i].weight = 1 / variance_of(&s[i]);
        memcpy(points[i].to, s[i].at[0], sizeof points[i].to);
        memcpy(points[i].from.p, s[i].at[1], sizeof points[i].from.p);
    }
    mukca_frame_nearest(&out->pose, s->at[0], s->at[1], sizeof *s / sizeof(double), n);
    for (int pass = 0; pass < MOST_STEPS; pass++)
        if (mukca_frame_refine(R, &out->pose, none, &meeting) < 1e-12) break;
    mukca_pool_free(&pool);
    if (!determined(R))
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "the sockets that the arms share lie on one line; record another "
                          "placement off it with both arms");
    judge(out, R, s, n);
    return MUKCA_OK;
}
