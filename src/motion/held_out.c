/* Torque errors on rows that were not fitted: on test runs, or on each eighth of the blocks with
 * the parameters and effects fitted to the others. */
#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "motion/findings.h"

typedef struct {
    const mukca_torques *t;
    double rows[MUKCA_MAX_JOINTS], square[MUKCA_MAX_JOINTS]; /* summed squared errors of a model */
} evaluated;

/* Errors of a fit of some columns, which end in the value, on the test runs or on the blocks;
 * without fit: of the value alone. */
static bool evaluate(evaluated *e, const mukca_torque_columns *c, bool fit, bool test)
{
    const mukca_torques *t = e->t;
    mukca_pool pool = {0};
    double *mean = MUKCA_TAKE(&pool, double, c->n), *G = MUKCA_TAKE(&pool, double, c->n * c->n);
    bool ok = !pool.failed;
    memset(e->square, 0, sizeof e->square);
    memset(e->rows, 0, sizeof e->rows);
    for (int fold = 0; fold < (test ? 1 : MUKCA_BLOCKS) && ok; fold++) {
        mukca_part_weights fitted = mukca_torques_whole, left = {{0}};
        const int part = test ? MUKCA_PART_TEST : fold;
        left.of[part] = 1;
        fitted.of[part] = test ? 0 : -1; /* of all */
        memset(mean, 0, sizeof *mean * (size_t)c->n);
        mean[c->n - 1] = -1;
        if (fit) ok = mukca_torques_fit(mean, t, c, &fitted);
        for (int j = 0; j < t->n && ok; j++) {
            memset(G, 0, sizeof *G * (size_t)(c->n * c->n));
            ok = mukca_torques_multiply(G, t, c, &left, j, false);
            e->square[j] += mukca_dense_quadratic(mean, G, c->n, c->n);
        }
        for (int j = 0; j < t->n; j++) e->rows[j] += t->part[part].rows[j];
    }
    mukca_pool_free(&pool);
    return ok;
}

static double rms(const evaluated *e, int joint)
{
    return sqrt(fmax(e->square[joint], 0) / fmax(e->rows[joint], 1));
}

/* Columns of the parameters, and of the members of the best set in the findings but `without`. */
static mukca_torque_columns columns_of(mukca_pool *pool, const mukca_motion *m,
                                       const mukca_torque_posterior *p, bool effects, int without)
{
    const mukca_torque_search *s = p->search;
    const mukca_torques *t = s->t;
    const mukca_set *set = &s->sets.set[s->set[0]];
    mukca_torque_columns c =
        mukca_torque_columns_take(pool, t->items.n_parameters + 1 + MUKCA_SET_COLUMNS);
    if (pool->failed) return c;
    mukca_torque_columns_parameters(&c, t);
    for (int i = 0; i < set->n && effects; i++) {
        const mukca_label *l = &p->label[p->label_of[set->item[i]]];
        bool in = false;
        for (int f = 0; f < m->n_findings; f++)
            in |= f != without && mukca_finding_holds(&m->finding[f].group, l);
        if (in)
            mukca_torque_columns_item(&c, t, s->kept[set->item[i]],
                                      s->question.item[set->item[i]].prior.size[set->size[i]]);
    }
    mukca_torque_columns_value(&c, t);
    return c;
}

/* What raises the held-out errors of all joints by what matters is no finding, but may be.  Neither
 * is, beside a reference, what does not reduce them by that: the parameters are those of the
 * reference, and imitate nothing that is new.  gain[n_findings]: squares, in parts of the ranges.
 */
static void demote(mukca_motion *m, const double *gain, bool reference)
{
    const double least = MUKCA_MOTION_RELEVANT * MUKCA_MOTION_RELEVANT;
    int kept = 0;
    for (int i = 0; i < m->n_findings; i++) {
        mukca_motion_finding f = m->finding[i];
        if (gain[i] >= (reference ? least : -least))
            m->finding[kept++] = f;
        else if (m->n_maybe < MUKCA_MOST_FINDINGS) {
            f.group.probability = MUKCA_FINDING_MAYBE; /* the posterior against these errors */
            m->maybe[m->n_maybe++] = f;
        }
    }
    m->n_findings = kept;
}

bool mukca_torque_held_out(mukca_motion *m, const mukca_torque_posterior *p)
{
    mukca_pool pool = {0};
    const mukca_torques *t = p->search->t;
    evaluated e = {.t = t};
    double gain[MUKCA_MOST_FINDINGS] = {0};
    mukca_torque_columns c = columns_of(&pool, m, p, false, -1);
    mukca_torque_columns value = mukca_torque_columns_take(&pool, 1);
    bool ok = !pool.failed;
    if (ok) mukca_torque_columns_value(&value, t);
    ok = ok && evaluate(&e, &value, false, t->test);
    for (int j = 0; j < t->n; j++) m->joint[j].nominal_nm = rms(&e, j);
    ok = ok && evaluate(&e, &c, true, t->test);
    for (int j = 0; j < t->n; j++) m->joint[j].baseline_nm = rms(&e, j);
    if (ok) c = columns_of(&pool, m, p, true, -1);
    ok = ok && !pool.failed && evaluate(&e, &c, true, t->test);
    for (int j = 0; j < t->n; j++) {
        m->joint[j].explained_nm = rms(&e, j);
        m->joint[j].floor_nm = t->sigma[j] / sqrt(1 - t->rho[j] * t->rho[j]);
        m->joint[j].range_nm = t->model.signals->range[j];
    }
    if (ok && t->input->view) ok = t->input->view(t->input->notes.context, t, &c);
    evaluated with = e; /* test runs change no verdict */
    if (t->test) ok = ok && evaluate(&with, &c, true, false);
    for (int i = 0; i < m->n_findings && ok; i++) {
        mukca_motion_finding *f = &m->finding[i];
        c = columns_of(&pool, m, p, true, i);
        ok = !pool.failed && evaluate(&e, &c, true, false);
        f->before_nm = rms(&e, f->worst);
        f->after_nm = rms(&with, f->worst);
        for (int j = 0; j < t->n; j++)
            if (j == f->worst || f->group.apart)
                gain[i] +=
                    (pow(rms(&e, j), 2) - pow(rms(&with, j), 2)) / pow(m->joint[j].range_nm, 2);
    }
    mukca_pool_free(&pool);
    if (ok) demote(m, gain, t->reference);
    return ok;
}
