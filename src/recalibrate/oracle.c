/* Do the poses contain a calibration, and do a few constants explain it? */
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
    static const double dust = 1e-6; /* m, rad: rounding of numbers in files */
    const mukca_pose_errors *before = &r->errors[MUKCA_BEFORE],
                            *after = &r->errors[MUKCA_WITH_BOTH];
    *oracle =
        (mukca_oracle){.position_nominal = mukca_histogram_median(&before->position_histogram),
                       .position_left = mukca_histogram_median(&after->position_histogram),
                       .rotation_nominal = mukca_histogram_median(&before->rotation_histogram),
                       .rotation_left = mukca_histogram_median(&after->rotation_histogram)};
    oracle->position_systematic = without(oracle->position_nominal, oracle->position_left);
    oracle->rotation_systematic = without(oracle->rotation_nominal, oracle->rotation_left);
    oracle->calibrated = oracle->position_systematic > fmax(oracle->position_left, dust) ||
                         oracle->rotation_systematic > fmax(oracle->rotation_left, dust);
}

typedef struct {
    mukca_pose_system system; /* all constants together */
    /* candidates: combinations of the system's unknowns */
    int n;
    double column[MUKCA_MAX_UNKNOWNS + MUKCA_MAX_JOINTS][MUKCA_MAX_UNKNOWNS]; /* in Q's frame */
    mukca_unknown unknown[MUKCA_MAX_UNKNOWNS + MUKCA_MAX_JOINTS];
    double direction[MUKCA_MAX_UNKNOWNS + MUKCA_MAX_JOINTS][3]; /* of a shift, parent's frame */
    bool along_axis[MUKCA_MAX_UNKNOWNS + MUKCA_MAX_JOINTS];
} search;

/* Weight of a residual of that length; 2.5 sigma is 1.6 times the median. */
static double huber(double length, double median)
{
    return length > 1.6 * median && median > 0 ? 1.6 * median / length : 1;
}

/* Rows at the nominal model, weighted by how well the full fit explains each. */
static mukca_status gather(search *s, const mukca_recalibration *r,
                           const mukca_recalibrate_task *task, mukca_error *error)
{
    const double p_scale = mukca_histogram_median(&r->errors[MUKCA_WITH_BOTH].position_histogram);
    const double w_scale = mukca_histogram_median(&r->errors[MUKCA_WITH_BOTH].rotation_histogram);
    mukca_pose_model model = r->stage[MUKCA_BEFORE];
    mukca_pose_reader reader;
    mukca_pose_look look;
    model.lag = r->lag;
    model.base = r->stage[MUKCA_WITH_BOTH].base;
    model.tool = r->stage[MUKCA_WITH_BOTH].tool;
    mukca_status status =
        mukca_pose_reader_start(&reader, task->logs, task->n_logs, task->chain->n_joints, error);
    while (status == MUKCA_OK) {
        const mukca_pose_row *row;
        double weight;
        bool more;
        status = mukca_pose_reader_next(&reader, &row, &weight, &more, error);
        if (status != MUKCA_OK || !more) break;
        mukca_pose_look_at(&look, &r->stage[MUKCA_WITH_BOTH], row, task->options->order);
        const double p = sqrt(mukca_dot3(look.position, look.position));
        const double w = sqrt(mukca_dot3(look.rotation, look.rotation));
        mukca_pose_look_at(&look, &model, row, task->options->order);
        mukca_pose_system_add(&s->system, &look, sqrt(weight * huber(p, p_scale)),
                              sqrt(weight * huber(w, w_scale)));
    }
    return status;
}

/* Column of `direction` over the unknowns u, u + 1, ... (three for a shift, one else). */
static void add_candidate(search *s, int u, int width, const double *direction, bool along_axis)
{
    const int n = s->system.n, to = s->n++;
    for (int i = 0; i < n; i++) {
        s->column[to][i] = 0;
        for (int a = 0; a < width; a++)
            s->column[to][i] += direction[a] * s->system.R[i * (n + 1) + u + a];
    }
    s->unknown[to] = s->system.unknown[u];
    s->along_axis[to] = along_axis;
    for (int a = 0; a < 3; a++) {
        s->direction[to][a] = width == 3 ? direction[a] : 0;
        if (width == 3 && fabs(direction[a]) > 0.999) s->unknown[to].axis = a;
    }
}

/* Zeros, shifts along the parents' axes, and along the joint's own axis ("d", before the others).
 */
static void list_candidates(search *s, const mukca_chain *chain)
{
    static const double one[1] = {1};
    for (int u = 0; u < s->system.n; u++) {
        const mukca_unknown *unknown = &s->system.unknown[u];
        if (unknown->kind != MUKCA_UNKNOWN_SHIFT) {
            add_candidate(s, u, 1, one, false);
            continue;
        }
        if (unknown->axis != 0) continue; /* all three at the first */
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

static double inner(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

/* Share of what can be explained that the chosen candidates explain; skip: one that is left out. */
static double explained(const search *s, const int *chosen, int count, int skip)
{
    const int n = s->system.n;
    double left[MUKCA_MAX_UNKNOWNS], basis[MUKCA_MAX_CONSTANTS][MUKCA_MAX_UNKNOWNS];
    int k = 0;
    for (int i = 0; i < n; i++) left[i] = s->system.R[i * (n + 1) + n];
    const double total = inner(left, left, n);
    for (int c = 0; c < count; c++) {
        if (c == skip) continue;
        double *v = basis[k];
        memcpy(v, s->column[chosen[c]], (size_t)n * sizeof *v);
        const double whole = inner(v, v, n);
        for (int b = 0; b < k; b++) {
            const double f = inner(basis[b], v, n);
            for (int i = 0; i < n; i++) v[i] -= f * basis[b][i];
        }
        const double norm2 = inner(v, v, n);
        if (!(norm2 > 1e-6 * whole)) continue; /* tells nothing new */
        for (int i = 0; i < n; i++) v[i] /= sqrt(norm2);
        const double f = inner(v, left, n);
        for (int i = 0; i < n; i++) left[i] -= f * v[i];
        k++;
    }
    return total > 0 ? 1 - inner(left, left, n) / total : 0;
}

/* Greedy choice (orthogonal matching pursuit) until all but 2 % is explained, then those out again
 * that are not needed.  Returns the count, 0 where no few do. */
static int choose(int chosen[MUKCA_MAX_CONSTANTS], double *share, search *s)
{
    const double enough = 0.98; /* of the square; what is left is 14 % of the difference */
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

/* Least squares on the chosen ones; the others' part counts as noise. */
static void solve_chosen(mukca_constants *out, const int *chosen, const search *s)
{
    const int n = s->system.n, k = out->n;
    double A[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_CONSTANTS], b[MUKCA_MAX_UNKNOWNS],
        noise = s->system.rss[0];
    double C[MUKCA_MAX_CONSTANTS * MUKCA_MAX_CONSTANTS] = {0}, x[MUKCA_MAX_CONSTANTS] = {0};
    double inverse[MUKCA_MAX_CONSTANTS * MUKCA_MAX_CONSTANTS] = {0};
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < k; c++) A[i * k + c] = s->column[chosen[c]][i];
        b[i] = s->system.R[i * (n + 1) + n];
    }
    mukca_dense_syrk(C, k, A, n, k);
    mukca_dense_xty(x, (mukca_columns){A, k, k}, (mukca_columns){b, 1, 1}, n);
    if (mukca_dense_cholesky(C, k)) return;
    mukca_dense_forward(x, 1, C, k);
    mukca_dense_backward(x, 1, C, k);
    for (int c = 0; c < k; c++) inverse[c * k + c] = 1;
    mukca_dense_forward(inverse, k, C, k);
    mukca_dense_backward(inverse, k, C, k);
    for (int i = 0; i < n; i++) {
        const double rest = b[i] - inner(A + i * k, x, k);
        noise += rest * rest;
    }
    noise /= (double)s->system.equations;
    for (int c = 0; c < k; c++) {
        out->value[c] = x[c];
        out->sigma[c] = sqrt(noise * inverse[c * k + c]);
    }
}

static mukca_status measure(mukca_constants *out, const int *chosen, const search *s,
                            const mukca_recalibration *r, const mukca_recalibrate_task *task,
                            mukca_error *error)
{
    mukca_recalibration *alone = calloc(1, sizeof *alone);
    mukca_pose_errors *errors = calloc(MUKCA_STAGES, sizeof *errors);
    mukca_status status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    if (alone && errors) {
        mukca_pose_model model = r->stage[MUKCA_BEFORE];
        model.lag = r->lag;
        model.base = r->stage[MUKCA_WITH_BOTH].base;
        model.tool = r->stage[MUKCA_WITH_BOTH].tool;
        for (int c = 0; c < out->n; c++) {
            mukca_unknown u = s->unknown[chosen[c]];
            if (u.kind != MUKCA_UNKNOWN_SHIFT) mukca_pose_model_add(&model, &u, out->value[c]);
            for (u.axis = 0; u.kind == MUKCA_UNKNOWN_SHIFT && u.axis < 3; u.axis++)
                mukca_pose_model_add(&model, &u, out->value[c] * s->direction[chosen[c]][u.axis]);
        }
        for (int i = 0; i < MUKCA_STAGES; i++) alone->stage[i] = model;
        status = mukca_recalibrate_test(errors, alone, task, error);
        out->errors = errors[0];
    }
    free(alone);
    free(errors);
    return status;
}

mukca_status mukca_recalibrate_constants(mukca_constants *constants, const mukca_recalibration *r,
                                         const mukca_recalibrate_task *task, mukca_error *error)
{
    int chosen[MUKCA_MAX_CONSTANTS] = {0};
    search *s = calloc(1, sizeof *s);
    memset(constants, 0, sizeof *constants);
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const double p = mukca_histogram_median(&r->errors[MUKCA_WITH_BOTH].position_histogram);
    const double w = mukca_histogram_median(&r->errors[MUKCA_WITH_BOTH].rotation_histogram);
    s->system.positions = true;
    s->system.rotations = r->rotations > 0;
    s->system.metres_per_radian = p > 1e-9 && w > 1e-9 ? fmin(fmax(p / w, 0.01), 10) : 1;
    for (int u = 0; u < r->n; u++)
        if (r->unknown[u].kind == MUKCA_UNKNOWN_ZERO || r->unknown[u].kind == MUKCA_UNKNOWN_SHIFT ||
            r->unknown[u].kind == MUKCA_UNKNOWN_TOOL_SHIFT)
            s->system.unknown[s->system.n++] = r->unknown[u];
    mukca_status status = gather(s, r, task, error);
    if (status == MUKCA_OK) {
        mukca_pose_solution *x = calloc(1, sizeof *x); /* flushes the last rows */
        if (x) mukca_pose_system_solve(x, &s->system, s->system.n, 1);
        free(x);
        list_candidates(s, task->chain);
        constants->n = choose(chosen, &constants->share, s);
        solve_chosen(constants, chosen, s);
        for (int c = 0; c < constants->n; c++) {
            constants->unknown[c] = s->unknown[chosen[c]];
            constants->along_axis[c] = s->along_axis[chosen[c]];
        }
        if (constants->n > 0) status = measure(constants, chosen, s, r, task, error);
    }
    free(s);
    return status;
}
