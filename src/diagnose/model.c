/* The model of a recording: the state of its rows, their groups, and predictions. */
#include "diagnose/model.h"

#include <math.h>
#include <string.h>

#include "fit/fit.h"

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
    if (m->command) state.command = m->command + r * n;
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
        if (!h->basis || h->kind == GAP_STRETCH) continue;
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

void gap_model_set_geometry(gap_model *m)
{
    mukca_geometry_set(&m->geometry, m->chain, NULL);
    const double factor = 1 + m->theta[6 * (m->n_slots - 1) + m->slot_width];
    for (int k = 0; k < m->chain->n_elements; k++)
        for (int c = 0; c < 3; c++) m->geometry.origin[k].p[c] *= factor;
    for (int k = 0; k < m->n_slots; k++) {
        const double *t = m->theta + 6 * k;
        mukca_frame local = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {t[0], t[1], t[2]}};
        if (k + 1 < m->n_slots || m->slot_width == 6) mukca_rotation_exp(local.R, t + 3);
        mukca_frame *origin = &m->geometry.origin[m->slot_element[k]];
        mukca_frame_multiply(origin, origin, &local);
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
        if (m->efforts_correlation > 0.5) scale_masses(m);
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
                             to = (size_t)row * (size_t)n_joints + (size_t)j;
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
    const size_t n = (size_t)m->chain->n_joints, size = n * sizeof(double);
    mukca_row_state rows;
    for (int row = 0; row < m->data->n_rows; row++) {
        const mukca_joint_state *state = mukca_dataset_state(&rows, m->data, row);
        memcpy(m->move + (size_t)row * n, state->move, size);
        if (m->command) memcpy(m->command + (size_t)row * n, state->command, size);
        m->time[row] = state->time;
        m->placement[row] = state->placement;
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
    if (m->options.free_base) { /* the tracker's frame: first guess from the nominal positions */
        double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
        mukca_fit_start(theta, chain, data, true);
        memcpy(m->tracker.p, theta, sizeof m->tracker.p);
        mukca_rotation_from_rpy(m->tracker.R, theta + 3);
    }

    /* A first joint's origin moves all sockets alike: only measured poses can see it. */
    for (int j = poses && !m->options.free_base ? 0 : 1; j < n_joints; j++)
        m->slot_element[m->n_slots++] = chain->joint_element[j];
    const int last = chain->n_elements - 1;
    m->slot_width = 6;
    if (chain->element[last].joint < 0) {
        m->slot_element[m->n_slots++] = last;
        m->slot_width = m->dim == 6 ? 6 : 3;
    }
    m->n_geometry = 6 * (m->n_slots - 1) + m->slot_width + 1 + (m->options.free_base ? 6 : 0);

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
    m->command = data->command ? MUKCA_TAKE(&m->pool, double, rows *n_joints) : NULL;
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
