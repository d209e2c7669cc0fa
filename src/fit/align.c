/* Alignment of measured poses to the arm: several starts, then robust Gauss-Newton. */
#include "fit/align.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/pool.h"
#include "fit/poses.h"
#include "math/dense.h"
#include "math/stats.h"
#include "model/dataset_subset.h"

/* Scale of the nominal model's errors (prior of the geometry: some millimetres), m; also the
 * rotation, rad, that displaces the tip by as much at an arm's length of 1 m. */
#define MODEL_ERROR 5e-3
/* A target is mounted within a hand's reach of the flange, m: matters only in directions that the
 * postures do not determine. */
#define TARGET_REACH 1
/* Steps of a search; 20 are enough but where directions are poorly determined. */
enum { MOST_STEPS = 60, FIRST_STEPS = 15 };
/* A frame that is not known to a fist's breadth or to three degrees is not determined, m and rad.
 */
static const double open_offset = 0.05, open_turn = 0.05;
/* In medians; nine standard deviations of normal noise: only wild samples have less weight, as the
 * error of a nominal model is the least that any frames leave. */
static const double gross = 6;
/* Relative gain of a step, below which no error changes in its third digit. */
static const double least_gain = 1e-6;

typedef struct {
    mukca_meeting_point *points; /* [n] prediction and measurement, with robust weights */
    double *length;              /* [n] scratch */
    int n;
    int steps; /* of a start, at most */
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
            if (isnan(p->points[i].turned[0]) || isnan(p->points[i + step].turned[0])) continue;
            mukca_mat3_tmul(tip, p->points[i].from.R, p->points[i + step].from.R);
            mukca_mat3_tmul(measured, p->points[i].turned, p->points[i + step].turned);
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

/* Orientation of the tracker (of the target, `tool`) from the measured orientations; that of the
 * other is known. */
static void turn_frame(mukca_alignment *a, const problem *p, bool tool)
{
    double H[9] = {0};
    for (int i = 0; i < p->n; i++) {
        const double *F = p->points[i].from.R, *M = p->points[i].turned;
        double known[9];
        if (isnan(M[0])) continue;
        mukca_mat3_mul(known, tool ? a->tracker.R : F, tool ? F : a->target.R);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                for (int k = 0; k < 3; k++) /* known' M, transposed; known M' */
                    H[3 * r + c] +=
                        tool ? M[3 * k + r] * known[3 * k + c] : known[3 * r + k] * M[3 * c + k];
    }
    mukca_rotation_nearest(tool ? a->target.R : a->tracker.R, H);
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
            mukca_dense_qr_absorb(R, row, 1, N, 1);
        }
    for (int c = 0; c < 3; c++) {
        double row[SIZE] = {0};
        row[12 + c] = 1.0 / TARGET_REACH;
        mukca_dense_qr_absorb(R, row, 1, N, 1);
    }
    mukca_dense_qr_solve(x, R, N);
    memcpy(a->target.p, x + 12, sizeof a->target.p);
}

/* Set `at` of the points to the target by the model, without the tracker. */
static void place(const mukca_alignment *a, const problem *p)
{
    for (int i = 0; i < p->n; i++)
        mukca_frame_point(p->points[i].at, &p->points[i].from, a->target.p);
}

/* Bring the tracker to the points; the target's position is known. */
static void meet(mukca_alignment *a, const problem *p)
{
    place(a, p);
    mukca_frame_nearest(&a->tracker, p->points->to, p->points->at,
                        sizeof *p->points / sizeof(double), p->n);
}

/* Weights from the residuals of the alignment: less for gross outliers; sets median and mean
 * distance, m.  Returns the rms residual, and their median. */
static double weigh(double *median, mukca_alignment *a, problem *p)
{
    double square = 0;
    a->mean_m = 0;
    place(a, p);
    for (int i = 0; i < p->n; i++) {
        double x[3], w[3] = {0};
        mukca_meeting_point *e = &p->points[i];
        mukca_frame_point(x, &a->tracker, e->at);
        p->length[i] = mukca_distance3(x, e->to);
        if (!isnan(e->turned[0])) {
            double TF[9], turned[9];
            mukca_mat3_mul(TF, a->tracker.R, e->from.R);
            mukca_mat3_mul(turned, TF, a->target.R);
            mukca_rotation_difference(w, e->turned, turned);
        }
        e->weight = hypot(p->length[i], MUKCA_METRES_PER_RADIAN * mukca_norm3(w));
        a->mean_m += p->length[i] / p->n;
    }
    a->median_m = mukca_stats_median(p->length, p->n);
    for (int i = 0; i < p->n; i++) p->length[i] = p->points[i].weight;
    *median = mukca_stats_median(p->length, p->n);
    const double bend = fmax(gross * *median, 1e-6);
    for (int i = 0; i < p->n; i++) {
        const double e = p->points[i].weight;
        p->points[i].weight = fmin(1, bend / e);
        square += e * fmin(e, bend);
    }
    const double far = *median * mukca_norm3(a->target.p) / TARGET_REACH;
    return sqrt((square + far * far) / p->n);
}

/* Where the search starts: the target at the solution of the linear system, turned as the relative
 * rotations say, on the flange, or a hand's reach from it along each axis.  Which of them is near
 * enough depends on how much the tool turns and how far it moves: the best result is kept. */
enum { LINEAR, HAND_EYE, AT_FLANGE, STARTS = AT_FLANGE + 7 };

static mukca_meeting meeting_of(const problem *p, double residual)
{
    return (mukca_meeting){.points = p->points,
                           .n = p->n,
                           .base = p->tracker,
                           .tool = p->target,
                           .pull = residual / TARGET_REACH,
                           .per_radian = p->turned ? MUKCA_METRES_PER_RADIAN : 0};
}

/* Start in closed form, then Gauss-Newton; returns the rms residual, m. */
static double solve(mukca_alignment *a, problem *p, int start)
{
    mukca_meeting meeting = meeting_of(p, MODEL_ERROR);
    double R[MUKCA_MEETING_FACTOR], median, rms;
    for (int i = 0; i < p->n; i++) p->points[i].weight = 1;
    if (start == LINEAR) place_target(a, p);
    if (start > AT_FLANGE) a->target.p[start % 3] = (start - AT_FLANGE) % 2 ? 0.3 : -0.3;
    if (start == HAND_EYE) turn_target(a, p);
    if (p->tracker) {
        meet(a, p);
        if (p->turned && (start == HAND_EYE || !p->target)) turn_frame(a, p, false);
    }
    if (p->turned && p->target && start != HAND_EYE) turn_frame(a, p, true);
    rms = weigh(&median, a, p);
    for (int pass = 0; pass < p->steps; pass++) {
        mukca_alignment next = *a;
        meeting.pull = fmax(median, 1e-6) / TARGET_REACH;
        const double step = mukca_frame_refine(R, &next.tracker, &next.target, &meeting);
        if (pass < FIRST_STEPS && p->tracker && !p->turned) meet(&next, p);
        const double reached = weigh(&median, &next, p), gain = 1 - reached / rms;
        if (gain > 0) {
            *a = next, rms = reached;
            meeting.damping /= 10;
        } else { /* damped as Levenberg and Marquardt do, from a tenth of the points' own weight */
            meeting.damping = fmax(0.1 * sqrt(p->n), 3 * meeting.damping);
            rms = weigh(&median, a, p);
        }
        if (step < 1e-9 || (step < 1e-4 && fabs(gain) < least_gain)) break; /* 1 nm, 1 nrad */
    }
    return rms;
}

/* Mark what the residuals, m, leave open at the end. */
static void find_open(mukca_alignment *a, const problem *p, double residual)
{
    const mukca_meeting meeting = meeting_of(p, residual);
    double R[MUKCA_MEETING_FACTOR], sigma[MUKCA_MEETING];
    const bool fits = residual < 2 * MODEL_ERROR; /* else they say nothing of the frames */
    mukca_alignment still = *a;
    (void)mukca_frame_refine(R, &still.tracker, &still.target, &meeting);
    mukca_meeting_errors(sigma, R, MUKCA_MEETING);
    a->open_target = p->target && fits && residual * mukca_norm3(sigma + 6) > open_offset;
    a->open_turn = p->tracker && fits && residual * mukca_norm3(sigma + 3) > open_turn;
}

static bool is_collected(const mukca_dataset *data, const mukca_align_options *options, int row)
{
    return data->socket[row] < 0 && isfinite(data->position[3 * (size_t)row]) &&
           (!options->group || options->group[row] == options->only);
}

static void collect(problem *p, const mukca_geometry *geometry, const mukca_dataset *data,
                    const mukca_align_options *options)
{
    int n = 0;
    for (int row = 0; row < data->n_rows; row++) n += is_collected(data, options, row);
    const int every = 1 + (n - 1) / MUKCA_MOST_SAMPLES;
    for (int row = 0, seen = 0; row < data->n_rows; row++) {
        const double *x = data->position + 3 * (size_t)row;
        if (!is_collected(data, options, row) || seen++ % every) continue;
        mukca_meeting_point *e = &p->points[p->n++];
        mukca_fk_pose(&e->from, geometry, data->q + (size_t)row * (size_t)data->n_joints, NULL);
        memcpy(e->to, x, sizeof e->to);
        const double *quaternion = data->quaternion ? data->quaternion + 4 * (size_t)row : NULL;
        e->turned[0] = NAN;
        if (!quaternion || !isfinite(quaternion[0])) continue;
        mukca_rotation_from_quaternion(e->turned, quaternion);
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
    const int starts = options->steps ? AT_FLANGE + 1 : STARTS;
    double least = NAN;
    *out = start;
    if (!data->position || data->n_rows < 3 || (!p.tracker && !p.target)) return true;
    const int most = data->n_rows < MUKCA_MOST_SAMPLES ? data->n_rows : MUKCA_MOST_SAMPLES;
    p.points = MUKCA_TAKE(&p.pool, mukca_meeting_point, most);
    p.length = MUKCA_TAKE(&p.pool, double, most);
    const bool failed = p.pool.failed;
    if (!failed) collect(&p, geometry, data, options);
    for (int k = 0, agree = 0; p.n >= 3 && !failed && k < starts && agree < 3; k++) {
        mukca_alignment a = start;
        if (k != AT_FLANGE && (!p.target || (k == HAND_EYE && !p.turned))) continue;
        const double rms = solve(&a, &p, k);
        agree += fabs(rms / least - 1) < 1e-3; /* well-conditioned poses have one minimum */
        if (!(rms >= least)) *out = a, least = rms;
    }
    if (p.n >= 3 && !failed) find_open(out, &p, fmax(least, 1e-6));
    mukca_pool_free(&p.pool);
    return !failed;
}

const char *mukca_alignment_open(const mukca_alignment *a)
{
    if (a->open_turn)
        return "the poses do not determine how the arm's base is turned in their frame (the tip "
               "moves along a line, or hardly): that turn and all that depends on it is arbitrary; "
               "move the tip in three dimensions";
    if (a->open_target)
        return "the poses do not determine the target's offset from the tip (the tool keeps its "
               "orientation); it is held near the tip; an error of it is one of the base's "
               "position, and the nominal error is larger than with a free target; turn the tool "
               "by 30 degrees or more about two axes";
    return NULL;
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
    const int tip = mukca_chain_tip_element(chain);
    mukca_geometry geometry;
    mukca_alignment found;
    mukca_chain_theta(theta, chain);
    if (!base && !tool) return MUKCA_OK;
    mukca_geometry_set(&geometry, chain, NULL);
    const mukca_align_options options = {.tracker = base,
                                         .target = tool,
                                         .group = data->n_targets > 1 ? data->target : NULL,
                                         .only = mukca_dataset_target(data, 0)};
    if (!mukca_align(&found, &geometry, data, &options))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    if (base) geometry.origin[0] = found.tracker;
    if (tool) mukca_frame_multiply(&geometry.origin[tip], &geometry.origin[tip], &found.target);
    mukca_geometry_theta(theta, chain, &geometry);
    return MUKCA_OK;
}
