/* The mathematics under the diagnosis: columns against differences of predictions, projected
 * evidence against evidence with the columns really added, the ripple scan against single fits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "diagnose/folds.h"
#include "diagnose/noise.h"
#include "diagnose/ripple_scan.h"
#include "diagnose/scales.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"
#include "diagnose/unlisted.h"
#include "math/dense.h"
#include "scene.h"

typedef struct {
    scene s;
    mukca_dataset data;
    mukca_regression m;
    mukca_candidates all;
    mukca_pool pool;
    mukca_projector projector;
} fixture;

static int set_up(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    mukca_error error = {0};
    const mukca_recording_options options = {.mass_spread = 0.1, .distance_sigma = 1e-4};
    assert_non_null(f);
    set_scene(&f->s, "joint_compliance:joint_2=1e-4", 7);
    f->s.how.noise = 1e-4;
    record(&f->data, &f->s);
    assert_int_equal(mukca_regression_create(&f->m, &f->s.chain, &f->data, &options, &error),
                     MUKCA_OK);
    mukca_regression_fit(&f->m, 5, MUKCA_FIT_ALL);
    assert_int_equal(
        mukca_candidates_list(&f->all, &f->m.pool, &f->m.recording, &f->m.unknowns, NULL, &error),
        MUKCA_OK);
    for (int i = f->all.first_unlisted; i < f->all.count; i++) /* a scan prepares these */
        assert_true(mukca_candidate_prepare(&f->all.list[i], &f->m.pool, &f->m.recording));
    assert_true(mukca_projector_create(&f->projector, &f->pool, &f->m));
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    mukca_regression_free(&f->m);
    mukca_dataset_free(&f->data);
    mukca_pool_free(&f->pool);
    free(f);
    return 0;
}

/* First hypothesis of that kind, effect and joint. */
static const mukca_candidate *find(const fixture *f, mukca_candidate_kind kind, int effect,
                                   int joint)
{
    for (int i = 0; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        if (h->kind == kind && h->joint == joint &&
            (kind != MUKCA_CANDIDATE_EFFECT || (int)h->effect.kind == effect))
            return h;
    }
    fail_msg("no such candidate");
    return NULL;
}

/* Columns of every effect that acts on the arm against differences of the forward model. */
static void effect_columns(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    int checked = 0;
    for (int i = 0; i < f->all.first_unlisted; i += 7) {
        const mukca_candidate *h = &f->all.list[i];
        if (!h->basis || h->kind == MUKCA_CANDIDATE_STRETCH) continue;
        double *E = calloc((size_t)(3 * m->recording.n_samples * h->terms), sizeof *E);
        assert_non_null(E);
        mukca_linearisation_columns(E, h->terms, &m->linear, &m->recording, h);
        assert_true(mukca_unknowns_add(&m->unknowns, h));
        mukca_accepted *cause = &m->unknowns.cause[m->unknowns.n_causes - 1];
        for (int t = 0; t < h->terms; t++)
            for (int row = 0; row < m->recording.n_samples; row += 61) {
                double up[3], down[3];
                const double step = 1e-6 * h->unit[t];
                cause->coefficient[t] = step;
                mukca_unknowns_predict(up, &m->unknowns, &m->recording, m->recording.order[row]);
                cause->coefficient[t] = -step;
                mukca_unknowns_predict(down, &m->unknowns, &m->recording, m->recording.order[row]);
                cause->coefficient[t] = 0;
                for (int c = 0; c < 3; c++) {
                    const double slope = (up[c] - down[c]) / (2 * step);
                    assert_close(E[(3 * row + c) * h->terms + t], slope, 8e-3 * (1 + fabs(slope)));
                }
            }
        mukca_unknowns_drop(&m->unknowns, m->unknowns.n_causes - 1);
        free(E);
        checked++;
    }
    assert_true(checked > 50);
}

/* log evidence with a block of columns minus that without, from G and g alone. */
static double gain(double *G, const double *g, int k, double scale, const double *unit)
{
    double A[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], x[MUKCA_MAX_COLUMNS], value = 0;
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++)
            A[i * k + j] = scale * scale * G[i * k + j] / (unit[i] * unit[j]) + (i == j);
        x[i] = scale * g[i] / unit[i];
    }
    assert_int_equal(mukca_dense_cholesky(A, k), 0);
    mukca_dense_forward(x, 1, A, k);
    for (int i = 0; i < k; i++) value += 0.5 * x[i] * x[i] - log(A[i * k + i]);
    return value;
}

/* The projected equations of one candidate give the same gain as adding its columns. */
static void projected_evidence(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_projector *p = &f->projector;
    const struct {
        mukca_candidate_kind kind;
        int effect, joint;
    } pick[] = {{MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, 1},
                {MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_LINK_BENDING, 2},
                {MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_AXIS_WOBBLE, 3},
                {MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_BASE_COMPLIANCE, -1},
                {MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_READBACK_LAG, -1},
                {MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_BALL_SHIFT, -1},
                {MUKCA_CANDIDATE_DISTANCE, MUKCA_EFFECT_SOCKET_DISTANCE, -1},
                {MUKCA_CANDIDATE_STEP, MUKCA_EFFECT_TOOL_MOTION, -1},
                {MUKCA_CANDIDATE_OWN_ANGLE, 0, 4},
                {MUKCA_CANDIDATE_OTHER_ANGLE, 0, 4},
                {MUKCA_CANDIDATE_ANGLE_PRODUCT, 0, 4},
                {MUKCA_CANDIDATE_TIME, 0, 4},
                {MUKCA_CANDIDATE_SLIP, 0, 4},
                {MUKCA_CANDIDATE_STRETCH, 0, 3}};
    for (int r = 0; r < MUKCA_RHOS; r++)
        for (size_t i = 0; i < sizeof pick / sizeof *pick; i++) {
            const mukca_candidate *h = find(f, pick[i].kind, pick[i].effect, pick[i].joint);
            const double sigma = 0.9e-4, scale = 1e-3;
            double G[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], g[MUKCA_MAX_COLUMNS];
            mukca_regression_linearise(m);
            mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
            mukca_regression_collect(m, r);
            const double without =
                mukca_evidence_evaluate(&m->evidence, &m->evidence.normal[r], sigma, NULL);
            mukca_projector_aim(p, &m->evidence.normal[r], sigma);
            mukca_linearisation_columns(p->scratch.E, h->terms, &m->linear, &m->recording, h);
            mukca_projector_project(G, g, p, h->terms, h);
            const double predicted = gain(G, g, h->terms, scale, h->unit);

            assert_true(mukca_unknowns_add(&m->unknowns, h));
            m->unknowns.cause[m->unknowns.n_causes - 1].scale = scale;
            mukca_regression_linearise(m);
            mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
            mukca_regression_collect(m, r);
            const double with =
                mukca_evidence_evaluate(&m->evidence, &m->evidence.normal[r], sigma, NULL);
            mukca_unknowns_drop(&m->unknowns, m->unknowns.n_causes - 1);
            assert_close(predicted, with - without, 1e-6 * (1 + fabs(with - without)));
        }
    mukca_regression_linearise(m);
}

/* Log Bayes factor of a candidate from its columns. */
static double score_columns(mukca_projector *p, const mukca_candidate *h)
{
    double G[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], g[MUKCA_MAX_COLUMNS];
    mukca_linearisation_columns(p->scratch.E, h->terms, &p->m->linear, &p->m->recording, h);
    mukca_projector_project(G, g, p, h->terms, h);
    return mukca_bayes_factor_average(G, g, h, p->residual, p->normal->dof, NULL);
}

/* A fault scores the same from the rows of all samples and from its columns. */
static void faults(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_projector *p = &f->projector;
    int n[3] = {0};
    mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
    for (int i = 0; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        const int kind = h->kind == MUKCA_CANDIDATE_STEP    ? 0
                         : h->kind == MUKCA_CANDIDATE_CREEP ? 1
                                                            : 2;
        if (!mukca_candidate_is_fault(h) || n[kind]++ % 7) continue;
        mukca_regression_collect(m, i % MUKCA_RHOS);
        mukca_projector_aim(p, &m->evidence.normal[i % MUKCA_RHOS], m->unknowns.sigma);
        const double columns = score_columns(p, h);
        mukca_projector_rows(p);
        assert_close(mukca_projector_fault(p, h, NULL), columns, 1e-7 * (1 + fabs(columns)));
    }
    assert_true(n[0] > 20 && n[1] > 5 && n[2] > 20);
    /* one after the other, forwards and back: what is kept from step to step is of this socket */
    mukca_projector_rows(p);
    for (int k = 0; k < 2 * f->all.count; k++) {
        const int i = k < f->all.count ? k : 2 * f->all.count - 1 - k;
        const mukca_candidate *h = &f->all.list[i];
        if (h->kind != MUKCA_CANDIDATE_STEP) continue;
        const double score = mukca_projector_fault(p, h, NULL);
        if (i % 11) continue;
        const double columns = score_columns(p, h);
        assert_close(score, columns, 1e-7 * (1 + fabs(columns)));
        n[0]++;
    }
    assert_true(n[0] > 60);
}

/* The evidence at the chosen noise is that of a factorisation, and no other noise has more. */
static void noise(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
    for (int r = 0; r < MUKCA_RHOS; r++) {
        double value, again;
        mukca_normal_equations *normal = mukca_regression_collect(m, r);
        const double sigma =
            mukca_noise_choose(&m->evidence, normal, NULL, m->unknowns.sigma, &value);
        assert_true(normal->reduced);
        assert_close(mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL), value,
                     1e-8 * fabs(value));
        for (int i = -1; i < 2; i += 2)
            assert_true(mukca_evidence_evaluate(&m->evidence, normal, sigma * (1 + 0.02 * i),
                                                NULL) < value);
        /* what was kept is not of other priors */
        for (int i = 0; i < normal->n; i++) m->evidence.prior[i] *= 0.5;
        mukca_noise_choose(&m->evidence, normal, NULL, m->unknowns.sigma, &again);
        for (int i = 0; i < normal->n; i++) m->evidence.prior[i] *= 2;
        assert_true(fabs(again - value) > 1e-3);
        /* far from the guess: by factorisations */
        assert_close(mukca_noise_choose(&m->evidence, normal, NULL, 50 * sigma, NULL), sigma,
                     0.01 * sigma);
    }
}

/* Noise and evidence without some columns are those with priors of width 0. */
static void noise_without(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    const mukca_left_out out[] = {{12, 3, 10}, {10, 1, 10}, {17, 6, 10}, {19, 2, 15}};
    mukca_normal_equations *normal = mukca_regression_collect(m, 1);
    for (size_t i = 0; i < sizeof out / sizeof *out; i++) {
        double value, expected;
        mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
        const double sigma =
            mukca_noise_choose(&m->evidence, normal, &out[i], m->unknowns.sigma, &value);
        assert_true(normal->reduced && normal->units <= out[i].from);
        memset(m->evidence.prior + out[i].column, 0,
               sizeof *m->evidence.prior * (size_t)out[i].count);
        assert_close(mukca_evidence_evaluate(&m->evidence, normal, sigma, NULL), value,
                     1e-7 * fabs(value));
        assert_close(mukca_noise_choose(&m->evidence, normal, NULL, m->unknowns.sigma, &expected),
                     sigma, 1e-4 * sigma);
        assert_close(expected, value, 1e-7 * fabs(value));
    }
    mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
    assert_true(normal->n > 22);
}

/* A scan that finds the scores of promising orders alone finds the best ones of all. */
static void check_screening(mukca_projector *p, double *all, int joint)
{
    double some[MUKCA_RIPPLE_ORDERS + 1];
    mukca_pool pool = {0};
    mukca_products x;
    assert_true(mukca_products_create(&x, &pool, p->m, 2 * MUKCA_RIPPLE_PROMISING, 2));
    mukca_ripple_scan(some, p, &x, joint);
    mukca_pool_free(&pool);
    for (int kept = 0; kept < MUKCA_RIPPLE_KEPT; kept++) {
        int best = 2;
        for (int order = 2; order <= MUKCA_RIPPLE_ORDERS; order++)
            if (all[order] + mukca_ripple_log_prior(order) >
                all[best] + mukca_ripple_log_prior(best))
                best = order;
        assert_close(some[best], all[best], 1e-9 * (1 + fabs(all[best])));
        all[best] = -HUGE_VAL;
    }
}

/* The scan of all orders scores each as a fit of that order alone does. */
static void harmonics(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_projector *p = &f->projector;
    double value[MUKCA_RIPPLE_ORDERS + 1];
    mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
    for (int r = 0; r < MUKCA_RHOS; r++)
        for (int joint = 1; joint < 7; joint += 2) {
            mukca_products x;
            mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                                 .joint = joint,
                                 .placement = -1,
                                 .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                            .joint = joint,
                                            .placement = -1,
                                            .variant.order = 2}};
            assert_true(mukca_products_create(&x, &f->pool, m, MUKCA_RIPPLE_COLUMNS, 2));
            assert_true(mukca_candidate_prepare(&h, &m->pool, &m->recording));
            mukca_regression_collect(m, r);
            mukca_projector_aim(p, &m->evidence.normal[r], m->unknowns.sigma);
            mukca_ripple_scan(value, p, &x, joint);
            for (int order = 2; order <= MUKCA_RIPPLE_ORDERS; order += 57) {
                h.effect.variant.order = order;
                assert_true(mukca_candidate_prepare(&h, &m->pool, &m->recording));
                assert_close(value[order], score_columns(p, &h), 1e-4);
            }
            check_screening(p, value, joint);
        }
}

/* Hold columns of other causes until the columns held need a wider stride. */
static void widen_columns(mukca_regression *m, const mukca_product_item *item, int n)
{
    const int stride = m->linear.stride;
    for (int i = 0; i < n && m->linear.stride == stride; i++) {
        assert_true(mukca_unknowns_add(&m->unknowns, item[i].candidate));
        mukca_regression_return(m);
        mukca_unknowns_drop(&m->unknowns, 0);
    }
    assert_true(m->linear.stride > stride);
}

/* Scores of all candidates in one batch, after other causes and then a fault joined the columns
 * held, are those of their columns one by one. */
static void held_products(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_projector *p = &f->projector;
    enum { MOST = 60 };
    const mukca_candidate *cause =
        find(f, MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, 1);
    const mukca_candidate *fault = find(f, MUKCA_CANDIDATE_STEP, 0, -1);
    mukca_products x[MOST] = {0};
    mukca_product_item item[MOST];
    mukca_scored scored[MOST];
    double value[MOST], information[MOST];
    int n = 0;
    for (int i = 0; i < f->all.count && n < MOST; i += 1 + f->all.first_unlisted / MOST) {
        const mukca_candidate *h = &f->all.list[i];
        const int joint = mukca_candidate_turns_joint(h) ? h->joint : -1;
        if (h->kind == MUKCA_CANDIDATE_DISTANCE) continue;
        item[n] = (mukca_product_item){h, joint, &x[n]};
        scored[n] = (mukca_scored){&x[n], h, &value[n], &information[n]};
        n++;
    }
    assert_true(n > 20);
    mukca_regression_freeze(m);
    const unsigned version = m->linear.version;
    for (int with = 0; with < 3; with++) {
        if (with == 2) assert_true(mukca_unknowns_add(&m->unknowns, fault));
        if (with == 1) {
            widen_columns(m, item, n);
            assert_true(mukca_unknowns_add(&m->unknowns, cause));
        }
        mukca_regression_refit(m);
        mukca_regression_collect_own(m);
        mukca_unknowns_prior(m->evidence.prior, &m->unknowns);
        mukca_projector_aim(p, mukca_regression_collect_own(m), m->unknowns.sigma);
        for (int i = 0; i < n; i++)
            assert_true(mukca_products_reserve(&x[i], &f->pool, m, item[i].candidate->terms));
        mukca_products_update(item, with ? n : n / 2, m, p->normal, &p->scratch);
        mukca_projector_score(p, scored, with ? n : n / 2);
        for (int i = 0; i < (with ? n : n / 2); i += 5)
            assert_close(value[i], score_columns(p, item[i].candidate),
                         1e-6 * (1 + fabs(value[i])));
    }
    assert_int_equal(m->linear.version, version); /* nothing was linearised again */
    m->unknowns.n_causes = 0;
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
}

/* A cause that is fitted to frozen columns comes out as it does by Gauss-Newton steps. */
static void frozen_fit(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    const mukca_candidate *h = find(f, MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, 1);
    double coefficient[2], sigma[2], score[2], error[2];
    mukca_regression_freeze(m);
    assert_true(mukca_unknowns_add(&m->unknowns, h));
    for (int full = 0; full < 2; full++) {
        if (full)
            mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
        else
            mukca_regression_refit(m);
        coefficient[full] = m->unknowns.cause[0].coefficient[0];
        sigma[full] = m->unknowns.sigma;
        score[full] = mukca_regression_score(m);
        error[full] = mukca_linearisation_error(&m->linear, &m->recording, &m->unknowns);
    }
    assert_close(coefficient[0], coefficient[1], 1e-2 * fabs(coefficient[1]));
    assert_close(sigma[0], sigma[1], 2e-3 * sigma[1]);
    assert_close(score[0], score[1], 1);
    assert_true(error[0] < 0.1 * sigma[0]);
    assert_true(error[1] < 1e-3 * sigma[0]);
    /* far from where y was taken the columns do not hold, until it is taken there */
    for (int k = 0; k < 20; k++) m->unknowns.theta[k] += 5e-3;
    mukca_unknowns_set_geometry(&m->unknowns, m->recording.chain);
    assert_true(mukca_linearisation_error(&m->linear, &m->recording, &m->unknowns) > sigma[0]);
    mukca_unknowns_drop(&m->unknowns, 0);
    for (int k = 0; k < 20; k++) m->unknowns.theta[k] -= 5e-3;
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
}

/* Without one of two causes the columns that are there give what Gauss-Newton steps give; columns
 * of another place do not hold. */
static void revised_fit(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    double coefficient[2];
    for (int joint = 1; joint <= 2; joint++)
        assert_true(mukca_unknowns_add(
            &m->unknowns, find(f, MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, joint)));
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
    const unsigned version = m->linear.version;
    mukca_unknowns_drop(&m->unknowns, 1);
    for (int full = 0; full < 2; full++) {
        if (full)
            mukca_regression_fit(m, 5, MUKCA_FIT_UNKNOWNS);
        else
            mukca_regression_revise(m);
        coefficient[full] = m->unknowns.cause[0].coefficient[0];
        assert_true(full || m->linear.version == version);
    }
    assert_close(coefficient[0], coefficient[1], 1e-4 * fabs(coefficient[1]));
    for (int k = 0; k < 20; k++) m->unknowns.theta[k] += 5e-3;
    mukca_regression_linearise(m);
    const unsigned elsewhere = m->linear.version;
    mukca_regression_revise(m);
    assert_true(m->linear.version != elsewhere);
    assert_close(m->unknowns.cause[0].coefficient[0], coefficient[1], 1e-4 * fabs(coefficient[1]));
    mukca_unknowns_drop(&m->unknowns, 0);
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
}

/* As many causes as there is room for: their columns stay within it. */
static void full_columns(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    const int most = mukca_unknowns_capacity(&m->unknowns) + 1;
    int at = 0;
    while (at < f->all.first_unlisted && (!f->all.list[at].basis || f->all.list[at].terms < 4 ||
                                          mukca_unknowns_add(&m->unknowns, &f->all.list[at])))
        at++;
    mukca_regression_freeze(m);
    assert_true(m->linear.n_columns + 1 > most - 32);
    assert_true(m->linear.stride >= m->linear.n_columns + 1 && m->linear.stride <= most);
    assert_true(mukca_regression_solve(m));
    m->unknowns.n_causes = 0;
    mukca_regression_fit(m, 4, MUKCA_FIT_ALL);
}

/* The prior odds of all candidates and orders sum to one. */
static void priors(void **state)
{
    const fixture *f = *state;
    double orders = 0, sum = 0;
    for (int order = 2; order <= MUKCA_RIPPLE_ORDERS; order++)
        orders += exp(mukca_ripple_log_prior(order));
    assert_close(orders, 1, 1e-12);
    for (int i = 0; i < f->all.first_unlisted; i++) sum += exp(f->all.list[i].log_prior);
    assert_close(sum + 1.0 / f->all.classes, 1, 1e-9); /* the ripple's class is scanned beside */
    double samples = 0;                                /* among which a slip's is chosen */
    for (int i = 0; i < f->all.first_unlisted; i++)
        samples += f->all.list[i].kind == MUKCA_CANDIDATE_STEP;
    sum = 0;
    for (int i = f->all.first_unlisted; i < f->all.count; i++) {
        const mukca_candidate *h = &f->all.list[i];
        sum += (mukca_unlisted_at_sample(h) ? samples : 1) * exp(h->log_prior);
    }
    assert_close(sum, 1.0 / f->all.classes, 1e-9);
}

/* A row cut as an outlier comes back when it fits; that it repeats the one before is told still. */
static void reinstated(void **state)
{
    fixture *f = *state;
    enum { ROW = 5 };
    mukca_faults *d = calloc(1, sizeof *d);
    assert_non_null(d);
    mukca_screening_add(d, &f->m.recording, MUKCA_FAULT_DUPLICATE, ROW, 0);
    mukca_screening_add(d, &f->m.recording, MUKCA_FAULT_OUTLIER, ROW, 0.1);
    f->m.recording.keep[ROW] = 0;
    mukca_recording_regroup(&f->m.recording);
    mukca_regression_fit(&f->m, 1, MUKCA_FIT_UNKNOWNS);
    assert_int_equal(mukca_screening_reinstate(d, &f->m), 1);
    assert_true(f->m.recording.keep[ROW]);
    assert_int_equal(d->count, 1);
    assert_int_equal(d->list[0].kind, MUKCA_FAULT_DUPLICATE);
    free(d);
}

/* Two poses beside sockets are too few for folds of their own: they are always fitted, and so no
 * error of theirs is a left-out one. */
static void never_left_out(void **state)
{
    enum { POSES = 2 };
    const fixture *f = *state;
    const mukca_recording_options options = {.mass_spread = 0.1, .distance_sigma = 1e-4};
    mukca_dataset data;
    mukca_error error = {0};
    mukca_regression m;
    record(&data, &f->s);
    data.position = malloc(3 * sizeof *data.position * (size_t)data.n_rows);
    assert_non_null(data.position);
    for (int i = 0; i < 3 * data.n_rows; i++) data.position[i] = NAN;
    for (int row = 0; row < POSES; row++) {
        data.socket[row] = -1;
        mukca_unknowns_predict(data.position + 3 * row, &f->m.unknowns, &f->m.recording, row);
    }
    assert_int_equal(mukca_regression_create(&m, &f->s.chain, &data, &options, &error), MUKCA_OK);
    mukca_regression_fit(&m, 3, MUKCA_FIT_ALL);
    mukca_folds b = {.m = &m};
    mukca_folds_create(&b);
    assert_false(m.pool.failed);
    for (int i = 0; i < 3 * data.n_rows; i++) b.position[i] = 1; /* what came before */
    mukca_folds_run(b.error, &b, false);
    for (int row = 0; row < data.n_rows; row++)
        assert_int_equal(isfinite(b.error[row]) != 0, row >= POSES);
    mukca_regression_free(&m);
    mukca_dataset_free(&data);
}

/* The scales that are chosen by Schur complements have the largest evidence of all. */
static void scales(void **state)
{
    fixture *f = *state;
    mukca_regression *m = &f->m;
    mukca_unknowns *u = &m->unknowns;
    const mukca_candidate *h = find(f, MUKCA_CANDIDATE_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, 1);
    double scale[MUKCA_MAX_SIZES], weight[MUKCA_MAX_SIZES], worst = HUGE_VAL;
    const int n = mukca_candidate_scales(scale, weight, h);
    assert_true(mukca_unknowns_add(u, h));
    mukca_regression_fit(m, 2, MUKCA_FIT_NOISE);
    const mukca_normal_equations *normal = mukca_regression_collect_own(m);
    mukca_scales_choose(u, &m->evidence, &m->recording, normal);
    const double before = u->cause[0].scale;
    mukca_scales_choose(u, &m->evidence, &m->recording, normal);
    const double best = mukca_regression_score(m), chosen = u->cause[0].scale,
                 length = u->sigma_length, angle = u->sigma_angle;
    for (int i = 0; i < n; i++) {
        u->cause[0].scale = scale[i];
        assert_true(mukca_regression_score(m) <= best + 1e-9);
    }
    u->cause[0].scale = chosen;
    assert_true(chosen == before); /* so the geometry's were chosen with it */
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) {
            static const double angles[] = {1e-3, 2.5e-3, 5e-3, 10e-3};
            u->sigma_length = 0.5e-3 * (1 << i), u->sigma_angle = angles[k];
            mukca_unknowns_set_geometry_prior(u, &m->recording);
            const double value = mukca_regression_score(m);
            assert_true(value <= best + 1e-9);
            worst = fmin(worst, value);
        }
    assert_true(worst < best - 0.1); /* the grid makes a difference */
    u->sigma_length = length, u->sigma_angle = angle;
    mukca_unknowns_set_geometry_prior(u, &m->recording);
    mukca_unknowns_drop(u, 0);
    mukca_regression_fit(m, 5, MUKCA_FIT_ALL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(effect_columns), cmocka_unit_test(projected_evidence),
        cmocka_unit_test(faults),         cmocka_unit_test(noise),
        cmocka_unit_test(noise_without),  cmocka_unit_test(harmonics),
        cmocka_unit_test(scales),         cmocka_unit_test(held_products),
        cmocka_unit_test(frozen_fit),     cmocka_unit_test(revised_fit),
        cmocka_unit_test(priors),         cmocka_unit_test(full_columns),
        cmocka_unit_test(reinstated),     cmocka_unit_test(never_left_out)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
