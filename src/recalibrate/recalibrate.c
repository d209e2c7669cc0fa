/* Re-calibration from measured poses: passes over the log and Gauss-Newton steps. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An unknown with a larger standard error (m, rad) is not identifiable: arms are built to 20 mm. */
static const double loosest = 0.02;

/* Gauss-Newton converges in 3 or 4 passes from nominal.  The threshold of a lag, in standard
 * errors, allows for correlated rows, which a standard error treats as independent. */
enum { MOST_PASSES = 10, LAG_SCORE = 8 };

/* Largest last step, m and rad, of a converged fit: a hundredth of the accuracy of trackers. */
static const double converged_step = 1e-6;

/* A lag must reduce the median error by 5 %; outliers alone do not. */
static const double lag_gain = 0.95;

typedef struct {
    mukca_recalibration *out;
    const mukca_recalibrate_task *task;
    mukca_pose_model model;
    mukca_pose_system angles, offsets; /* joint solution: all unknowns in `offsets` */
    mukca_pose_step step;
    mukca_pose_errors errors;
    bool measured;   /* `errors` are those of the last pass */
    bool lag_denied; /* a lag did not reduce the median */
} session;

static void add_unknown(mukca_pose_system *s, mukca_unknown_kind kind, int element, int axis)
{
    const bool tool = kind == MUKCA_UNKNOWN_TOOL_SHIFT || kind == MUKCA_UNKNOWN_TOOL_TURN;
    s->unknown[s->n++] =
        (mukca_unknown){.kind = kind, .element = element, .axis = axis, .tool = tool};
}

static void add_three(mukca_pose_system *s, mukca_unknown_kind kind, int element)
{
    for (int axis = 0; axis < 3; axis++) add_unknown(s, kind, element, axis);
}

/* Assign angles to `a` and lengths to `p` (the same system in the joint solution).  A free base
 * replaces the first joint's origin and zero; the tip's offset is that of the last fixed
 * element. */
static void choose_unknowns(mukca_pose_system *a, mukca_pose_system *p, const mukca_chain *chain,
                            const mukca_recalibrate_options *o, bool oriented)
{
    const int last = chain->n_elements - 1;
    for (int k = 0; k <= last; k++) {
        const mukca_element *e = &chain->element[k];
        const bool first = o->free_base && e->joint == 0;
        if (e->joint < 0 && k < last) continue;
        if (!first) add_three(p, MUKCA_UNKNOWN_SHIFT, k);
        if (e->joint < 0 || e->type == MUKCA_PRISMATIC || first) continue;
        add_unknown(a, MUKCA_UNKNOWN_ZERO, k, 0);
        for (int axis = 0; o->tilts && axis < 2; axis++)
            add_unknown(a, MUKCA_UNKNOWN_TILT, k, axis);
    }
    if (chain->element[last].joint >= 0)
        add_three(p, MUKCA_UNKNOWN_TOOL_SHIFT, -1);
    else
        for (int i = p->n - 3; i < p->n; i++) p->unknown[i].tool = true;
    if (o->free_base) {
        add_three(p, MUKCA_UNKNOWN_BASE_SHIFT, -1);
        add_three(a, MUKCA_UNKNOWN_BASE_TURN, -1);
    }
    if (o->free_tool && oriented) add_three(a, MUKCA_UNKNOWN_TOOL_TURN, -1);
}

/* Huber's weight of a residual of that length; `median` is the median length. */
static double huber(double length, double median)
{
    const double bend = 1.6 * median; /* 2.5 sigma: the median length of 3 normals is 1.54 */
    return length > bend && bend > 0 ? bend / length : 1;
}

/* Ratio of position to rotation error (medians), 0.01 to 10 m; 0 if either vanishes. */
static double metres_per_radian(const mukca_pose_errors *errors)
{
    const double p = mukca_errors_median(&errors->position);
    const double w = mukca_errors_median(&errors->rotation);
    return p > 1e-9 && w > 1e-9 ? fmin(fmax(p / w, 0.01), 10) : 0;
}

/* Read the log once with the present model: errors, and the equations of a system (or NULL). */
static mukca_status pass(session *s, mukca_pose_system *system, mukca_error *error)
{
    const double position_scale = mukca_errors_median(&s->errors.position);
    const double rotation_scale = mukca_errors_median(&s->errors.rotation);
    const mukca_recalibrate_options *options = s->task->options;
    const bool robust = options->robust && s->measured;
    const mukca_pose_row *row;
    mukca_pose_look look;
    mukca_status status = mukca_pose_log_rewind(s->task->log, error);
    if (system) mukca_pose_system_clear(system);
    memset(&s->errors, 0, sizeof s->errors);
    for (long i = 0; status == MUKCA_OK; i++) {
        status = mukca_pose_log_next(&row, s->task->log, error);
        if (status != MUKCA_OK || !row) break;
        if (i % 1024 == 0 && options->stop && options->stop())
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        mukca_pose_look_at(&look, &s->model, row);
        mukca_pose_errors_add(&s->errors, &look);
        double p = 1, w = 1;
        if (robust) p = sqrt(huber(mukca_norm3(look.position), position_scale));
        if (robust) w = sqrt(huber(mukca_norm3(look.rotation), rotation_scale));
        if (system) mukca_pose_system_add(system, &look, p, w);
    }
    s->measured = true;
    s->out->passes++;
    return status;
}

static bool has_lag(const mukca_pose_system *s)
{
    return s->n > 0 && s->unknown[s->n - 1].kind == MUKCA_UNKNOWN_LAG;
}

/* Solve for all unknowns, the lag only `with_lag`, and update the model.  The estimates before this
 * system are `found`. */
static mukca_status step(double *size, session *s, mukca_pose_system *system, bool with_lag,
                         const int found[3], mukca_error *error)
{
    mukca_pose_estimates *out = &s->out->found;
    const int n = system->n - (has_lag(system) && !with_lag);
    *size = 0;
    out->n = found[0], out->rank = found[1], out->n_null = found[2];
    if (!mukca_pose_system_solve(&s->step, out, system, n, loosest))
        return mukca_fail(error, MUKCA_INPUT, "the rows contain numbers that are not finite");
    for (int u = 0; u < n; u++) {
        mukca_pose_model_add(&s->model, &system->unknown[u], s->step.x[u]);
        if (found[0] + u < out->n) out->value[found[0] + u] += s->step.x[u];
        *size = fmax(*size, fabs(s->step.x[u]));
    }
    return MUKCA_OK;
}

static bool lag_shows(session *s, const mukca_pose_system *system)
{
    double value;
    const double score = mukca_pose_system_last(&value, system);
    const double rms = score * sqrt(system->rss) / (double)(system->equations + 1);
    if (s->lag_denied || !(score > LAG_SCORE) || !(rms > 1e-7)) return false;
    s->out->lag_score = fmax(s->out->lag_score, score);
    return true;
}

/* Median error that a lag must reduce; outliers have no effect on it. */
static double lag_median(const session *s, const mukca_pose_system *system)
{
    return mukca_errors_median(system->rotations ? &s->errors.rotation : &s->errors.position);
}

/* Repeat pass and step for one system, including its lag, at least `least` times and, with
 * `repeat`, until it converges.  Errors before are those of `stage`. */
static mukca_status converge(session *s, mukca_pose_system *system, int stage, int least,
                             bool repeat, mukca_error *error)
{
    const mukca_pose_estimates *out = &s->out->found;
    const int first = least - 1; /* first pass that may be the last */
    const int found[3] = {out->n, out->rank, out->n_null};
    mukca_pose_model without = s->model;
    double size, median = 0;
    for (int i = 0;; i++) {
        mukca_status status = pass(s, system, error);
        if (status != MUKCA_OK) return status;
        if (i == 0) s->out->errors[stage] = s->errors;
        if (s->model.lag != 0 && without.lag == 0 && lag_median(s, system) > lag_gain * median) {
            s->model = without; /* repeat without the lag */
            for (int u = 0; found[0] + u < out->n; u++)
                s->out->found.value[found[0] + u] -= s->step.x[u];
            s->lag_denied = true;
            continue;
        }
        const bool lag =
            has_lag(system) && i > 0 && i < MOST_PASSES + first && lag_shows(s, system);
        median = lag_median(s, system);
        without = s->model;
        status = step(&size, s, system, lag, found, error);
        if (status != MUKCA_OK) return status;
        const double scale = metres_per_radian(&s->errors);
        if (system->positions && scale > 0) system->metres_per_radian = scale;
        const bool enough = size < 1e-10 || i >= MOST_PASSES + first || (!lag && !repeat);
        if (i < first || !enough) continue;
        s->out->converged &= !repeat || size < converged_step;
        return MUKCA_OK;
    }
}

/* Assign the unknowns to the systems; the lag is the last one of its system. */
static void set_systems(session *s, bool together, bool oriented)
{
    mukca_pose_system *angles = &s->angles, *offsets = &s->offsets;
    choose_unknowns(together ? offsets : angles, offsets, s->task->chain, s->task->options,
                    oriented);
    angles->rotations = offsets->positions = true;
    offsets->rotations = together && oriented;
    add_unknown(together ? offsets : angles, MUKCA_UNKNOWN_LAG, -1, 0);
}

/* Ratio of root mean square to median, relative to that of normal vectors, 1.126. */
static double tail(const mukca_vector_errors *e)
{
    const mukca_moments *m = &e->length;
    const double median = mukca_errors_median(e);
    if (m->n < 20 || !(median > 0)) return 1;
    return sqrt(m->mean * m->mean + m->m2 / (double)m->n) / (1.126 * median);
}

static mukca_pose_gain gain(const mukca_vector_errors *before, const mukca_vector_errors *after)
{
    const double nominal = mukca_errors_median(before), left = mukca_errors_median(after);
    return (mukca_pose_gain){nominal, left,
                             nominal > left ? sqrt(nominal * nominal - left * left) : 0};
}

static bool shows(const mukca_pose_gain *g)
{
    return g->systematic > fmax(g->left, 1e-6); /* rounding of numbers in files, m and rad */
}

mukca_status mukca_recalibrate(mukca_recalibration *result, const mukca_recalibrate_task *task,
                               mukca_error *error)
{
    const mukca_recalibrate_options *o = task->options;
    const bool oriented = task->log->oriented, together = o->joint || !oriented,
               repeat = o->iterate || o->robust || !oriented;
    session *s = calloc(1, sizeof *s);
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    memset(result, 0, sizeof *result);
    result->converged = true;
    s->out = result;
    s->task = task;
    mukca_pose_model_set(&s->model, task->chain, &o->base, &o->tool);
    for (int i = 0; i < MUKCA_STAGES; i++) result->stage[i] = s->model;
    set_systems(s, together, oriented);
    mukca_status status =
        converge(s, together ? &s->offsets : &s->angles, MUKCA_BEFORE, 2 - together, repeat, error);
    if (!together) { /* lengths at these angles */
        result->has_angles = true;
        result->stage[MUKCA_WITH_ANGLES] = s->model;
        if (status == MUKCA_OK)
            status = converge(s, &s->offsets, MUKCA_WITH_ANGLES, 1, o->robust, error);
    }
    const int per_pose = together && oriented ? 6 : 3;
    const int unknowns = (s->offsets.n > s->angles.n ? s->offsets.n : s->angles.n) - !together;
    const long equations = task->log->n * per_pose;
    if (status == MUKCA_OK && equations < unknowns)
        status = mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                            "%ld poses give %ld equations for %d unknowns; record at least %d",
                            task->log->n, equations, unknowns,
                            (unknowns + !together + 2) / per_pose + 1);
    result->stage[MUKCA_WITH_BOTH] = s->model;
    if (!result->has_angles) result->stage[MUKCA_WITH_ANGLES] = s->model;
    result->lag = s->model.lag;
    if (status == MUKCA_OK) status = pass(s, NULL, error);
    result->errors[MUKCA_WITH_BOTH] = s->errors;
    result->position = gain(&result->errors[MUKCA_BEFORE].position, &s->errors.position);
    result->rotation = gain(&result->errors[MUKCA_BEFORE].rotation, &s->errors.rotation);
    result->calibrated = shows(&result->position) || shows(&result->rotation);
    result->tail = fmax(tail(&s->errors.position), tail(&s->errors.rotation));
    free(s);
    return status;
}

mukca_status mukca_recalibrate_test(mukca_pose_errors *errors, const mukca_pose_model *models,
                                    int n, const mukca_recalibrate_task *task, mukca_error *error)
{
    const mukca_pose_row *row;
    mukca_pose_look look;
    mukca_status status = mukca_pose_log_rewind(task->log, error);
    memset(errors, 0, (size_t)n * sizeof *errors);
    while (status == MUKCA_OK) {
        status = mukca_pose_log_next(&row, task->log, error);
        if (!row) break;
        for (int i = 0; i < n; i++) {
            mukca_pose_look_at(&look, &models[i], row);
            mukca_pose_errors_add(&errors[i], &look);
        }
    }
    return status;
}
