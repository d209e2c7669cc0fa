/* The verdict on the identified sets of causes: names, unexplained structure, location. */
#include "diagnose/cause.h"

#include <math.h>
#include <stdlib.h>

#include "base/order.h"
#include "diagnose/findings.h"

/* Least size of an outlier that is reported as a fault, in sigmas of the noise. */
#define OUTLIER_SIGMAS 12

static void add_outlier(mukca_diagnosis *d, const mukca_regression *m, const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    const double size = mukca_norm3(cause->coefficient);
    const int last = h->fault.shape == MUKCA_FAULT_FADING ? h->fault.first : h->fault.last;
    if (size > OUTLIER_SIGMAS * m->unknowns.sigma)
        for (int row = h->fault.first; row <= last; row++)
            mukca_screening_add(d, &m->recording, MUKCA_FAULT_OUTLIER, row, size);
}

/* Widen range[2] to all angles at which an unknown function of a joint's angle deviates from its
 * mean by half its largest deviation or more. */
static void widen_by_unknown(double range[2], const mukca_recording *recording,
                             const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    const int n_joints = recording->chain->n_joints;
    const bool angle =
        h->kind == MUKCA_CANDIDATE_UNLISTED && h->unlisted.place == MUKCA_PLACE_ANGLE &&
        mukca_unlisted_functions[h->unlisted.function].argument == MUKCA_ARGUMENT_ANGLE;
    const int argument = angle ? h->unlisted.argument : -1;
    double mean = 0, largest = 0;
    for (int pass = 0; pass < 3 && argument >= 0; pass++)
        for (int i = 0; i < recording->n_samples; i++) {
            const int row = recording->order[i];
            double value = 0;
            for (int t = 0; t < h->terms; t++)
                value += cause->coefficient[t] * (double)h->basis[row * h->terms + t];
            if (pass == 0) mean += value / recording->n_samples;
            if (pass == 1) largest = fmax(largest, fabs(value - mean));
            if (pass < 2 || fabs(value - mean) < 0.5 * largest) continue;
            const double q = recording->data->q[row * n_joints + argument];
            range[0] = fmin(range[0], q), range[1] = fmax(range[1], q);
        }
}

static int by_share(const void *a, const void *b)
{
    const mukca_where *x = a, *y = b;
    return x->share != y->share ? (x->share < y->share) - (x->share > y->share)
                                : x->joint - y->joint;
}

/* Share of each joint: in the sets with unknown functions, if these are probable, else in the
 * evidence for the listed causes. */
static void find_where(mukca_diagnosis *d, const mukca_search *search, bool unknown)
{
    const mukca_regression *m = search->m;
    double weight[MUKCA_MAX_JOINTS] = {0}, total = 0;
    for (int i = 0; i < search->n_sets && unknown; i++)
        for (int k = 0; k < search->set[i].n; k++) {
            const mukca_candidate *h = &search->all.list[search->set[i].candidate[k]];
            if (mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN && h->joint >= 0)
                weight[h->joint] += search->set[i].weight;
        }
    for (int c = 0; c < d->n_causes && !unknown; c++)
        if (d->causes[c].effect.joint >= 0)
            weight[d->causes[c].effect.joint] += fmax(d->causes[c].log_bayes_factor, 0);
    for (int j = 0; j < m->recording.chain->n_joints; j++) total += weight[j];
    for (int j = 0; j < m->recording.chain->n_joints; j++) {
        if (!(weight[j] > 0)) continue;
        double range[2] = {HUGE_VAL, -HUGE_VAL};
        for (int c = 0; c < m->unknowns.n_causes; c++)
            if (m->unknowns.cause[c].candidate.joint == j)
                widen_by_unknown(range, &m->recording, &m->unknowns.cause[c]);
        if (range[0] > range[1]) mukca_recording_travel(range, &m->recording, j);
        d->where[d->n_where++] = (mukca_where){
            .joint = j, .share = weight[j] / total, .range_rad = {range[0], range[1]}};
    }
    qsort(d->where, (size_t)d->n_where, sizeof *d->where, by_share);
}

MUKCA_FALLING(by_evidence, mukca_cause, log_bayes_factor)

/* The first set with a member of each finding. */
static const mukca_causes *choose_set(const mukca_diagnosis *d, const mukca_search *search)
{
    for (int i = 0; i < search->n_sets; i++) {
        int f = 0;
        while (f < d->n_findings &&
               mukca_cause_is_in(search, &search->set[i], &d->findings[f].group))
            f++;
        if (f == d->n_findings) return &search->set[i];
    }
    return &search->set[0];
}

double mukca_verdict_probability(const mukca_search *search, int class)
{
    double sum = 0;
    for (int i = 0; i < search->n_sets; i++) {
        bool found = false;
        for (int k = 0; k < search->set[i].n; k++) {
            const int member =
                mukca_candidate_class(&search->all.list[search->set[i].candidate[k]]);
            found |= class < 0 ? member != MUKCA_CLASS_OUTLIER : member == class;
        }
        if (found) sum += search->set[i].weight;
    }
    return sum;
}

static void list_sets(mukca_diagnosis *d, const mukca_search *search)
{
    const mukca_dataset *data = search->m->recording.data;
    for (int i = 0; i < search->n_sets && i < MUKCA_MAX_SETS; i++) {
        mukca_cause_set *out = &d->sets[d->n_sets++];
        *out = (mukca_cause_set){.probability = search->set[i].weight, .n = search->set[i].n};
        for (int k = 0; k < out->n; k++) {
            const mukca_candidate *h = &search->all.list[search->set[i].candidate[k]];
            out->member[k].effect = mukca_candidate_effect(h);
            out->member[k].unknown = mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN;
            if (!mukca_candidate_is_fault(h)) continue;
            out->member[k].row = data->row[h->fault.first];
            out->member[k].file = data->file[h->fault.first];
        }
    }
}

mukca_verdict mukca_verdict_of(const mukca_diagnosis *d, double any, double outside)
{
    double named = 0;
    if (!d->n_findings)
        return any < MUKCA_FINDING_SURE         ? MUKCA_VERDICT_NONE
               : outside >= MUKCA_FINDING_MAYBE ? MUKCA_VERDICT_UNKNOWN
                                                : MUKCA_VERDICT_TIED;
    for (int i = 0; i < d->n_findings; i++) {
        const mukca_finding_group *g = &d->findings[i].group;
        const bool whole_arm = g->effect >= 0 && !mukca_effect_has_joint(g->effect);
        if (g->effect >= 0 && (g->from == g->to || whole_arm)) named += d->findings[i].share;
    }
    return named >= MUKCA_VERDICT_HALF                   ? MUKCA_VERDICT_NAMED
           : d->findings[0].outside > MUKCA_VERDICT_HALF ? MUKCA_VERDICT_UNKNOWN
                                                         : MUKCA_VERDICT_TIED;
}

/* Describe the members of the set to which the regression is fitted: causes, suspected ones and
 * faults. */
static void list_causes(mukca_diagnosis *d, mukca_search *search, const mukca_causes *best)
{
    const mukca_unknowns *u = &search->m->unknowns;
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        mukca_cause *cause = &d->causes[d->n_causes];
        const int class = mukca_candidate_class(h);
        if (class == MUKCA_CLASS_OUTLIER) add_outlier(d, search->m, &u->cause[c]);
        if (class >= MUKCA_EFFECT_COUNT || d->n_causes == MUKCA_MAX_CAUSES) continue;
        mukca_cause_describe(cause, search, best, c);
        const mukca_label l = mukca_candidate_label(h, &search->m->recording, u);
        cause->applied = false; /* of the alternatives of a finding, that of this set is */
        for (int f = 0; f < d->n_findings; f++)
            cause->applied |= mukca_finding_holds(&d->findings[f].group, &l);
        if (!cause->applied && cause->probability < MUKCA_SUSPECTED) continue;
        /* other causes may turn a sign that physics excludes */
        if (mukca_effect_table[class]->nonnegative && !(cause->amplitude > 0)) continue;
        d->n_causes++;
        const bool rivalled =
            cause->n_ties || (cause->or_unknown && cause->probability >= MUKCA_SUSPECTED);
        cause->suspected = cause->probability < MUKCA_LISTED && !(cause->applied && rivalled);
        if (!cause->suspected && mukca_effect_table[class]->site == MUKCA_SITE_SOCKET)
            mukca_screening_add(d, &search->m->recording, MUKCA_FAULT_TOOL_MOTION, h->fault.first,
                                cause->amplitude);
    }
    qsort(d->causes, (size_t)d->n_causes, sizeof *d->causes, by_evidence);
    const int n = d->n_causes;
    d->n_causes = 0;
    for (int c = 0; c < n; c++)
        if (d->causes[c].suspected)
            d->suspected[d->n_suspected++] = d->causes[c];
        else
            d->causes[d->n_causes++] = d->causes[c];
}

void mukca_verdict_reach(mukca_diagnosis *d, mukca_search *search)
{
    mukca_regression *m = search->m;
    const mukca_causes *best = choose_set(d, search);
    const double any = mukca_verdict_probability(search, -1),
                 unknown = mukca_verdict_probability(search, MUKCA_CLASS_UNKNOWN);
    if (best != &search->set[0]) mukca_identify_fit(search, best);
    mukca_regression_factor(m); /* intervals are those of the full model */
    d->structure = -HUGE_VAL;
    for (int c = 0; c < best->n; c++)
        if (mukca_candidate_class(&search->all.list[best->candidate[c]]) == MUKCA_CLASS_UNKNOWN)
            d->structure = fmax(d->structure, mukca_cause_gain(search, best, c));
    list_causes(d, search, best);
    d->verdict = mukca_verdict_of(d, any, unknown);
    find_where(d, search, unknown >= MUKCA_LISTED);
    list_sets(d, search);
    d->unexplained = unknown >= MUKCA_LISTED && d->n_causes;
}
