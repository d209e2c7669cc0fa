/* Re-calibration from measured poses: lag, fit of all parameters, and its restrictions. */
#include "recalibrate/recalibrate.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "fit/align.h"
#include "model/dataset_subset.h"
#include "model/prior.h"

/* ---- lag between angles and poses: the minimum of the cost of fits to shifted angles ---- */

/* Samples that are enough for a lag, evenly spread; the most times that its parabola is renewed. */
enum { LAG_PART = 2000, ROUNDS = 4 };

/* Least distance from zero, in standard errors: rows that are correlated count as independent in
 * these.  Largest part of the cost that is left: 5 % of the error; outliers alone do not do that.
 */
static const double least_score = 8, most_left = 0.9;

/* Shift of the tip between the fits that define a parabola, m. */
static const double probe = 1e-4;

/* Root mean square velocity of the tip by its joints, m per unit of time. */
static double tip_velocity(const mukca_chain *chain, const mukca_dataset *log)
{
    const double step = 1e-6; /* of a forward difference, s or rows */
    double squares = 0;
    mukca_geometry g;
    mukca_geometry_set(&g, chain, NULL);
    for (int i = 0; i < log->n_rows; i++) {
        double a[3], b[3], q[MUKCA_MAX_JOINTS];
        const double *at = log->q + i * log->n_joints, *v = log->velocity + i * log->n_joints;
        for (int j = 0; j < log->n_joints; j++) q[j] = at[j] + step * v[j];
        mukca_fk_position(a, &g, at, NULL);
        mukca_fk_position(b, &g, q, NULL);
        squares += pow(mukca_distance3(a, b) / step, 2);
    }
    return sqrt(squares / log->n_rows);
}

/* Fits to a part of a log, whose angles are `now` later than recorded. */
typedef struct {
    const mukca_chain *chain;
    const mukca_fit_options *options;
    mukca_dataset part;
    double now;
    mukca_fit fit;
} shifted;

/* Cost with the angles `lag` later. */
static mukca_status cost_at(double *cost, shifted *s, double lag, mukca_error *error)
{
    double start[MUKCA_MAX_FREE];
    mukca_fit_options warm = *s->options;
    memcpy(start, s->fit.theta, sizeof start);
    if (s->fit.parameters.n) warm.start = start;
    mukca_pose_log_shift(&s->part, lag - s->now);
    s->now = lag;
    const mukca_status status = mukca_fit_run(&s->fit, s->chain, &s->part, &warm, error);
    *cost = s->fit.calibrated.total;
    return status;
}

/* Age of the angles relative to the poses, s, or rows without times; 0: none found.  *score: its
 * distance from 0 in standard errors. */
static mukca_status find_lag(double *lag, double *score, const mukca_chain *chain,
                             const mukca_dataset *log, const mukca_fit_options *options,
                             mukca_error *error)
{
    shifted *s = calloc(1, sizeof *s);
    double at = 0, cost[3], first = 0;
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the lag");
    s->chain = chain;
    s->options = options;
    *lag = *score = 0;
    mukca_status status = mukca_part_take(&s->part, log, LAG_PART, error);
    const double velocity = status == MUKCA_OK ? tip_velocity(chain, &s->part) : 0;
    const double step = probe / velocity;
    for (int round = 0; round < ROUNDS && velocity > 0; round++) {
        for (int k = 0; k < 3 && status == MUKCA_OK; k++)
            status = cost_at(&cost[k], s, at + (k - 1) * step, error);
        if (status != MUKCA_OK) break;
        const double bend = cost[0] - 2 * cost[1] + cost[2], slope = (cost[2] - cost[0]) / 2;
        const int spare = s->fit.n_measured - s->fit.parameters.n;
        if (!(bend > 0) || spare <= 0) break;
        if (round == 0) first = cost[1];
        const double left = fmax(cost[1] - slope * slope / (2 * bend), 1e-6 * first);
        *score = fmax(*score, sqrt(fmax(first - left, 0) / left * spare));
        if (!(*score > least_score && left < most_left * first)) break;
        at -= step * slope / bend;
        *lag = at;
        if (fabs(slope / bend) < 0.1) break; /* a hundredth of a millimetre */
    }
    mukca_dataset_free(&s->part);
    free(s);
    return status;
}

/* ---- fits ---- */

/* Characters of a parameter list: at most 16 joints of four parameters, 27 characters. */
enum { LIST = 1024 };

typedef struct {
    mukca_recalibration *out;
    const mukca_chain *arm;
    const mukca_dataset *rows; /* the log, or its rows without outliers */
    mukca_dataset part;        /* of these, for the noise and the restrictions */
    bool oriented;
    char list[LIST];
} session;

/* Set the free parameters of a restriction: zeros, or also link offsets, without those of the first
 * joint, which a free base replaces. */
static void restrict_to(mukca_fit_options *options, session *s, bool lengths)
{
    const mukca_split_arm *split = &s->out->split;
    mukca_text text = MUKCA_TEXT(s->list);
    const mukca_chain *chain = &split->chain;
    const int tip = mukca_chain_tip_element(chain);
    s->list[0] = '\0';
    for (int j = options->free_base; j < chain->n_joints; j++) { /* a free base turns joint 1 */
        const int k = split->of[chain->joint_element[j]];
        const char *comma = text.used ? "," : "";
        if (split->axis[j] >= 0)
            mukca_text_put(&text, "%sa%d.%s", comma, k, mukca_parameter_name[3 + split->axis[j]]);
        else
            mukca_text_put(&text, "%sl%d.x", comma, k); /* the list must not be empty */
        if (lengths) mukca_text_put(&text, ",l%d.x,l%d.y,l%d.z", k, k, k);
    }
    options->selection.free = s->list;
    if (tip < 0) return;
    const char *name = chain->element[tip].name;
    if (lengths) mukca_text_put(&text, ",%s.x,%s.y,%s.z", name, name, name);
    if (options->free_tool && s->oriented)
        mukca_text_put(&text, ",%s.roll,%s.pitch,%s.yaw", name, name, name);
}

/* Joint zeros and link offsets; without `lengths` joint zeros, from the orientations alone, as the
 * first step of the paper. */
static mukca_status fit_offsets(session *s, bool lengths, mukca_error *error)
{
    mukca_recalibration *out = s->out;
    mukca_fit *fit = &out->lengths;
    mukca_fit_options options = out->options;
    double *position = s->part.position;
    options.parameters_only = !lengths;
    if (!lengths) s->part.position = NULL;
    restrict_to(&options, s, lengths);
    const mukca_status status = mukca_fit_run(fit, &out->split.chain, &s->part, &options, error);
    s->part.position = position;
    MUKCA_TRY(status);
    if (lengths)
        MUKCA_TRY(mukca_frames_start(out->start, &fit->chain, &s->part, options.free_base,
                                     options.free_tool, error));
    mukca_geometry_set(&out->stage[lengths ? MUKCA_WITH_LENGTHS : MUKCA_WITH_ANGLES], &fit->chain,
                       fit->theta);
    return MUKCA_OK;
}

/* Weight of the regularisation for the most probable arm: noise^2 / (samples * prior size^2). */
static double weight_of_prior(const mukca_fit *fit, int rows)
{
    const double prior = mukca_prior_expected.length, noise = fit->identification.noise;
    const double weight = pow(noise / prior, 2) / rows;
    return weight > 1e-12 ? fmin(weight, MUKCA_LAMBDA) : 1e-12; /* without noise: rounding */
}

/* All parameters.  A part measures the noise, first with the usual regularisation, whose bias adds
 * to it, then with that of the noise so found. */
static mukca_status fit_all(session *s, mukca_error *error)
{
    mukca_recalibration *out = s->out;
    mukca_fit *fit = &out->all;
    mukca_fit_options *options = &out->options;
    double nominal[MUKCA_MAX_FREE], start[MUKCA_MAX_FREE];
    for (int round = 0; round < 3; round++) {
        mukca_fit_options warm = *options;
        if (round) warm.start = memcpy(start, fit->theta, sizeof start);
        MUKCA_TRY(mukca_fit_run(fit, s->arm, round < 2 ? &s->part : s->rows, &warm, error));
        if (round < 2) options->cost.lambda = weight_of_prior(fit, s->rows->n_rows);
    }
    MUKCA_TRY(mukca_frames_start(nominal, &fit->chain, s->rows, options->free_base,
                                 options->free_tool, error));
    mukca_geometry_set(&out->stage[MUKCA_BEFORE], &fit->chain, nominal);
    mukca_geometry_set(&out->stage[MUKCA_WITH_ALL], &fit->chain, fit->theta);
    return MUKCA_OK;
}

/* Fail with fewer equations than unknowns. */
static mukca_status check_number(session *s, mukca_error *error)
{
    mukca_fit_options options = s->out->options;
    mukca_parameters parameters;
    const int rows = s->rows->n_rows, per_pose = s->oriented ? 6 : 3;
    restrict_to(&options, s, true);
    MUKCA_TRY(
        mukca_parameters_select(&parameters, &s->out->split.chain, &options.selection, error));
    if (per_pose * rows >= parameters.n) return MUKCA_OK;
    return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                      "%d poses give %d equations for %d unknowns; record at least %d", rows,
                      per_pose * rows, parameters.n, parameters.n / per_pose + 1);
}

/* Fit the rows in use; the errors are those of the whole log. */
static mukca_status fit_stages(session *s, const mukca_dataset *log, mukca_error *error)
{
    mukca_recalibration *out = s->out;
    mukca_status status = mukca_part_take(&s->part, s->rows, MUKCA_MOST_SAMPLES, error);
    if (status == MUKCA_OK) status = fit_all(s, error);
    if (status == MUKCA_OK && s->oriented) status = fit_offsets(s, false, error);
    if (status == MUKCA_OK) status = fit_offsets(s, true, error);
    for (int k = 0; k < MUKCA_STAGES && status == MUKCA_OK; k++)
        if (k != MUKCA_WITH_ANGLES || s->oriented)
            status = mukca_pose_errors_find(&out->errors[k], &out->stage[k], log, error);
    mukca_dataset_free(&s->part);
    return status;
}

/* Ratio of root mean square to median, relative to that of normal vectors, 1.126. */
static double tail_ratio(const mukca_vector_errors *e)
{
    const mukca_moments *m = &e->length;
    if (m->n < 20 || !(e->median > 0)) return 1;
    return sqrt(m->mean * m->mean + m->m2 / (double)m->n) / (1.126 * e->median);
}

static mukca_pose_gain gain_between(const mukca_vector_errors *before,
                                    const mukca_vector_errors *after)
{
    const double nominal = before->median, left = after->median;
    return (mukca_pose_gain){nominal, left,
                             nominal > left ? sqrt(nominal * nominal - left * left) : 0};
}

static bool is_systematic(const mukca_pose_gain *g)
{
    return g->systematic > fmax(g->left, 1e-6); /* rounding of numbers in files, m and rad */
}

static void judge(mukca_recalibration *out)
{
    const mukca_pose_errors *before = &out->errors[MUKCA_BEFORE],
                            *after = &out->errors[MUKCA_WITH_ALL];
    out->position = gain_between(&before->position, &after->position);
    out->rotation = gain_between(&before->rotation, &after->rotation);
    out->calibrated = is_systematic(&out->position) || is_systematic(&out->rotation);
    out->tail = fmax(tail_ratio(&after->position), tail_ratio(&after->rotation));
}

/* Fit again without the outliers: the result if `robust`, else the basis of the verdict alone. */
static mukca_status fit_trimmed(const session *s, const mukca_dataset *log, bool robust,
                                mukca_error *error)
{
    mukca_recalibration *out = s->out, *again = malloc(sizeof *again);
    mukca_dataset kept = {0};
    session trimmed = *s;
    if (!again) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_status status = mukca_pose_log_trim(&kept, &out->stage[MUKCA_WITH_ALL],
                                              &out->errors[MUKCA_WITH_ALL], log, error);
    if (status != MUKCA_OK) goto out;
    *again = *out;
    trimmed.out = again;
    trimmed.rows = &kept;
    status = check_number(&trimmed, error);
    if (status == MUKCA_OK) status = fit_stages(&trimmed, log, error);
    if (status != MUKCA_OK) goto out;
    judge(again);
    again->tail = out->tail;
    if (robust) *out = *again;
    out->calibrated = again->calibrated;
    out->position = again->position;
    out->rotation = again->rotation;
    out->trimmed = true;
out:
    mukca_dataset_free(&kept);
    free(again);
    return status;
}

mukca_status mukca_recalibrate(mukca_recalibration *out, const mukca_chain *arm, mukca_dataset *log,
                               const mukca_fit_options *options, bool robust, mukca_error *error)
{
    const double tailed = 1.5; /* outliers; normal errors: 1 */
    session s = {.out = out, .arm = arm, .rows = log, .oriented = mukca_pose_oriented(log, 0)};
    memset(out, 0, sizeof *out);
    out->options = *options;
    out->has_angles = s.oriented;
    MUKCA_TRY(mukca_split_arm_set(&out->split, arm, error));
    MUKCA_TRY(check_number(&s, error));
    MUKCA_TRY(find_lag(&out->lag, &out->lag_score, arm, log, options, error));
    mukca_pose_log_shift(log, out->lag);
    free(log->velocity); /* memory for the fit */
    log->velocity = NULL;
    MUKCA_TRY(fit_stages(&s, log, error));
    judge(out);
    if (!robust && !(out->tail > tailed)) return MUKCA_OK;
    const mukca_status status = fit_trimmed(&s, log, robust, error);
    /* else too few samples are left: the verdict is that of all */
    return robust || status == MUKCA_MEMORY || status == MUKCA_INTERRUPTED ? status : MUKCA_OK;
}
