/* Summaries of recordings, and their collection to a fleet. */
#include "fleet/fleet.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "diagnose/scan.h"
#include "math/dense.h"
#include "math/stats.h"
#include "model/chain_hash.h"

void mukca_fleet_model_of(mukca_fleet_model *model, const mukca_chain *chain)
{
    *model = (mukca_fleet_model){.n_joints = chain->n_joints, .masses = MUKCA_HASH_START};
    memcpy(model->robot, chain->robot, sizeof model->robot);
    memcpy(model->base, chain->base, sizeof model->base);
    memcpy(model->tip, chain->tip, sizeof model->tip);
    for (int j = 0; j < chain->n_joints; j++)
        memcpy(model->joint[j], mukca_chain_joint_name(chain, j), sizeof *model->joint);
    const int last = chain->joint_element[chain->n_joints - 1];
    for (int i = 0; i < chain->n_masses; i++) {
        if (chain->mass[i].element >= last) continue; /* the last link carries the tool */
        const double element = chain->mass[i].element;
        model->masses = mukca_hash_numbers(model->masses, &element, 1, 1);
        model->masses = mukca_hash_numbers(model->masses, &chain->mass[i].kg, 1, 1e-3);
        model->masses = mukca_hash_numbers(model->masses, chain->mass[i].com, 3, 1e-6);
    }
    model->masses = mukca_hash_numbers(model->masses, chain->gravity, 3, 1e-3);
    /* factory files differ between arms of one model */
    model->geometry = chain->urdf_geometry ? chain->urdf_geometry : mukca_chain_hash(chain);
}

const char *mukca_fleet_model_differs(const mukca_fleet_model *a, const mukca_fleet_model *b)
{
    if (a->n_joints != b->n_joints) return "the number of joints differs";
    if (strcmp(a->base, b->base) != 0) return "the base of the chain differs";
    for (int j = 0; j < a->n_joints; j++)
        if (strcmp(a->joint[j], b->joint[j]) != 0) return "the names of the joints differ";
    if (a->geometry != b->geometry) return "the nominal geometry differs";
    return a->masses != b->masses ? "the link masses differ (--inertials)" : NULL;
}

uint64_t mukca_summary_hash(const mukca_dataset *data)
{
    const size_t rows = (size_t)data->n_rows;
    uint64_t hash =
        mukca_hash(MUKCA_HASH_START, data->q, rows * (size_t)data->n_joints * sizeof(double));
    hash = mukca_hash(hash, data->socket, rows * sizeof *data->socket);
    if (data->position) hash = mukca_hash(hash, data->position, 3 * rows * sizeof(double));
    return hash;
}

/* True if a gear harmonic of the joint is among the causes. */
static bool has_ripple(const mukca_unknowns *u, int joint)
{
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (mukca_candidate_class(h) == MUKCA_EFFECT_GEAR_HARMONIC && h->joint == joint)
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
    double log_odds[MUKCA_RIPPLE_ORDERS + 1] = {value[order] + log(1 - STRAYS)}, total = 0;
    int n = 1;
    for (int o = 2; o <= MUKCA_RIPPLE_ORDERS; o++) {
        const double half = 0.5 * abs(o - order) * travel;
        if (o == order || half >= acos(-1)) continue;
        total += pow(sin(half) / half, 2);
        log_odds[n++] = value[o] + 2 * log(sin(half) / half) + log(STRAYS);
    }
    for (int i = 1; i < n; i++) log_odds[i] -= log(total);
    return n > 1 ? mukca_stats_log_sum_exp(log_odds, n) : value[order];
}

/* Log Bayes factors of all orders of one joint against the present model (-1: of all joints without
 * a gear harmonic in it). */
static bool scan_orders(mukca_summary *s, mukca_regression *m, int only)
{
    const mukca_recording *r = &m->recording;
    mukca_candidates none = {0};
    mukca_scan scan;
    none.capacity = 1;
    if (!mukca_scan_create(&scan, &m->pool, m, &none)) return false;
    mukca_scan_aim(&scan, m->unknowns.family);
    for (int j = 0; j < r->chain->n_joints; j++) {
        double value[MUKCA_RIPPLE_ORDERS + 1], travel[2];
        if (only < 0 ? has_ripple(&m->unknowns, j) : j != only) continue;
        mukca_recording_travel(travel, r, j);
        const mukca_joint_type type = r->chain->element[r->chain->joint_element[j]].type;
        if (!mukca_joint_turns((int)type) || travel[1] - travel[0] < MUKCA_LEAST_RANGE) continue;
        if (!mukca_scan_orders(value, &scan, j)) return false;
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
    const double *L = m->evidence.factor, *z = m->evidence.work, *D = m->evidence.prior;
    const int n = m->linear.n_columns, terms = mukca_fleet_terms(s->model.n_joints);
    int first = n, column[MUKCA_FLEET_TERMS];
    for (int i = 0; i < terms; i++) {
        const mukca_effect term = mukca_fleet_term(i, s->model.n_joints);
        column[i] = -1;
        for (int c = 0; c < u->n_causes; c++)
            if (u->cause[c].known && mukca_effect_same(&u->cause[c].candidate.effect, &term))
                column[i] = mukca_unknowns_column(u, c);
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
    mukca_fleet_prior prior[MUKCA_FLEET_TERMS];
    mukca_unknowns *own = MUKCA_TAKE(&m->pool, mukca_unknowns, 1);
    for (int i = 0; i < MUKCA_FLEET_TERMS; i++) prior[i] = (mukca_fleet_prior){0, held};
    mukca_fleet_model_of(&s->model, m->recording.chain);
    s->samples = m->recording.n_samples;
    bool ok = own && mukca_unknowns_clone(own, &m->pool, &m->unknowns);
    /* The orders of a joint are scored without the identified orders of that joint, but with those
     * of the others: unmodelled strong ripple would appear as faint ripple elsewhere. */
    for (int j = m->recording.chain->n_joints - 1; j >= -1 && ok; j--) {
        if (j >= 0 && !has_ripple(own, j)) continue;
        mukca_unknowns_assign(&m->unknowns, own);
        mukca_fleet_strip(m, j);
        ok = mukca_fleet_add(m, prior);
        mukca_regression_fit(m, 4, MUKCA_FIT_INDEPENDENT);
        if (ok) ok = scan_orders(s, m, j);
    }
    if (!ok || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the summary");
    s->sigma_m = m->unknowns.sigma;
    if (!isfinite(mukca_regression_factor(m)))
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE, "the data cannot be summarised: no fit");
    marginalise(s, m);
    return MUKCA_OK;
}

/* ---- elastic coefficients shared by arms of one model, as causes of a regression ---- */

int mukca_fleet_terms(int n_joints)
{
    return 2 * n_joints;
}

mukca_effect mukca_fleet_term(int i, int n_joints)
{
    const bool base = i == 2 * n_joints - 1;
    return (mukca_effect){.kind = i < n_joints ? MUKCA_EFFECT_JOINT_COMPLIANCE
                                  : base       ? MUKCA_EFFECT_BASE_COMPLIANCE
                                               : MUKCA_EFFECT_LINK_BENDING,
                          .joint = i < n_joints ? i
                                   : base       ? -1
                                                : i - n_joints + 1,
                          .placement = -1,
                          .terms = 1};
}

void mukca_fleet_strip(mukca_regression *m, int joint)
{
    for (int c = m->unknowns.n_causes - 1; c >= 0; c--) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        const int class = mukca_candidate_class(h);
        if (class == MUKCA_CLASS_UNKNOWN || mukca_effect_has(class, MUKCA_TRAIT_ELASTIC) ||
            (class == MUKCA_EFFECT_GEAR_HARMONIC && h->joint == joint))
            mukca_unknowns_drop(&m->unknowns, c);
    }
}

static bool add(mukca_regression *m, const mukca_effect *effect)
{
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                         .joint = effect->joint,
                         .placement = effect->placement,
                         .effect = *effect};
    return mukca_candidate_prepare(&h, &m->pool, &m->recording) &&
           mukca_unknowns_add(&m->unknowns, &h);
}

bool mukca_fleet_add(mukca_regression *m, const mukca_fleet_prior *prior)
{
    mukca_unknowns *u = &m->unknowns;
    const int n = m->recording.chain->n_joints;
    const double spread = m->recording.options.mass_spread;
    bool ok = true;
    m->recording.options.mass_spread = 0; /* one coefficient instead of a factor per mass */
    for (int i = 0; i < mukca_fleet_terms(n) && ok; i++) {
        const mukca_effect effect = mukca_fleet_term(i, n);
        const bool load = effect.kind == MUKCA_EFFECT_JOINT_COMPLIANCE ? m->recording.have_torques
                                                                       : m->recording.have_moments;
        if (!load) continue;
        ok = add(m, &effect);
        if (!ok) break;
        mukca_accepted *cause = &u->cause[u->n_causes - 1];
        if (!(cause->candidate.unit[0] > MUKCA_LEAST_TORQUE)) {
            mukca_unknowns_drop(u, u->n_causes - 1);
            continue;
        }
        cause->known = true;
        cause->centre = cause->coefficient[0] = prior[i].mean;
        cause->scale = prior[i].sigma * cause->candidate.unit[0];
    }
    m->recording.options.mass_spread = spread;
    return ok;
}

int mukca_fleet_add_harmonic(mukca_regression *m, int joint, int order)
{
    const mukca_effect effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                 .joint = joint,
                                 .placement = -1,
                                 .variant.order = order};
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (h->kind == MUKCA_CANDIDATE_EFFECT && mukca_effect_same(&h->effect, &effect)) return c;
    }
    return add(m, &effect) ? m->unknowns.n_causes - 1 : -1;
}

/* ---- collection of the summaries of arms of one model ---- */

/* Is the information positive definite, up to a prior of the softest gears? */
static bool is_possible(const mukca_summary *s, int terms)
{
    const double softest = 1e-3; /* rad/(N m) */
    double A[MUKCA_FLEET_TERMS * MUKCA_FLEET_TERMS];
    for (int i = 0; i < terms; i++) {
        for (int j = 0; j <= i; j++)
            A[i * terms + j] = s->information[mukca_fleet_packed(i) + j] * softest * softest;
        if (!(A[i * terms + i] >= 0) || !isfinite(s->vector[i])) return false;
        A[i * terms + i] = A[i * terms + i] * (1 + 1e-9) + 1; /* rounding in the file */
    }
    return mukca_dense_cholesky(A, terms) == 0;
}

static bool grow(mukca_fleet *f)
{
    if (f->n_sessions < f->capacity) return true;
    f->capacity = f->capacity ? 2 * f->capacity : 64;
    mukca_summary **bigger = MUKCA_TAKE(&f->pool, mukca_summary *, f->capacity);
    for (int i = 0; bigger && i < f->n_sessions; i++) bigger[i] = f->session[i];
    f->session = bigger;
    return bigger != NULL;
}

mukca_status mukca_fleet_take(mukca_fleet *f, const mukca_summary *s, mukca_error *error)
{
    if (f->n_sessions == 0) {
        f->model = s->model;
        f->n_terms = mukca_fleet_terms(s->model.n_joints);
    }
    const size_t size =
        offsetof(mukca_summary, ripple) + (size_t)f->model.n_joints * sizeof *s->ripple;
    const char *differs = mukca_fleet_model_differs(&f->model, &s->model);
    if (differs)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: of another model than %s: %s; pool arms of one model only", s->path,
                          f->session[0]->path, differs);
    if (!is_possible(s, f->n_terms))
        return mukca_fail(
            error, MUKCA_INPUT,
            "%s: the information is not positive semidefinite; write the summary again", s->path);
    mukca_summary *copy = mukca_pool_take(&f->pool, 1, size);
    if (!copy || !grow(f)) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %s", s->path);
    memcpy(copy, s, size);
    f->session[f->n_sessions++] = copy;
    return MUKCA_OK;
}

static int by_data(const void *a, const void *b)
{
    const mukca_summary *x = *(mukca_summary *const *)a, *y = *(mukca_summary *const *)b;
    return (x->data > y->data) - (x->data < y->data);
}

static int by_arm(const void *a, const void *b)
{
    const mukca_summary *x = *(mukca_summary *const *)a, *y = *(mukca_summary *const *)b;
    const int order = strcmp(x->arm, y->arm);
    return order ? order : by_data(a, b);
}

/* Sum the sessions from `first` on that have its name. */
static bool sum(mukca_fleet_arm *arm, mukca_fleet *f, int first)
{
    const int packed = mukca_fleet_packed(f->n_terms);
    *arm = (mukca_fleet_arm){.name = f->session[first]->arm,
                             .first = first,
                             .end = first,
                             .information = MUKCA_TAKE(&f->pool, double, packed),
                             .vector = MUKCA_TAKE(&f->pool, double, f->n_terms)};
    if (f->pool.failed) return false;
    for (; arm->end < f->n_sessions; arm->end++) {
        const mukca_summary *s = f->session[arm->end];
        if (strcmp(s->arm, arm->name) != 0) break;
        for (int i = 0; i < packed; i++) arm->information[i] += s->information[i];
        for (int i = 0; i < f->n_terms; i++) arm->vector[i] += s->vector[i];
        arm->samples += s->samples;
    }
    return true;
}

mukca_status mukca_fleet_gather(mukca_fleet *f, mukca_error *error)
{
    const size_t n = (size_t)f->n_sessions;
    qsort(f->session, n, sizeof(void *), by_data);
    for (int i = 1; i < f->n_sessions; i++) {
        const mukca_summary *s = f->session[i], *before = f->session[i - 1];
        if (s->data == before->data)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s: the same recording as %s (arms '%s' and '%s'); give it once",
                              s->path, before->path, s->arm, before->arm);
    }
    qsort(f->session, n, sizeof(void *), by_arm);
    f->n_arms = 0;
    f->arm = MUKCA_TAKE(&f->pool, mukca_fleet_arm, n + 1);
    for (int s = 0; s < f->n_sessions && f->arm; s = f->arm[f->n_arms++].end)
        if (!sum(&f->arm[f->n_arms], f, s)) break;
    if (f->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d arms", f->n_arms);
    return MUKCA_OK;
}

double mukca_fleet_ripple(const mukca_fleet *f, int arm, int joint, int order)
{
    int quanta = 0;
    for (int s = f->arm[arm].first; s < f->arm[arm].end; s++)
        quanta += f->session[s]->ripple[joint][order - 2];
    return quanta * MUKCA_FLEET_QUANTUM;
}

void mukca_fleet_free(mukca_fleet *f)
{
    mukca_pool_free(&f->pool);
    memset(f, 0, sizeof *f);
}
