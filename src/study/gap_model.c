/* The linearised model of a recording: rows, groups, levers and columns. */
#include "study/gap_model.h"

#include <math.h>
#include <string.h>

mukca_joint_state gap_model_state(const gap_model *m, int row)
{
    const size_t r = (size_t)row, n = (size_t)m->chain->n_joints;
    mukca_joint_state state = {.q = m->data->q + r * n,
                               .move = m->move + r * n,
                               .time = m->time[row],
                               .placement = m->placement[row]};
    if (m->have_torques) state.torque = m->total_torque + r * n;
    if (m->have_moments) {
        state.moment = (const double(*)[3])(m->total_moment + 3 * r * n);
        state.base_moment = m->total_base + 3 * r;
    }
    if (m->data->command) state.command = m->data->command + r * n;
    return state;
}

void gap_model_displacement(mukca_displacement *d, const gap_model *m, int row)
{
    memset(d, 0, sizeof *d);
    if (!m->n_causes) return;
    const int n_joints = m->chain->n_joints;
    for (int c = 0; c < m->n_causes; c++) {
        const gap_cause *cause = &m->cause[c];
        const gap_hypothesis *h = &cause->hypothesis;
        if (!h->basis) continue;
        const float *basis = h->basis + (size_t)row * (size_t)(h->terms * h->width);
        const mukca_effect_site site =
            h->kind == GAP_BUMPS ? MUKCA_SITE_ANGLE : mukca_effect_table[h->effect.kind].site;
        double *into = site == MUKCA_SITE_ANGLE      ? &d->q[h->effect.joint]
                       : site == MUKCA_SITE_ROTATION ? d->rotation[h->effect.joint]
                       : site == MUKCA_SITE_BASE     ? d->base
                       : site == MUKCA_SITE_TIP      ? d->tip
                                                     : d->q;
        if (site == MUKCA_SITE_ANGLES && h->width != n_joints) continue;
        d->any_rotation |= site == MUKCA_SITE_ROTATION || site == MUKCA_SITE_BASE;
        for (int t = 0; t < h->terms; t++)
            for (int i = 0; i < h->width; i++)
                into[i] += cause->coefficient[t] * (double)basis[t * h->width + i];
    }
}

void gap_model_predict(double position[3], const gap_model *m, int row)
{
    mukca_displacement d;
    gap_model_displacement(&d, m, row);
    mukca_fk_position(position, &m->geometry, m->data->q + (size_t)row * (size_t)m->chain->n_joints,
                      m->n_causes ? &d : NULL);
}

/* Is dataset row `row` moved by a socket fault, and by how much of its coefficients? */
static double fault_share(const gap_model *m, const gap_hypothesis *h, int row)
{
    const gap_group *g = &m->groups[h->group];
    if (m->data->socket[row] != g->socket) return 0;
    switch (h->kind) {
        case GAP_STEP:
            return row >= h->row;
        case GAP_SPIKE:
            return row == h->row;
        case GAP_CREEP: { /* from 0 at the socket's first kept row to 1 at its last */
            const int first = m->order[g->start], last = m->order[g->start + g->count - 1];
            return last > first ? (double)(row - first) / (last - first) : 0;
        }
        default:
            return 0;
    }
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

void gap_model_set_geometry(gap_model *m)
{
    mukca_geometry_set(&m->geometry, m->chain, NULL);
    for (int k = 0; k < m->n_slots; k++) {
        const double *t = m->theta + 6 * k;
        mukca_frame local = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {t[0], t[1], t[2]}};
        if (k + 1 < m->n_slots || m->slot_width == 6) mukca_rotation_exp(local.R, t + 3);
        mukca_frame *origin = &m->geometry.origin[m->slot_element[k]];
        mukca_frame_multiply(origin, origin, &local);
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

void gap_model_linearise(gap_model *m)
{
    const int d = m->dim, n_joints = m->chain->n_joints;
    int used = m->n_geometry;
    for (int c = 0; c < m->n_causes; c++) used += m->cause[c].hypothesis.terms;
    m->n_columns = used;
    const int ld = used + 1;
    gap_model_set_geometry(m);

    for (int i = 0; i < m->n; i++) {
        const int row = m->order[i];
        const double *q = m->data->q + (size_t)row * (size_t)n_joints;
        double *X = m->columns + (size_t)i * (size_t)d * (size_t)ld;
        mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
        mukca_displacement displacement;
        gap_model_displacement(&displacement, m, row);
        mukca_fk_frames(before, &tip, &m->geometry, q, &displacement);
        memcpy(m->tip + 3 * i, tip.p, sizeof tip.p);
        memcpy(m->tip_frame + 9 * i, tip.R, sizeof tip.R);
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
        if (m->options.free_base) {
            const int at = m->n_geometry - 6;
            for (int a = 0; a < 3; a++) {
                X[a * ld + at + a] = 1;
                for (int c = 0; c < d; c++) X[c * ld + at + 3 + a] = base_lever[c * 3 + a];
            }
        }
    }
    int at = m->n_geometry;
    memset(m->direct, 0, sizeof *m->direct * (size_t)(m->n_pairs * ld));
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        gap_hypothesis_columns(m->columns + at, ld, m, h);
        if (h->kind == GAP_DISTANCE)
            for (int p = 0; p < m->n_pairs; p++) m->direct[p * ld + at] = -1;
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
                for (int t = 0; h->basis && t < h->terms; t++)
                    sum += X[c * ld + column + t] * m->cause[e].coefficient[t];
                column += h->terms;
            }
            X[c * ld + used] = sum;
        }
    }
    /* Pairs of sockets: direction between their means as predicted now. */
    for (int p = 0; p < m->n_pairs; p++) {
        gap_pair *pair = &m->pairs[p];
        double mean[2][3] = {{0}}, norm = 0;
        for (int side = 0; side < 2; side++) {
            const gap_group *g = &m->groups[side ? pair->b : pair->a];
            for (int i = g->start; i < g->start + g->count; i++)
                for (int c = 0; c < 3; c++) mean[side][c] += m->tip[3 * i + c] / g->count;
        }
        for (int c = 0; c < 3; c++) {
            pair->direction[c] = mean[0][c] - mean[1][c];
            norm += pair->direction[c] * pair->direction[c];
        }
        for (int c = 0; c < 3; c++) pair->direction[c] /= fmax(sqrt(norm), 1e-9);
    }
}

void gap_model_regroup(gap_model *m)
{
    const mukca_dataset *data = m->data;
    m->n = m->n_groups = m->n_pairs = 0;
    for (int s = -1; s < data->n_sockets; s++) {
        gap_group *g = &m->groups[m->n_groups];
        *g = (gap_group){.start = m->n, .socket = s, .placement = -1};
        for (int row = 0; row < data->n_rows; row++)
            if (m->keep[row] && data->socket[row] == s) {
                m->order[m->n++] = row;
                g->placement = m->placement[row];
            }
        g->count = m->n - g->start;
        /* Groups keep their index (faults refer to it), so empty sockets stay in the table. */
        if (s >= 0 || g->count) m->n_groups++;
    }
    for (int p = 0; p < data->n_distances; p++) {
        const mukca_distance *known = &data->distances[p];
        const int shift = m->groups[0].socket < 0;
        const gap_pair pair = {known->a + shift, known->b + shift, known->distance, {0}};
        if (m->groups[pair.a].count && m->groups[pair.b].count) m->pairs[m->n_pairs++] = pair;
    }
}

/* Ridge estimate of each lump's mass factor from measured efforts: noise 0.15 N m, prior 10 %. */
static void scale_masses(gap_model *m)
{
    const int k = m->n_lumps, n_joints = m->chain->n_joints;
    double normal[GAP_MAX_LUMPS][GAP_MAX_LUMPS] = {{0}}, right[GAP_MAX_LUMPS] = {0};
    const double weight = 1 / (0.15 * 0.15), prior = 1 / (0.1 * 0.1);
    for (int row = 0; row < m->data->n_rows; row++)
        for (int j = 0; j < n_joints; j++) {
            const double effort = m->data->effort[row * n_joints + j];
            if (!isfinite(effort)) continue;
            for (int a = 0; a < k; a++) {
                const double ta =
                    m->torque[((size_t)row * (size_t)k + (size_t)a) * (size_t)n_joints + (size_t)j];
                right[a] += weight * ta * effort;
                for (int b = 0; b <= a; b++)
                    normal[a][b] +=
                        weight * ta *
                        m->torque[((size_t)row * (size_t)k + (size_t)b) * (size_t)n_joints +
                                  (size_t)j];
            }
        }
    for (int a = 0; a < k; a++) right[a] += prior, normal[a][a] += prior;
    for (int a = 0; a < k; a++) { /* Cholesky and both substitutions on a small dense system */
        for (int b = 0; b <= a; b++) {
            double sum = normal[a][b];
            for (int c = 0; c < b; c++) sum -= normal[a][c] * normal[b][c];
            if (a == b)
                normal[a][a] = sqrt(fmax(sum, 1e-12));
            else
                normal[a][b] = sum / normal[b][b];
        }
    }
    for (int a = 0; a < k; a++) {
        for (int c = 0; c < a; c++) right[a] -= normal[a][c] * right[c];
        right[a] /= normal[a][a];
    }
    for (int a = k - 1; a >= 0; a--) {
        for (int c = a + 1; c < k; c++) right[a] -= normal[c][a] * right[c];
        right[a] /= normal[a][a];
        m->lump_scale[a] = fmin(fmax(right[a], 0.3), 3.0);
    }
}

/* Moments of gravity per mass, at the nominal geometry, and their totals. */
static void fill_moments(gap_model *m)
{
    const mukca_chain *chain = m->chain;
    const int n_joints = chain->n_joints, k = m->n_lumps;
    double agree = 0, efforts = 0, torques = 0;
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, chain, NULL);
    m->efforts_correlation = NAN;
    for (int row = 0; row < m->data->n_rows; row++) {
        const double *q = m->data->q + (size_t)row * (size_t)n_joints;
        for (int a = 0; a < k; a++) {
            double scale[MUKCA_MAX_MASSES];
            const size_t at = (size_t)row * (size_t)k + (size_t)a;
            for (int i = 0; i < chain->n_masses; i++)
                scale[i] = chain->mass[i].element == m->lump_element[a];
            const bool tip = m->lump_element[a] == chain->n_elements - 1;
            const double payload = tip && m->data->payload && isfinite(m->data->payload[row])
                                       ? m->data->payload[row]
                                       : 0;
            mukca_chain_moments((double(*)[3])(m->moment + 3 * at * (size_t)n_joints),
                                m->torque + at * (size_t)n_joints, m->base_moment + 3 * at, chain,
                                &nominal, q, scale, payload);
        }
    }
    for (int a = 0; a < k; a++) m->lump_scale[a] = 1;
    if (m->options.lump_scale)
        memcpy(m->lump_scale, m->options.lump_scale, sizeof *m->lump_scale * (size_t)k);
    if (m->data->effort && k && !m->options.lump_scale) {
        for (int row = 0; row < m->data->n_rows; row++)
            for (int j = 0; j < n_joints; j++) {
                double torque = 0;
                for (int a = 0; a < k; a++)
                    torque += m->torque[((size_t)row * (size_t)k + (size_t)a) * (size_t)n_joints +
                                        (size_t)j];
                const double effort = m->data->effort[row * n_joints + j];
                if (!isfinite(effort)) continue;
                agree += torque * effort;
                efforts += effort * effort;
                torques += torque * torque;
            }
        if (efforts > 0 && torques > 0) m->efforts_correlation = agree / sqrt(efforts * torques);
        if (agree > 0) scale_masses(m);
    }
    m->have_moments = m->have_torques = k > 0;
    for (int row = 0; row < m->data->n_rows; row++)
        for (int a = 0; a < k; a++) {
            const size_t at = (size_t)row * (size_t)k + (size_t)a;
            const double s = m->lump_scale[a];
            for (int c = 0; c < 3; c++) {
                m->base_moment[3 * at + (size_t)c] *= s;
                m->total_base[3 * row + c] += m->base_moment[3 * at + (size_t)c];
            }
            for (int j = 0; j < n_joints; j++) {
                const size_t from = at * (size_t)n_joints + (size_t)j,
                             to = (size_t)(row * n_joints + j);
                m->torque[from] *= s;
                m->total_torque[to] += m->torque[from];
                for (int c = 0; c < 3; c++) {
                    m->moment[3 * from + (size_t)c] *= s;
                    m->total_moment[3 * to + (size_t)c] += m->moment[3 * from + (size_t)c];
                }
            }
        }
    if (!k && m->data->effort) { /* no masses: measured torque serves what acts about the axis */
        m->have_torques = true;
        for (int i = 0; i < m->data->n_rows * n_joints; i++)
            m->total_torque[i] = isfinite(m->data->effort[i]) ? m->data->effort[i] : 0;
    }
}

static void fill_state(gap_model *m)
{
    const mukca_dataset *data = m->data;
    const int n_joints = m->chain->n_joints;
    for (int row = 0, first = 0; row < data->n_rows; row++) {
        const bool same = row > 0 && data->file[row] == data->file[row - 1];
        if (!same) first = row;
        for (int j = 0; j < n_joints; j++)
            m->move[row * n_joints + j] =
                same ? data->q[row * n_joints + j] - data->q[(row - 1) * n_joints + j] : 0;
        const bool timed = data->time && isfinite(data->time[row]) && isfinite(data->time[first]);
        m->time[row] = timed ? data->time[row] : MUKCA_SECONDS_PER_ROW * (data->row[row] - data->row[first]);
        m->placement[row] = mukca_dataset_placement(data, row);
    }
    fill_moments(m);
}

mukca_status gap_model_create(gap_model *m, const mukca_chain *chain, const mukca_dataset *data,
                              const gap_options *options, mukca_error *error)
{
    memset(m, 0, sizeof *m);
    m->chain = chain;
    m->data = data;
    m->options = *options;
    const int rows = data->n_rows, n_joints = chain->n_joints;
    bool poses = false, turned = true;
    for (int row = 0; row < rows; row++)
        if (data->socket[row] < 0) {
            poses = true;
            turned = turned && data->quaternion && isfinite(data->quaternion[4 * (size_t)row]);
        } else {
            turned = false;
        }
    m->dim = poses && turned ? 6 : 3;
    m->rotation_weight = 0.3;
    m->tracker = (mukca_frame){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    if (!poses) m->options.free_base = false;

    /* A first joint's origin moves all sockets alike: only measured poses can see it. */
    for (int j = poses && !m->options.free_base ? 0 : 1; j < n_joints; j++)
        m->slot_element[m->n_slots++] = chain->joint_element[j];
    const int last = chain->n_elements - 1;
    m->slot_width = 6;
    if (chain->element[last].joint < 0) {
        m->slot_element[m->n_slots++] = last;
        m->slot_width = m->dim == 6 ? 6 : 3;
    }
    m->n_geometry = 6 * (m->n_slots - 1) + m->slot_width + (m->options.free_base ? 6 : 0);

    for (int element = 0; element < chain->n_elements; element++) {
        double kg = 0;
        for (int i = 0; i < chain->n_masses; i++)
            if (chain->mass[i].element == element) kg += chain->mass[i].kg;
        const bool payload = data->payload && element == last && chain->n_masses > 0;
        if (kg > 0 || payload) m->lump_element[m->n_lumps++] = element;
    }

    const int d = m->dim, capacity = m->n_geometry + 3 * GAP_MAX_TERMS;
    const int lumps = m->n_lumps ? m->n_lumps : 1;
    m->capacity = capacity;
    m->moment = MUKCA_TAKE(&m->pool, double, 3 * rows * lumps * n_joints);
    m->torque = MUKCA_TAKE(&m->pool, double, rows *lumps *n_joints);
    m->base_moment = MUKCA_TAKE(&m->pool, double, 3 * rows * lumps);
    m->total_moment = MUKCA_TAKE(&m->pool, double, 3 * rows * n_joints);
    m->total_torque = MUKCA_TAKE(&m->pool, double, rows *n_joints);
    m->total_base = MUKCA_TAKE(&m->pool, double, 3 * rows);
    m->move = MUKCA_TAKE(&m->pool, double, rows *n_joints);
    m->time = MUKCA_TAKE(&m->pool, double, rows);
    m->placement = MUKCA_TAKE(&m->pool, int, rows);
    m->keep = MUKCA_TAKE(&m->pool, unsigned char, rows);
    m->order = MUKCA_TAKE(&m->pool, int, rows);
    m->groups = MUKCA_TAKE(&m->pool, gap_group, data->n_sockets + 2);
    m->pairs = MUKCA_TAKE(&m->pool, gap_pair, data->n_distances + 1);
    m->theta = MUKCA_TAKE(&m->pool, double, m->n_geometry);
    m->theta_sigma = MUKCA_TAKE(&m->pool, double, m->n_geometry);
    m->cause = MUKCA_TAKE(&m->pool, gap_cause, GAP_MAX_CAUSES);
    m->tip = MUKCA_TAKE(&m->pool, double, 3 * rows);
    m->tip_frame = MUKCA_TAKE(&m->pool, double, 9 * rows);
    m->lever = MUKCA_TAKE(&m->pool, double, rows *n_joints *d);
    m->rotation_lever = MUKCA_TAKE(&m->pool, double, 3 * rows * n_joints * d);
    m->base_lever = MUKCA_TAKE(&m->pool, double, 3 * rows * d);
    m->columns = MUKCA_TAKE(&m->pool, double, (size_t)(rows * d) * (size_t)(capacity + 1));
    m->direct = MUKCA_TAKE(&m->pool, double, (data->n_distances + 1) * (capacity + 1));
    for (int i = 0; i < GAP_RHOS; i++) {
        m->pack[i].gram = MUKCA_TAKE(&m->pool, double, (capacity + 1) * (capacity + 1));
        m->pack[i].distance =
            MUKCA_TAKE(&m->pool, double, (data->n_distances + 1) * (capacity + 1));
        m->pack[i].variance = MUKCA_TAKE(&m->pool, double, data->n_distances + 1);
        m->pack[i].white =
            MUKCA_TAKE(&m->pool, double, (size_t)(rows * d) * (size_t)(capacity + 1));
    }
    m->work = MUKCA_TAKE(&m->pool, double, (capacity + 1) * (capacity + 1));
    m->posterior_chol = MUKCA_TAKE(&m->pool, double, (capacity + 1) * (capacity + 1));
    m->prior = MUKCA_TAKE(&m->pool, double, capacity);
    m->mean = MUKCA_TAKE(&m->pool, double, capacity);
    if (m->pool.failed) {
        gap_model_free(m);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    }
    memset(m->keep, 1, (size_t)rows);
    fill_state(m);
    gap_model_regroup(m);
    m->sigma_length = 2e-3;
    m->sigma_angle = 5e-3;
    m->sigma = 1e-4;
    return MUKCA_OK;
}

void gap_model_free(gap_model *m)
{
    mukca_pool_free(&m->pool);
    memset(m, 0, sizeof *m);
}

bool gap_model_add(gap_model *m, const gap_hypothesis *h)
{
    int used = m->n_geometry + h->terms;
    for (int c = 0; c < m->n_causes; c++) used += m->cause[c].hypothesis.terms;
    if (m->n_causes == GAP_MAX_CAUSES || used > m->capacity) return false;
    const double *scales;
    const int n = gap_scales(&scales, h);
    m->cause[m->n_causes++] = (gap_cause){.hypothesis = *h, .scale = scales[n / 2]};
    return true;
}

void gap_model_drop(gap_model *m, int index)
{
    for (int c = index; c + 1 < m->n_causes; c++) m->cause[c] = m->cause[c + 1];
    m->n_causes--;
}
