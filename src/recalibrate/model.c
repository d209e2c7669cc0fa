/* Kinematics of re-calibration. */
#include "recalibrate/model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const mukca_frame identity = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
static const char axis_letter[3] = {'x', 'y', 'z'};

static bool turns(const mukca_geometry *geometry, int k)
{
    return geometry->type[k] == MUKCA_REVOLUTE || geometry->type[k] == MUKCA_CONTINUOUS;
}

void mukca_unknown_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_unknown *unknown,
                        const mukca_chain *chain)
{
    static const char *const names[] = {
#define UNKNOWN_NAME(name, text) text,
        MUKCA_UNKNOWN_LIST(UNKNOWN_NAME)
#undef UNKNOWN_NAME
    };
    const char *name = names[unknown->kind];
    const char *joint = unknown->element >= 0 ? chain->element[unknown->element].name : "";
    switch (unknown->kind) {
        case MUKCA_UNKNOWN_ZERO:
            snprintf(text, MUKCA_UNKNOWN_TEXT, "%s %s", joint, name);
            break;
        case MUKCA_UNKNOWN_SHIFT:
            snprintf(text, MUKCA_UNKNOWN_TEXT, "%s %c", joint, axis_letter[unknown->axis]);
            break;
        case MUKCA_UNKNOWN_TILT:
            snprintf(text, MUKCA_UNKNOWN_TEXT, "%s %s %d", joint, name, 1 + unknown->axis);
            break;
        case MUKCA_UNKNOWN_LAG:
            snprintf(text, MUKCA_UNKNOWN_TEXT, "%s", name);
            break;
        default:
            snprintf(text, MUKCA_UNKNOWN_TEXT, "%s %c", name, axis_letter[unknown->axis]);
            break;
    }
}

void mukca_pose_model_set(mukca_pose_model *model, const mukca_chain *chain)
{
    memset(model, 0, sizeof *model);
    mukca_geometry_set(&model->geometry, chain, NULL);
    model->base = model->tool = identity;
}

/* R := R exp(w), or exp(w) R. */
static void turn(double R[9], const double w[3], bool left)
{
    double E[9], old[9];
    mukca_rotation_exp(E, w);
    memcpy(old, R, sizeof old);
    mukca_mat3_mul(R, left ? E : old, left ? old : E);
}

void mukca_pose_model_add(mukca_pose_model *model, const mukca_unknown *unknown, double by)
{
    const int k = unknown->element, a = unknown->axis;
    double w[3] = {0, 0, 0}, e[2][3], p[3];
    switch (unknown->kind) {
        case MUKCA_UNKNOWN_ZERO:
            model->zero[model->geometry.joint[k]] += by;
            break;
        case MUKCA_UNKNOWN_SHIFT:
            model->geometry.origin[k].p[a] += by;
            break;
        case MUKCA_UNKNOWN_TILT:
            mukca_rotation_transverse(e[0], e[1], model->geometry.axis[k]);
            for (int i = 0; i < 3; i++) w[i] = by * e[a][i];
            turn(model->geometry.origin[k].R, w, false);
            break;
        case MUKCA_UNKNOWN_BASE_SHIFT:
            model->base.p[a] += by;
            break;
        case MUKCA_UNKNOWN_BASE_TURN:
            w[a] = by;
            turn(model->base.R, w, true);
            memcpy(p, model->base.p, sizeof p);
            {
                double R[9];
                mukca_rotation_exp(R, w);
                mukca_mat3_vec(model->base.p, R, p);
            }
            break;
        case MUKCA_UNKNOWN_TOOL_SHIFT:
            model->tool.p[a] += by;
            break;
        case MUKCA_UNKNOWN_TOOL_TURN:
            w[a] = by;
            turn(model->tool.R, w, false);
            break;
        case MUKCA_UNKNOWN_LAG:
            model->lag += by;
            break;
    }
}

void mukca_pose_model_theta(double *theta, const mukca_pose_model *model, const mukca_chain *chain)
{
    mukca_geometry geometry = model->geometry;
    for (int k = 0; k < geometry.n_elements; k++) {
        if (!turns(&geometry, k)) continue;
        double w[3];
        for (int i = 0; i < 3; i++) w[i] = geometry.axis[k][i] * model->zero[geometry.joint[k]];
        turn(geometry.origin[k].R, w, false);
    }
    mukca_geometry_theta(theta, chain, &geometry);
}

/* Rotation vector from the vector of R - I: exact, without R's trace where the angle is small. */
static void log_of(double w[3], const double v[3], const double R[9])
{
    const double s2 = mukca_dot3(v, v);
    if (s2 > 1e-4 || R[0] + R[4] + R[8] < 0) {
        mukca_rotation_log(w, R);
        return;
    }
    const double scale = 1 + s2 * (1.0 / 6 + s2 * (3.0 / 40 + s2 * (15.0 / 336))); /* asin(s) / s */
    for (int i = 0; i < 3; i++) w[i] = v[i] * scale;
}

void mukca_pose_look_at(mukca_pose_look *look, const mukca_pose_model *model,
                        const mukca_pose_row *row, mukca_quaternion_order order)
{
    const mukca_geometry *g = &model->geometry;
    mukca_frame frame = model->base;
    look->model = model;
    look->row = row;
    for (int k = 0; k < g->n_elements; k++) {
        const signed char j = g->joint[k];
        memcpy(look->parent[k], frame.R, sizeof frame.R);
        mukca_frame_multiply(&frame, &frame, &g->origin[k]);
        look->before[k] = frame;
        if (j < 0) continue;
        const double lag = model->lag != 0 ? model->lag * row->velocity[j] : 0;
        const double angle = row->q[j] + model->zero[j] + lag;
        if (g->axis_z[k] && turns(g, k)) {
            const double s = g->axis_z[k] * sin(angle), c = cos(angle);
            for (int i = 0; i < 9; i += 3) {
                const double x = frame.R[i], y = frame.R[i + 1];
                frame.R[i] = c * x + s * y;
                frame.R[i + 1] = c * y - s * x;
            }
        } else if (turns(g, k)) {
            double R[9], old[9];
            mukca_rotation_about(R, g->axis[k], angle);
            memcpy(old, frame.R, sizeof old);
            mukca_mat3_mul(frame.R, old, R);
        } else {
            double step[3];
            mukca_mat3_vec(step, frame.R, g->axis[k]);
            for (int i = 0; i < 3; i++) frame.p[i] += angle * step[i];
        }
    }
    look->flange = frame;
    mukca_frame_multiply(&look->tip, &frame, &model->tool);
    for (int i = 0; i < 3; i++) {
        look->position[i] = row->position[i] - look->tip.p[i];
        look->rotation[i] = look->rotation_error[i] = NAN;
    }
    const double *q = row->quaternion;
    if (!isfinite(q[0])) return;
    const double last[4] = {q[3], q[0], q[1], q[2]};
    double measured[9], back[9], off[9];
    mukca_rotation_from_quaternion(measured, order == MUKCA_QUATERNION_W_LAST ? last : q);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) back[3 * i + j] = look->tip.R[3 * j + i];
    mukca_mat3_mul(off, back, measured);
    look->rotation_error[0] = 0.5 * (off[7] - off[5]);
    look->rotation_error[1] = 0.5 * (off[2] - off[6]);
    look->rotation_error[2] = 0.5 * (off[3] - off[1]);
    log_of(look->rotation, look->rotation_error, off);
}

/* Columns of a turn about `axis` through `point` (poses' frame). */
static void set_turn(double *position, double *rotation, int stride, const double axis[3],
                     const double point[3], const mukca_pose_look *look)
{
    double lever[3] = {0, 0, 0}, v[3];
    for (int i = 0; i < 3; i++) lever[i] = look->tip.p[i] - point[i];
    mukca_cross(v, axis, lever);
    for (int i = 0; position && i < 3; i++) position[i * stride] = v[i];
    mukca_mat3_tvec(v, look->tip.R, axis);
    for (int i = 0; rotation && i < 3; i++) rotation[i * stride] = v[i];
}

static void set_shift(double *position, double *rotation, int stride, const double v[3])
{
    for (int i = 0; position && i < 3; i++) position[i * stride] = v[i];
    for (int i = 0; rotation && i < 3; i++) rotation[i * stride] = 0;
}

/* Motion of the tip by the joints' velocities. */
static void set_lag(double *position, double *rotation, int stride, const mukca_pose_look *look)
{
    const mukca_geometry *g = &look->model->geometry;
    static const double none[3] = {0, 0, 0};
    set_shift(position, rotation, stride, none);
    for (int k = 0; k < g->n_elements; k++) {
        if (g->joint[k] < 0) continue;
        const double rate = look->row->velocity[g->joint[k]];
        double axis[3] = {0, 0, 0}, p[3] = {0, 0, 0}, w[3] = {0, 0, 0};
        if (!(fabs(rate) > 0)) continue;
        mukca_mat3_vec(axis, look->before[k].R, g->axis[k]);
        if (turns(g, k))
            set_turn(p, w, 1, axis, look->before[k].p, look);
        else
            memcpy(p, axis, sizeof p);
        for (int i = 0; position && i < 3; i++) position[i * stride] += rate * p[i];
        for (int i = 0; rotation && i < 3; i++) rotation[i * stride] += rate * w[i];
    }
}

void mukca_pose_derivatives(double *position, double *rotation, int stride,
                            const mukca_pose_look *look, const mukca_unknown *unknowns, int n)
{
    const mukca_pose_model *model = look->model;
    static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double origin[3] = {0, 0, 0};
    for (int u = 0; u < n; u++) {
        const int k = unknowns[u].element, a = unknowns[u].axis;
        double *p = position ? position + u : NULL, *w = rotation ? rotation + u : NULL;
        double v[3] = {0, 0, 0}, e[2][3];
        switch (unknowns[u].kind) {
            case MUKCA_UNKNOWN_ZERO:
                mukca_mat3_vec(v, look->before[k].R, model->geometry.axis[k]);
                set_turn(p, w, stride, v, look->before[k].p, look);
                break;
            case MUKCA_UNKNOWN_SHIFT:
                for (int i = 0; i < 3; i++) v[i] = look->parent[k][3 * i + a];
                set_shift(p, w, stride, v);
                break;
            case MUKCA_UNKNOWN_TILT:
                mukca_rotation_transverse(e[0], e[1], model->geometry.axis[k]);
                mukca_mat3_vec(v, look->before[k].R, e[a]);
                set_turn(p, w, stride, v, look->before[k].p, look);
                break;
            case MUKCA_UNKNOWN_BASE_SHIFT:
                set_shift(p, w, stride, unit[a]);
                break;
            case MUKCA_UNKNOWN_BASE_TURN:
                set_turn(p, w, stride, unit[a], origin, look);
                break;
            case MUKCA_UNKNOWN_TOOL_SHIFT:
                for (int i = 0; i < 3; i++) v[i] = look->flange.R[3 * i + a];
                set_shift(p, w, stride, v);
                break;
            case MUKCA_UNKNOWN_TOOL_TURN:
                for (int i = 0; i < 3; i++) v[i] = look->tip.R[3 * i + a];
                set_turn(p, w, stride, v, look->tip.p, look);
                break;
            case MUKCA_UNKNOWN_LAG:
                set_lag(p, w, stride, look);
                break;
        }
    }
}
