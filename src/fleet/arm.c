/* One arm of a fleet: the summary of its recording, and the traits of its model as prior. */
#include "fleet/fleet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/held_out.h"
#include "diagnose/scan.h"
#include "math/stats.h"

/* Prior sigma of a coefficient unknown to the fleet, rad/(N m): typical sizes of
 * mukca_sizes_spring. */
#define WIDE 30e-6

/* Prior sigma of a fixed coefficient, rad/(N m): far below the resolution of any data. */
#define HELD 1e-10

/* Remove from the regression all elastic causes, unknown functions, which would absorb elasticity,
 * and the orders at a joint (-1: none). */
static void drop_elastic(mukca_regression *m, int joint)
{
    for (int c = m->unknowns.n_causes - 1; c >= 0; c--) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        const int class = mukca_candidate_class(h);
        if (class == MUKCA_CLASS_UNKNOWN || mukca_effect_has(class, MUKCA_TRAIT_ELASTIC) ||
            (mukca_effect_has(class, MUKCA_TRAIT_ORDERS) && h->joint == joint))
            mukca_unknowns_drop(&m->unknowns, c);
    }
}

static bool add_cause(mukca_regression *m, const mukca_effect *effect)
{
    mukca_candidate h = mukca_candidate_of(effect);
    h.as_one = true;
    return mukca_candidate_prepare(&h, &m->pool, &m->recording) &&
           mukca_unknowns_add(&m->unknowns, &h);
}

/* Index of an effect among the causes; -1: none. */
static int find_cause(const mukca_unknowns *u, const mukca_effect *effect)
{
    int c = u->n_causes - 1;
    while (c >= 0 && !(u->cause[c].candidate.kind == MUKCA_CANDIDATE_EFFECT &&
                       mukca_effect_same(&u->cause[c].candidate.effect, effect)))
        c--;
    return c;
}

static const mukca_trait *find_trait(const mukca_traits *traits, const mukca_effect *effect)
{
    for (int i = 0; traits && i < traits->n; i++)
        if (mukca_effect_same(&traits->list[i].effect, effect)) return &traits->list[i];
    return NULL;
}

/* Append the elastic coefficients to the causes, each with one coefficient for all masses.  The
 * prior of a trait (NULL: none) combines the scatter of the arms and the uncertainty of the mean;
 * others have the prior sigma, and all of them if it is HELD.  A coefficient without influence on
 * this recording is omitted.  Fit afterwards.  False: no space. */
static bool add_elastic(mukca_regression *m, const mukca_traits *traits, double sigma)
{
    mukca_unknowns *u = &m->unknowns;
    const int n = m->recording.chain->n_joints;
    for (int i = 0; i < mukca_fleet_terms(n); i++) {
        const mukca_effect effect = mukca_fleet_term(i, n);
        const mukca_trait *trait = find_trait(traits, &effect);
        const bool about_axis = mukca_effect_table[effect.kind]->site == MUKCA_SITE_ANGLE;
        const bool load = about_axis ? m->recording.have_torques : m->recording.have_moments;
        if (!load) continue;
        if (!add_cause(m, &effect)) return false;
        mukca_accepted *cause = &u->cause[u->n_causes - 1];
        if (!(cause->candidate.unit[0] > MUKCA_LEAST_TORQUE)) {
            mukca_unknowns_drop(u, u->n_causes - 1);
            continue;
        }
        cause->known = true;
        cause->centre = cause->coefficient[0] = trait ? trait->mean : 0;
        cause->scale = cause->candidate.unit[0] *
                       (trait && sigma > HELD ? hypot(trait->spread, trait->error) : sigma);
    }
    return true;
}

/* ---- summary of a recording ---- */

static bool has_ripple(const mukca_unknowns *u, int joint)
{
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (mukca_effect_has(mukca_candidate_class(h), MUKCA_TRAIT_ORDERS) && h->joint == joint)
            return true;
    }
    return false;
}

/* Share of recordings that show a gear's order at a neighbour. */
#define STRAYS 0.1

/* Orders that this recording cannot tell apart: a wave that its mounting modulates is read at a
 * neighbour less than one period away over the travel.  A neighbour's weight is the share of the
 * wave that it explains on evenly spread angles, sinc^2 of half the phase between their ends. */
static double pool_neighbours(const double *value, int order, double travel)
{
    double log_odds[MUKCA_LAST_ORDER + 1] = {value[order] + log(1 - STRAYS)}, total = 0;
    int n = 1;
    for (int o = 2; o <= MUKCA_LAST_ORDER; o++) {
        const double half = 0.5 * abs(o - order) * travel;
        if (o == order || half >= acos(-1)) continue;
        total += pow(sin(half) / half, 2);
        log_odds[n++] = value[o] + 2 * log(sin(half) / half) + log(STRAYS);
    }
    for (int i = 1; i < n; i++) log_odds[i] -= log(total);
    return n > 1 ? mukca_stats_log_sum_exp(log_odds, n) : value[order];
}

/* Log Bayes factors of all orders of one joint against the present model (-1: of all joints without
 * an order in it). */
static bool scan_orders(mukca_summary *s, mukca_regression *m, int only)
{
    const mukca_recording *r = &m->recording;
    mukca_candidates none = {0};
    mukca_scan scan;
    none.capacity = 1;
    if (!mukca_scan_create(&scan, &m->pool, m, &none)) return false;
    mukca_scan_aim(&scan, m->unknowns.family);
    for (int j = 0; j < r->chain->n_joints; j++) {
        const mukca_effect wave = mukca_fleet_wave(j);
        double value[MUKCA_LAST_ORDER + 1], travel[2];
        if (only < 0 ? has_ripple(&m->unknowns, j) : j != only) continue;
        mukca_recording_travel(travel, r, j);
        const mukca_joint_type type = r->chain->element[r->chain->joint_element[j]].type;
        if (!mukca_joint_turns((int)type) || travel[1] - travel[0] < MUKCA_LEAST_RANGE) continue;
        if (!mukca_scan_orders(value, &scan, &wave)) return false;
        for (int o = 0; o < MUKCA_FLEET_ORDERS; o++) {
            const double pooled = pool_neighbours(value, o + 2, travel[1] - travel[0]),
                         quanta = round(pooled / MUKCA_FLEET_QUANTUM);
            s->ripple[j][o] = (int16_t)fmin(fmax(quanta, -INT16_MAX), INT16_MAX);
        }
    }
    return true;
}

/* Information S on the last columns with all others marginalised: their block of the factor of the
 * scaled posterior precision is the factor of the Schur complement I + D S D, with the prior sigmas
 * D. */
static void marginalise(mukca_summary *s, const mukca_regression *m)
{
    const mukca_unknowns *u = &m->unknowns;
    const double *L = m->evidence.posterior.factor, *z = m->evidence.posterior.work,
                 *D = m->evidence.posterior.prior;
    const int n = m->linear.n_columns, terms = mukca_fleet_terms(s->model.n_joints);
    int first = n, column[MUKCA_FLEET_TERMS];
    for (int i = 0; i < terms; i++) {
        const mukca_effect term = mukca_fleet_term(i, s->model.n_joints);
        const int c = find_cause(u, &term);
        column[i] = c < 0 ? -1 : mukca_unknowns_column(u, c);
        if (column[i] >= 0 && column[i] < first) first = column[i];
    }
    for (int i = 0; i < terms; i++) {
        const int a = column[i];
        double *row = s->information + mukca_fleet_packed(i);
        s->vector[i] = 0;
        for (int k = first; a >= 0 && k <= a; k++) s->vector[i] += L[a * n + k] * z[k] / D[a];
        for (int j = 0; j <= i; j++) {
            const int b = column[j];
            row[j] = 0;
            if (a < 0 || b < 0) continue;
            for (int k = first; k <= b; k++) row[j] += L[a * n + k] * L[b * n + k];
            row[j] = (row[j] - (a == b)) / (D[a] * D[b]);
        }
    }
}

mukca_status mukca_summary_take(mukca_summary *s, mukca_regression *m, mukca_error *error)
{
    /* For the linearisation, each coefficient has a prior of the size of soft gears, three times a
     * Panda's largest.  The summary does not contain this prior. */
    const double held = 300e-6;
    mukca_unknowns *diagnosed = MUKCA_TAKE(&m->pool, mukca_unknowns, 1);
    mukca_fleet_model_of(&s->model, m->recording.chain);
    s->samples = m->recording.n_samples;
    bool ok = diagnosed && mukca_unknowns_clone(diagnosed, &m->pool, &m->unknowns);
    /* The orders of a joint are scored without the identified orders of that joint, but with those
     * of the others: unmodelled strong ripple would appear as faint ripple elsewhere. */
    for (int j = m->recording.chain->n_joints - 1; j >= -1 && ok; j--) {
        if (j >= 0 && !has_ripple(diagnosed, j)) continue;
        mukca_unknowns_assign(&m->unknowns, diagnosed);
        drop_elastic(m, j);
        ok = add_elastic(m, NULL, held);
        mukca_regression_fit(m, 4, MUKCA_FIT_INDEPENDENT);
        if (ok) ok = scan_orders(s, m, j);
    }
    if (!ok || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the summary");
    s->sigma_m = m->unknowns.sigma;
    if (!isfinite(mukca_regression_factor(m)))
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE, "the data cannot be summarised: no fit");
    marginalise(s, m);
    mukca_unknowns_assign(&m->unknowns, diagnosed);
    mukca_regression_linearise(m);
    return MUKCA_OK;
}

/* ---- one more arm with the traits of its model as prior ---- */

typedef struct {
    mukca_adoption *adoption;
    mukca_regression *m;
    mukca_unknowns diagnosed; /* as diagnosed; a backup once the traits are adopted */
    mukca_unknowns base;      /* without elastic causes, with the known orders */
} trial;

/* Add the orders of ripple known from the fleet, each with a prior size chosen by evidence. */
static bool put_orders(trial *t)
{
    mukca_unknowns *u = &t->m->unknowns;
    const mukca_traits *traits = t->adoption->traits;
    for (int i = 0; i < traits->n; i++) {
        const mukca_trait *known = &traits->list[i];
        if (!mukca_effect_has((int)known->effect.kind, MUKCA_TRAIT_ORDERS)) continue;
        if (find_cause(u, &known->effect) < 0 && !add_cause(t->m, &known->effect)) return false;
        u->cause[find_cause(u, &known->effect)].candidate.log_prior =
            log(known->probability); /* no look-elsewhere penalty */
    }
    return true;
}

/* Fit with a prior of the coefficients; returns the log posterior up to a common constant. */
static double fit_with_prior(trial *t, const mukca_traits *traits, double sigma)
{
    mukca_unknowns_assign(&t->m->unknowns, &t->base);
    if (!add_elastic(t->m, traits, sigma)) return -HUGE_VAL;
    mukca_regression_fit(t->m, 6, MUKCA_FIT_ALL);
    return mukca_regression_score(t->m);
}

static void list_coefficients(trial *t)
{
    mukca_adoption *a = t->adoption;
    mukca_unknowns *u = &t->m->unknowns;
    const double one = 1;
    mukca_regression_factor(t->m);
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_accepted *cause = &u->cause[c];
        const mukca_trait *trait =
            cause->known ? find_trait(t->adoption->traits, &cause->candidate.effect) : NULL;
        if (!trait) continue;
        const double value = cause->coefficient[0],
                     sigma = mukca_regression_standard_error(t->m, mukca_unknowns_column(u, c),
                                                             &one, 1),
                     kept = sigma * cause->candidate.unit[0] / cause->scale;
        a->list[a->n++] = (mukca_inherited){.trait = trait,
                                            .value = value,
                                            .low = fmax(value - MUKCA_SIGMAS_95 * sigma, 0),
                                            .high = value + MUKCA_SIGMAS_95 * sigma,
                                            .own_share = fmax(1 - kept * kept, 0)};
    }
}

/* Effects of single placements do not transfer to other placements: keep them only if they reduce
 * the held-out error. */
static void choose_placement_effects(trial *t, const mukca_diagnosis *d)
{
    mukca_unknowns *u = &t->m->unknowns;
    const int n = u->n_causes;
    if (d->folds < 3) return;
    mukca_unknowns_assign(&t->diagnosed, u);
    for (int c = n - 1; c >= 0; c--) {
        const int class = mukca_candidate_class(&u->cause[c].candidate);
        if (mukca_effect_has(class, MUKCA_TRAIT_PER_PLACEMENT)) mukca_unknowns_drop(u, c);
    }
    if (u->n_causes == n) return;
    const double error_m = mukca_held_out_structure(t->m);
    mukca_regression_fit(t->m, 6, MUKCA_FIT_ALL);
    if (mukca_held_out_structure(t->m) < error_m) return;
    mukca_unknowns_assign(u, &t->diagnosed);
    mukca_regression_linearise(t->m);
}

/* Copy errors and applicable effects from the fit with the traits. */
static mukca_status take_over(trial *t, mukca_diagnosis *d, mukca_error *error)
{
    mukca_regression *m = t->m;
    mukca_status status = MUKCA_OK;
    d->geometry = m->unknowns.arm.geometry;
    if (d->folds > 1) {
        mukca_folds b = {.m = m};
        const int rows = m->recording.data->n_rows;
        mukca_folds_create(&b);
        if (m->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
        mukca_folds_run(b.error, &b, false);
        d->applied_m = mukca_folds_mean(b.error, rows);
        mukca_folds_by_placement(d->placement_mae_m, &m->recording, b.error);
        if (!t->adoption->test) memcpy(d->after_m, b.error, sizeof *b.error * (size_t)rows);
    }
    if (t->adoption->test) {
        const double of_arm[2] = {d->test_geometry_m,
                                  d->test_explained_m}; /* of the arm by itself */
        status = mukca_test_data_measure(d, NULL, m, &m->unknowns.arm, t->adoption->test, error);
        d->test_applied_m = d->test_explained_m;
        d->test_geometry_m = of_arm[0], d->test_explained_m = of_arm[1];
    }
    memset(&d->applied, 0, sizeof d->applied);
    mukca_applied_fit(&d->applied, m);
    return status;
}

mukca_status mukca_adopt(mukca_adoption *a, mukca_regression *m, mukca_diagnosis *d,
                         mukca_error *error)
{
    trial *t = MUKCA_TAKE(&m->pool, trial, 1);
    if (t) t->adoption = a, t->m = m;
    bool ok = t && mukca_unknowns_clone(&t->diagnosed, &m->pool, &m->unknowns) &&
              mukca_unknowns_clone(&t->base, &m->pool, &m->unknowns);
    double separate = mukca_regression_score(m);
    if (ok) {
        drop_elastic(m, -1);
        ok = a->only || put_orders(t);
        mukca_unknowns_assign(&t->base, &m->unknowns);
    }
    if (!ok || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the traits");
    separate = fmax(separate, fit_with_prior(t, NULL, WIDE));
    a->log_evidence = fit_with_prior(t, a->traits, a->only ? HELD : WIDE) - separate;
    a->adopted = a->only || a->log_evidence > 0;
    if (a->adopted) {
        choose_placement_effects(t, d);
        list_coefficients(t);
        return take_over(t, d, error);
    }
    mukca_unknowns_assign(&m->unknowns, &t->diagnosed);
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
        mukca_effects_displacement(&d, effects, n, chain, &nominal, &state);
        mukca_fk_position(from, &nominal, q, NULL);
        mukca_fk_position(to, &nominal, q, &d);
        for (int c = 0; c < 3; c++) to[c] -= from[c];
        mukca_linearisation_seat(q, to, data->n_joints, &nominal, &none);
    }
}
