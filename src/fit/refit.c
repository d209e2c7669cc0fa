/* Approximation of the arm with its effects by a model that cannot represent them. */
#include "fit/refit.h"

#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "base/pool.h"
#include "math/dense.h"

enum {
    DRAWN = 800,     /* postures; half are fitted: 9 * 400 rows for at most 6 * 16 unknowns */
    RECORDED = 2000, /* maximum of postures from the data */
    MARKS = 9,       /* numbers of a pose: three points */
    ROUNDS = 4       /* Gauss-Newton iterations; effects are small, two are enough */
};

/* Distance from the tip to the two other points of a pose, m: weight of an angle by the
 * displacement at the end of a typical tool. */
static const double tool_length = 0.1;
/* Of forward differences, rad or m; their error is removed by the next iteration. */
static const double step = 1e-6;
/* Weight of no change, relative to that of all postures: parameters that none determines stay. */
static const double ridge = 1e-9;

typedef struct {
    const mukca_refit_task *task;
    int n_rows, n_unknowns;
    double *q;      /* [n_rows][n_joints], postures to fit first */
    double *target; /* [n_rows][MARKS] of the arm */
    double *rows; /* [fitted][MARKS][n_unknowns + 1] derivatives and residual; those of the ridge */
    double *R;    /* [n_unknowns][n_unknowns + 1] */
    int fitted;
} problem;

/* Three points of the tool as marks of a pose. */
static void find_marks(double marks[MARKS], const mukca_refit_task *task,
                       const mukca_geometry *geometry, const double *q, bool whole)
{
    const mukca_effect *effects = whole ? task->arm->effects : task->held;
    const int n = whole ? task->arm->n_effects : task->n_held;
    const mukca_joint_state state = {.q = q, .placement = -1};
    mukca_frame T;
    mukca_tip_pose(&T, effects, n, task->chain, geometry, &state);
    for (int i = 0; i < 3; i++) {
        marks[i] = T.p[i];
        marks[3 + i] = T.p[i] + tool_length * T.R[3 * i];
        marks[6 + i] = T.p[i] + tool_length * T.R[3 * i + 1];
    }
}

/* Marks of the model in posture `row`. */
static void model_marks(double marks[MARKS], const problem *p, const mukca_geometry *geometry,
                        const double *zeros, int row)
{
    double q[MUKCA_MAX_JOINTS];
    const int n = p->task->chain->n_joints;
    for (int j = 0; j < n; j++) q[j] = p->q[row * n + j] + zeros[j];
    find_marks(marks, p->task, geometry, q, false);
}

/* Pointer to the unknown of that index, in refit->theta or refit->zeros. */
static double *unknown(mukca_refit *refit, const mukca_refit_task *task, int index)
{
    if (task->zeros_only) return &refit->zeros[index];
    const int element = task->chain->joint_element[index / MUKCA_PARAMETERS];
    return &refit->theta[MUKCA_PARAMETERS * element + index % MUKCA_PARAMETERS];
}

/* Column of an unknown by forward differences; before all others the last one, the residual. */
static void fill_column(problem *p, mukca_refit *refit, int column)
{
    mukca_geometry geometry;
    const int n = p->n_unknowns;
    double none = 0, *x = column < n ? unknown(refit, p->task, column) : &none;
    const double kept = *x;
    *x += step;
    mukca_geometry_set(&geometry, p->task->chain, refit->theta);
    for (int row = 0; row < p->fitted; row++) {
        double marks[MARKS];
        model_marks(marks, p, &geometry, refit->zeros, row);
        for (int i = 0; i < MARKS; i++) {
            double *to = p->rows + (row * MARKS + i) * (n + 1);
            const double left = p->target[row * MARKS + i] - marks[i];
            to[column] = column < n ? (to[n] - left) / step : left;
        }
    }
    *x = kept;
}

static void improve(problem *p, mukca_refit *refit)
{
    const int n = p->n_unknowns, m = p->fitted * MARKS, size = n * (n + 1);
    double change[MUKCA_MAX_THETA], *held = p->rows + m * (n + 1);
    memset(p->R, 0, (size_t)size * sizeof *p->R);
    memset(held, 0, (size_t)size * sizeof *held);
    for (int i = 0; i < n; i++) held[i * (n + 2)] = sqrt(ridge * m);
    for (int column = n; column >= 0; column--) fill_column(p, refit, column);
    mukca_dense_qr_absorb(p->R, p->rows, m + n, n, 1);
    mukca_dense_qr_solve(change, p->R, n);
    for (int i = 0; i < n; i++) *unknown(refit, p->task, i) += change[i];
}

/* Mean and largest distance between the tips in the held-out postures. */
static double score(double *largest, const problem *p, const mukca_refit *refit)
{
    mukca_geometry geometry;
    double sum = 0;
    *largest = 0;
    mukca_geometry_set(&geometry, p->task->chain, refit->theta);
    for (int row = p->fitted; row < p->n_rows; row++) {
        double marks[MARKS];
        model_marks(marks, p, &geometry, refit->zeros, row);
        const double error = mukca_distance3(marks, p->target + row * MARKS);
        sum += error;
        *largest = fmax(*largest, error);
    }
    return sum / (p->n_rows - p->fitted);
}

/* Even postures are fitted, odd ones are held out. */
static void set_postures(problem *p)
{
    const mukca_refit_task *task = p->task;
    const int n = task->chain->n_joints, given = task->postures ? task->n_postures : 0;
    mukca_random random = mukca_random_seeded(1);
    mukca_geometry geometry;
    mukca_geometry_set(&geometry, task->chain, task->arm->theta);
    for (int i = 0; i < p->n_rows; i++) {
        const int row = i % 2 ? p->fitted + i / 2 : i / 2;
        const long from = given ? (long)i * given / p->n_rows : 0;
        if (given)
            memcpy(p->q + row * n, task->postures + from * n, sizeof *p->q * (size_t)n);
        else
            mukca_posture_draw(p->q + row * n, task->chain, &random);
        find_marks(p->target + row * MARKS, task, &geometry, p->q + row * n, true);
    }
}

/* With `zeros_only` the origins are nominal; while it is fitted, except fixed ones (the tool),
 * whose offsets no zero should take up. */
static void start(mukca_refit *refit, const mukca_refit_task *task)
{
    const size_t one = MUKCA_PARAMETERS * sizeof *refit->theta;
    *refit = (mukca_refit){.mean = 0};
    memcpy(refit->theta, task->arm->theta, sizeof refit->theta);
    for (int j = 0; j < task->chain->n_joints && task->zeros_only; j++) {
        double nominal[MUKCA_MAX_THETA];
        const int at = MUKCA_PARAMETERS * task->chain->joint_element[j];
        mukca_chain_theta(nominal, task->chain);
        memcpy(refit->theta + at, nominal + at, one);
    }
}

mukca_status mukca_refit_run(mukca_refit *refit, const mukca_refit_task *task, mukca_error *error)
{
    const int joints = task->chain->n_joints, given = task->postures ? task->n_postures : 0;
    const int rows = given > 1 ? given < RECORDED ? given : RECORDED : DRAWN;
    problem p = {.task = task, .n_rows = rows, .fitted = (rows + 1) / 2};
    p.n_unknowns = task->zeros_only ? joints : MUKCA_PARAMETERS * joints;
    const int n = p.n_unknowns, m = p.fitted * MARKS;
    mukca_pool pool = {0};
    p.q = MUKCA_TAKE(&pool, double, rows *joints);
    p.target = MUKCA_TAKE(&pool, double, rows *MARKS);
    p.rows = MUKCA_TAKE(&pool, double, (m + n) * (n + 1));
    p.R = MUKCA_TAKE(&pool, double, n *(n + 1));
    if (pool.failed) {
        mukca_pool_free(&pool);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    set_postures(&p);
    start(refit, task);
    refit->mean_before = score(&refit->largest, &p, refit);
    for (int round = 0; round < ROUNDS; round++) improve(&p, refit);
    if (task->zeros_only) mukca_chain_theta(refit->theta, task->chain);
    refit->mean = score(&refit->largest, &p, refit);
    mukca_pool_free(&pool);
    return MUKCA_OK;
}
