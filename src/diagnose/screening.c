/* Faults of a recording that must be found before anything is fitted. */
#include "diagnose/screening.h"

#include <math.h>
#include <string.h>

#include "math/stats.h"

void mukca_screening_add(mukca_faults *faults, const mukca_recording *recording,
                         mukca_fault_kind kind, int row, double size_m)
{
    const mukca_dataset *data = recording->data;
    if (faults->count == MUKCA_MAX_FAULTS) return;
    faults->list[faults->count++] = (mukca_data_fault){.kind = kind,
                                                       .placement = recording->placement[row],
                                                       .socket = data->socket[row],
                                                       .row = data->row[row],
                                                       .file = data->file[row],
                                                       .data_row = row,
                                                       .size_m = size_m};
}

static double distance3(const double *a, const double *b)
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(mukca_dot3(d, d));
}

/* Component-wise median of the positions of a group's rows. */
static void group_median(double median[3], const mukca_regression *m, const mukca_group *g,
                         double *scratch)
{
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < g->count; i++) scratch[i] = m->linear.tip[3 * (g->start + i) + c];
        median[c] = mukca_stats_median(scratch, g->count);
    }
}

/* Own socket more than 20 mm away (some times the error of any nominal geometry) and another one of
 * the placement under 0.4 of that: a wrong label, before anything is fitted. */
static void wrong_labels(mukca_faults *faults, mukca_regression *m, double *scratch)
{
    double(*median)[3] = MUKCA_TAKE(&m->pool, double[3], m->recording.n_groups);
    if (!median) return;
    for (int g = 0; g < m->recording.n_groups; g++)
        if (m->recording.groups[g].count)
            group_median(median[g], m, &m->recording.groups[g], scratch);
    for (int g = 0; g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        if (group->socket < 0) continue;
        for (int i = group->start; i < group->start + group->count; i++) {
            const double own = distance3(m->linear.tip + 3 * i, median[g]);
            for (int o = 0; o < m->recording.n_groups; o++) {
                const mukca_group *other = &m->recording.groups[o];
                if (o == g || !other->count || other->placement != group->placement) continue;
                if (own > 0.02 && distance3(m->linear.tip + 3 * i, median[o]) < 0.4 * own) {
                    mukca_screening_add(faults, &m->recording, MUKCA_FAULT_WRONG_SOCKET,
                                        m->recording.order[i], own);
                    m->recording.keep[m->recording.order[i]] = 0;
                    break;
                }
            }
        }
    }
}

/* Residual length of each kept row about its socket's centre (geometric median), or about its
 * measurement. */
static void residuals(double *r, const mukca_regression *m)
{
    for (int g = 0; g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        double centre[3] = {0, 0, 0};
        if (group->socket < 0) {
            for (int i = group->start; i < group->start + group->count; i++) {
                const double *measured =
                    m->recording.data->position + 3 * (size_t)m->recording.order[i];
                double difference[3], in_base[3];
                for (int c = 0; c < 3; c++) difference[c] = measured[c] - m->unknowns.tracker.p[c];
                mukca_mat3_tvec(in_base, m->unknowns.tracker.R, difference);
                r[i] = distance3(in_base, m->linear.tip + 3 * i);
            }
            continue;
        }
        for (int i = group->start; i < group->start + group->count; i++)
            for (int c = 0; c < 3; c++) centre[c] += m->linear.tip[3 * i + c] / group->count;
        for (int pass = 0; pass < 6; pass++) { /* Weiszfeld */
            double sum = 0, next[3] = {0, 0, 0};
            for (int i = group->start; i < group->start + group->count; i++) {
                const double w = 1 / (distance3(m->linear.tip + 3 * i, centre) + 1e-5);
                sum += w;
                for (int c = 0; c < 3; c++) next[c] += w * m->linear.tip[3 * i + c];
            }
            for (int c = 0; c < 3; c++) centre[c] = next[c] / sum;
        }
        for (int i = group->start; i < group->start + group->count; i++)
            r[i] = distance3(m->linear.tip + 3 * i, centre);
    }
}

/* Wild rows of a robust fit: at another socket (wrong label), or nowhere (outlier). */
static void wild_rows(mukca_faults *faults, mukca_regression *m, const double *r, double *scratch)
{
    memcpy(scratch, r, sizeof *r * (size_t)m->recording.n_samples);
    const double median = mukca_stats_median(scratch, m->recording.n_samples);
    const double limit = fmax(12 * median, 4e-3);
    int wild = 0;
    for (int i = 0; i < m->recording.n_samples; i++) wild += r[i] > limit;
    if (wild > fmax(4, 0.05 * m->recording.n_samples))
        return; /* that many are no outliers but an effect */
    for (int g = 0; g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        for (int i = group->start; i < group->start + group->count; i++) {
            if (!(r[i] > limit)) continue;
            double nearest = HUGE_VAL;
            for (int o = 0; o < m->recording.n_groups && group->socket >= 0; o++) {
                const mukca_group *other = &m->recording.groups[o];
                if (o == g || !other->count || other->placement != group->placement) continue;
                double centre[3];
                group_median(centre, m, other, scratch);
                nearest = fmin(nearest, distance3(m->linear.tip + 3 * i, centre));
            }
            const bool wrong = nearest < 0.2 * r[i] && nearest < limit;
            if (!wrong && r[i] < fmax(20 * median, 6e-3)) continue;
            mukca_screening_add(faults, &m->recording,
                                wrong ? MUKCA_FAULT_WRONG_SOCKET : MUKCA_FAULT_OUTLIER,
                                m->recording.order[i], r[i]);
            m->recording.keep[m->recording.order[i]] = 0;
        }
    }
}

/* Rows recorded twice: every angle within 0.2 mrad of the row before, where moves are larger. */
static void duplicates(mukca_faults *faults, const mukca_regression *m, double *scratch)
{
    const int n_joints = m->recording.chain->n_joints;
    int moves = 0;
    for (int row = 0; row < m->recording.data->n_rows; row++) {
        double largest = 0;
        for (int j = 0; j < n_joints; j++)
            largest = fmax(largest, fabs(m->recording.move[row * n_joints + j]));
        if (row && m->recording.data->socket[row] == m->recording.data->socket[row - 1])
            scratch[moves++] = largest;
    }
    if (moves < 4) return;
    const double usual = mukca_stats_median(scratch, moves);
    for (int row = 1; row < m->recording.data->n_rows; row++) {
        double largest = 0;
        if (m->recording.data->socket[row] != m->recording.data->socket[row - 1] ||
            m->recording.data->file[row] != m->recording.data->file[row - 1])
            continue;
        for (int j = 0; j < n_joints; j++)
            largest = fmax(largest, fabs(m->recording.move[row * n_joints + j]));
        if (largest < 2e-4 && largest < 0.01 * usual)
            mukca_screening_add(faults, &m->recording, MUKCA_FAULT_DUPLICATE, row, 0);
    }
}

void mukca_screening_run(mukca_faults *faults, mukca_regression *m)
{
    double *r = MUKCA_TAKE(&m->pool, double, m->recording.data->n_rows);
    double *scratch = MUKCA_TAKE(&m->pool, double, m->recording.data->n_rows);
    double *weight = MUKCA_TAKE(&m->pool, double, m->recording.data->n_rows);
    if (!r || !scratch || !weight) return;
    duplicates(faults, m, scratch);
    mukca_regression_linearise(m);
    wrong_labels(faults, m, scratch);
    mukca_recording_regroup(&m->recording);
    if (m->recording.n_samples < 4) return;

    for (int row = 0; row < m->recording.data->n_rows; row++) weight[row] = 1;
    m->unknowns.weight = weight;
    for (int pass = 0; pass < 12; pass++) { /* iteratively reweighted, heavy-tailed loss */
        mukca_regression_fit(m, 1, pass ? MUKCA_FIT_UNKNOWNS : MUKCA_FIT_NOISE);
        residuals(r, m);
        memcpy(scratch, r, sizeof *r * (size_t)m->recording.n_samples);
        const double c = fmax(3 * mukca_stats_median(scratch, m->recording.n_samples), 3e-4);
        double change = 0;
        for (int i = 0; i < m->recording.n_samples; i++) {
            const double w = 1 / sqrt(1 + (r[i] / c) * (r[i] / c));
            change = fmax(change, fabs(w - weight[m->recording.order[i]]));
            weight[m->recording.order[i]] = w;
        }
        if (change < 1e-3) break;
    }
    m->unknowns.weight = NULL;
    wild_rows(faults, m, r, scratch);
    mukca_recording_regroup(&m->recording);
}

int mukca_screening_reinstate(mukca_faults *faults, mukca_regression *m)
{
    int back = 0;
    for (int f = 0; f < faults->count; f++) {
        mukca_data_fault *fault = &faults->list[f];
        const bool cut =
            fault->kind == MUKCA_FAULT_OUTLIER || fault->kind == MUKCA_FAULT_WRONG_SOCKET;
        if (!cut || fault->socket < 0 || m->recording.keep[fault->data_row]) continue;
        double p[3], centre[3] = {0, 0, 0};
        int n = 0;
        mukca_unknowns_predict(p, &m->unknowns, &m->recording, fault->data_row);
        for (int i = 0; i < m->recording.n_samples; i++)
            if (m->recording.data->socket[m->recording.order[i]] == fault->socket) {
                for (int c = 0; c < 3; c++) centre[c] += m->linear.tip[3 * i + c];
                n++;
            }
        for (int c = 0; c < 3; c++) centre[c] /= n ? n : 1;
        const double r = distance3(p, centre);
        if (n && r < fmax(8 * m->unknowns.sigma, 0.25 * fault->size_m)) {
            m->recording.keep[fault->data_row] = 1;
            *fault = faults->list[--faults->count];
            f--, back++;
        } else {
            fault->size_m = r;
        }
    }
    if (back) mukca_recording_regroup(&m->recording);
    return back;
}
