/* Kinematic model of re-calibration: residuals and derivatives of one pose. */
#include "recalibrate/recalibrate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "math/stats.h"

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

const mukca_element *mukca_unknown_element(const mukca_unknown *unknown, const mukca_chain *chain)
{
    const int k = unknown->element;
    return k == MUKCA_UNKNOWN_BASE || k == MUKCA_UNKNOWN_TOOL ? NULL : &chain->element[k];
}

void mukca_unknown_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_unknown *unknown,
                        const mukca_chain *chain)
{
    const mukca_element *element = mukca_unknown_element(unknown, chain);
    const char *frame = unknown->element == MUKCA_UNKNOWN_BASE ? "base" : "tool",
               *name = kinds[unknown->kind].name, *axes = kinds[unknown->kind].axes;
    snprintf(text, MUKCA_UNKNOWN_TEXT, "%s%s%s%s%.1s", element ? element->name : frame,
             *name ? " " : "", name, *axes ? " " : "", *axes ? axes + unknown->axis : "");
}

/* Update `placed`. */
static void place_in_poses(mukca_pose_model *model)
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
    place_in_poses(model);
}

/* Axis of an unknown in the frame that it is a part of; `axis` is storage for it. */
static inline const double *local_axis(double axis[3], const mukca_geometry *g,
                                       const mukca_frame *frame, const mukca_unknown *u)
{
    double e[2][3];
    switch (u->kind) {
        case MUKCA_UNKNOWN_ZERO:
            return g->axis[u->element];
        case MUKCA_UNKNOWN_TILT:
            mukca_rotation_transverse(e[0], e[1], g->axis[u->element]);
            memcpy(axis, e[u->axis], sizeof e[0]);
            return axis;
        case MUKCA_UNKNOWN_TURN:
            if (u->element == MUKCA_UNKNOWN_TOOL) return identity.R + 3 * u->axis;
            break;
        default:
            break;
    }
    return frame->R + 3 * u->axis; /* an axis of the parent frame */
}

/* Turn a frame about an axis in it. */
static void turn_frame(mukca_frame *T, const double axis[3], double angle)
{
    const double w[3] = {angle * axis[0], angle * axis[1], angle * axis[2]};
    mukca_frame step = identity;
    mukca_rotation_exp(step.R, w);
    mukca_frame_multiply(T, T, &step);
}

void mukca_pose_model_add(mukca_pose_model *model, const mukca_unknown *unknown, double by)
{
    mukca_geometry *g = &model->geometry;
    mukca_frame *T = unknown->element == MUKCA_UNKNOWN_BASE   ? &model->base
                     : unknown->element == MUKCA_UNKNOWN_TOOL ? &model->tool
                                                              : g->origin + unknown->element;
    double axis[3];
    if (unknown->kind == MUKCA_UNKNOWN_LAG)
        model->lag += by;
    else if (unknown->kind == MUKCA_UNKNOWN_ZERO)
        model->zero[g->joint[unknown->element]] += by;
    else if (unknown->kind == MUKCA_UNKNOWN_SHIFT)
        T->p[unknown->axis] += by;
    else
        turn_frame(T, local_axis(axis, g, T, unknown), by);
    place_in_poses(model);
}

void mukca_pose_model_theta(double *theta, const mukca_pose_model *model, const mukca_chain *chain)
{
    mukca_geometry g = model->geometry;
    for (int k = 0; k < g.n_elements; k++)
        if (mukca_joint_turns(g.type[k]))
            turn_frame(&g.origin[k], g.axis[k], model->zero[g.joint[k]]);
    mukca_geometry_theta(theta, chain, &g);
}

void mukca_pose_look_at(mukca_pose_look *look, const mukca_pose_model *model,
                        const mukca_dataset *log, int row)
{
    const size_t first = (size_t)row * (size_t)log->n_joints;
    double q[MUKCA_MAX_JOINTS], measured[9], off[9];
    mukca_frame flange;
    look->model = model;
    look->velocity = log->velocity + first;
    for (int j = 0; j < model->geometry.n_joints; j++)
        q[j] = log->q[first + (size_t)j] + model->zero[j] + model->lag * look->velocity[j];
    mukca_fk_frames(look->before, &flange, &model->placed, q, NULL);
    mukca_frame_multiply(&look->tip, &flange, &model->tool);
    for (int i = 0; i < 3; i++) {
        look->position[i] = log->position[3 * (size_t)row + (size_t)i] - look->tip.p[i];
        look->rotation[i] = look->rotation_error[i] = NAN;
    }
    if (!mukca_pose_oriented(log, row)) return;
    mukca_rotation_from_quaternion(measured, log->quaternion + 4 * (size_t)row);
    mukca_mat3_tmul(off, look->tip.R, measured);
    look->rotation_error[0] = 0.5 * (off[7] - off[5]);
    look->rotation_error[1] = 0.5 * (off[2] - off[6]);
    look->rotation_error[2] = 0.5 * (off[3] - off[1]);
    mukca_rotation_log(look->rotation, off);
}

/* Derivative of the tip's position, m per m or rad, and of its rotation about its own axes, by a
 * rotation about (`turning`) or a translation along an axis given in frame T. */
static inline void motion_of_tip(double position[3], double rotation[3],
                                 const mukca_pose_look *look, const mukca_frame *T,
                                 const double axis[3], bool turning)
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
        const double rate = look->velocity[g->joint[k]];
        if (!(fabs(rate) > 0)) continue;
        motion_of_tip(p, w, look, &look->before[k], g->axis[k], mukca_joint_turns(g->type[k]));
        for (int i = 0; i < 3; i++) {
            position[i] += rate * p[i];
            rotation[i] += rate * w[i];
        }
    }
}

void mukca_pose_derivatives(double *position, double *rotation, int stride,
                            const mukca_pose_look *look, const mukca_unknown *unknowns, int n)
{
    const mukca_pose_model *model = look->model;
    for (int u = 0; u < n; u++) {
        const mukca_unknown *unknown = &unknowns[u];
        double p[3], w[3], axis[3];
        if (unknown->kind == MUKCA_UNKNOWN_LAG) {
            lag_motion(p, w, look);
        } else {
            const int k = unknown->element;
            const bool base = k == MUKCA_UNKNOWN_BASE, tool = k == MUKCA_UNKNOWN_TOOL;
            const mukca_frame *in_parent = base   ? &model->base
                                           : tool ? &model->tool
                                                  : &model->geometry.origin[k],
                              *in_poses = base   ? in_parent
                                          : tool ? &look->tip
                                                 : &look->before[k];
            motion_of_tip(p, w, look, in_poses,
                          local_axis(axis, &model->geometry, in_parent, unknown),
                          kinds[unknown->kind].angle);
        }
        for (int i = 0; i < 3; i++) {
            if (position) position[i * stride + u] = p[i];
            if (rotation) rotation[i * stride + u] = w[i];
        }
    }
}

/* ---- statistics: Welford's algorithm, and lengths for medians ---- */

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

/* Keep a length, or every second one of the lengths kept so far. */
static void keep_length(mukca_vector_errors *e, double length)
{
    if (!e->between) e->between = 1;
    if (e->length.n % e->between != 0) return;
    if (e->n_kept == MUKCA_KEPT_LENGTHS) {
        e->n_kept /= 2;
        e->between *= 2;
        for (int i = 0; i < e->n_kept; i++) e->kept[i] = e->kept[2 * i];
    }
    e->kept[e->n_kept++] = length;
}

static void add_error(mukca_vector_errors *errors, const double vector[3], const double axes[3])
{
    const double length = mukca_norm3(vector);
    if (!isfinite(vector[0])) return;
    keep_length(errors, length);
    moments_add(&errors->length, length);
    for (int i = 0; i < 3; i++) moments_add(&errors->axis[i], fabs(axes[i]));
}

void mukca_pose_errors_add(mukca_pose_errors *errors, const mukca_pose_look *look)
{
    add_error(&errors->position, look->position, look->position);
    add_error(&errors->rotation, look->rotation, look->rotation_error);
}

void mukca_pose_errors_finish(mukca_pose_errors *errors)
{
    mukca_vector_errors *const both[] = {&errors->position, &errors->rotation};
    for (int i = 0; i < 2; i++)
        both[i]->median = mukca_stats_median(both[i]->kept, both[i]->n_kept);
}
