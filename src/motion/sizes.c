/* Sizes of findings: torque, coefficient, alternatives; averaged over sets. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "math/dense.h"
#include "math/stats.h"
#include "motion/findings.h"

/* Least probability of an alternative. */
#define ALTERNATIVE 0.05

enum { LABEL = 1 + MUKCA_INERTIAL }; /* mixtures of a label */

typedef struct {
    const mukca_torque_posterior *p;
    int columns; /* of the present set */
    int at[MUKCA_SET_ITEMS];
    double *V, *mean; /* covariance and mean of its columns */
    int *plain;       /* its columns in p->plain */
} measured;

static void take_set(measured *w, const mukca_set *set, double *scratch)
{
    mukca_torque_search *s = w->p->search;
    mukca_sets_mean(scratch, &s->sets, set);
    w->columns = mukca_sets_covariance(w->V, &s->sets);
    for (int m = 0, row = 0; m < set->n; m++) {
        const mukca_item *h = &s->question.item[set->item[m]];
        w->at[m] = row;
        for (int t = 0; t < h->terms; t++, row++) {
            w->mean[row] = scratch[h->at + t];
            w->plain[row] = w->p->at[set->item[m]] + t;
        }
    }
}

/* Columns of the members of a set that belong to a group.  Returns their number. */
static int columns_of(int *index, const measured *w, const mukca_set *set,
                      const mukca_finding_group *group)
{
    int count = 0;
    for (int m = 0; m < set->n; m++)
        for (int t = 0; t < w->p->search->question.item[set->item[m]].terms; t++)
            if (mukca_finding_holds(group, &w->p->label[w->p->label_of[set->item[m]]]))
                index[count++] = w->at[m] + t;
    return count;
}

double mukca_torque_square(double *slope, const mukca_torque_posterior *p, int joint,
                           const int *column, const double *mean, int n)
{
    double square = 0;
    for (int a = 0; a < n; a++) {
        double sum = 0;
        for (int b = 0; b < n; b++)
            sum += p->plain[joint][column[a] * p->columns.n + column[b]] / p->rows[joint] * mean[b];
        square += mean[a] * sum;
        if (slope) slope[a] = sum;
    }
    return fmax(square, 0);
}

/* Mean square of the torque of some columns at a joint; *variance of its root. */
static double square_at(double *variance, const measured *w, int joint, const int *index, int n)
{
    const mukca_torque_posterior *p = w->p;
    double along = 0, trace = 0, slope[MUKCA_SET_COLUMNS], mean[MUKCA_SET_COLUMNS] = {0};
    int column[MUKCA_SET_COLUMNS] = {0};
    for (int a = 0; a < n; a++) column[a] = w->plain[index[a]], mean[a] = w->mean[index[a]];
    const double square = mukca_torque_square(slope, p, joint, column, mean, n);
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            const double v = w->V[index[a] * w->columns + index[b]];
            trace += p->plain[joint][column[a] * p->columns.n + column[b]] / p->rows[joint] * v;
            along += slope[a] * slope[b] * v;
        }
    *variance = square > 0 ? along / square : trace;
    return square + trace;
}

static mukca_motion_finding *finding_at(mukca_motion *m, int i)
{
    return i < m->n_findings ? &m->finding[i] : &m->maybe[i - m->n_findings];
}

/* Joint at which the group has the largest part of the range, over all sets. */
static void find_worst(mukca_motion *motion, measured *w, double *scratch)
{
    const mukca_torque_search *s = w->p->search;
    const int n = motion->n_findings + motion->n_maybe;
    double best[2 * MUKCA_MOST_FINDINGS] = {0};
    int index[MUKCA_SET_COLUMNS];
    for (int k = 0; k < s->n_sets; k++) {
        const mukca_set *set = &s->sets.set[s->set[k]];
        if (s->weight[k] < 0.05 && k) break;
        take_set(w, set, scratch);
        for (int i = 0; i < n; i++) {
            mukca_motion_finding *f = finding_at(motion, i);
            const int of = columns_of(index, w, set, &f->group);
            for (int j = 0; j < s->t->n && of; j++) {
                double variance;
                const double part = sqrt(fmax(square_at(&variance, w, j, index, of), 0)) /
                                    s->t->model.signals->range[j] * s->weight[k];
                if (part > best[i]) best[i] = part, f->worst = j;
            }
        }
    }
}

MUKCA_FALLING(by_probability, mukca_motion_alternative, probability)

static const mukca_torque_effect *row_of(const measured *w, const mukca_set *set, int member)
{
    const mukca_torque_search *s = w->p->search;
    return &mukca_torque_table[s->t->items.row[s->kept[set->item[member]]]];
}

/* slope[columns] of the coefficient of a member in those of functions outside the catalogue of its
 * joint's motion: the part of these that the one-column effects of all sets there imitate. */
static void project(double *slope, const measured *w, const mukca_set *set, int member)
{
    const mukca_torque_posterior *p = w->p;
    const mukca_label *own = &p->label[p->label_of[set->item[member]]];
    double L[MUKCA_SET_ITEMS * MUKCA_SET_ITEMS], x[MUKCA_SET_ITEMS];
    int at[MUKCA_SET_ITEMS], n = 0, index = 0;
    for (int i = 0; i < p->search->n_kept && n < MUKCA_SET_ITEMS; i++) {
        const mukca_label *l = &p->label[p->label_of[i]];
        if (p->at[i] < 0 || l->effect < 0 || p->search->question.item[i].terms > 1) continue;
        if (l->from != own->from || l->to != own->to) continue;
        if (i == set->item[member]) index = n;
        at[n++] = p->at[i];
    }
    for (int m = 0; m < set->n; m++) {
        const mukca_label *l = &p->label[p->label_of[set->item[m]]];
        if (l->effect >= 0 || l->from != own->from || l->to != own->to ||
            row_of(w, set, m)->raw == MUKCA_RAW_BESIDE)
            continue;
        for (int a = w->at[m]; a < w->at[m] + p->search->question.item[set->item[m]].terms; a++) {
            const double *G = p->plain[own->to];
            for (int i = 0; i < n; i++) {
                x[i] = G[at[i] * p->columns.n + w->plain[a]];
                for (int k = 0; k < n; k++) L[i * n + k] = G[at[i] * p->columns.n + at[k]];
            }
            if (!mukca_dense_cholesky(L, n)) return;
            mukca_dense_forward(x, 1, L, n);
            mukca_dense_backward(x, 1, L, n);
            slope[a] = x[index];
        }
    }
}

/* Amplitude of a member: the root of its squares, of waves and vectors, else its first coefficient,
 * with its part in functions outside the catalogue. */
static void amplitude_of(double *mean, double *variance, const measured *w, const mukca_set *set,
                         int member)
{
    const mukca_torque_search *s = w->p->search;
    const mukca_torque_effect *row = row_of(w, set, member);
    const int at = w->at[member], terms = s->question.item[set->item[member]].terms;
    const bool norm = row->orders || (row->links && row->raw == MUKCA_RIGID_CENTRE);
    double slope[MUKCA_SET_COLUMNS] = {[0] = 0}, square = 0;
    for (int a = at; a < at + terms; a++) square += w->mean[a] * w->mean[a];
    for (int a = at; a < at + terms; a++)
        slope[a] = norm ? w->mean[a] / sqrt(fmax(square, 1e-300)) : a == at;
    if (row->n == 1) project(slope, w, set, member);
    *mean = 0;
    for (int a = 0; a < w->columns; a++) *mean += slope[a] * w->mean[a];
    *variance = mukca_dense_quadratic(slope, w->V, w->columns, w->columns);
}

/* Relative uncertainty of the scale of an effect's coefficient: all gains together are not
 * determined by a motion, as all masses may be larger with them; nor are all masses a load has. */
static double scale_of(const mukca_torque_posterior *p, int effect)
{
    const bool share = effect >= 0 && !strpbrk(mukca_torque_table[effect].unit, "Nk");
    if (effect == MUKCA_MOTION_LOAD_FRICTION) return MUKCA_MASS_ERROR;
    return p->search->t->input->run[0].current && !share ? MUKCA_CURRENT_GAIN : 0;
}

/* What a rigid effect adds to the parameters of its link: its columns there. */
static void add_inertial(mukca_gaussians *parameter, const measured *w, int item, int at,
                         double weight)
{
    const mukca_items *all = &w->p->search->t->items;
    const int terms = all->item[item].terms, first = all->n_parameters + 1 + all->item[item].at;
    for (int p = 0; p < MUKCA_INERTIAL; p++) {
        double slope[MUKCA_INERTIAL] = {0}, mean = 0;
        for (int a = 0; a < terms; a++)
            for (int k = all->first[first + a]; k < all->first[first + a + 1]; k++)
                if (all->term[k].joint == all->label[item].to && all->term[k].raw == p)
                    slope[a] += all->term[k].weight;
        for (int a = 0; a < terms; a++) mean += slope[a] * w->mean[at + a];
        const double *V = w->V + at * w->columns + at;
        mukca_gaussians_add(&parameter[p], mean, mukca_dense_quadratic(slope, V, w->columns, terms),
                            weight);
    }
}

/* `label`: amplitude, then the parameters of a link, of each label. */
static void add_amplitudes(mukca_gaussians *label, double *probability, const measured *w,
                           const mukca_set *set, double weight)
{
    const mukca_torque_search *s = w->p->search;
    for (int m = 0; m < set->n; m++) {
        const int of = w->p->label_of[set->item[m]], item = s->kept[set->item[m]];
        const double unit = s->t->items.unit[item], scale = scale_of(w->p, w->p->label[of].effect);
        double mean, variance;
        bool again = false;
        for (int k = 0; k < m; k++) again |= w->p->label_of[set->item[k]] == of;
        if (!again) probability[of] += weight;
        amplitude_of(&mean, &variance, w, set, m);
        mukca_gaussians_add(&label[of * LABEL], unit * mean,
                            unit * unit * (variance + scale * scale * mean * mean), weight);
        if (mukca_torque_table[s->t->items.row[item]].links)
            add_inertial(&label[of * LABEL + 1], w, item, w->at[m], weight);
    }
}

static void describe(mukca_motion_finding *f, const measured *w, const mukca_gaussians *label,
                     const double *probability)
{
    const mukca_torque_posterior *p = w->p;
    mukca_motion_alternative *all = f->alternative;
    double outside = 0, total = 0;
    for (int l = 0; l < p->n_labels; l++) {
        const mukca_label *of = &p->label[l];
        if (!mukca_finding_holds(&f->group, of)) continue;
        total += probability[l];
        if (of->effect < 0) outside += probability[l];
        if (!(probability[l] >= ALTERNATIVE)) continue;
        mukca_motion_alternative a = {
            .effect = of->effect >= 0 ? of->effect : -1,
            .from = of->from,
            .to = of->to,
            .detail = of->detail,
            .all = of->apart,
            .probability = fmin(probability[l], 1),
            .amplitude = mukca_gaussians_estimate(&label[l * LABEL], 1, false)};
        for (int i = 0; i < MUKCA_INERTIAL; i++)
            a.inertial[i] = mukca_gaussians_estimate(&label[l * LABEL + 1 + i], 1, false);
        int k = f->n_alternatives < MUKCA_MOTION_ALTERNATIVES ? f->n_alternatives++ : -1;
        if (k < 0 && all[MUKCA_MOTION_ALTERNATIVES - 1].probability < a.probability)
            k = MUKCA_MOTION_ALTERNATIVES - 1;
        if (k >= 0) all[k] = a;
        qsort(all, (size_t)f->n_alternatives, sizeof *all, by_probability);
    }
    f->outside = total > 0 ? outside / total : 0;
    f->coefficient = MUKCA_ESTIMATE_NONE;
    if (f->group.effect >= 0 && f->n_alternatives == 1) f->coefficient = all[0].amplitude;
    if (f->group.kind == MUKCA_GROUP_DETAIL)
        mukca_finding_details(f->order, &f->group, &p->posterior, probability);
}

bool mukca_torque_sizes(mukca_motion *motion, mukca_pool *pool, const mukca_torque_posterior *p)
{
    const mukca_torque_search *s = p->search;
    const int n = motion->n_findings + motion->n_maybe;
    measured w = {.p = p,
                  .V = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS *MUKCA_SET_COLUMNS),
                  .mean = MUKCA_TAKE(pool, double, MUKCA_SET_COLUMNS),
                  .plain = MUKCA_TAKE(pool, int, MUKCA_SET_COLUMNS)};
    mukca_gaussians *size = MUKCA_TAKE(pool, mukca_gaussians, n + 1),
                    *label = MUKCA_TAKE(pool, mukca_gaussians, LABEL * p->n_labels + 1);
    double *probability = MUKCA_TAKE(pool, double, p->n_labels + 1),
           *scratch = MUKCA_TAKE(pool, double, s->question.stride + 1);
    if (pool->failed) return false;
    find_worst(motion, &w, scratch);
    for (int k = 0; k < s->n_sets; k++) {
        const mukca_set *set = &s->sets.set[s->set[k]];
        int index[MUKCA_SET_COLUMNS];
        take_set(&w, set, scratch);
        add_amplitudes(label, probability, &w, set, s->weight[k]);
        for (int i = 0; i < n; i++) {
            const mukca_motion_finding *f = finding_at(motion, i);
            double variance;
            const int of = columns_of(index, &w, set, &f->group);
            if (!of) continue;
            const double square = square_at(&variance, &w, f->worst, index, of);
            mukca_gaussians_add(&size[i], sqrt(fmax(square, 0)), variance, s->weight[k]);
        }
    }
    for (int i = 0; i < n; i++) {
        mukca_motion_finding *f = finding_at(motion, i);
        f->size_nm = mukca_gaussians_estimate(&size[i], 1, true);
        f->size_percent = 100 * f->size_nm.value / s->t->model.signals->range[f->worst];
        f->share = mukca_finding_share(&f->group, &p->posterior);
        describe(f, &w, label, probability);
    }
    return true;
}
