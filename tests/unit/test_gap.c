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
#include "diagnose/projector.h"
#include "diagnose/ripple.h"
#include "diagnose/scan.h"
#include "diagnose/screening.h"
#include "math/dense.h"
#include "scene.h"

typedef struct {
    scene s;
    mukca_dataset data;
    gap_model m;
    gap_hypotheses all;
    double *memory;
} fixture;

static int set_up(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    mukca_error error = {0};
    const gap_options options = {.mass_spread = 0.1, .distance_sigma = 1e-4};
    assert_non_null(f);
    set_scene(&f->s, "joint_compliance:joint_2=1e-4", 7);
    f->s.how.noise = 1e-4;
    record(&f->data, &f->s);
    assert_int_equal(gap_model_create(&f->m, &f->s.chain, &f->data, &options, &error), MUKCA_OK);
    gap_model_fit(&f->m, 5, GAP_FREE);
    assert_int_equal(gap_hypotheses_list(&f->all, &f->m.pool, &f->m, NULL, &error), MUKCA_OK);
    f->memory = malloc(sizeof *f->memory * (gap_projector_size(&f->m) + gap_joint_view_size(&f->m) +
                                            6 * GAP_MAX_TERMS * (size_t)(f->m.n_groups + 1)));
    assert_non_null(f->memory);
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    gap_model_free(&f->m);
    mukca_dataset_free(&f->data);
    free(f->memory);
    free(f);
    return 0;
}

/* First hypothesis of that kind, effect and joint. */
static const gap_hypothesis *find(const fixture *f, gap_kind kind, int effect, int joint)
{
    for (int i = 0; i < f->all.count; i++) {
        const gap_hypothesis *h = &f->all.list[i];
        if (h->kind == kind && h->effect.joint == joint &&
            (kind != GAP_EFFECT || (int)h->effect.kind == effect))
            return h;
    }
    fail_msg("no such candidate");
    return NULL;
}

/* Each geometry column is the derivative of the prediction at the seated angles; noise of 0.1 mm
 * over half a metre leaves 1e-3 between those and the recorded ones. */
static void geometry_columns(void **state)
{
    fixture *f = *state;
    gap_model *m = &f->m;
    const int size = m->n_columns + 1;
    const double h = 1e-6;
    for (int k = 0; k < m->n_geometry; k++)
        for (int i = 0; i < m->n; i += 37) {
            double up[3], down[3];
            const double was = m->theta[k];
            m->theta[k] = was + h;
            gap_model_set_geometry(m);
            gap_model_predict(up, m, m->order[i]);
            m->theta[k] = was - h;
            gap_model_set_geometry(m);
            gap_model_predict(down, m, m->order[i]);
            m->theta[k] = was;
            for (int c = 0; c < 3; c++)
                assert_close(m->columns[(3 * i + c) * size + k], (up[c] - down[c]) / (2 * h), 8e-3);
        }
    gap_model_set_geometry(m);
}

/* Columns of every effect that acts on the arm against differences of the forward model. */
static void effect_columns(void **state)
{
    fixture *f = *state;
    gap_model *m = &f->m;
    int checked = 0;
    for (int i = 0; i < f->all.count; i += 7) {
        const gap_hypothesis *h = &f->all.list[i];
        if (!h->basis || h->kind == GAP_STRETCH) continue;
        double *E = calloc((size_t)(3 * m->n * h->terms), sizeof *E);
        assert_non_null(E);
        gap_hypothesis_columns(E, h->terms, m, h);
        assert_true(gap_model_add(m, h));
        gap_cause *cause = &m->cause[m->n_causes - 1];
        for (int t = 0; t < h->terms; t++)
            for (int row = 0; row < m->n; row += 61) {
                double up[3], down[3];
                const double step = 1e-6 * h->unit[t];
                cause->coefficient[t] = step;
                gap_model_predict(up, m, m->order[row]);
                cause->coefficient[t] = -step;
                gap_model_predict(down, m, m->order[row]);
                cause->coefficient[t] = 0;
                for (int c = 0; c < 3; c++) {
                    const double slope = (up[c] - down[c]) / (2 * step);
                    assert_close(E[(3 * row + c) * h->terms + t], slope, 8e-3 * (1 + fabs(slope)));
                }
            }
        gap_model_drop(m, m->n_causes - 1);
        free(E);
        checked++;
    }
    assert_true(checked > 50);
}

/* log evidence with a block of columns minus that without, from G and g alone. */
static double gain(double *G, const double *g, int k, double scale, const double *unit)
{
    double A[GAP_MAX_TERMS * GAP_MAX_TERMS], x[GAP_MAX_TERMS], value = 0;
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
    gap_model *m = &f->m;
    const struct {
        gap_kind kind;
        int effect, joint;
    } pick[] = {{GAP_EFFECT, MUKCA_EFFECT_JOINT_COMPLIANCE, 1},
                {GAP_EFFECT, MUKCA_EFFECT_LINK_BENDING, 2},
                {GAP_EFFECT, MUKCA_EFFECT_AXIS_WOBBLE, 3},
                {GAP_EFFECT, MUKCA_EFFECT_BASE_COMPLIANCE, -1},
                {GAP_EFFECT, MUKCA_EFFECT_READBACK_LAG, -1},
                {GAP_EFFECT, MUKCA_EFFECT_BALL_SHIFT, -1},
                {GAP_DISTANCE, MUKCA_EFFECT_SOCKET_DISTANCE, -1},
                {GAP_STEP, MUKCA_EFFECT_TOOL_MOTION, -1},
                {GAP_BUMPS, 0, 4},
                {GAP_STRETCH, 0, 3}};
    for (int r = 0; r < GAP_RHOS; r++)
        for (size_t i = 0; i < sizeof pick / sizeof *pick; i++) {
            const gap_hypothesis *h = find(f, pick[i].kind, pick[i].effect, pick[i].joint);
            const double sigma = 0.9e-4, scale = 1e-3;
            double G[GAP_MAX_TERMS * GAP_MAX_TERMS], g[GAP_MAX_TERMS];
            gap_model_linearise(m);
            gap_model_prior(m->prior, m, -1);
            gap_model_pack(&m->pack[r], m, gap_rho[r]);
            const double without = gap_model_evidence(m, &m->pack[r], m->prior, sigma, NULL);
            gap_projector p = gap_projector_lay_out(m, f->memory);
            gap_projector_aim(&p, &m->pack[r], sigma);
            gap_hypothesis_columns(p.E, h->terms, m, h);
            gap_project(G, g, &p, p.E, h->terms, h);
            const double predicted = gain(G, g, h->terms, scale, h->unit);

            assert_true(gap_model_add(m, h));
            m->cause[m->n_causes - 1].scale = scale;
            gap_model_linearise(m);
            gap_model_prior(m->prior, m, -1);
            gap_model_pack(&m->pack[r], m, gap_rho[r]);
            const double with = gap_model_evidence(m, &m->pack[r], m->prior, sigma, NULL);
            gap_model_drop(m, m->n_causes - 1);
            assert_close(predicted, with - without, 1e-6 * (1 + fabs(with - without)));
        }
    gap_model_linearise(m);
}

/* The scan of all orders scores each as a fit of that order alone does. */
static void harmonics(void **state)
{
    fixture *f = *state;
    gap_model *m = &f->m;
    double value[GAP_LAST_ORDER + 1], information;
    gap_model_prior(m->prior, m, -1);
    for (int r = 0; r < GAP_RHOS; r++)
        for (int joint = 1; joint < 7; joint += 2) {
            gap_projector p = gap_projector_lay_out(m, f->memory);
            double *view_memory = f->memory + gap_projector_size(m);
            double *mean = view_memory + gap_joint_view_size(m);
            gap_model_pack(&m->pack[r], m, gap_rho[r]);
            gap_projector_aim(&p, &m->pack[r], m->sigma);
            const gap_joint_view view = gap_joint_view_aim(&p, joint, view_memory);
            gap_harmonic_scan(value, &view, mean, p.white);
            for (int order = 2; order <= GAP_LAST_ORDER; order += 57) {
                gap_hypothesis h = {.kind = GAP_EFFECT,
                                    .effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                               .joint = joint,
                                               .placement = -1,
                                               .variant = order}};
                assert_true(gap_hypothesis_prepare(&h, &m->pool, m));
                assert_close(value[order], gap_field_log_bayes(&p, &h, &information), 1e-4);
            }
        }
}

/* The prior odds of all candidates and orders sum to one. */
static void priors(void **state)
{
    const fixture *f = *state;
    double orders = 0, sum = 0;
    for (int order = 2; order <= GAP_LAST_ORDER; order++) orders += exp(gap_order_log_prior(order));
    assert_close(orders, 1, 1e-12);
    for (int i = 0; i < f->all.count; i++) sum += exp(f->all.list[i].log_prior);
    assert_close(sum + 1.0 / f->all.classes, 1, 1e-9); /* the ripple's class is scanned beside */
}

/* A row cut as an outlier comes back when it fits; that it repeats the one before is told still. */
static void reinstated(void **state)
{
    fixture *f = *state;
    enum { ROW = 5 };
    mukca_diagnosis *d = calloc(1, sizeof *d);
    assert_non_null(d);
    gap_fault_add(d, &f->m, MUKCA_FAULT_DUPLICATE, ROW, 0);
    gap_fault_add(d, &f->m, MUKCA_FAULT_OUTLIER, ROW, 0.1);
    f->m.keep[ROW] = 0;
    gap_model_regroup(&f->m);
    gap_model_fit(&f->m, 1, GAP_FIXED);
    assert_int_equal(gap_reinstate(d, &f->m), 1);
    assert_true(f->m.keep[ROW]);
    assert_int_equal(d->n_faults, 1);
    assert_int_equal(d->faults[0].kind, MUKCA_FAULT_DUPLICATE);
    free(d);
}

/* Two poses beside sockets are too few for folds of their own: they are always fitted, and so no
 * error of theirs is a left-out one. */
static void never_left_out(void **state)
{
    enum { POSES = 2 };
    const fixture *f = *state;
    const unsigned char use[GAP_MAX_CAUSES] = {0};
    const gap_options options = {.mass_spread = 0.1, .distance_sigma = 1e-4};
    mukca_dataset data;
    mukca_error error = {0};
    gap_model m;
    record(&data, &f->s);
    data.position = malloc(3 * sizeof *data.position * (size_t)data.n_rows);
    assert_non_null(data.position);
    for (int i = 0; i < 3 * data.n_rows; i++) data.position[i] = NAN;
    for (int row = 0; row < POSES; row++) {
        data.socket[row] = -1;
        gap_model_predict(data.position + 3 * row, &f->m, row);
    }
    assert_int_equal(gap_model_create(&m, &f->s.chain, &data, &options, &error), MUKCA_OK);
    gap_model_fit(&m, 3, GAP_FREE);
    gap_left_out b = {.m = &m};
    gap_left_out_take(&b);
    assert_false(m.pool.failed);
    for (int i = 0; i < 3 * data.n_rows; i++) b.position[i] = 1; /* what came before */
    gap_left_out_run(b.error, &b, gap_left_out_pack(&m), use, false);
    for (int row = 0; row < data.n_rows; row++)
        assert_int_equal(isfinite(b.error[row]) != 0, row >= POSES);
    gap_model_free(&m);
    mukca_dataset_free(&data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(geometry_columns),
                                       cmocka_unit_test(effect_columns),
                                       cmocka_unit_test(projected_evidence),
                                       cmocka_unit_test(harmonics),
                                       cmocka_unit_test(priors),
                                       cmocka_unit_test(reinstated),
                                       cmocka_unit_test(never_left_out)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
