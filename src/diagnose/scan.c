/* Score every candidate cause against the present model. */
#include "diagnose/scan.h"

#include <math.h>
#include <string.h>

#include "diagnose/projector.h"
#include "diagnose/ripple.h"
#include "math/dense.h"

const gap_hypothesis *gap_scan_hypothesis(const gap_scan *scan, int index)
{
    return index < scan->all->count ? &scan->all->list[index]
                                    : &scan->harmonic[index - scan->all->count];
}

/* The best orders of each joint join the candidates. */
static void pick_harmonics(gap_scan *scan, const gap_joint_view *view, double *mean)
{
    const gap_model *m = view->p->m;
    const int n_joints = m->chain->n_joints, j = view->joint;
    double value[GAP_LAST_ORDER + 1], lo = HUGE_VAL, hi = -HUGE_VAL;
    const mukca_element *element = &m->chain->element[m->chain->joint_element[j]];
    for (int i = 0; i < m->n; i++) {
        lo = fmin(lo, m->data->q[m->order[i] * n_joints + j]);
        hi = fmax(hi, m->data->q[m->order[i] * n_joints + j]);
    }
    if (element->type == MUKCA_PRISMATIC || hi - lo < 1e-2) return;
    gap_harmonic_scan(value, view, mean, view->p->white);
    for (int order = 2; order <= GAP_LAST_ORDER; order++)
        value[order] += gap_order_log_prior(order);
    for (int k = 0; k < GAP_HARMONICS_KEPT; k++) {
        int best = 2, known = 0, of_joint = 0;
        for (int order = 3; order <= GAP_LAST_ORDER; order++)
            if (value[order] > value[best]) best = order;
        for (int i = 0; i < scan->n_harmonic; i++) {
            const mukca_effect *e = &scan->harmonic[i].effect;
            known |= e->joint == j && e->variant == best;
            of_joint += e->joint == j;
        }
        value[best] = -HUGE_VAL;
        if (known || of_joint == GAP_HARMONICS_MOST) continue;
        gap_hypothesis *h = &scan->harmonic[scan->n_harmonic];
        *h = (gap_hypothesis){
            .kind = GAP_EFFECT,
            .effect = {
                .kind = MUKCA_EFFECT_GEAR_HARMONIC, .joint = j, .placement = -1, .variant = best}};
        if (!gap_hypothesis_prepare(h, &scan->pool, m)) continue;
        h->log_prior = gap_order_log_prior(best) - log(n_joints) - log(scan->all->classes);
        scan->n_harmonic++;
    }
}

static bool turns_joint(const gap_hypothesis *h)
{
    return h->basis && h->width == 1 &&
           (h->kind == GAP_BUMPS ||
            (h->kind == GAP_EFFECT && mukca_effect_table[h->effect.kind].site == MUKCA_SITE_ANGLE));
}

/* Score those functions of one joint's angle that `wanted` marks, several in one product. */
static void score_angles(double *value, double *information, gap_scan *scan,
                         const gap_joint_view *view, const unsigned char *wanted, double *mean)
{
    const gap_projector *p = view->p;
    const gap_model *m = p->m;
    double G[GAP_MAX_TERMS * GAP_MAX_TERMS], g[2 * GAP_MAX_TERMS];
    int batch[2 * GAP_MAX_TERMS], at[2 * GAP_MAX_TERMS], n = 0, width = 0;
    for (int k = 0; k <= scan->n_scores; k++) {
        const gap_hypothesis *h = k < scan->n_scores ? gap_scan_hypothesis(scan, k) : NULL;
        if (h && (!wanted[k] || !turns_joint(h) || h->effect.joint != view->joint)) continue;
        if (n && (!h || width + h->terms > 2 * GAP_MAX_TERMS)) {
            for (int b = 0; b < n; b++) {
                const gap_hypothesis *x = gap_scan_hypothesis(scan, batch[b]);
                for (int i = 0; i < m->n; i++) {
                    const float *basis = x->basis + (size_t)m->order[i] * (size_t)x->terms;
                    double *f = view->F + (size_t)i * (size_t)width + at[b];
                    for (int t = 0; t < x->terms; t++) f[t] = (double)basis[t];
                }
            }
            gap_joint_view_project(g, mean, view, width);
            for (int b = 0; b < n; b++) {
                const gap_hypothesis *x = gap_scan_hypothesis(scan, batch[b]);
                gap_joint_view_gram(G, view, mean, width, at[b], x->terms);
                value[batch[b]] = gap_block_log_bayes(G, g + at[b], x, p->residual, p->pack->dof,
                                                      &information[batch[b]]);
            }
            n = width = 0;
        }
        if (!h) break;
        batch[n] = k, at[n++] = width;
        width += h->terms;
    }
}

/* Prior sigmas with one cause taken out: a prior of width 0 does that. */
static void leave_out(gap_model *m, int without)
{
    gap_model_prior(m->prior, m, -1);
    if (without < 0) return;
    int column = m->n_geometry;
    for (int c = 0; c < without; c++) column += m->cause[c].hypothesis.terms;
    for (int t = 0; t < m->cause[without].hypothesis.terms; t++) m->prior[column + t] = 0;
}

/* Odds that make a candidate a contender for the place of an accepted cause. */
#define NEAR_THE_FRONT (-3.0F)

/* The same effect at the same joint, placement or socket. */
static bool kin(const gap_hypothesis *a, const gap_hypothesis *b)
{
    return gap_hypothesis_class(a) == gap_hypothesis_class(b) &&
           a->effect.joint == b->effect.joint && a->effect.placement == b->effect.placement &&
           a->kind != GAP_SPIKE;
}

static bool contends(const gap_scan *scan, int index, const gap_cause *cause, int capacity)
{
    const gap_hypothesis *h = gap_scan_hypothesis(scan, index), *own = &cause->hypothesis;
    if (own->kind == GAP_SPIKE)
        return h->kind == GAP_SPIKE && h->row == own->row && h->last == own->last;
    if (kin(h, own)) return true;
    for (int step = cause->step; step < scan->steps && step < GAP_STEPS; step++)
        if (scan->seen[step * capacity + index] > NEAR_THE_FRONT) return true;
    return false;
}

/* Is a candidate worth the other AR(1) coefficients?  Its score hardly depends on them, so only
 * those near the front are averaged. */
static bool worth_averaging(double log_bayes, double log_prior, double most)
{
    return log_bayes + log_prior > -4.0 || log_bayes > fmax(0.25 * most, 4.0);
}

void gap_scan_run(gap_scan *scan, gap_model *m, int without, gap_scan_extent extent)
{
    gap_projector p = gap_projector_lay_out(m, scan->memory);
    double *view_memory = scan->memory + gap_projector_size(m);
    double *mean = view_memory + gap_joint_view_size(m);
    double value[GAP_RHOS], sigma[GAP_RHOS], most = -HUGE_VAL;
    int order[GAP_RHOS] = {0, 1, 2};
    leave_out(m, without);
    for (int i = 0; i < GAP_RHOS; i++) {
        gap_model_pack(&m->pack[i], m, gap_rho[i]);
        sigma[i] = gap_model_best_sigma(m, &m->pack[i], m->prior, &value[i]);
        if (without >= 0) { /* the noise is what the full model leaves, not what the hole adds */
            sigma[i] = fmin(sigma[i], 1.15 * m->sigma);
            value[i] = gap_model_evidence(m, &m->pack[i], m->prior, sigma[i], NULL);
        }
    }
    for (int i = 1; i < GAP_RHOS; i++) /* best rho first: the harmonics are picked there */
        if (value[i] > value[order[0]]) order[i] = order[0], order[0] = i;

    double first = -HUGE_VAL; /* evidence of the rhos averaged so far */
    const int step = scan->steps < GAP_STEPS ? scan->steps : GAP_STEPS - 1;
    const int capacity = scan->all->count + m->chain->n_joints * GAP_HARMONICS_MOST;
    memset(scan->wanted, 1, (size_t)capacity);
    scan->n_scores = scan->all->count + scan->n_harmonic;
    for (int k = 0; extent == GAP_SCAN_CONTENDERS && k < scan->n_scores; k++)
        scan->wanted[k] = contends(scan, k, &m->cause[without], capacity);
    for (int k = 0; k < scan->n_scores; k++)
        scan->score[k] = (gap_score){k, -HUGE_VAL, -HUGE_VAL, 0};
    for (int i = 0; i < GAP_RHOS; i++) {
        const int which = order[i];
        if (i && value[which] < value[order[0]] - 15 - 0.25 * fmax(most, 0)) continue;
        gap_projector_aim(&p, &m->pack[which], sigma[which]);
        if (i == 0) scan->rho = which, scan->sigma = sigma[which];
        for (int j = 0; j < m->chain->n_joints; j++) {
            const gap_joint_view view = gap_joint_view_aim(&p, j, view_memory);
            if (i == 0 && scan->all->harmonics && extent == GAP_SCAN_ALL)
                pick_harmonics(scan, &view, mean);
            scan->n_scores = scan->all->count + scan->n_harmonic;
            score_angles(scan->value, scan->information, scan, &view, scan->wanted, mean);
        }
        for (int k = 0; k < scan->n_scores; k++) {
            const gap_hypothesis *h = gap_scan_hypothesis(scan, k);
            if (!scan->wanted[k] || turns_joint(h)) continue;
            const bool fault = h->kind == GAP_STEP || h->kind == GAP_CREEP || h->kind == GAP_SPIKE;
            if (fault && (!m->groups[h->group].count || !m->keep[h->row]))
                scan->value[k] = -HUGE_VAL;
            else if (fault)
                scan->value[k] = gap_fault_log_bayes(&p, h, &scan->information[k]);
            else
                scan->value[k] = gap_field_log_bayes(&p, h, &scan->information[k]);
        }
        /* Running average over rho, weighted by the evidence of the model scanned against. */
        const double hi = fmax(first, value[which]);
        const double old_share = exp(first - hi) / (exp(first - hi) + exp(value[which] - hi));
        for (int k = 0; k < scan->n_scores; k++) {
            gap_score *score = &scan->score[k];
            if (!scan->wanted[k]) continue;
            if (i == 0) {
                *score = (gap_score){k, scan->value[k], 0, scan->information[k]};
                most = fmax(most, scan->value[k]);
            } else if (scan->value[k] > -HUGE_VAL) {
                const double a = score->log_bayes + log(fmax(old_share, 1e-300));
                const double b = scan->value[k] + log(fmax(1 - old_share, 1e-300));
                score->log_bayes = fmax(a, b) + log1p(exp(-fabs(a - b)));
            }
        }
        first = hi + log(exp(first - hi) + exp(value[which] - hi));
        for (int k = 0; i == 0 && k < scan->n_scores; k++)
            scan->wanted[k] =
                worth_averaging(scan->value[k], gap_scan_hypothesis(scan, k)->log_prior, most);
    }
    for (int k = 0; k < scan->n_scores; k++) {
        gap_score *score = &scan->score[k];
        score->log_odds = score->log_bayes + gap_scan_hypothesis(scan, k)->log_prior;
        if (without < 0) scan->seen[step * capacity + k] = (float)score->log_odds;
    }
    if (without < 0) scan->steps++;
}

/* Columns that stand for a hypothesis when two are compared: elastic ones by their sum of masses.
 */
static int own_terms(const gap_hypothesis *h)
{
    return h->kind == GAP_EFFECT && h->basis ? mukca_effect_terms(h->effect.kind, h->effect.variant)
                                             : h->terms;
}

double gap_scan_correlation(gap_scan *scan, gap_model *m, int without, const gap_hypothesis *a,
                            const gap_hypothesis *b)
{
    enum { MOST = GAP_MAX_TERMS };
    double G[MOST * MOST], g[MOST], block[3][MOST * MOST], s[MOST];
    const int k = a->terms + b->terms, ka = own_terms(a), kb = own_terms(b);
    if (k > MOST || a->kind == GAP_DISTANCE || b->kind == GAP_DISTANCE) return NAN;
    gap_projector p = gap_projector_lay_out(m, scan->memory);
    leave_out(m, without);
    gap_model_pack(&m->pack[scan->rho], m, gap_rho[scan->rho]);
    gap_projector_aim(&p, &m->pack[scan->rho], scan->sigma);
    gap_hypothesis_columns(p.E, k, m, a);
    gap_hypothesis_columns(p.E + a->terms, k, m, b);
    gap_project(G, g, &p, p.E, k, a);
    for (int i = 0; i < ka; i++)
        for (int j = 0; j < ka; j++) block[0][i * ka + j] = G[i * k + j];
    for (int i = 0; i < kb; i++)
        for (int j = 0; j < kb; j++) block[1][i * kb + j] = G[(a->terms + i) * k + a->terms + j];
    for (int i = 0; i < ka; i++) block[0][i * ka + i] *= 1 + 1e-9;
    for (int i = 0; i < kb; i++) block[1][i * kb + i] *= 1 + 1e-9;
    if (mukca_dense_cholesky(block[0], ka) || mukca_dense_cholesky(block[1], kb)) return NAN;
    for (int i = 0; i < ka; i++)
        for (int j = 0; j < kb; j++) block[2][i * kb + j] = G[i * k + a->terms + j];
    mukca_dense_forward(block[2], kb, block[0], ka);
    for (int i = 0; i < kb;
         i++) /* G as scratch: the transposed block, solved from the other side */
        for (int j = 0; j < ka; j++) G[i * ka + j] = block[2][j * kb + i];
    mukca_dense_forward(G, ka, block[1], kb);
    if (ka > kb) { /* the singular values of the transpose are the same */
        for (int i = 0; i < kb; i++)
            for (int j = 0; j < ka; j++) block[2][j * kb + i] = G[i * ka + j];
        memcpy(G, block[2], sizeof *G * (size_t)(ka * kb));
    }
    if (mukca_dense_svd(G, s, NULL, ka > kb ? ka : kb, ka > kb ? kb : ka)) return NAN;
    return fmin(s[0], 1);
}

mukca_status gap_scan_create(gap_scan *scan, gap_hypotheses *all, const gap_model *m,
                             mukca_error *error)
{
    const int harmonics = m->chain->n_joints * GAP_HARMONICS_MOST, most = all->count + harmonics;
    memset(scan, 0, sizeof *scan);
    scan->all = all;
    scan->harmonic = MUKCA_TAKE(&scan->pool, gap_hypothesis, harmonics);
    scan->score = MUKCA_TAKE(&scan->pool, gap_score, most);
    scan->seen = MUKCA_TAKE(&scan->pool, float, (size_t)most *GAP_STEPS);
    scan->wanted = MUKCA_TAKE(&scan->pool, unsigned char, most);
    scan->value = MUKCA_TAKE(&scan->pool, double, most);
    scan->information = MUKCA_TAKE(&scan->pool, double, most);
    scan->memory = MUKCA_TAKE(&scan->pool, double,
                              gap_projector_size(m) + gap_joint_view_size(m) +
                                  (size_t)(m->data->n_sockets + 1) * 6 * GAP_MAX_TERMS);
    for (int k = 0; scan->seen && k < most * GAP_STEPS; k++) scan->seen[k] = -HUGE_VALF;
    if (!scan->pool.failed) return MUKCA_OK;
    gap_scan_free(scan);
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the scan of %d candidates",
                      all->count);
}

void gap_scan_free(gap_scan *scan)
{
    mukca_pool_free(&scan->pool);
    memset(scan, 0, sizeof *scan);
}
