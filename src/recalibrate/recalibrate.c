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

/* A step of the fit: some of the unknowns from some of the equations. */
typedef struct {
    bool angles, lengths;      /* the unknowns, with the lag of the angles */
    bool rotations, positions; /* the equations */
    int stage;                 /* of the errors before it */
    int least;                 /* number of passes, at least */
    bool repeat;               /* until convergence */
} restriction;

typedef struct {
    mukca_recalibration *out;
    const mukca_recalibrate_task *task;
    mukca_pose_model model;
    mukca_pose_system system; /* of the present step */
    mukca_pose_errors errors;
    bool measured;   /* `errors` are those of the last pass */
    bool lag_denied; /* a lag did not reduce the median */
} session;

static void add_unknowns(mukca_pose_system *s, mukca_unknown_kind kind, int element, int axes,
                         bool tool)
{
    for (int axis = 0; axis < axes; axis++)
        s->unknown[s->n++] =
            (mukca_unknown){.kind = kind, .element = element, .axis = axis, .tool = tool};
}

/* The unknowns of a step; the lag is the last one.  A free base replaces the first joint's origin
 * and zero; the tip's offset is that of the last fixed element. */
static void choose_unknowns(mukca_pose_system *s, const mukca_recalibrate_task *task,
                            const restriction *step)
{
    const mukca_chain *chain = task->chain;
    const mukca_recalibrate_options *o = task->options;
    const int last = chain->n_elements - 1, lengths = step->lengths ? 3 : 0,
              angles = step->angles ? 3 : 0;
    *s = (mukca_pose_system){.positions = step->positions, .rotations = step->rotations};
    for (int k = 0; k <= last; k++) {
        const mukca_element *e = &chain->element[k];
        const bool fixed = e->joint < 0, turns = angles && mukca_joint_turns((int)e->type);
        if ((fixed && k < last) || (o->free_base && e->joint == 0)) continue;
        add_unknowns(s, MUKCA_UNKNOWN_SHIFT, k, lengths, fixed);
        add_unknowns(s, MUKCA_UNKNOWN_ZERO, k, turns, false);
        add_unknowns(s, MUKCA_UNKNOWN_TILT, k, turns && o->tilts ? 2 : 0, false);
    }
    if (chain->element[last].joint >= 0)
        add_unknowns(s, MUKCA_UNKNOWN_SHIFT, MUKCA_UNKNOWN_TOOL, lengths, true);
    if (o->free_base) add_unknowns(s, MUKCA_UNKNOWN_SHIFT, MUKCA_UNKNOWN_BASE, lengths, false);
    if (o->free_base) add_unknowns(s, MUKCA_UNKNOWN_TURN, MUKCA_UNKNOWN_BASE, angles, false);
    if (o->free_tool && step->rotations)
        add_unknowns(s, MUKCA_UNKNOWN_TURN, MUKCA_UNKNOWN_TOOL, angles, true);
    add_unknowns(s, MUKCA_UNKNOWN_LAG, MUKCA_UNKNOWN_TOOL, step->angles, false);
}

/* Huber's weight of a residual of that length; `median` is the median length. */
static double huber_weight(double length, double median)
{
    const double bend = 1.6 * median; /* 2.5 sigma: the median length of 3 normals is 1.54 */
    return length > bend && bend > 0 ? bend / length : 1;
}

/* Ratio of position to rotation error (medians), 0.01 to 10 m; 0 if either vanishes. */
static double metres_per_radian(const mukca_pose_errors *errors)
{
    const double p = errors->position.median, w = errors->rotation.median;
    return p > 1e-9 && w > 1e-9 ? fmin(fmax(p / w, 0.01), 10) : 0;
}

static bool is_stopped(const mukca_recalibrate_task *task, int row)
{
    return row % 1024 == 0 && task->options->stop && task->options->stop();
}

/* Pass over the log with the present model: errors, and the equations of the step. */
static mukca_status read_equations(session *s, mukca_error *error)
{
    const double position_scale = s->errors.position.median;
    const double rotation_scale = s->errors.rotation.median;
    const bool robust = s->task->options->robust && s->measured;
    mukca_pose_look look;
    mukca_pose_system_clear(&s->system);
    memset(&s->errors, 0, sizeof s->errors);
    for (int i = 0; i < s->task->log->n_rows; i++) {
        if (is_stopped(s->task, i)) return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        mukca_pose_look_at(&look, &s->model, s->task->log, i);
        mukca_pose_errors_add(&s->errors, &look);
        double p = 1, w = 1;
        if (robust) p = sqrt(huber_weight(mukca_norm3(look.position), position_scale));
        if (robust) w = sqrt(huber_weight(mukca_norm3(look.rotation), rotation_scale));
        mukca_pose_system_add(&s->system, &look, p, w);
    }
    mukca_pose_errors_finish(&s->errors);
    s->measured = true;
    s->out->passes++;
    return MUKCA_OK;
}

/* Move by the solution of the first n unknowns, or back; their estimates start at `first`. */
static void apply_solution(session *s, int first, int n, int sign)
{
    mukca_pose_estimates *out = &s->out->found;
    for (int u = 0; u < n; u++) {
        const double by = sign * s->system.x[u];
        mukca_pose_model_add(&s->model, &s->system.unknown[u], by);
        if (first + u < out->n) out->value[first + u] += by;
    }
}

static bool lag_shows(session *s)
{
    mukca_pose_system *system = &s->system;
    const double score = mukca_pose_system_last(system);
    const double rms = score * sqrt(system->rss) / (double)(system->equations + 1);
    if (s->lag_denied || !(score > LAG_SCORE) || !(rms > 1e-7)) return false;
    s->out->lag_score = fmax(s->out->lag_score, score);
    return true;
}

/* Median error that a lag must reduce; outliers have no effect on it. */
static double lag_median(const session *s)
{
    return (s->system.rotations ? &s->errors.rotation : &s->errors.position)->median;
}

/* Fail with fewer equations than unknowns. */
static mukca_status check_number(const session *s, int unknowns, mukca_error *error)
{
    const mukca_pose_system *system = &s->system;
    const int per_pose = 3 * (system->positions + system->rotations);
    if (system->equations >= unknowns) return MUKCA_OK;
    return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                      "%d poses give %ld equations for %d unknowns; record at least %d",
                      s->task->log->n_rows, system->equations, unknowns, unknowns / per_pose + 1);
}

/* Repeat pass and solution for these unknowns, including the lag. */
static mukca_status converge(session *s, const restriction *step, mukca_error *error)
{
    mukca_pose_estimates *out = &s->out->found;
    mukca_pose_system *system = &s->system;
    const int first = step->least - 1; /* first pass that may be the last */
    const int known = out->n, rank = out->rank, n_null = out->n_null;
    double median = 0;
    bool lag = false;
    choose_unknowns(system, s->task, step);
    for (int i = 0;; i++) {
        const int unknowns = system->n - step->angles; /* without the lag */
        const bool new_lag = lag && !(fabs(s->model.lag - system->x[unknowns]) > 0);
        mukca_status status = read_equations(s, error);
        if (status == MUKCA_OK) status = check_number(s, unknowns, error);
        if (status != MUKCA_OK) return status;
        if (i == 0) s->out->errors[step->stage] = s->errors;
        if (new_lag && lag_median(s) > lag_gain * median) {
            apply_solution(s, known, unknowns + 1, -1); /* repeat without the lag */
            s->lag_denied = true;
            lag = false;
            continue;
        }
        lag = step->angles && i > 0 && i < MOST_PASSES + first && lag_shows(s);
        median = lag_median(s);
        out->n = known, out->rank = rank, out->n_null = n_null;
        if (!mukca_pose_system_solve(out, system, unknowns + lag, loosest))
            return mukca_fail(error, MUKCA_INPUT, "the rows contain numbers that are not finite");
        apply_solution(s, known, unknowns + lag, 1);
        double size = 0;
        for (int u = 0; u < unknowns + lag; u++) size = fmax(size, fabs(system->x[u]));
        const double scale = metres_per_radian(&s->errors);
        if (system->positions && scale > 0) system->metres_per_radian = scale;
        const bool enough = size < 1e-10 || i >= MOST_PASSES + first || (!lag && !step->repeat);
        if (i < first || !enough) continue;
        s->out->converged &= !step->repeat || size < converged_step;
        return MUKCA_OK;
    }
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

mukca_status mukca_recalibrate(mukca_recalibration *result, const mukca_recalibrate_task *task,
                               mukca_error *error)
{
    const mukca_recalibrate_options *o = task->options;
    const bool oriented = mukca_pose_oriented(task->log, 0), together = o->joint || !oriented;
    /* angles from orientations, then lengths from positions at these angles; or all together */
    const restriction steps[] = {{.angles = true,
                                  .lengths = together,
                                  .rotations = oriented,
                                  .positions = together,
                                  .stage = MUKCA_BEFORE,
                                  .least = together ? 1 : 2,
                                  .repeat = o->iterate || o->robust || !oriented},
                                 {.lengths = true,
                                  .positions = true,
                                  .stage = MUKCA_WITH_ANGLES,
                                  .least = 1,
                                  .repeat = o->robust}};
    mukca_status status = MUKCA_OK;
    session *s = calloc(1, sizeof *s);
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    memset(result, 0, sizeof *result);
    result->converged = true;
    result->has_angles = !together;
    s->out = result;
    s->task = task;
    mukca_pose_model_set(&s->model, task->chain, &o->base, &o->tool);
    result->stage[MUKCA_BEFORE] = s->model;
    for (int k = 0; k < 2 - together && status == MUKCA_OK; k++) {
        status = converge(s, &steps[k], error);
        if (k == 0) result->stage[MUKCA_WITH_ANGLES] = s->model;
    }
    result->stage[MUKCA_WITH_BOTH] = s->model;
    result->lag = s->model.lag;
    result->passes++;
    mukca_pose_errors *before = &result->errors[MUKCA_BEFORE],
                      *after = &result->errors[MUKCA_WITH_BOTH];
    if (status == MUKCA_OK) status = mukca_recalibrate_test(after, &s->model, 1, task, error);
    result->position = gain_between(&before->position, &after->position);
    result->rotation = gain_between(&before->rotation, &after->rotation);
    result->calibrated = is_systematic(&result->position) || is_systematic(&result->rotation);
    result->tail = fmax(tail_ratio(&after->position), tail_ratio(&after->rotation));
    free(s);
    return status;
}

mukca_status mukca_recalibrate_test(mukca_pose_errors *errors, const mukca_pose_model *models,
                                    int n, const mukca_recalibrate_task *task, mukca_error *error)
{
    mukca_pose_look look;
    memset(errors, 0, (size_t)n * sizeof *errors);
    for (int i = 0; i < task->log->n_rows; i++) {
        if (is_stopped(task, i)) return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        for (int k = 0; k < n; k++) {
            mukca_pose_look_at(&look, &models[k], task->log, i);
            mukca_pose_errors_add(&errors[k], &look);
        }
    }
    for (int k = 0; k < n; k++) mukca_pose_errors_finish(&errors[k]);
    return MUKCA_OK;
}
