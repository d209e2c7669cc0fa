/* Description of an identified cause: probability, rivals, size. */
#include "diagnose/cause.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"
#include "math/stats.h"

enum {
    LEAST_VALUES = 20, /* distinct values that make a step evident */
    MOST_PARTS = 4     /* largest number of steps in the smallest difference */
};
/* Largest deviation of a difference from whole steps: rounding in the file's last digits.  By
 * chance one difference in five is within it, and not twenty in a row. */
#define WHOLE 0.1
/* Width of the bumps below which an unknown function resolves more than long waves, rad: half a
 * period. */
#define FINE_WIDTH (M_PI / MUKCA_LONG_ORDER)

static bool contains(const mukca_search *id, const mukca_causes *set, int name)
{
    for (int i = 0; i < set->n; i++)
        if (id->name[set->candidate[i]] == name) return true;
    return false;
}

/* Elastic causes are fitted with one factor per mass, and reported as the single coefficient
 * nearest to it in the recorded samples (least squares): sum of weight[t] coefficient[t]. */
static void mass_weights(double *weight, const mukca_recording *recording, const mukca_candidate *h)
{
    const int terms = h->terms, width = h->width_of_term;
    memset(weight, 0, sizeof *weight * MUKCA_MAX_COLUMNS);
    for (int i = 0; i < recording->n_samples; i++) {
        const float *basis = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        for (int t = 0; t < terms; t++)
            for (int k = 0; k < width; k++)
                weight[t] += (double)basis[t * width + k] * (double)basis[k];
    }
    const double square = weight[0];
    for (int t = 0; t < terms; t++) weight[t] = square > 0 ? weight[t] / square : t == 0;
}

static mukca_effect fitted_effect(const mukca_recording *recording, const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    mukca_effect effect = mukca_candidate_effect(h);
    if (mukca_candidate_by_mass(h)) {
        double weight[MUKCA_MAX_COLUMNS];
        mass_weights(weight, recording, h);
        for (int t = 0; t < h->terms; t++)
            effect.coefficient[0] += weight[t] * cause->coefficient[t];
    } else {
        memcpy(effect.coefficient, cause->coefficient,
               sizeof *cause->coefficient * (size_t)effect.terms);
    }
    return effect;
}

/* Size; its interval is by the delta method, from the posterior covariance. */
static void measure(mukca_cause *out, mukca_regression *m, int index)
{
    const mukca_candidate *h = &m->unknowns.cause[index].candidate;
    const int terms = out->effect.terms, column = mukca_unknowns_column(&m->unknowns, index);
    const double *coefficient = out->effect.coefficient, one = 1;
    double direction[MUKCA_MAX_COLUMNS] = {1};
    out->amplitude = coefficient[0];
    if (terms > 1) {
        double square = 0;
        for (int t = 0; t < terms; t++) square += coefficient[t] * coefficient[t];
        out->amplitude = sqrt(square);
        for (int t = 0; t < terms; t++) {
            direction[t] = square > 0 ? coefficient[t] / out->amplitude : 0;
            out->sigma[t] = mukca_regression_standard_error(m, column + t, &one, 1);
        }
    } else if (mukca_candidate_by_mass(h)) {
        mass_weights(direction, &m->recording, h);
    }
    const double sigma = mukca_regression_standard_error(m, column, direction, h->terms);
    if (terms == 1) out->sigma[0] = sigma;
    out->low = out->amplitude - MUKCA_SIGMAS_95 * sigma;
    out->high = out->amplitude + MUKCA_SIGMAS_95 * sigma;
    if (terms > 1 || mukca_effect_table[out->effect.kind]->nonnegative)
        out->low = fmax(out->low, 0);
}

/* Effect of a tied candidate; its coefficients displace the joints about as much as the cause. */
static mukca_effect rival_effect(const mukca_candidate *h, const mukca_effect *cause, double unit)
{
    mukca_effect rival = mukca_candidate_effect(h);
    double square = 0;
    for (int t = 0; t < cause->terms; t++) square += pow(cause->coefficient[t] * unit, 2);
    rival.terms = mukca_effect_terms(&rival);
    for (int t = 0; t < rival.terms; t++)
        rival.coefficient[t] = sqrt(square / rival.terms) / h->unit[0];
    return rival;
}

/* Largest canonical correlation of two items given the set weighed last: with Gram blocks A = L L',
 * B = M M' and their cross block C, the largest singular value of L^-1 C M'^-1 (Golub and Van Loan,
 * Matrix Computations, section 6.4.3).  Without the terms of single masses. */
static double correlation_of(mukca_search *id, int a, int b)
{
    double *A = id->scan.scratch->A, *B = id->scan.scratch->B, *C = id->scan.scratch->C,
           s[MUKCA_MOST_TERMS];
    const mukca_candidate *x = &id->all.list[id->kept[a]], *y = &id->all.list[id->kept[b]];
    const int ka = mukca_candidate_own_terms(x), kb = mukca_candidate_own_terms(y);
    mukca_sets_gram(A, &id->sets, a, a);
    mukca_sets_gram(B, &id->sets, b, b);
    mukca_sets_gram(C, &id->sets, a, b);
    for (int i = 0; i < ka; i++) {
        for (int k = 0; k < ka; k++) A[i * ka + k] = A[i * x->terms + k];
        for (int k = 0; k < kb; k++) C[i * kb + k] = C[i * y->terms + k];
        A[i * ka + i] *= 1 + 1e-9; /* singular to rounding */
    }
    for (int i = 0; i < kb; i++) {
        for (int k = 0; k < kb; k++) B[i * kb + k] = B[i * y->terms + k];
        B[i * kb + i] *= 1 + 1e-9;
    }
    if (mukca_dense_cholesky(A, ka) || mukca_dense_cholesky(B, kb)) return NAN;
    mukca_dense_forward(C, kb, A, ka);
    for (int i = 0; i < ka; i++) mukca_dense_forward(C + i * kb, 1, B, kb); /* rows times M'^-1 */
    const int n = ka > kb ? ka : kb; /* more zeros change no other singular value */
    for (int i = 0; i < n * n; i++) A[i] = i / n < ka && i % n < kb ? C[i / n * kb + i % n] : 0;
    if (mukca_dense_svd(A, s, B, n)) return NAN;
    return fmin(s[0], 1);
}

/* Does flexibility resemble the effect?  It is a smooth function of the angles, and differs between
 * placements: unlike fine ripple, readback lag and recording faults. */
static bool resembles_flexibility(const mukca_effect *effect)
{
    return !mukca_effect_has((int)effect->kind, MUKCA_TRAIT_RECORDING_FAULT) &&
           effect->variant.order <= MUKCA_SMOOTH_ORDER &&
           mukca_effect_table[effect->kind]->site != MUKCA_SITE_ANGLES;
}

/* Without masses the load is unknown: an effect that flexibility resembles is tied with the
 * untested flexibility, and shares its probability. */
static void tie_untested_flexibility(mukca_cause *out, const mukca_recording *r)
{
    if (r->have_torques || !resembles_flexibility(&out->effect)) return;
    out->probability *= 0.5;
    if (out->n_ties < MUKCA_MAX_TIES) /* gravity loads the second joint most */
        out->ties[out->n_ties++] = (mukca_tie){
            .effect = mukca_effect_at(MUKCA_SITE_ANGLE, MUKCA_TRAIT_FLEXIBLE),
            .joint = out->effect.joint >= 0 ? out->effect.joint : r->chain->n_joints > 1,
            .log_bayes_factor = NAN,
            .correlation = NAN};
}

/* A set of the last search with these candidates, but one. */
static mukca_set set_without(mukca_search *id, const mukca_causes *set, int without)
{
    int item[MUKCA_SET_ITEMS], n = 0;
    for (int k = 0; k < id->n_kept; k++)
        for (int i = 0; i < set->n; i++)
            if (i != without && set->candidate[i] == id->kept[k]) item[n++] = k;
    const int at = mukca_sets_insert(&id->sets, item, NULL, n);
    return id->sets.set[at < 0 ? 0 : at];
}

double mukca_cause_gain(mukca_search *id, const mukca_causes *set, int member)
{
    const mukca_set rest = set_without(id, set, member);
    const int own = mukca_identify_item(id, set->candidate[member]);
    return own >= 0 && mukca_sets_weigh(&id->sets, &rest) ? mukca_sets_gain(&id->sets, &rest, own)
                                                          : -HUGE_VAL;
}

/* Rivals: what replaces the cause in the sets that lack it, and is not in the best set. */
static void add_ties(mukca_cause *out, mukca_search *id, const mukca_causes *best, int member,
                     const mukca_set *rest, int own)
{
    const mukca_candidate *cause = &id->all.list[best->candidate[member]];
    const int name = id->name[best->candidate[member]];
    double unknown = 0;
    memset(id->instead, 0, sizeof *id->instead * (size_t)id->n_names);
    for (int i = 0; i < id->n_sets; i++) {
        const mukca_causes *set = &id->set[i];
        bool counted = false;
        if (contains(id, set, name)) continue;
        for (int k = 0; k < set->n; k++) {
            const mukca_candidate *h = &id->all.list[set->candidate[k]];
            const int of = id->name[set->candidate[k]];
            if (contains(id, best, of)) continue;
            if (mukca_candidate_class(h) != MUKCA_CLASS_UNKNOWN)
                id->instead[of] += set->again;
            else if (!counted)
                unknown += set->again, counted = true;
        }
    }
    out->or_unknown = unknown > MUKCA_DOUBT;
    while (out->n_ties < MUKCA_MAX_TIES) {
        int most = 0;
        for (int n = 1; n < id->n_names; n++)
            if (id->instead[n] > id->instead[most]) most = n;
        if (!(id->instead[most] > MUKCA_DOUBT)) break;
        id->instead[most] = 0;
        const mukca_candidate *h = &id->all.list[id->of_name[most]];
        if (mukca_candidate_class(h) >= MUKCA_EFFECT_COUNT) continue;
        const int item = own < 0 ? -1 : mukca_identify_item(id, id->of_name[most]);
        out->ties[out->n_ties++] = (mukca_tie){
            .effect = (mukca_effect_kind)mukca_candidate_class(h),
            .joint = h->joint,
            .log_bayes_factor = item < 0 ? (double)NAN : mukca_sets_gain(&id->sets, rest, item),
            .correlation = item < 0 ? (double)NAN : correlation_of(id, own, item),
            .rival = rival_effect(h, &out->effect, cause->unit[0])};
    }
    tie_untested_flexibility(out, &id->m->recording);
}

/* Can an unknown function be a part of the same cause as this name?  Of a short wave only if it is
 * fine, too, or if postures repeat: these are few, and what differs between them resembles waves of
 * any length. */
static bool may_belong(const mukca_search *id, int candidate, int order)
{
    const mukca_candidate *unknown = &id->all.list[candidate];
    return mukca_candidate_class(unknown) == MUKCA_CLASS_UNKNOWN &&
           (order <= MUKCA_LONG_ORDER || id->m->recording.repeats ||
            (unknown->kind == MUKCA_CANDIDATE_OWN_ANGLE && unknown->of.size < FINE_WIDTH));
}

/* A name is conditional on the catalogue.  An unknown function in the same set shows that the
 * catalogue lacks a cause of this arm, and the name may be the remainder of that cause which the
 * function does not follow.  A remainder is any fraction of its cause: its amplitude is below the
 * name's share of both, the root of its share of their log evidence, with that share as
 * probability, which is returned. */
static double share_with_unknown(mukca_cause *out, const mukca_search *id, int name)
{
    const double unknown_gain = id->diagnosis->structure, own = fmax(out->log_bayes_factor, 0),
                 remainder = unknown_gain > 0 ? 1 - sqrt(own / (own + unknown_gain)) : 0.5;
    double beside = 0, all = 0;
    for (int i = 0; i < id->n_sets; i++) {
        bool unknown = false;
        if (!contains(id, &id->set[i], name)) continue;
        for (int k = 0; k < id->set[i].n; k++)
            unknown |= may_belong(id, id->set[i].candidate[k], out->effect.variant.order);
        all += id->set[i].weight;
        if (unknown) beside += id->set[i].weight;
    }
    beside = all > 0 ? beside / all : 0;
    out->probability *= 1 - remainder * beside;
    out->or_unknown |= remainder * beside > MUKCA_DOUBT;
    return 1 - remainder * beside;
}

/* Largest step of which all recorded angles of a joint are multiples, rad: of a coarse encoder, or
 * of the digits in the file; 0: no evident step.  scratch[n_rows] is overwritten. */
static double resolution_of(double *scratch, const mukca_recording *r, int joint)
{
    const int n = r->data->n_rows, joints = r->chain->n_joints;
    double smallest = HUGE_VAL;
    int values = 0;
    for (int row = 0; row < n; row++) scratch[row] = r->data->q[row * joints + joint];
    mukca_stats_sort(scratch, n);
    for (int i = 1; i < n; i++) { /* differences between neighbours, in place */
        const double difference = scratch[i] - scratch[i - 1];
        if (difference > 1e-9) smallest = fmin(smallest, scratch[values++] = difference);
    }
    for (int parts = 1; values >= LEAST_VALUES && parts <= MOST_PARTS; parts++) {
        const double step = smallest / parts;
        int i = 0;
        while (i < values && fabs(scratch[i] / step - round(scratch[i] / step)) < WHOLE) i++;
        if (i == values) return step;
    }
    return 0;
}

/* Angles rounded to steps are aliased to fine waves in chosen postures, with at most the amplitude
 * of a sawtooth, step / pi. */
static void doubt_rounding(mukca_cause *out, mukca_search *id)
{
    const mukca_recording *r = &id->m->recording;
    const double *c = out->effect.coefficient;
    double *scratch = MUKCA_TAKE(&id->pool, double, r->data->n_rows);
    if (scratch && M_PI * hypot(c[0], c[1]) < resolution_of(scratch, r, out->effect.joint))
        mukca_cause_doubt(out);
}

/* 95 % interval of the order. */
static void find_orders(mukca_cause *out, const mukca_search *id, int name)
{
    double weight[MUKCA_LAST_ORDER + 1] = {0}, total = 0, below = 0;
    for (int i = 0; i < id->n_sets; i++)
        for (int k = 0; k < id->set[i].n; k++) {
            const mukca_candidate *h = &id->all.list[id->set[i].candidate[k]];
            if (id->name[id->set[i].candidate[k]] != name) continue;
            weight[h->effect.variant.order] += id->set[i].weight;
            total += id->set[i].weight;
        }
    for (int o = 2; o <= MUKCA_LAST_ORDER; o++) {
        if (below <= 0.025 * total && below + weight[o] > 0.025 * total) out->order_range[0] = o;
        if (below < 0.975 * total && below + weight[o] >= 0.975 * total) out->order_range[1] = o;
        below += weight[o];
    }
}

double mukca_cause_describe(mukca_cause *out, mukca_search *id, const mukca_causes *best,
                            int member)
{
    const mukca_recording *recording = &id->m->recording;
    const mukca_candidate *h = &id->all.list[best->candidate[member]];
    const mukca_accepted *cause = &id->m->unknowns.cause[member];
    const mukca_set rest = set_without(id, best, member);
    const int name = id->name[best->candidate[member]],
              own = mukca_sets_weigh(&id->sets, &rest)
                        ? mukca_identify_item(id, best->candidate[member])
                        : -1;
    *out = (mukca_cause){
        .effect = fitted_effect(recording, cause),
        .socket = -1,
        .log_bayes_factor = own < 0 ? -HUGE_VAL : mukca_sets_gain(&id->sets, &rest, own),
        .probability = id->probability[name],
        .held_out = MUKCA_SHRINK_NONE,
        .rung_m = NAN};
    add_ties(out, id, best, member, &rest, own);
    const double named = id->probability[name] * share_with_unknown(out, id, name);
    if (mukca_effect_has((int)out->effect.kind, MUKCA_TRAIT_ORDERS)) {
        doubt_rounding(out, id);
        find_orders(out, id, name);
    }
    if (mukca_candidate_is_fault(h)) {
        out->socket = recording->groups[h->fault.group].socket;
        out->row = recording->data->row[h->fault.first];
        out->file = recording->data->file[h->fault.first];
        out->creep = h->fault.shape == MUKCA_FAULT_GROWING;
    }
    measure(out, id->m, member);
    return named;
}

int mukca_cause_find(const mukca_regression *m, const mukca_cause *cause)
{
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (mukca_candidate_class(h) >= MUKCA_EFFECT_COUNT) continue;
        const mukca_effect effect = mukca_candidate_effect(h);
        if (mukca_effect_same(&effect, &cause->effect) &&
            (cause->socket < 0 || m->recording.groups[h->fault.group].socket == cause->socket))
            return c;
    }
    return -1;
}

void mukca_cause_doubt(mukca_cause *cause)
{
    cause->or_unknown = true;
    cause->probability *= 0.5; /* the rival has equal odds */
}
