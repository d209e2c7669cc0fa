/* Screening: recording faults that must be found before any fit. */
#include "diagnose/screening.h"

#include <math.h>
#include <string.h>

#include "math/stats.h"

void mukca_screening_add(mukca_diagnosis *d, const mukca_recording *recording,
                         mukca_fault_kind kind, int row, double size_m)
{
    const mukca_dataset *data = recording->data;
    if (d->n_faults == MUKCA_MAX_FAULTS) return;
    d->faults[d->n_faults++] = (mukca_data_fault){.kind = kind,
                                                  .placement = recording->placement[row],
                                                  .socket = data->socket[row],
                                                  .row = data->row[row],
                                                  .file = data->file[row],
                                                  .data_row = row,
                                                  .size_m = size_m};
}

/* Component-wise median of the predicted positions of each group; NULL: no memory. */
static double (*group_medians(mukca_regression *m, double *scratch))[3]
{
    double(*median)[3] = MUKCA_TAKE(&m->pool, double[3], m->recording.n_groups);
    for (int g = 0; median && g < m->recording.n_groups; g++) {
        const mukca_group *group = &m->recording.groups[g];
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < group->count; i++)
                scratch[i] = m->linear.tip[3 * (group->start + i) + c];
            median[g][c] = mukca_stats_median(scratch, group->count);
        }
    }
    return median;
}

/* Distance of sample i of group g from the nearest other socket of its placement. */
static double nearest_other(const mukca_regression *m, double (*median)[3], int g, int i)
{
    const mukca_group *groups = m->recording.groups;
    double nearest = HUGE_VAL;
    for (int o = 0; o < m->recording.n_groups && groups[g].socket >= 0; o++)
        if (o != g && groups[o].count && groups[o].placement == groups[g].placement)
            nearest = fmin(nearest, mukca_distance3(m->linear.tip + 3 * i, median[o]));
    return nearest;
}

/* Report sample i and exclude it. */
static void exclude(mukca_diagnosis *d, mukca_recording *r, mukca_fault_kind kind, int i,
                    double size)
{
    mukca_screening_add(d, r, kind, r->order[i], size);
    r->keep[r->order[i]] = 0;
}

/* Wrong labels, before any fit: the own socket is more than 20 mm away (several times the error of
 * any nominal geometry), and another one of the placement at less than 0.4 of that distance. */
static void wrong_labels(mukca_diagnosis *d, mukca_regression *m, double *scratch)
{
    mukca_recording *r = &m->recording;
    double(*median)[3] = group_medians(m, scratch);
    for (int g = 0; median && g < r->n_groups; g++)
        for (int i = r->groups[g].start; i < r->groups[g].start + r->groups[g].count; i++) {
            const double distance = mukca_distance3(m->linear.tip + 3 * i, median[g]);
            if (distance > 0.02 && nearest_other(m, median, g, i) < 0.4 * distance)
                exclude(d, r, MUKCA_FAULT_WRONG_SOCKET, i, distance);
        }
}

/* residual[n_samples]: distance of each sample from its socket's median, or from its measurement;
 * the medians.  NULL: no memory. */
static double (*residuals(double *residual, mukca_regression *m, double *scratch))[3]
{
    const mukca_recording *r = &m->recording;
    double(*median)[3] = group_medians(m, scratch);
    for (int g = 0; median && g < r->n_groups; g++)
        for (int i = r->groups[g].start; i < r->groups[g].start + r->groups[g].count; i++) {
            if (r->groups[g].socket < 0)
                mukca_unknowns_to_base(median[g], &m->unknowns, r->log[r->order[i]],
                                       r->data->position + 3 * (size_t)r->order[i]);
            residual[i] = mukca_distance3(median[g], m->linear.tip + 3 * i);
        }
    return median;
}

static double median_of(const double *x, int n, double *scratch)
{
    memcpy(scratch, x, sizeof *x * (size_t)n);
    return mukca_stats_median(scratch, n);
}

/* A bad seat or a lost reflector is one sample, or two.  More of them are a model that does not fit
 * if the error of all samples exceeds any noise: no sample of the only postures in which a joint
 * moved is an outlier. */
static bool judge_outliers(mukca_diagnosis *d, mukca_recording *r)
{
    double square = 0;
    int count = 0;
    for (int f = 0; f < d->n_faults; f++) {
        if (d->faults[f].kind != MUKCA_FAULT_OUTLIER) continue;
        square += d->faults[f].size_m * d->faults[f].size_m;
        count++;
    }
    const bool fits =
        count <= 2 || square <= 3 * r->n_samples * MUKCA_MOST_SIGMA * MUKCA_MOST_SIGMA;
    for (int f = 0; f < d->n_faults && !fits; f++)
        if (d->faults[f].kind == MUKCA_FAULT_OUTLIER) r->keep[d->faults[f].data_row] = 1;
    return fits;
}

/* Outliers of a robust fit: close to another socket (wrong label), or to none (outlier). */
static void outliers(mukca_diagnosis *d, mukca_regression *m, const double *residual,
                     double (*median)[3], double *scratch)
{
    mukca_recording *r = &m->recording;
    const double usual = median_of(residual, r->n_samples, scratch);
    const double limit = fmax(12 * usual, 4e-3);
    int count = 0;
    for (int i = 0; i < r->n_samples; i++) count += residual[i] > limit;
    /* too many for outliers: an effect */
    if (count > fmax(4, 0.05 * r->n_samples)) return;
    for (int g = 0; median && g < r->n_groups; g++)
        for (int i = r->groups[g].start; i < r->groups[g].start + r->groups[g].count; i++) {
            if (!(residual[i] > limit)) continue;
            const double nearest = nearest_other(m, median, g, i);
            if (nearest < 0.2 * residual[i] && nearest < limit)
                exclude(d, r, MUKCA_FAULT_WRONG_SOCKET, i, residual[i]);
            else if (residual[i] >= fmax(20 * usual, 6e-3))
                exclude(d, r, MUKCA_FAULT_OUTLIER, i, residual[i]);
        }
}

/* Largest move of a joint from the preceding row; NAN: that row has another socket. */
static double move_in_socket(const mukca_recording *r, int row)
{
    const int n_joints = r->chain->n_joints;
    double largest = 0;
    if (row == 0 || r->data->socket[row] != r->data->socket[row - 1]) return NAN;
    const double *q = r->data->q + row * n_joints;
    for (int j = 0; j < n_joints; j++) largest = fmax(largest, fabs(q[j] - q[j - n_joints]));
    return largest;
}

/* Rows recorded twice: every angle within 0.2 mrad of the preceding row, and moves are usually
 * larger. */
static void duplicates(mukca_diagnosis *d, const mukca_recording *r, double *scratch)
{
    int moves = 0;
    if (r->repeats) return; /* by design */
    for (int row = 0; row < r->data->n_rows; row++) {
        scratch[moves] = move_in_socket(r, row);
        moves += isfinite(scratch[moves]);
    }
    if (moves < 4) return;
    const double usual = mukca_stats_median(scratch, moves);
    for (int row = 1; row < r->data->n_rows; row++) {
        const double move = move_in_socket(r, row);
        if (r->data->file[row] == r->data->file[row - 1] && move < 2e-4 && move < 0.01 * usual)
            mukca_screening_add(d, r, MUKCA_FAULT_DUPLICATE, row, 0);
    }
}

bool mukca_screening_run(mukca_diagnosis *d, mukca_regression *m)
{
    mukca_recording *r = &m->recording;
    const int rows = r->data->n_rows;
    double *residual = MUKCA_TAKE(&m->pool, double, rows);
    double *scratch = MUKCA_TAKE(&m->pool, double, rows);
    double *weight = MUKCA_TAKE(&m->pool, double, rows);
    if (!residual || !scratch || !weight) return true;
    duplicates(d, r, scratch);
    mukca_unknowns_set_geometry_prior(&m->unknowns, r);
    mukca_regression_linearise(m);
    wrong_labels(d, m, scratch);
    mukca_recording_regroup(r);
    if (r->n_samples < 4) return true;
    if (r->n_samples < rows) mukca_regression_linearise(m);

    for (int row = 0; row < rows; row++) weight[row] = 1;
    m->unknowns.weight = weight;
    double(*median)[3] = NULL;
    for (int pass = 0; pass < 12; pass++) { /* iteratively reweighted, heavy-tailed loss */
        mukca_regression_step(m, pass ? MUKCA_FIT_UNKNOWNS : MUKCA_FIT_INDEPENDENT);
        median = residuals(residual, m, scratch);
        const double scale = fmax(3 * median_of(residual, r->n_samples, scratch), 3e-4);
        double change = 0;
        for (int i = 0; i < r->n_samples; i++) {
            const double x = residual[i] / scale, w = 1 / sqrt(1 + x * x);
            change = fmax(change, fabs(w - weight[r->order[i]]));
            weight[r->order[i]] = w;
        }
        if (change < 1e-3) break;
    }
    m->unknowns.weight = NULL;
    outliers(d, m, residual, median, scratch);
    const bool fits = judge_outliers(d, r);
    mukca_recording_regroup(r);
    return fits;
}

int mukca_screening_reinstate(mukca_diagnosis *d, mukca_regression *m)
{
    mukca_recording *r = &m->recording;
    int back = 0;
    for (int f = 0; f < d->n_faults; f++) {
        mukca_data_fault *fault = &d->faults[f];
        const bool was_cut =
            fault->kind == MUKCA_FAULT_OUTLIER || fault->kind == MUKCA_FAULT_WRONG_SOCKET;
        if (!was_cut || fault->socket < 0 || r->keep[fault->data_row]) continue;
        const int g = fault->socket + (r->groups[0].socket < 0); /* behind a pose log */
        double p[3];
        mukca_unknowns_predict(p, &m->unknowns, r, fault->data_row);
        const double distance = mukca_distance3(p, m->linear.mean[g]);
        if (r->groups[g].count && distance < fmax(8 * m->unknowns.sigma, 0.25 * fault->size_m)) {
            r->keep[fault->data_row] = 1;
            *fault = d->faults[--d->n_faults];
            f--, back++;
        } else {
            fault->size_m = distance;
        }
    }
    if (back) mukca_recording_regroup(r);
    return back;
}
