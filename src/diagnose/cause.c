/* Description of an identified cause: probability, rivals, size. */
#include "diagnose/cause.h"

#include <math.h>
#include <string.h>

#include "diagnose/findings.h"
#include "math/dense.h"
#include "math/stats.h"

/* Elastic causes are fitted with one factor per mass, and reported as the single coefficient
 * nearest to it in the recorded samples (least squares): sum of weight[t] coefficient[t]. */
static void mass_weights(double *weight, const mukca_recording *recording, const mukca_candidate *h)
{
    const int terms = h->terms, width = h->width_of_term;
    memset(weight, 0, sizeof *weight * MUKCA_MOST_TERMS);
    for (int i = 0; i < recording->n_samples; i++) {
        const float *basis = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        for (int t = 0; t < terms; t++)
            for (int k = 0; k < width; k++)
                weight[t] += (double)basis[t * width + k] * (double)basis[k];
    }
    const double square = weight[0];
    for (int t = 0; t < terms; t++) weight[t] = square > 0 ? weight[t] / square : t == 0;
}

/* Coefficients and size; its interval is by the delta method, from the posterior covariance. */
static void measure(mukca_cause *out, mukca_regression *m, int index)
{
    const mukca_accepted *cause = &m->unknowns.cause[index];
    const mukca_candidate *h = &cause->candidate;
    const int terms = out->effect.terms, column = mukca_unknowns_column(&m->unknowns, index);
    const double one = 1;
    double *coefficient = out->effect.coefficient, direction[MUKCA_MOST_TERMS] = {1};
    if (mukca_candidate_by_mass(h)) { /* of an effect with one coefficient */
        mass_weights(direction, &m->recording, h);
        for (int t = 0; t < h->terms; t++) coefficient[0] += direction[t] * cause->coefficient[t];
    } else {
        memcpy(coefficient, cause->coefficient, sizeof *coefficient * (size_t)terms);
    }
    out->amplitude = coefficient[0];
    if (terms > 1) {
        double square = 0;
        for (int t = 0; t < terms; t++) square += coefficient[t] * coefficient[t];
        out->amplitude = sqrt(square);
        for (int t = 0; t < terms; t++) {
            direction[t] = square > 0 ? coefficient[t] / out->amplitude : 0;
            out->sigma[t] = mukca_regression_standard_error(m, column + t, &one, 1);
        }
    }
    const double sigma = mukca_regression_standard_error(m, column, direction, h->terms);
    if (terms == 1) out->sigma[0] = sigma;
    out->low = out->amplitude - MUKCA_SIGMAS_95 * sigma;
    out->high = out->amplitude + MUKCA_SIGMAS_95 * sigma;
    if (terms > 1 || mukca_effect_table[out->effect.kind]->nonnegative)
        out->low = fmax(out->low, 0);
}

double mukca_cause_gain(mukca_search *search, const mukca_causes *set, int member)
{
    int others[MUKCA_SET_ITEMS] = {0}, n = 0, own = -1; /* items of the last search */
    for (int k = 0; k < search->n_kept; k++)
        for (int i = 0; i < set->n; i++)
            if (set->candidate[i] == search->kept[k]) *(i == member ? &own : &others[n++]) = k;
    const int at = mukca_sets_insert(&search->sets, others, NULL, n);
    const mukca_set *rest = &search->sets.set[at < 0 ? 0 : at];
    return own >= 0 && mukca_sets_weigh(&search->sets, rest)
               ? mukca_sets_gain(&search->sets, rest, own)
               : -HUGE_VAL;
}

bool mukca_cause_is_in(const mukca_search *search, const mukca_causes *set,
                       const mukca_finding_group *group)
{
    for (int k = 0; k < set->n; k++) {
        const mukca_candidate *h = &search->all.list[set->candidate[k]];
        if (mukca_candidate_class(h) == MUKCA_CLASS_OUTLIER) continue;
        const mukca_label label =
            mukca_candidate_label(h, &search->m->recording, &search->m->unknowns);
        if (mukca_finding_holds(group, &label)) return true;
    }
    return false;
}

/* Weight of the sets with a cause that a report calls the same: one effect at one joint or socket;
 * orders of ripple that a joint's travel cannot tell apart are the same. */
static double probability_of(const mukca_search *search, const mukca_label *label)
{
    const mukca_finding_group same = mukca_finding_alone(label);
    double sum = 0;
    for (int i = 0; i < search->n_sets; i++)
        if (mukca_cause_is_in(search, &search->set[i], &same)) sum += search->set[i].weight;
    return fmin(sum, 1);
}

/* The finding, or what may be one, of which a candidate is a member; NULL: none. */
static const mukca_finding *finding_of(const mukca_diagnosis *d, const mukca_label *label)
{
    for (int i = 0; i < d->n_findings; i++)
        if (mukca_finding_holds(&d->findings[i].group, label)) return &d->findings[i];
    for (int i = 0; i < d->n_maybe; i++)
        if (mukca_finding_holds(&d->maybe[i].group, label)) return &d->maybe[i];
    return NULL;
}

/* Rivals: the alternatives of its finding. */
static void add_ties(mukca_cause *out, const mukca_finding *f)
{
    if (!f) return;
    double own_probability = MUKCA_DOUBT; /* of what is no alternative */
    for (int a = f->n_alternatives - 1; a >= 0; a--) {
        const mukca_effect *e = &f->alternatives[a].effect;
        if (f->alternatives[a].listed && e->kind == out->effect.kind &&
            e->joint == out->effect.joint && e->placement == out->effect.placement)
            own_probability = f->alternatives[a].probability;
    }
    out->probability = fmin(out->probability, fmin(own_probability, f->group.probability));
    memcpy(out->order_range, f->order, sizeof f->order);
    for (int a = 0; a < f->n_alternatives && out->n_ties < MUKCA_MAX_TIES; a++) {
        const mukca_effect *e = &f->alternatives[a].effect;
        const bool same = e->kind == out->effect.kind && e->joint == out->effect.joint &&
                          e->placement == out->effect.placement;
        if (!f->alternatives[a].listed || same) continue;
        out->ties[out->n_ties++] = (mukca_tie){
            .effect = e->kind,
            .joint = e->joint,
            .log_bayes_factor =
                out->log_bayes_factor +
                log(fmax(f->alternatives[a].probability, 1e-6) / fmax(own_probability, 1e-6)),
            .rival = *e};
    }
    /* what its name lacks of the finding's probability, and no other name has, is outside */
    out->or_unknown = f->outside > MUKCA_DOUBT ||
                      (!out->n_ties && f->group.probability - out->probability > MUKCA_DOUBT);
}

void mukca_cause_describe(mukca_cause *out, mukca_search *search, const mukca_causes *best,
                          int member)
{
    const mukca_recording *recording = &search->m->recording;
    const mukca_candidate *h = &search->all.list[best->candidate[member]];
    const mukca_label label = mukca_candidate_label(h, recording, &search->m->unknowns);
    const mukca_finding *f = finding_of(search->diagnosis, &label);
    *out = (mukca_cause){.effect = mukca_candidate_effect(h),
                         .socket = -1,
                         .log_bayes_factor = mukca_cause_gain(search, best, member),
                         .probability = probability_of(search, &label),
                         .held_out = MUKCA_SHRINK_NONE,
                         .rung_m = NAN};
    add_ties(out, f);
    if (mukca_candidate_is_fault(h)) {
        out->socket = recording->groups[h->fault.group].socket;
        out->row = recording->data->row[h->fault.first];
        out->file = recording->data->file[h->fault.first];
        out->creep = h->fault.shape == MUKCA_FAULT_GROWING;
    }
    measure(out, search->m, member);
}
