/* The verdict on the causes accepted in a competition: names, unexplained structure, location. */
#include "diagnose/verdict.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/cause.h"

/* Least size of an outlier that is reported as a fault, in sigmas of the noise. */
#define OUTLIER_SIGMAS 12

/* An accepted cause during the verdict. */
typedef struct {
    int index;        /* of the accepted cause */
    bool named, part; /* part: of an unknown function */
    mukca_standing standing;
    mukca_cause cause; /* if named */
} described;

static void add_outlier(mukca_faults *faults, const mukca_regression *m,
                        const mukca_accepted *cause)
{
    const double size = sqrt(mukca_dot3(cause->coefficient, cause->coefficient));
    if (size > OUTLIER_SIGMAS * m->unknowns.sigma)
        for (int row = cause->candidate.fault.first; row <= cause->candidate.fault.last; row++)
            mukca_screening_add(faults, &m->recording, MUKCA_FAULT_OUTLIER, row, size);
}

/* Widen range[2] to all angles at which an unknown function of a joint's angle deviates from its
 * mean by half its largest deviation or more. */
static void widen_by_unknown(double range[2], const mukca_recording *recording,
                             const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    const int n_joints = recording->chain->n_joints;
    const int argument =
        h->kind == MUKCA_CANDIDATE_OWN_ANGLE ? h->joint
        : h->kind == MUKCA_CANDIDATE_OTHER_ANGLE || h->kind == MUKCA_CANDIDATE_ANGLE_PRODUCT
            ? h->other
            : -1;
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

/* Share of each joint in the accepted causes, by odds; in the unknown functions alone, if any. */
static void find_where(mukca_findings *findings, const mukca_regression *m, const described *found)
{
    const mukca_recording *recording = &m->recording;
    const int n_joints = recording->chain->n_joints, n = m->unknowns.n_causes;
    double share[MUKCA_MAX_JOINTS] = {0}, total = 0;
    bool unknown = false;
    for (int c = 0; c < n; c++)
        unknown |= mukca_candidate_class(&m->unknowns.cause[c].candidate) == MUKCA_CLASS_UNKNOWN;
    for (int c = 0; c < n; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (!unknown && h->joint >= 0)
            share[h->joint] += fmax(found[c].standing.log_odds, 0);
        else if (mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN)
            for (int j = 0; j < n_joints; j++) share[j] += found[c].standing.by_joint[j];
    }
    for (int j = 0; j < n_joints; j++) total += share[j];
    for (int j = 0; j < n_joints; j++) {
        if (!(share[j] > 0)) continue;
        double range[2] = {HUGE_VAL, -HUGE_VAL};
        for (int c = 0; c < n; c++)
            if (m->unknowns.cause[c].candidate.joint == j)
                widen_by_unknown(range, recording, &m->unknowns.cause[c]);
        if (range[0] > range[1]) mukca_recording_travel(range, recording, j);
        findings->where[findings->n_where++] =
            (mukca_where){.joint = j, .share = share[j] / total, .range_rad = {range[0], range[1]}};
    }
    qsort(findings->where, (size_t)findings->n_where, sizeof *findings->where, by_share);
}

/* Is a named cause part of an accepted unknown function of similar odds: of the same joint's angle,
 * or of time? */
static bool part_of_unknown(const mukca_unknowns *u, const described *found, int cause)
{
    const mukca_effect *effect = &found[cause].cause.effect;
    const int kind = (int)effect->kind, joint = effect->joint;
    const bool timed = mukca_effect_has(kind, MUKCA_TRAIT_OF_TIME | MUKCA_TRAIT_PER_PLACEMENT);
    const bool smooth = mukca_effect_has(kind, MUKCA_TRAIT_SMOOTH | MUKCA_TRAIT_PERIODIC) &&
                        effect->variant.order <= MUKCA_SMOOTH_ORDER;
    for (int c = 0; c < u->n_causes; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (mukca_candidate_class(h) != MUKCA_CLASS_UNKNOWN ||
            !(found[c].standing.log_odds > 0.5 * found[cause].standing.log_odds))
            continue;
        const bool of_time = h->kind == MUKCA_CANDIDATE_TIME || h->kind == MUKCA_CANDIDATE_SLIP ||
                             h->kind == MUKCA_CANDIDATE_STRETCH;
        if (of_time ? timed : smooth && h->joint == joint) return true;
    }
    return false;
}

/* Is a cause reported: more probable than not, or with rivals?  Least probability with named
 * rivals: that of a tie, with an unknown function: one in five.  An amplitude of a sign that
 * physics excludes is not reported: the score respects the sign, but other causes may turn it. */
static bool is_reported(const mukca_cause *cause)
{
    if (mukca_effect_table[cause->effect.kind]->nonnegative && !(cause->amplitude > 0))
        return false;
    double probability = cause->probability;
    bool rivals = false;
    for (int t = 0; t < cause->n_ties; t++)
        if (isnan(cause->ties[t].log_bayes_factor))
            probability *= 2; /* tied with an untested effect */
        else
            rivals = true;
    return probability >= (rivals ? exp(-MUKCA_TIE_MOST) : cause->or_unknown ? 0.2 : 0.5);
}

static int by_odds(const void *a, const void *b)
{
    const described *x = a, *y = b;
    const double p = x->standing.log_odds, q = y->standing.log_odds;
    return p != q ? (p < q) - (p > q) : x->index - y->index;
}

/* Log odds of the strongest unexplained structure: of an unknown function, or of a name that one
 * may replace. */
static double unnamed_structure(const described *found, int n)
{
    double most = -HUGE_VAL;
    for (int c = 0; c < n; c++)
        if (found[c].standing.unknown > MUKCA_UNKNOWN_SHARE)
            most = fmax(most, found[c].standing.log_odds);
    return most;
}

/* One unknown function rarely fits an unlisted cause completely, and the nearest names share the
 * remainder: those with less evidence are in doubt.  Fine ripple resembles no smooth function. */
static bool is_remainder(const described *d, double structure)
{
    return d->standing.log_odds < structure && d->cause.effect.variant.order <= MUKCA_FINE_ORDER;
}

void mukca_verdict_reach(mukca_findings *findings, mukca_faults *faults, mukca_competition *contest)
{
    mukca_regression *m = contest->m;
    const mukca_unknowns *u = &m->unknowns;
    described found[MUKCA_MAX_ACCEPTED];
    int named = 0, on_arm = 0;
    bool unknown = false, tied = false;
    memset(findings, 0, sizeof *findings);
    for (int c = 0; c < u->n_causes; c++) {
        found[c] = (described){.index = c, .standing = {.log_odds = -HUGE_VAL}};
        unknown |= mukca_candidate_class(&u->cause[c].candidate) == MUKCA_CLASS_UNKNOWN;
        if (u->cause[c].candidate.kind == MUKCA_CANDIDATE_OUTLIER)
            add_outlier(faults, m, &u->cause[c]);
        else
            found[c].named = mukca_cause_describe(named < MUKCA_MAX_CAUSES ? &found[c].cause : NULL,
                                                  &found[c].standing, contest, c);
        named += found[c].named;
    }
    find_where(findings, m, found);
    mukca_regression_factor(m); /* intervals are those of the full model */
    for (int c = 0; c < u->n_causes; c++)
        if (found[c].named) {
            mukca_cause_measure(&found[c].cause, m, c);
            found[c].part = part_of_unknown(u, found, c);
        }
    qsort(found, (size_t)u->n_causes, sizeof *found, by_odds);
    const double structure = unnamed_structure(found, u->n_causes);

    for (int c = 0; c < u->n_causes; c++) {
        mukca_cause *cause = &found[c].cause;
        if (!found[c].named) continue;
        const bool moved = mukca_effect_table[cause->effect.kind]->site == MUKCA_SITE_SOCKET;
        if (moved)
            mukca_screening_add(faults, &m->recording, MUKCA_FAULT_TOOL_MOTION,
                                u->cause[found[c].index].candidate.fault.first, cause->amplitude);
        if (found[c].part || !is_reported(cause)) {
            unknown = true;
            continue;
        }
        if (is_remainder(&found[c], structure)) mukca_cause_doubt(cause);
        on_arm += !moved;
        tied |= cause->n_ties > 0 || cause->or_unknown;
        findings->causes[findings->n_causes++] = *cause;
    }
    findings->verdict = unknown && !on_arm    ? MUKCA_VERDICT_UNKNOWN
                        : !findings->n_causes ? MUKCA_VERDICT_NONE
                        : tied                ? MUKCA_VERDICT_TIED
                                              : MUKCA_VERDICT_NAMED;
    findings->unexplained = unknown && findings->n_causes > 0;
}
