/* One more arm with the traits of its model as prior. */
#include "fleet/fleet.h"

#include <math.h>
#include <string.h>

#include "diagnose/held_out.h"
#include "math/stats.h"

/* Prior sigma of a coefficient unknown to the fleet, rad/(N m): typical sizes of
 * mukca_sizes_spring. */
#define WIDE 30e-6

/* Prior sigma of a fixed coefficient, rad/(N m): far below the resolution of any data. */
#define HELD 1e-10

typedef struct {
    mukca_adoption *adoption;
    mukca_regression *m;
    const mukca_adopt_options *options;
    mukca_unknowns own, base; /* as diagnosed; without elastic causes, with the known orders */
    mukca_unknowns kept;      /* backup */
    mukca_fleet_prior prior[MUKCA_FLEET_TERMS];
} task;

/* Add the orders of ripple known from the fleet. */
static bool put_orders(task *t)
{
    mukca_unknowns *u = &t->m->unknowns;
    const mukca_traits *traits = t->options->traits;
    for (int i = 0; i < traits->n; i++) {
        const mukca_trait *known = &traits->list[i];
        if (known->effect.kind != MUKCA_EFFECT_GEAR_HARMONIC) continue;
        const int c =
            mukca_fleet_add_harmonic(t->m, known->effect.joint, known->effect.variant.order);
        if (c < 0) return false;
        u->cause[c].candidate.log_prior = log(known->probability); /* no look-elsewhere penalty */
    }
    return true;
}

/* Fit with a prior of the coefficients; returns the log posterior up to a common constant. */
static double fit(task *t, const mukca_fleet_prior *prior)
{
    mukca_unknowns_assign(&t->m->unknowns, &t->base);
    if (!mukca_fleet_add(t->m, prior)) return -HUGE_VAL;
    mukca_regression_fit(t->m, 6, MUKCA_FIT_ALL);
    return mukca_regression_score(t->m);
}

static const mukca_trait *find_trait(const mukca_traits *traits, const mukca_effect *effect)
{
    for (int i = 0; i < traits->n; i++)
        if (mukca_effect_same(&traits->list[i].effect, effect)) return &traits->list[i];
    return NULL;
}

/* Prior of the coefficients: scatter of the arms and uncertainty of the mean combined. */
static void read_prior(task *t)
{
    const int n = t->m->recording.chain->n_joints;
    for (int k = 0; k < mukca_fleet_terms(n); k++) {
        const mukca_effect term = mukca_fleet_term(k, n);
        const mukca_trait *trait = find_trait(t->options->traits, &term);
        t->prior[k] = (mukca_fleet_prior){.mean = trait ? trait->mean : 0,
                                          .sigma = t->options->only ? HELD
                                                   : trait ? hypot(trait->spread, trait->error)
                                                           : WIDE};
    }
}

static void list_coefficients(task *t)
{
    mukca_adoption *a = t->adoption;
    mukca_unknowns *u = &t->m->unknowns;
    const double one = 1;
    mukca_regression_factor(t->m);
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_accepted *cause = &u->cause[c];
        const mukca_trait *trait =
            cause->known ? find_trait(t->options->traits, &cause->candidate.effect) : NULL;
        if (!trait) continue;
        const double value = cause->coefficient[0],
                     sigma = mukca_regression_standard_error(t->m, mukca_unknowns_column(u, c),
                                                             &one, 1),
                     kept = sigma * cause->candidate.unit[0] / cause->scale;
        a->list[a->n++] = (mukca_inherited){.trait = trait,
                                            .value = value,
                                            .low = fmax(value - MUKCA_SIGMAS_95 * sigma, 0),
                                            .high = value + MUKCA_SIGMAS_95 * sigma,
                                            .own = fmax(1 - kept * kept, 0)};
    }
}

/* Effects of single placements do not transfer to other placements: keep them only if they reduce
 * the held-out error. */
static void choose_placement_effects(task *t, const mukca_diagnosis *d)
{
    mukca_unknowns *u = &t->m->unknowns;
    const int n = u->n_causes;
    if (d->folds < 3) return;
    mukca_unknowns_assign(&t->kept, u);
    for (int c = n - 1; c >= 0; c--) {
        const int class = mukca_candidate_class(&u->cause[c].candidate);
        if (mukca_effect_has(class, MUKCA_TRAIT_PER_PLACEMENT)) mukca_unknowns_drop(u, c);
    }
    if (u->n_causes == n) return;
    const double with = mukca_held_out_structure(t->m);
    mukca_regression_fit(t->m, 6, MUKCA_FIT_ALL);
    if (mukca_held_out_structure(t->m) < with) return;
    mukca_unknowns_assign(u, &t->kept);
    mukca_regression_linearise(t->m);
}

/* Copy errors and applicable effects from the fit with the traits. */
static mukca_status take_over(task *t, mukca_diagnosis *d, mukca_error *error)
{
    mukca_regression *m = t->m;
    mukca_status status = MUKCA_OK;
    d->geometry = m->unknowns.geometry;
    if (d->folds > 1) {
        mukca_folds b = {.m = m};
        const int rows = m->recording.data->n_rows;
        mukca_folds_create(&b);
        if (m->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
        mukca_folds_run(b.error, &b, false);
        d->applied_m = mukca_folds_mean(b.error, rows);
        mukca_folds_by_placement(d->placement_mae_m, &m->recording, b.error);
        if (!t->options->test) memcpy(d->after_m, b.error, sizeof *b.error * (size_t)rows);
    }
    if (t->options->test) {
        const double own[2] = {d->test_geometry_m, d->test_explained_m}; /* of the arm by itself */
        const mukca_arm_state arm = mukca_unknowns_arm(&m->unknowns);
        status = mukca_test_data_measure(d, NULL, m, &arm, t->options->test, error);
        d->test_applied_m = d->test_explained_m;
        d->test_geometry_m = own[0], d->test_explained_m = own[1];
    }
    memset(&d->applied, 0, sizeof d->applied);
    mukca_applied_fit(&d->applied, m);
    return status;
}

mukca_status mukca_adopt(mukca_adoption *a, mukca_regression *m, mukca_diagnosis *d,
                         const mukca_adopt_options *options, mukca_error *error)
{
    task *t = MUKCA_TAKE(&m->pool, task, 1);
    mukca_fleet_prior wide[MUKCA_FLEET_TERMS];
    *a = (mukca_adoption){.traits = options->traits, .only = options->only};
    if (t) t->adoption = a, t->m = m, t->options = options;
    bool ok = t && mukca_unknowns_clone(&t->own, &m->pool, &m->unknowns) &&
              mukca_unknowns_clone(&t->base, &m->pool, &m->unknowns) &&
              mukca_unknowns_clone(&t->kept, &m->pool, &m->unknowns);
    double own = mukca_regression_score(m);
    for (int k = 0; k < MUKCA_FLEET_TERMS; k++) wide[k] = (mukca_fleet_prior){0, WIDE};
    if (ok) {
        mukca_fleet_strip(m, -1);
        ok = options->only || put_orders(t);
        mukca_unknowns_assign(&t->base, &m->unknowns);
    }
    if (!ok || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the traits");
    read_prior(t);
    own = fmax(own, fit(t, wide));
    a->log_evidence = fit(t, t->prior) - own;
    a->adopted = options->only || a->log_evidence > 0;
    if (a->adopted) {
        choose_placement_effects(t, d);
        list_coefficients(t);
        return take_over(t, d, error);
    }
    mukca_unknowns_assign(&m->unknowns, &t->own);
    mukca_regression_linearise(m);
    return MUKCA_OK;
}

/* ---- correction of a recording for the traits of its model ---- */

int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits,
                         double share)
{
    int n = 0;
    for (int i = 0; share > 0 && i < traits->n; i++) {
        const mukca_trait *t = &traits->list[i];
        if (!(t->mean > 0) || n == MUKCA_FLEET_TERMS) continue;
        if (sigma) sigma[n] = hypot(t->spread, t->error);
        effects[n] = t->effect;
        effects[n++].coefficient[0] = share * t->mean;
    }
    return n;
}

void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain, const mukca_traits *traits,
                          double share)
{
    static const mukca_displacement none = {0};
    mukca_effect effects[MUKCA_FLEET_TERMS];
    mukca_geometry nominal;
    const int n = mukca_traits_effects(effects, NULL, traits, share);
    mukca_geometry_set(&nominal, chain, NULL);
    for (int row = 0; row < data->n_rows && n > 0; row++) {
        double *q = data->q + (size_t)row * (size_t)data->n_joints, from[3], to[3];
        const mukca_joint_state state = {
            .q = q,
            .payload_kg = data->payload && isfinite(data->payload[row]) ? data->payload[row] : 0,
            .placement = -1};
        mukca_displacement d = {0};
        mukca_effects_displacement(&d, effects, n, chain, &nominal, q, &state);
        mukca_fk_position(from, &nominal, q, NULL);
        mukca_fk_position(to, &nominal, q, &d);
        for (int c = 0; c < 3; c++) to[c] -= from[c];
        mukca_linearisation_seat(q, to, data->n_joints, &nominal, &none);
    }
}
