/* Faults of a recording that must be found before anything is fitted. */
#include "diagnose/screening.h"

#include <math.h>
#include <string.h>

#include "math/stats.h"

void gap_fault_add(mukca_diagnosis *diagnosis, const gap_model *m, mukca_fault_kind kind, int row,
                   double size_m)
{
    if (diagnosis->n_faults == MUKCA_MAX_FAULTS) return;
    diagnosis->faults[diagnosis->n_faults++] =
        (mukca_data_fault){.kind = kind,
                           .placement = mukca_dataset_placement(m->data, row),
                           .socket = m->data->socket[row],
                           .row = m->data->row[row],
                           .file = m->data->file[row],
                           .data_row = row,
                           .size_m = size_m};
}

static double distance3(const double *a, const double *b)
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(mukca_dot3(d, d));
}

/* Component-wise median of the positions of a group's rows. */
static void group_median(double median[3], const gap_model *m, const gap_group *g, double *scratch)
{
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < g->count; i++) scratch[i] = m->tip[3 * (g->start + i) + c];
        median[c] = mukca_stats_median(scratch, g->count);
    }
}

/* Own socket more than 20 mm away and another one of the placement under 0.4 of that: a wrong
 * label, seen at the nominal geometry already. */
static void wrong_labels(mukca_diagnosis *diagnosis, gap_model *m, double *scratch)
{
    double(*median)[3] = MUKCA_TAKE(&m->pool, double[3], m->n_groups);
    if (!median) return;
    for (int g = 0; g < m->n_groups; g++)
        if (m->groups[g].count) group_median(median[g], m, &m->groups[g], scratch);
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        if (group->socket < 0) continue;
        for (int i = group->start; i < group->start + group->count; i++) {
            const double own = distance3(m->tip + 3 * i, median[g]);
            for (int o = 0; o < m->n_groups; o++) {
                const gap_group *other = &m->groups[o];
                if (o == g || !other->count || other->placement != group->placement) continue;
                if (own > 0.02 && distance3(m->tip + 3 * i, median[o]) < 0.4 * own) {
                    gap_fault_add(diagnosis, m, MUKCA_FAULT_WRONG_SOCKET, m->order[i], own);
                    m->keep[m->order[i]] = 0;
                    break;
                }
            }
        }
    }
}

/* Residual length of each kept row about its socket's centre (geometric median), or about its
 * measurement. */
static void residuals(double *r, const gap_model *m)
{
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        double centre[3] = {0, 0, 0};
        if (group->socket < 0) {
            for (int i = group->start; i < group->start + group->count; i++) {
                const double *measured = m->data->position + 3 * (size_t)m->order[i];
                double difference[3], in_base[3];
                for (int c = 0; c < 3; c++) difference[c] = measured[c] - m->tracker.p[c];
                mukca_mat3_tvec(in_base, m->tracker.R, difference);
                r[i] = distance3(in_base, m->tip + 3 * i);
            }
            continue;
        }
        for (int i = group->start; i < group->start + group->count; i++)
            for (int c = 0; c < 3; c++) centre[c] += m->tip[3 * i + c] / group->count;
        for (int pass = 0; pass < 6; pass++) { /* Weiszfeld */
            double sum = 0, next[3] = {0, 0, 0};
            for (int i = group->start; i < group->start + group->count; i++) {
                const double w = 1 / (distance3(m->tip + 3 * i, centre) + 1e-5);
                sum += w;
                for (int c = 0; c < 3; c++) next[c] += w * m->tip[3 * i + c];
            }
            for (int c = 0; c < 3; c++) centre[c] = next[c] / sum;
        }
        for (int i = group->start; i < group->start + group->count; i++)
            r[i] = distance3(m->tip + 3 * i, centre);
    }
}

/* Wild rows of a robust fit: at another socket (wrong label), or nowhere (outlier). */
static void wild_rows(mukca_diagnosis *diagnosis, gap_model *m, const double *r, double *scratch)
{
    memcpy(scratch, r, sizeof *r * (size_t)m->n);
    const double median = mukca_stats_median(scratch, m->n);
    const double limit = fmax(12 * median, 4e-3);
    int wild = 0;
    for (int i = 0; i < m->n; i++) wild += r[i] > limit;
    if (wild > fmax(4, 0.05 * m->n)) return; /* that many are no outliers but an effect */
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        for (int i = group->start; i < group->start + group->count; i++) {
            if (!(r[i] > limit)) continue;
            double nearest = HUGE_VAL;
            for (int o = 0; o < m->n_groups && group->socket >= 0; o++) {
                const gap_group *other = &m->groups[o];
                if (o == g || !other->count || other->placement != group->placement) continue;
                double centre[3];
                group_median(centre, m, other, scratch);
                nearest = fmin(nearest, distance3(m->tip + 3 * i, centre));
            }
            const bool wrong = nearest < 0.2 * r[i] && nearest < limit;
            if (!wrong && r[i] < fmax(20 * median, 6e-3)) continue;
            gap_fault_add(diagnosis, m, wrong ? MUKCA_FAULT_WRONG_SOCKET : MUKCA_FAULT_OUTLIER,
                          m->order[i], r[i]);
            m->keep[m->order[i]] = 0;
        }
    }
}

/* Rows recorded twice: every angle within 0.2 mrad of the row before, where moves are larger. */
static void duplicates(mukca_diagnosis *diagnosis, const gap_model *m, double *scratch)
{
    const int n_joints = m->chain->n_joints;
    int moves = 0;
    for (int row = 0; row < m->data->n_rows; row++) {
        double largest = 0;
        for (int j = 0; j < n_joints; j++)
            largest = fmax(largest, fabs(m->move[row * n_joints + j]));
        if (row && m->data->socket[row] == m->data->socket[row - 1]) scratch[moves++] = largest;
    }
    if (moves < 4) return;
    const double usual = mukca_stats_median(scratch, moves);
    for (int row = 1; row < m->data->n_rows; row++) {
        double largest = 0;
        if (m->data->socket[row] != m->data->socket[row - 1] ||
            m->data->file[row] != m->data->file[row - 1])
            continue;
        for (int j = 0; j < n_joints; j++)
            largest = fmax(largest, fabs(m->move[row * n_joints + j]));
        if (largest < 2e-4 && largest < 0.01 * usual)
            gap_fault_add(diagnosis, m, MUKCA_FAULT_DUPLICATE, row, 0);
    }
}

void gap_screen(mukca_diagnosis *diagnosis, gap_model *m)
{
    double *r = MUKCA_TAKE(&m->pool, double, m->data->n_rows);
    double *scratch = MUKCA_TAKE(&m->pool, double, m->data->n_rows);
    double *weight = MUKCA_TAKE(&m->pool, double, m->data->n_rows);
    if (!r || !scratch || !weight) return;
    duplicates(diagnosis, m, scratch);
    gap_model_linearise(m);
    wrong_labels(diagnosis, m, scratch);
    gap_model_regroup(m);
    if (m->n < 4) return;

    for (int row = 0; row < m->data->n_rows; row++) weight[row] = 1;
    m->weight = weight;
    for (int pass = 0; pass < 12; pass++) { /* iteratively reweighted, heavy-tailed loss */
        gap_model_fit(m, 1, pass ? GAP_FIXED : GAP_NOISE);
        residuals(r, m);
        memcpy(scratch, r, sizeof *r * (size_t)m->n);
        const double c = fmax(3 * mukca_stats_median(scratch, m->n), 3e-4);
        double change = 0;
        for (int i = 0; i < m->n; i++) {
            const double w = 1 / sqrt(1 + (r[i] / c) * (r[i] / c));
            change = fmax(change, fabs(w - weight[m->order[i]]));
            weight[m->order[i]] = w;
        }
        if (change < 1e-3) break;
    }
    m->weight = NULL;
    wild_rows(diagnosis, m, r, scratch);
    gap_model_regroup(m);
}

int gap_reinstate(mukca_diagnosis *diagnosis, gap_model *m)
{
    int back = 0;
    for (int f = 0; f < diagnosis->n_faults; f++) {
        mukca_data_fault *fault = &diagnosis->faults[f];
        const bool cut =
            fault->kind == MUKCA_FAULT_OUTLIER || fault->kind == MUKCA_FAULT_WRONG_SOCKET;
        if (!cut || fault->socket < 0 || m->keep[fault->data_row]) continue;
        double p[3], centre[3] = {0, 0, 0};
        int n = 0;
        gap_model_predict(p, m, fault->data_row);
        for (int i = 0; i < m->n; i++)
            if (m->data->socket[m->order[i]] == fault->socket) {
                for (int c = 0; c < 3; c++) centre[c] += m->tip[3 * i + c];
                n++;
            }
        for (int c = 0; c < 3; c++) centre[c] /= n ? n : 1;
        const double r = distance3(p, centre);
        if (n && r < fmax(8 * m->sigma, 0.25 * fault->size_m)) {
            m->keep[fault->data_row] = 1;
            *fault = diagnosis->faults[--diagnosis->n_faults];
            f--, back++;
        } else {
            fault->size_m = r;
        }
    }
    if (back) gap_model_regroup(m);
    return back;
}
