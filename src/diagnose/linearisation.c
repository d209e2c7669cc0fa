/* Linearisation of the model of a recording: levers, columns of geometry and causes. */
#include <math.h>
#include <string.h>

#include "diagnose/model.h"
#include "math/dense.h"

/* Is dataset row `row` moved by a socket fault, and by how much of its coefficients? */
static double fault_share(const gap_model *m, const gap_hypothesis *h, int row)
{
    const gap_group *g = &m->groups[h->group];
    if (m->data->socket[row] != g->socket) return 0;
    switch (h->kind) {
        case GAP_STEP:
            return row >= h->row;
        case GAP_SPIKE:
            return row >= h->row && row <= h->last;
        case GAP_CREEP: { /* from 0 at the socket's first kept row to 1 at its last */
            const int first = m->order[g->start], last = m->order[g->start + g->count - 1];
            return last > first ? (double)(row - first) / (last - first) : 0;
        }
        default:
            return 0;
    }
}

bool gap_distance_acts(const gap_model *m, const gap_hypothesis *h, int pair)
{
    return h->effect.placement < 0 || m->groups[m->pairs[pair].a].placement == h->effect.placement;
}

void gap_hypothesis_columns(double *E, int ld, const gap_model *m, const gap_hypothesis *h)
{
    const int d = m->dim, n_joints = m->chain->n_joints, j = h->effect.joint;
    const mukca_effect_site site =
        h->kind == GAP_BUMPS ? MUKCA_SITE_ANGLE : mukca_effect_table[h->effect.kind].site;
    for (int i = 0; i < m->n; i++) {
        double *out = E + (size_t)i * (size_t)d * (size_t)ld;
        const int row = m->order[i];
        const float *basis =
            h->basis ? h->basis + (size_t)row * (size_t)(h->terms * h->width) : NULL;
        for (int c = 0; c < d; c++)
            for (int t = 0; t < h->terms; t++) out[c * ld + t] = 0;
        if (!basis) { /* faults of a socket, and its distance */
            if (h->kind == GAP_DISTANCE) continue;
            const double share = fault_share(m, h, row);
            for (int c = 0; c < 3; c++) out[c * ld + c] = -share;
            continue;
        }
        const double *lever = NULL;
        int width = h->width, stride = width; /* lever[c * stride + i] */
        if (h->kind == GAP_STRETCH) { /* along the axes of the slot's frame: as its x y z do */
            const int ldx = m->n_columns + 1;
            lever = m->columns + (size_t)i * (size_t)d * (size_t)ldx + 6 * h->group;
            for (int c = 0; c < d; c++)
                for (int t = 0; t < 3; t++) out[c * ld + t] = lever[c * ldx + t] * (double)basis[0];
            continue;
        }
        if (site == MUKCA_SITE_ANGLE) {
            lever = m->lever + (size_t)(i * n_joints + j) * (size_t)d;
        } else if (site == MUKCA_SITE_ROTATION) {
            lever = m->rotation_lever + (size_t)(i * n_joints + j) * (size_t)(3 * d);
        } else if (site == MUKCA_SITE_BASE) {
            lever = m->base_lever + (size_t)i * (size_t)(3 * d);
        } else if (site == MUKCA_SITE_TIP) {
            for (int c = 0; c < 3; c++)
                for (int t = 0; t < 3; t++)
                    out[c * ld + t] =
                        m->tip_frame[9 * i + 3 * c + t] * (double)basis[t * h->width + t];
            continue;
        } else { /* all angles: joints' levers lie one after the other */
            for (int k = 0; k < n_joints; k++)
                for (int c = 0; c < d; c++)
                    out[c * ld] += m->lever[(size_t)(i * n_joints + k) * (size_t)d + (size_t)c] *
                                   (double)basis[k];
            continue;
        }
        for (int t = 0; t < h->terms; t++)
            for (int c = 0; c < d; c++) {
                double sum = 0;
                for (int k = 0; k < width; k++)
                    sum += lever[c * stride + k] * (double)basis[t * width + k];
                out[c * ld + t] = sum;
            }
    }
}

/* Measured minus predicted of one row of a pose log, in the base frame. */
static void pose_residual(double *y, const gap_model *m, int row, const double *p, const double *R)
{
    const double *x = m->data->position + 3 * (size_t)row;
    double in_base[3], difference[3];
    for (int c = 0; c < 3; c++) difference[c] = x[c] - m->tracker.p[c];
    mukca_mat3_tvec(in_base, m->tracker.R, difference);
    for (int c = 0; c < 3; c++) y[c] = in_base[c] - p[c];
    if (m->dim < 6) return;
    const double *quaternion = m->data->quaternion + 4 * (size_t)row;
    double measured[9], base[9], relative[9], turned[9], w[3];
    mukca_rotation_from_quaternion(measured, quaternion);
    for (int a = 0; a < 3; a++) /* base := tracker' measured */
        for (int b = 0; b < 3; b++)
            base[3 * a + b] = m->tracker.R[a] * measured[b] +
                              m->tracker.R[3 + a] * measured[3 + b] +
                              m->tracker.R[6 + a] * measured[6 + b];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) turned[3 * a + b] = R[3 * b + a];
    mukca_mat3_mul(relative, base, turned);
    mukca_rotation_log(w, relative);
    for (int c = 0; c < 3; c++) y[3 + c] = m->rotation_weight * w[c];
}

/* Predictions of the kept rows at the present unknowns, and the pairs of sockets seen with them. */
static void predict_rows(gap_model *m)
{
    const int n_joints = m->chain->n_joints;
    for (int i = 0; i < m->n; i++) {
        mukca_frame tip;
        mukca_displacement displacement;
        gap_model_displacement(&displacement, m, m->order[i]);
        mukca_fk_pose(&tip, &m->geometry, m->data->q + (size_t)(m->order[i] * n_joints),
                      &displacement);
        memcpy(m->tip + 3 * i, tip.p, sizeof tip.p);
        memcpy(m->tip_frame + 9 * i, tip.R, sizeof tip.R);
    }
    for (int g = 0; g < m->n_groups; g++) {
        gap_group *group = &m->groups[g];
        memset(group->mean, 0, sizeof group->mean);
        for (int i = group->start; i < group->start + group->count; i++)
            for (int c = 0; c < 3; c++) group->mean[c] += m->tip[3 * i + c] / group->count;
    }
    for (int p = 0; p < m->n_pairs; p++) {
        gap_pair *pair = &m->pairs[p];
        double square = 0;
        for (int c = 0; c < 3; c++) {
            pair->direction[c] = m->groups[pair->a].mean[c] - m->groups[pair->b].mean[c];
            square += pair->direction[c] * pair->direction[c];
        }
        for (int c = 0; c < 3; c++) pair->direction[c] /= fmax(sqrt(square), 1e-9);
    }
}

/* The recorded angles, moved the least so that the prediction lies in the socket's mean.  Columns
 * are taken there: at the recorded angles they would go with the noise of their own row, and the
 * regression would shrink the arm to shrink its noise. */
static void seat(double *seated, const gap_model *m, const gap_group *group, int i,
                 const mukca_displacement *displacement)
{
    const int n = m->chain->n_joints, row = m->order[i];
    const double *q = m->data->q + (size_t)(row * n);
    double J[6 * MUKCA_MAX_JOINTS], A[9], r[3];
    memcpy(seated, q, sizeof *seated * (size_t)n);
    if (group->socket < 0) return;
    for (int c = 0; c < 3; c++) r[c] = group->mean[c] - m->tip[3 * i + c];
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        if (h->kind != GAP_STEP && h->kind != GAP_CREEP && h->kind != GAP_SPIKE) continue;
        const double share = fault_share(m, h, row);
        for (int k = 0; k < 3; k++) r[k] += share * m->cause[c].coefficient[k];
    }
    mukca_fk_jacobian(J, NULL, &m->geometry, q, displacement);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            A[3 * a + b] = a == b ? 1e-4 : 0;
            for (int j = 0; j < n; j++) A[3 * a + b] += J[a * n + j] * J[b * n + j];
        }
    if (mukca_dense_cholesky(A, 3)) return;
    mukca_dense_forward(r, 1, A, 3);
    mukca_dense_backward(r, 1, A, 3);
    for (int j = 0; j < n; j++)
        for (int c = 0; c < 3; c++) seated[j] += J[c * n + j] * r[c];
}

/* Levers and geometry columns of kept row i. */
static void row_columns(gap_model *m, int i, const double *q,
                        const mukca_displacement *displacement)
{
    const int d = m->dim, n_joints = m->chain->n_joints, ld = m->n_columns + 1;
    double *X = m->columns + (size_t)i * (size_t)d * (size_t)ld;
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    mukca_fk_frames(before, &tip, &m->geometry, q, displacement);
    memset(X, 0, sizeof *X * (size_t)d * (size_t)ld);
    double *base_lever = m->base_lever + (size_t)i * (size_t)(3 * d);
    for (int a = 0; a < 3; a++) {
        double e[3] = {0, 0, 0}, cross[3];
        e[a] = 1;
        mukca_cross(cross, e, tip.p);
        for (int c = 0; c < 3; c++) {
            base_lever[c * 3 + a] = cross[c];
            if (d == 6) base_lever[(3 + c) * 3 + a] = m->rotation_weight * e[c];
        }
    }
    int slot = 0;
    for (int k = 0; k < m->chain->n_elements; k++) {
        const mukca_element *element = &m->chain->element[k];
        double turn[6][3]; /* rotation vector of this frame -> tip */
        const double *R = before[k].R;
        const bool free = slot < m->n_slots && m->slot_element[slot] == k;
        if (!free && element->joint < 0) continue;
        for (int a = 0; a < 3; a++) {
            const double column[3] = {R[a], R[3 + a], R[6 + a]};
            double lever[3], cross[3];
            for (int c = 0; c < 3; c++) lever[c] = tip.p[c] - before[k].p[c];
            mukca_cross(cross, column, lever);
            for (int c = 0; c < 3; c++) {
                turn[c][a] = cross[c];
                turn[3 + c][a] = m->rotation_weight * column[c];
            }
        }
        if (element->joint >= 0) {
            const size_t at = (size_t)(i * n_joints + element->joint) * (size_t)d;
            for (int c = 0; c < d; c++) {
                memcpy(m->rotation_lever + 3 * (at + (size_t)c), turn[c], sizeof turn[c]);
                double along = mukca_dot3(turn[c], element->axis);
                if (element->type == MUKCA_PRISMATIC)
                    along = c < 3 ? mukca_dot3(R + 3 * c, element->axis) : 0;
                m->lever[at + (size_t)c] = along;
            }
        }
        if (!free) continue;
        const int width = slot + 1 < m->n_slots ? 6 : m->slot_width;
        for (int c = 0; c < d; c++)
            for (int a = 0; a < 3; a++) {
                if (c < 3) X[c * ld + 6 * slot + a] = R[3 * c + a];
                if (width == 6) X[c * ld + 6 * slot + 3 + a] = turn[c][a];
            }
        slot++;
    }
    for (int c = 0; c < 3; c++) X[c * ld + 6 * (m->n_slots - 1) + m->slot_width] = tip.p[c];
    if (m->options.free_base) {
        const int at = m->n_geometry - 6;
        for (int a = 0; a < 3; a++) {
            X[a * ld + at + a] = 1;
            for (int c = 0; c < d; c++) X[c * ld + at + 3 + a] = base_lever[c * 3 + a];
        }
    }
}

void gap_model_linearise(gap_model *m)
{
    const int d = m->dim;
    int used = m->n_geometry;
    for (int c = 0; c < m->n_causes; c++) used += m->cause[c].hypothesis.terms;
    m->n_columns = used;
    const int ld = used + 1;
    gap_model_set_geometry(m);
    predict_rows(m);
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        for (int i = group->start; i < group->start + group->count; i++) {
            double seated[MUKCA_MAX_JOINTS];
            mukca_displacement displacement;
            gap_model_displacement(&displacement, m, m->order[i]);
            seat(seated, m, group, i, &displacement);
            row_columns(m, i, seated, &displacement);
        }
    }
    int at = m->n_geometry;
    memset(m->direct, 0, sizeof *m->direct * (size_t)(m->n_pairs * ld));
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        gap_hypothesis_columns(m->columns + at, ld, m, h);
        if (h->kind == GAP_DISTANCE)
            for (int p = 0; p < m->n_pairs; p++)
                m->direct[p * ld + at] = gap_distance_acts(m, h, p) ? -1 : 0;
        at += h->terms;
    }

    /* y = measured - predicted + what the columns already explain, so that solutions are totals. */
    for (int i = 0; i < m->n; i++) {
        double y[6] = {0};
        double *X = m->columns + (size_t)i * (size_t)d * (size_t)ld;
        const int row = m->order[i];
        if (m->data->socket[row] < 0) {
            pose_residual(y, m, row, m->tip + 3 * i, m->tip_frame + 9 * i);
        } else {
            for (int c = 0; c < 3; c++) y[c] = -m->tip[3 * i + c];
        }
        for (int c = 0; c < d; c++) {
            double sum = y[c];
            for (int k = 0; k < m->n_geometry; k++) sum += X[c * ld + k] * m->theta[k];
            int column = m->n_geometry;
            for (int e = 0; e < m->n_causes; e++) {
                const gap_hypothesis *h = &m->cause[e].hypothesis;
                /* A socket's fault moves the socket, not the arm: tip does not hold it. */
                for (int t = 0; h->basis && h->kind != GAP_STRETCH && t < h->terms; t++)
                    sum += X[c * ld + column + t] * m->cause[e].coefficient[t];
                column += h->terms;
            }
            X[c * ld + used] = sum;
        }
    }
}
