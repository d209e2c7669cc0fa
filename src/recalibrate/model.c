/* Kinematic model of re-calibration: residuals and derivatives of one pose. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const mukca_frame identity = {.R = MUKCA_IDENTITY};

static const struct {
    const char *name, *axes;
    bool angle;
} kinds[] = {
#define UNKNOWN_ROW(kind, name, axes, angle) {name, axes, angle},
    MUKCA_UNKNOWN_LIST(UNKNOWN_ROW)
#undef UNKNOWN_ROW
};

bool mukca_unknown_is_angle(mukca_unknown_kind kind)
{
    return kinds[kind].angle;
}

void mukca_unknown_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_unknown *unknown,
                        const mukca_chain *chain)
{
    const char *joint = unknown->element >= 0 ? chain->element[unknown->element].name : "";
    const char *name = kinds[unknown->kind].name, *axes = kinds[unknown->kind].axes;
    const char axis[2] = {*axes ? axes[unknown->axis] : '\0'};
    snprintf(text, MUKCA_UNKNOWN_TEXT, "%s%s%s%s%s", joint, *joint ? " " : "", name,
             *name && *axis ? " " : "", axis);
}

/* Update `placed`. */
static void place(mukca_pose_model *model)
{
    model->placed = model->geometry;
    mukca_frame_multiply(&model->placed.origin[0], &model->base, &model->geometry.origin[0]);
}

static mukca_frame or_identity(const mukca_frame *T)
{
    return mukca_dot3(T->R, T->R) > 0 ? *T : identity;
}

void mukca_pose_model_set(mukca_pose_model *model, const mukca_chain *chain,
                          const mukca_frame *base, const mukca_frame *tool)
{
    *model = (mukca_pose_model){.base = or_identity(base), .tool = or_identity(tool)};
    mukca_geometry_set(&model->geometry, chain, NULL);
    if (chain->element[chain->n_elements - 1].joint < 0) { /* has the tool's position */
        mukca_frame *last = &model->geometry.origin[chain->n_elements - 1], shifted;
        mukca_frame_multiply(&shifted, last, &model->tool);
        memcpy(last->p, shifted.p, sizeof last->p);
        memset(model->tool.p, 0, sizeof model->tool.p);
    }
    place(model);
}

/* Axis of an unknown in its joint's frame, or in the frame of base or tool; `own` is storage for
 * it. */
static inline const double *local_axis(double own[3], const mukca_geometry *g,
                                       const mukca_unknown *u)
{
    double e[2][3];
    switch (u->kind) {
        case MUKCA_UNKNOWN_ZERO:
            return g->axis[u->element];
        case MUKCA_UNKNOWN_SHIFT:
            return g->origin[u->element].R + 3 * u->axis; /* from parent to joint */
        case MUKCA_UNKNOWN_TILT:
            mukca_rotation_transverse(e[0], e[1], g->axis[u->element]);
            memcpy(own, e[u->axis], sizeof e[0]);
            return own;
        default:
            return identity.R + 3 * u->axis;
    }
}

static mukca_frame turn(const double axis[3], double angle)
{
    const double w[3] = {angle * axis[0], angle * axis[1], angle * axis[2]};
    mukca_frame T = identity;
    mukca_rotation_exp(T.R, w);
    return T;
}

void mukca_pose_model_add(mukca_pose_model *model, const mukca_unknown *unknown, double by)
{
    const bool base =
        unknown->kind == MUKCA_UNKNOWN_BASE_SHIFT || unknown->kind == MUKCA_UNKNOWN_BASE_TURN;
    mukca_frame *T = base ? &model->base : &model->tool;
    if (unknown->element >= 0) T = &model->geometry.origin[unknown->element];
    if (unknown->kind == MUKCA_UNKNOWN_LAG) {
        model->lag += by;
    } else if (unknown->kind == MUKCA_UNKNOWN_ZERO) {
        model->zero[model->geometry.joint[unknown->element]] += by;
    } else if (!kinds[unknown->kind].angle) {
        T->p[unknown->axis] += by;
    } else {
        double own[3];
        const mukca_frame step = turn(local_axis(own, &model->geometry, unknown), by);
        mukca_frame_multiply(T, base ? &step : T, base ? T : &step);
    }
    place(model);
}

void mukca_pose_model_theta(double *theta, const mukca_pose_model *model, const mukca_chain *chain)
{
    mukca_geometry g = model->geometry;
    for (int k = 0; k < g.n_elements; k++) {
        if (!mukca_joint_turns(g.type[k])) continue;
        const mukca_frame zero = turn(g.axis[k], model->zero[g.joint[k]]);
        mukca_frame_multiply(&g.origin[k], &g.origin[k], &zero);
    }
    mukca_geometry_theta(theta, chain, &g);
}

void mukca_pose_look_at(mukca_pose_look *look, const mukca_pose_model *model,
                        const mukca_pose_row *row)
{
    const mukca_geometry *g = &model->geometry;
    double q[MUKCA_MAX_JOINTS], measured[9], off[9];
    look->model = model;
    look->row = row;
    for (int j = 0; j < g->n_joints; j++)
        q[j] = row->q[j] + model->zero[j] + model->lag * row->velocity[j];
    mukca_fk_frames(look->before, &look->flange, &model->placed, q, NULL);
    mukca_frame_multiply(&look->tip, &look->flange, &model->tool);
    for (int i = 0; i < 3; i++) {
        look->position[i] = row->position[i] - look->tip.p[i];
        look->rotation[i] = look->rotation_error[i] = NAN;
    }
    if (!isfinite(row->quaternion[0])) return;
    mukca_rotation_from_quaternion(measured, row->quaternion);
    mukca_mat3_tmul(off, look->tip.R, measured);
    look->rotation_error[0] = 0.5 * (off[7] - off[5]);
    look->rotation_error[1] = 0.5 * (off[2] - off[6]);
    look->rotation_error[2] = 0.5 * (off[3] - off[1]);
    mukca_rotation_log(look->rotation, off);
}

/* Derivative of the tip's position, m per m or rad, and of its rotation about its own axes, by a
 * rotation about (`turning`) or a translation along an axis given in frame T. */
static inline void motion(double position[3], double rotation[3], const mukca_pose_look *look,
                          const mukca_frame *T, const double axis[3], bool turning)
{
    if (!turning) {
        mukca_mat3_vec(position, T->R, axis);
        for (int i = 0; i < 3; i++) rotation[i] = 0;
        return;
    }
    double world[3], lever[3];
    mukca_mat3_vec(world, T->R, axis);
    for (int i = 0; i < 3; i++) lever[i] = look->tip.p[i] - T->p[i];
    mukca_cross(position, world, lever);
    mukca_mat3_tvec(rotation, look->tip.R, world);
}

/* Derivative of the tip's pose by the lag: its velocity. */
static void lag_motion(double position[3], double rotation[3], const mukca_pose_look *look)
{
    const mukca_geometry *g = &look->model->geometry;
    memset(position, 0, 3 * sizeof *position);
    memset(rotation, 0, 3 * sizeof *rotation);
    for (int k = 0; k < g->n_elements; k++) {
        double p[3], w[3];
        if (g->joint[k] < 0) continue;
        const double rate = look->row->velocity[g->joint[k]];
        if (!(fabs(rate) > 0)) continue;
        motion(p, w, look, &look->before[k], g->axis[k], mukca_joint_turns(g->type[k]));
        for (int i = 0; i < 3; i++) {
            position[i] += rate * p[i];
            rotation[i] += rate * w[i];
        }
    }
}

void mukca_pose_derivatives(double *position, double *rotation, int stride,
                            const mukca_pose_look *look, const mukca_unknown *unknowns, int n)
{
    const mukca_frame *const frames[] = {[MUKCA_UNKNOWN_BASE_SHIFT] = &identity,
                                         [MUKCA_UNKNOWN_BASE_TURN] = &identity,
                                         [MUKCA_UNKNOWN_TOOL_SHIFT] = &look->flange,
                                         [MUKCA_UNKNOWN_TOOL_TURN] = &look->tip};
    for (int u = 0; u < n; u++) {
        const mukca_unknown *unknown = &unknowns[u];
        double p[3], w[3], own[3];
        if (unknown->kind == MUKCA_UNKNOWN_LAG) {
            lag_motion(p, w, look);
        } else {
            const mukca_frame *T =
                unknown->element >= 0 ? &look->before[unknown->element] : frames[unknown->kind];
            motion(p, w, look, T, local_axis(own, &look->model->geometry, unknown),
                   kinds[unknown->kind].angle);
        }
        for (int i = 0; i < 3; i++) {
            if (position) position[i * stride + u] = p[i];
            if (rotation) rotation[i * stride + u] = w[i];
        }
    }
}

/* ---- statistics: Welford's algorithm, and a logarithmic histogram for medians ---- */

static void moments_add(mukca_moments *m, double x)
{
    m->n++;
    if (!(x <= m->max)) m->max = x;
    const double step = x - m->mean;
    m->mean += step / (double)m->n;
    m->m2 += step * (x - m->mean);
}

double mukca_moments_std(const mukca_moments *moments)
{
    return moments->n > 1 ? sqrt(moments->m2 / (double)(moments->n - 1)) : 0;
}

static void histogram_add(mukca_histogram *h, double x)
{
    int exponent = 0, bin = 0;
    if (x > 0x1p-60 && x < 0x1p9) {
        const double mantissa = frexp(x, &exponent); /* 0.5 .. 1 */
        bin = (exponent + 60) * 32 + (int)((mantissa - 0.5) * 64);
    } else if (x > 1) {
        bin = MUKCA_HISTOGRAM_BINS - 1;
    }
    h->count[bin]++;
    h->total++;
}

double mukca_errors_median(const mukca_vector_errors *errors)
{
    const mukca_histogram *histogram = &errors->histogram;
    double below = 0, half = 0.5 * histogram->total;
    for (int bin = 0; bin < MUKCA_HISTOGRAM_BINS; bin++) {
        const double here = histogram->count[bin];
        if (here > 0 && below + here >= half) {
            const double at = bin % 32 + (half - below) / here;
            return bin == 0 ? 0 : ldexp(0.5 + at / 64, bin / 32 - 60);
        }
        below += here;
    }
    return 0;
}

static void add_error(mukca_vector_errors *errors, const double vector[3], const double axes[3])
{
    const double length = mukca_norm3(vector);
    if (!isfinite(vector[0])) return;
    moments_add(&errors->length, length);
    histogram_add(&errors->histogram, length);
    for (int i = 0; i < 3; i++) moments_add(&errors->axis[i], fabs(axes[i]));
}

void mukca_pose_errors_add(mukca_pose_errors *errors, const mukca_pose_look *look)
{
    add_error(&errors->position, look->position, look->position);
    add_error(&errors->rotation, look->rotation, look->rotation_error);
}
