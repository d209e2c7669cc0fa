/* Damped least squares with an active set of joint limits.
 *
 * Each step solves (J J' + mu I) y = e for the task error e (at most 6 numbers) and moves by dq =
 * J' y.  A joint that would exceed its range is set to the limit and removed from J for that step.
 * mu decreases while the error decreases and increases when a step fails (Levenberg-Marquardt). */
#include "arm/inverse.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

enum { TASK = 6, DEFAULT_STEPS = 100 };

/* Lever that converts rotation errors to lengths (m). */
static const double lever = 0.3;

typedef struct {
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    const mukca_frame *target;
    const mukca_inverse_options *options;
    int rows; /* of the task: 3 or 6 */
} problem;

typedef struct {
    double q[MUKCA_MAX_JOINTS];
    double error[TASK], size; /* of the task, and its norm */
    double J[TASK * MUKCA_MAX_JOINTS];
    double position_error, rotation_error;
} point;

/* Evaluate a point at its q. */
static void look(point *at, const problem *p)
{
    const int n = p->chain->n_joints;
    mukca_displacement displacement = {0};
    mukca_frame reached;
    if (p->options->displace) p->options->displace(&displacement, at->q, p->options->context);
    mukca_fk_jacobian(at->J, &reached, p->geometry, at->q,
                      p->options->displace ? &displacement : NULL);
    for (int i = 0; i < 3; i++) at->error[i] = p->target->p[i] - reached.p[i];
    at->position_error = mukca_norm3(at->error);
    at->rotation_error = 0;
    if (p->rows == TASK) {
        double w[3];
        mukca_rotation_difference(w, p->target->R, reached.R);
        at->rotation_error = mukca_norm3(w);
        for (int i = 0; i < 3; i++) at->error[3 + i] = lever * w[i];
        for (int i = 3 * n; i < TASK * n; i++) at->J[i] *= lever;
    }
    at->size = hypot(at->position_error, lever * at->rotation_error);
}

/* Compute one step dq[n] from a point, without the joints with fixed[j]. */
static void step(double *dq, const point *at, const bool *fixed, double damping, const problem *p)
{
    const int n = p->chain->n_joints, m = p->rows;
    const double *J = at->J;
    double A[TASK * TASK], y[TASK], trace = 0, largest = 0;
    for (int a = 0; a < m; a++) {
        y[a] = at->error[a];
        for (int b = 0; b < m; b++) A[a * m + b] = 0;
        for (int j = 0; j < n; j++)
            for (int b = 0; b <= a && !fixed[j]; b++) A[a * m + b] += J[a * n + j] * J[b * n + j];
        trace += A[a * m + a];
    }
    for (int a = 0; a < m; a++) A[a * m + a] += damping * (trace / m + 1e-12);
    if (!mukca_dense_solve(y, 1, A, m)) memset(y, 0, sizeof y);
    for (int j = 0; j < n; j++) {
        dq[j] = 0;
        for (int a = 0; a < m; a++) dq[j] += fixed[j] ? 0 : J[a * n + j] * y[a];
        largest = fmax(largest, fabs(dq[j]));
    }
    /* Limit the step of a joint to half a radian, the range of the linearisation. */
    for (int j = 0; j < n && largest > 0.5; j++) dq[j] *= 0.5 / largest;
}

static bool within(double q, int joint, const problem *p)
{
    const mukca_element *e = &p->chain->element[p->chain->joint_element[joint]];
    return q > e->lower && q < e->upper;
}

/* next = q + dq; joints that would exceed their range are set to the limit and marked in fixed.
 * Returns whether there was one. */
static bool advance(double *next, bool *fixed, const double *q, const double *dq, const problem *p)
{
    bool stopped = false;
    for (int j = 0; j < p->chain->n_joints; j++) {
        const mukca_element *e = &p->chain->element[p->chain->joint_element[j]];
        if (fixed[j]) continue;
        next[j] = q[j] + dq[j];
        if (within(next[j], j, p)) continue;
        next[j] = next[j] <= e->lower ? e->lower : e->upper;
        stopped = fixed[j] = true;
    }
    return stopped;
}

mukca_inverse_result mukca_inverse_solve(double *q, const mukca_chain *chain,
                                         const mukca_geometry *geometry, const mukca_frame *target,
                                         bool with_rotation, const mukca_inverse_options *options)
{
    const problem p = {chain, geometry, target, options, with_rotation ? TASK : 3};
    const int n = chain->n_joints;
    const int steps = p.options->max_steps > 0 ? p.options->max_steps : DEFAULT_STEPS;
    const double tolerance = p.options->tolerance > 0 ? p.options->tolerance : 1e-9;
    mukca_inverse_result result = {0};
    double damping = 1e-3, dq[MUKCA_MAX_JOINTS];
    point here, next;
    memcpy(here.q, q, (size_t)n * sizeof *q);
    look(&here, &p);
    for (; result.steps < steps; result.steps++) {
        if (here.position_error <= tolerance && here.rotation_error <= tolerance) break;
        bool fixed[MUKCA_MAX_JOINTS] = {false};
        do {
            step(dq, &here, fixed, damping, &p);
        } while (advance(next.q, fixed, here.q, dq, &p));
        look(&next, &p);
        if (next.size < here.size) {
            here = next;
            damping = fmax(0.1 * damping, 1e-12);
        } else {
            damping *= 10;
            if (damping > 1e6) break;
        }
    }
    memcpy(q, here.q, (size_t)n * sizeof *q);
    result.position_error = here.position_error;
    result.rotation_error = here.rotation_error;
    result.reached = here.position_error <= tolerance && here.rotation_error <= tolerance;
    for (int j = 0; j < n; j++) result.limited |= !within(q[j], j, &p);
    return result;
}
