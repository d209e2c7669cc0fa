/* Whether poses contain a calibration, and whether a few constants explain it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/dense.h"
#include "recalibrate/recalibrate.h"

static double without(double nominal, double left)
{
    return nominal > left ? sqrt(nominal * nominal - left * left) : 0;
}

void mukca_recalibrate_oracle(mukca_oracle *oracle, const mukca_recalibration *r)
{
    static const double rounding = 1e-6; /* rounding of numbers in files, m and rad */
    const mukca_pose_errors *before = &r->errors[MUKCA_BEFORE],
                            *after = &r->errors[MUKCA_WITH_BOTH];
    *oracle =
        (mukca_oracle){.position_nominal = mukca_histogram_median(&before->position_histogram),
                       .position_left = mukca_histogram_median(&after->position_histogram),
                       .rotation_nominal = mukca_histogram_median(&before->rotation_histogram),
                       .rotation_left = mukca_histogram_median(&after->rotation_histogram)};
    oracle->position_systematic = without(oracle->position_nominal, oracle->position_left);
    oracle->rotation_systematic = without(oracle->rotation_nominal, oracle->rotation_left);
    oracle->calibrated = oracle->position_systematic > fmax(oracle->position_left, rounding) ||
                         oracle->rotation_systematic > fmax(oracle->rotation_left, rounding);
}

/* A longer log is thinned to every second, third ... row: constants are then determined to 1/100 of
 * the noise. */
enum { MOST_ROWS = 20000 };

enum { MAX_CANDIDATES = MUKCA_MAX_UNKNOWNS + MUKCA_MAX_JOINTS };

/* One constant that may explain the difference: a combination of the system's unknowns. */
typedef struct {
    double column[MUKCA_MAX_UNKNOWNS]; /* column of R for this candidate */
    mukca_unknown unknown;
    double direction[3]; /* of a shift, in the parent's frame */
    bool along_axis;
} candidate;

typedef struct {
    mukca_pose_system system; /* all constants */
    mukca_pose_model model;   /* nominal, with lag and frames of the full fit */
    int n;
    candidate list[MAX_CANDIDATES];
} search;

/* Accumulate the rows at the nominal model, with Huber weights from the residuals of the full
 * fit. */
static mukca_status gather(long *rows, search *s, const mukca_recalibration *r,
                           const mukca_recalibrate_task *task, mukca_error *error)
{
    const mukca_pose_errors *errors = &r->errors[MUKCA_WITH_BOTH];
    const double p_scale = mukca_histogram_median(&errors->position_histogram);
    const double w_scale = mukca_histogram_median(&errors->rotation_histogram);
    mukca_pose_reader reader = mukca_recalibrate_reader(task);
    mukca_pose_look look;
    const long every = 1 + (r->rows - 1) / MOST_ROWS;
    for (long i = 0;; i++) {
        const mukca_status status = mukca_pose_reader_next(&reader, error);
        if (status != MUKCA_OK || !reader.now) return status;
        if (i % every != 0) continue;
        ++*rows;
        mukca_pose_look_at(&look, &r->stage[MUKCA_WITH_BOTH], reader.now, task->options->order);
        const double p = mukca_pose_huber(mukca_norm3(look.position), p_scale);
        const double w = mukca_pose_huber(mukca_norm3(look.rotation), w_scale);
        mukca_pose_look_at(&look, &s->model, reader.now, task->options->order);
        mukca_pose_system_add(&s->system, &look, sqrt(reader.weight * p), sqrt(reader.weight * w));
    }
}

/* Add the candidate `direction` over the unknowns u, u + 1, ... (three for a shift, else one). */
static void add_candidate(search *s, int u, int width, const double *direction, bool along_axis)
{
    const int n = s->system.n;
    candidate *c = &s->list[s->n++];
    *c = (candidate){.unknown = s->system.unknown[u], .along_axis = along_axis};
    for (int a = 0; a < width; a++) {
        for (int i = 0; i < n; i++) c->column[i] += direction[a] * s->system.R[i * (n + 1) + u + a];
        if (width == 3) c->direction[a] = direction[a];
        if (width == 3 && fabs(direction[a]) > 0.999) c->unknown.axis = a;
    }
}

/* List the candidates: zeros, shifts along the joint's own axis ("d") and along the parent's
 * axes. */
static void list_candidates(search *s, const mukca_chain *chain)
{
    static const double one[1] = {1};
    for (int u = 0; u < s->system.n; u++) {
        const mukca_unknown *unknown = &s->system.unknown[u];
        if (unknown->kind != MUKCA_UNKNOWN_SHIFT) {
            add_candidate(s, u, 1, one, false);
            continue;
        }
        if (unknown->axis != 0) continue; /* all three with the first */
        const mukca_element *e = &chain->element[unknown->element];
        double R[9], d[3] = {0, 0, 0};
        if (e->joint >= 0) {
            mukca_rotation_from_rpy(R, e->rpy);
            mukca_mat3_vec(d, R, e->axis);
            add_candidate(s, u, 3, d, true);
        }
        for (int a = 0; a < 3; a++) {
            const double axis[3] = {a == 0, a == 1, a == 2};
            if (fabs(d[a]) < 0.999) add_candidate(s, u, 3, axis, false);
        }
    }
}

/* Fraction of the explainable square that the chosen candidates explain, without number `skip` (-1:
 * with all). */
static double explained(const search *s, const int *chosen, int count, int skip)
{
    const int n = s->system.n;
    double A[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_CONSTANTS], b[MUKCA_MAX_UNKNOWNS];
    double singular[MUKCA_MAX_CONSTANTS], total = 0, gained = 0;
    const int width = count - (skip >= 0);
    int k = 0;
    for (int c = 0; c < count; c++) {
        if (c == skip) continue;
        const double *column = s->list[chosen[c]].column;
        double size = 0;
        for (int i = 0; i < n; i++) size = hypot(size, column[i]);
        for (int i = 0; i < n; i++) A[i * width + k] = size > 0 ? column[i] / size : 0;
        k++;
    }
    for (int i = 0; i < n; i++) {
        b[i] = s->system.R[i * (n + 1) + n];
        total += b[i] * b[i];
    }
    if (mukca_dense_svd(A, singular, NULL, n, width)) return 0;
    /* Ignore directions of which less than 1e-3 is independent of the other columns. */
    for (int c = 0; c < width && singular[c] > 1e-3 * singular[0]; c++) {
        double part = 0;
        for (int i = 0; i < n; i++) part += A[i * width + c] * b[i];
        gained += part * part;
    }
    return total > 0 ? gained / total : 0;
}

/* Choose greedily (orthogonal matching pursuit) until all but 2 % is explained, then remove the
 * superfluous ones.  Returns the count; 0: no few constants suffice. */
static int choose(int chosen[MUKCA_MAX_CONSTANTS], double *share, search *s)
{
    const double enough = 0.98; /* of the square: 14 % of the difference remain */
    int count = 0;
    for (*share = 0; *share < enough && count < MUKCA_MAX_CONSTANTS; count++) {
        double best = *share;
        int found = -1;
        for (int c = 0; c < s->n; c++) {
            chosen[count] = c;
            const double with = explained(s, chosen, count + 1, -1);
            if (with > best + 1e-6) best = with, found = c; /* the first of equals: "d" */
        }
        if (found < 0) return 0;
        chosen[count] = found;
        *share = best;
    }
    if (*share < enough) return 0;
    for (int c = count - 1; c >= 0; c--)
        if (explained(s, chosen, count, c) >= enough) {
            count--;
            for (int k = c; k < count; k++) chosen[k] = chosen[k + 1];
        }
    *share = explained(s, chosen, count, -1);
    return count;
}

/* Least squares for the chosen candidates; the remainder counts as noise. */
static void solve_chosen(mukca_constants *out, const int *chosen, const search *s)
{
    const int n = s->system.n, k = out->n;
    double A[MUKCA_MAX_UNKNOWNS * (MUKCA_MAX_CONSTANTS + 1)];
    double R[MUKCA_MAX_CONSTANTS * (MUKCA_MAX_CONSTANTS + 1)] = {0}, rest = 0;
    double L[MUKCA_MAX_CONSTANTS * MUKCA_MAX_CONSTANTS];
    double inverse[MUKCA_MAX_CONSTANTS * MUKCA_MAX_CONSTANTS] = {0};
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < k; c++) A[i * (k + 1) + c] = s->list[chosen[c]].column[i];
        A[i * (k + 1) + k] = s->system.R[i * (n + 1) + n];
    }
    mukca_dense_qr_absorb(R, &rest, A, n, k, 1);
    for (int c = 0; c < k; c++) {
        for (int d = 0; d <= c; d++) L[c * k + d] = R[d * (k + 1) + c];
        out->value[c] = R[c * (k + 1) + k];
        inverse[c * k + c] = 1;
    }
    mukca_dense_backward(out->value, 1, L, k);
    mukca_dense_backward(inverse, k, L, k);
    const double noise = (s->system.rss[0] + rest) / (double)s->system.equations;
    for (int c = 0; c < k; c++) {
        double sum = 0;
        for (int d = 0; d < k; d++) sum += inverse[c * k + d] * inverse[c * k + d];
        out->sigma[c] = sqrt(noise * sum);
    }
}

/* Compute the errors of the nominal model with the chosen constants alone. */
static mukca_status measure(mukca_constants *out, const int *chosen, search *s,
                            const mukca_recalibrate_task *task, mukca_error *error)
{
    for (int c = 0; c < out->n; c++) {
        const candidate *from = &s->list[chosen[c]];
        mukca_unknown u = from->unknown;
        if (u.kind != MUKCA_UNKNOWN_SHIFT) mukca_pose_model_add(&s->model, &u, out->value[c]);
        for (u.axis = 0; u.kind == MUKCA_UNKNOWN_SHIFT && u.axis < 3; u.axis++)
            mukca_pose_model_add(&s->model, &u, out->value[c] * from->direction[u.axis]);
    }
    return mukca_recalibrate_test(&out->errors, &s->model, 1, task, error);
}

mukca_status mukca_recalibrate_constants(mukca_constants *constants, const mukca_recalibration *r,
                                         const mukca_recalibrate_task *task, mukca_error *error)
{
    const mukca_pose_model *fitted = &r->stage[MUKCA_WITH_BOTH];
    int chosen[MUKCA_MAX_CONSTANTS] = {0};
    search *s = calloc(1, sizeof *s);
    memset(constants, 0, sizeof *constants);
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    s->model = r->stage[MUKCA_BEFORE];
    s->model.lag = r->lag;
    s->model.base = fitted->base;
    s->model.tool = fitted->tool;
    s->system.positions = true;
    s->system.rotations = r->rotations > 0;
    s->system.metres_per_radian = mukca_metres_per_radian(&r->errors[MUKCA_WITH_BOTH]);
    for (int zeros = 0; zeros < 2; zeros++) /* zeros last: see the blocks in system.h */
        for (int u = 0; u < r->n; u++) {
            const mukca_unknown_kind kind = r->unknown[u].kind;
            const bool length = kind == MUKCA_UNKNOWN_SHIFT || kind == MUKCA_UNKNOWN_TOOL_SHIFT;
            if (zeros ? kind == MUKCA_UNKNOWN_ZERO : length)
                s->system.unknown[s->system.n++] = r->unknown[u];
        }
    mukca_status status = gather(&constants->rows, s, r, task, error);
    if (status == MUKCA_OK) {
        mukca_pose_system_flush(&s->system);
        list_candidates(s, task->chain);
        constants->n = choose(chosen, &constants->share, s);
        solve_chosen(constants, chosen, s);
        for (int c = 0; c < constants->n; c++) {
            constants->unknown[c] = s->list[chosen[c]].unknown;
            constants->along_axis[c] = s->list[chosen[c]].along_axis;
        }
        if (constants->n > 0) status = measure(constants, chosen, s, task, error);
        /* Most of the difference may be due to tilts and frames, which are not candidates. */
        const double left = mukca_histogram_median(&constants->errors.position_histogram);
        if (left > 0.5 * mukca_histogram_median(&r->errors[MUKCA_BEFORE].position_histogram))
            constants->n = 0;
    }
    free(s);
    return status;
}
