/* What a competition found, told: causes with size, probability and ties, verdict, where it lies.
 */
#include "diagnose/verdict.h"

#include <math.h>
#include <string.h>

#include "diagnose/screening.h"
#include "diagnose/untested.h"

/* Ties: within this much log odds, or twice that where the two do nearly the same (canonical
 * correlation after geometry is projected out). */
#define TIE_ODDS 3.0
#define TIE_CORRELATION 0.9
/* Probability from which a function that no effect makes is told beside a cause. */
#define UNKNOWN_SHARE 0.25

/* Elastic causes were fitted with one factor per mass, and are told as the one coefficient that
 * does most nearly the same to the recorded rows: sum of weight[t] coefficient[t]. */
static void load_weights(double *weight, const mukca_regression *m, const mukca_candidate *h)
{
    memset(weight, 0, sizeof *weight * MUKCA_MAX_COLUMNS);
    for (int i = 0; i < m->recording.n_samples; i++) {
        const float *basis =
            h->basis + (size_t)m->recording.order[i] * (size_t)(h->terms * h->width_of_term);
        for (int t = 0; t < h->terms; t++)
            for (int k = 0; k < h->width_of_term; k++)
                weight[t] += (double)basis[t * h->width_of_term + k] * (double)basis[k];
    }
    const double square = weight[0];
    for (int t = 0; t < h->terms; t++) weight[t] = square > 0 ? weight[t] / square : t == 0;
}

static void effect_coefficients(mukca_cause *out, const mukca_regression *m,
                                const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    mukca_effect *effect = &out->effect;
    *effect = mukca_candidate_effect(h);
    if (mukca_candidate_by_mass(h)) {
        double weight[MUKCA_MAX_COLUMNS];
        load_weights(weight, m, h);
        for (int t = 0; t < h->terms; t++)
            effect->coefficient[0] += weight[t] * cause->coefficient[t];
        return;
    }
    for (int t = 0; t < effect->terms && t < MUKCA_MAX_TERMS; t++)
        effect->coefficient[t] = cause->coefficient[t];
}

/* Size of a cause and its 95 % interval from the posterior covariance (delta method). */
static void measure(mukca_cause *out, mukca_regression *m, int index)
{
    const mukca_candidate *h = &m->unknowns.cause[index].candidate;
    const int terms = out->effect.terms;
    int column = m->unknowns.n_geometry;
    double direction[MUKCA_MAX_COLUMNS] = {1};
    for (int c = 0; c < index; c++) column += m->unknowns.cause[c].candidate.terms;
    out->amplitude = out->effect.coefficient[0];
    if (terms > 1) {
        double square = 0;
        for (int t = 0; t < terms; t++)
            square += out->effect.coefficient[t] * out->effect.coefficient[t];
        out->amplitude = sqrt(square);
        for (int t = 0; t < terms; t++) {
            const double one = 1;
            direction[t] = square > 0 ? out->effect.coefficient[t] / out->amplitude : 0;
            out->sigma[t] = mukca_regression_standard_error(m, column + t, &one, 1);
        }
    } else if (mukca_candidate_by_mass(h)) {
        load_weights(direction, m, h);
    }
    const double sigma = mukca_regression_standard_error(m, column, direction, h->terms);
    const double half = 1.959963984540054 * sigma;
    if (terms == 1) out->sigma[0] = sigma;
    out->low = out->amplitude - half;
    out->high = out->amplitude + half;
    if (terms > 1 || mukca_effect_table[out->effect.kind].nonnegative) out->low = fmax(out->low, 0);
}

/* The effect of a tied hypothesis, of a size that moves the joints about as much as the cause. */
static mukca_effect rival_effect(const mukca_candidate *h, const mukca_effect *cause,
                                 const mukca_candidate *of)
{
    mukca_effect rival = mukca_candidate_effect(h);
    double square = 0;
    for (int t = 0; t < cause->terms; t++) square += pow(cause->coefficient[t] * of->unit[0], 2);
    rival.terms = mukca_effect_terms(rival.kind, rival.variant);
    for (int t = 0; t < rival.terms; t++)
        rival.coefficient[t] = sqrt(square / rival.terms) / h->unit[0];
    return rival;
}

/* Without masses nobody knows the load, and what gravity bends looks like a smooth error of the
 * angle: such a name shares its place with the flexibility that cannot be tested. */
static void tie_untested_flexibility(mukca_cause *out, const mukca_competition *contest)
{
    const mukca_regression *m = contest->m;
    const mukca_effect_kind kind = out->effect.kind;
    const unsigned char *disabled = contest->options->disabled;
    const bool smooth = kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                        kind == MUKCA_EFFECT_JOINT_SCALE || kind == MUKCA_EFFECT_JOINT_COUPLING ||
                        kind == MUKCA_EFFECT_AXIS_WOBBLE ||
                        (kind == MUKCA_EFFECT_GEAR_HARMONIC && out->effect.variant <= 3);
    if (m->recording.have_torques || !smooth || out->n_ties == MUKCA_MAX_TIES ||
        (disabled && disabled[MUKCA_EFFECT_JOINT_COMPLIANCE]))
        return;
    out->ties[out->n_ties++] = (mukca_tie){.effect = MUKCA_EFFECT_JOINT_COMPLIANCE,
                                           .joint = out->effect.joint,
                                           .log_bayes_factor = NAN,
                                           .correlation = NAN};
}

static void add_ties(mukca_cause *out, mukca_competition *contest, int index)
{
    mukca_regression *m = contest->m;
    const double best = contest->n_table ? contest->table[0].log_odds : 0;
    for (int i = 0; i < contest->n_table && out->n_ties < MUKCA_MAX_TIES; i++) {
        const mukca_contender *c = &contest->table[i];
        if (c->log_odds < best - 2 * TIE_ODDS) break;
        if (c->class >= MUKCA_EFFECT_COUNT) continue;
        if (c->class == (int)out->effect.kind && c->joint == out->effect.joint) continue;
        bool listed = false;
        for (int t = 0; t < out->n_ties; t++)
            listed |= (int)out->ties[t].effect == c->class && out->ties[t].joint == c->joint;
        if (listed) continue;
        const mukca_candidate *cause = &m->unknowns.cause[index].candidate;
        const mukca_candidate *rival = mukca_scan_hypothesis(contest->scan, c->best);
        const double correlation = mukca_scan_correlation(contest->scan, m, index, cause, rival);
        if (c->log_odds < best - TIE_ODDS && !(correlation > TIE_CORRELATION)) continue;
        out->ties[out->n_ties++] =
            (mukca_tie){.effect = (mukca_effect_kind)c->class,
                        .joint = c->joint,
                        .log_bayes_factor = contest->scan->score[c->best].log_bayes,
                        .correlation = correlation,
                        .rival = rival_effect(rival, &out->effect, cause)};
    }
}

typedef struct {
    double log_odds;
    int index;
    double unknown_share[MUKCA_MAX_JOINTS];
} standing;

/* One cause of the final model, told: who else could it be, how probable, how large. */
static void tell_cause(mukca_diagnosis *d, mukca_competition *contest, int index, standing *place)
{
    mukca_regression *m = contest->m;
    const mukca_candidate h = m->unknowns.cause[index].candidate;
    mukca_scan_run(contest->scan, m, index, MUKCA_SCAN_CONTENDERS);
    mukca_competition_rank(contest);
    int others = 0;
    for (int i = 0; i < contest->n_table; i++)
        if (!mukca_competition_taken(contest, &contest->table[i], index))
            contest->table[others++] = contest->table[i];
    contest->n_table = others;
    double total = 0, own = 0;
    const double best = fmax(contest->n_table ? contest->table[0].log_odds : 0, 0);
    const int class = mukca_candidate_class(&h);
    const mukca_contender *mine = NULL;
    memset(place, 0, sizeof *place);
    place->index = -1;
    for (int i = 0; i < contest->n_table; i++) {
        const mukca_contender *c = &contest->table[i];
        const double p = exp(c->log_odds - best);
        total += p;
        const mukca_candidate *member = mukca_scan_hypothesis(contest->scan, c->best);
        if (c->class == MUKCA_CLASS_UNKNOWN) place->unknown_share[c->joint] += p;
        if (c->class == class && c->joint == h.joint &&
            (class != MUKCA_EFFECT_TOOL_MOTION || member->fault.group == h.fault.group)) {
            own += p;
            if (!mine) mine = c;
        }
    }
    total += exp(-best);
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) place->unknown_share[j] /= total;
    place->log_odds = mine ? mine->log_odds : -HUGE_VAL;
    if (class >= MUKCA_EFFECT_COUNT || d->n_causes == MUKCA_MAX_CAUSES) return;
    mukca_cause *out = &d->causes[d->n_causes];
    memset(out, 0, sizeof *out);
    out->held_out = d->held_out; /* not measured yet */
    out->socket = -1;
    effect_coefficients(out, m, &m->unknowns.cause[index]);
    out->log_bayes_factor = mine ? contest->scan->score[mine->best].log_bayes : -HUGE_VAL;
    out->probability = fmin(own / total, 1);
    add_ties(out, contest, index);
    double unknown = 0;
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) unknown += place->unknown_share[j];
    out->or_unknown = unknown > UNKNOWN_SHARE;
    tie_untested_flexibility(out, contest);
    if (h.kind == MUKCA_CANDIDATE_STEP || h.kind == MUKCA_CANDIDATE_CREEP) {
        out->socket = m->recording.groups[h.fault.group].socket;
        out->row = m->recording.data->row[h.fault.first];
        out->file = m->recording.data->file[h.fault.first];
        out->creep = h.kind == MUKCA_CANDIDATE_CREEP;
    }
    place->index = d->n_causes++;
}

static void tell_spike(mukca_diagnosis *d, const mukca_regression *m, const mukca_accepted *cause)
{
    double size = 0;
    for (int c = 0; c < 3; c++) size += cause->coefficient[c] * cause->coefficient[c];
    if (sqrt(size) > 12 * m->unknowns.sigma)
        for (int row = cause->candidate.fault.first; row <= cause->candidate.fault.last; row++)
            mukca_screening_add(d, m, MUKCA_FAULT_OUTLIER, row, sqrt(size));
}

/* Where an unknown function of a joint's angle departs from its mean by half its largest. */
static void unknown_range(double range[2], const mukca_regression *m, const mukca_accepted *cause)
{
    const mukca_candidate *h = &cause->candidate;
    const int n_joints = m->recording.chain->n_joints;
    const int argument =
        h->kind == MUKCA_CANDIDATE_OWN_ANGLE ? h->joint
        : h->kind == MUKCA_CANDIDATE_OTHER_ANGLE || h->kind == MUKCA_CANDIDATE_ANGLE_PRODUCT
            ? h->other
            : -1;
    double mean = 0, largest = 0;
    for (int pass = 0; pass < 3; pass++)
        for (int i = 0; i < m->recording.n_samples; i++) {
            const int row = m->recording.order[i];
            double value = 0;
            for (int t = 0; t < h->terms; t++)
                value += cause->coefficient[t] * (double)h->basis[row * h->terms + t];
            if (pass == 0) mean += value / m->recording.n_samples;
            if (pass == 1) largest = fmax(largest, fabs(value - mean));
            if (pass < 2 || fabs(value - mean) < 0.5 * largest) continue;
            if (argument < 0) continue;
            const double q = m->recording.data->q[row * n_joints + argument];
            range[0] = fmin(range[0], q), range[1] = fmax(range[1], q);
        }
}

static void tell_where(mukca_diagnosis *d, const mukca_regression *m, const standing *place, int n)
{
    double share[MUKCA_MAX_JOINTS] = {0}, total = 0;
    const int n_joints = m->recording.chain->n_joints;
    bool unknown = false;
    for (int c = 0; c < n; c++)
        unknown |= mukca_candidate_class(&m->unknowns.cause[c].candidate) == MUKCA_CLASS_UNKNOWN;
    for (int c = 0; c < n; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (unknown) {
            if (mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN)
                for (int j = 0; j < n_joints; j++) share[j] += place[c].unknown_share[j];
        } else if (h->joint >= 0) {
            share[h->joint] += fmax(place[c].log_odds, 0);
        }
    }
    for (int j = 0; j < n_joints; j++) total += share[j];
    for (int j = 0; j < n_joints; j++) {
        if (!(share[j] > 0)) continue;
        mukca_where *w = &d->where[d->n_where++];
        *w = (mukca_where){j, share[j] / total, {HUGE_VAL, -HUGE_VAL}};
        for (int c = 0; c < n; c++)
            if (mukca_candidate_class(&m->unknowns.cause[c].candidate) == MUKCA_CLASS_UNKNOWN &&
                m->unknowns.cause[c].candidate.joint == j)
                unknown_range(w->range_rad, m, &m->unknowns.cause[c]);
        if (w->range_rad[0] > w->range_rad[1])
            for (int i = 0; i < m->recording.n_samples; i++) {
                const double q = m->recording.data->q[m->recording.order[i] * n_joints + j];
                w->range_rad[0] = fmin(w->range_rad[0], q);
                w->range_rad[1] = fmax(w->range_rad[1], q);
            }
    }
    for (int i = 1; i < d->n_where; i++) /* largest share first */
        for (int k = i; k > 0 && d->where[k].share > d->where[k - 1].share; k--) {
            const mukca_where swap = d->where[k];
            d->where[k] = d->where[k - 1];
            d->where[k - 1] = swap;
        }
}

/* What each (effect, joint) scored alone, and what these data could show of it at all. */
static void tell_tested(mukca_diagnosis *d, const mukca_competition *contest)
{
    for (int i = 0; i < contest->n_first && d->n_tested < MUKCA_MAX_TESTED; i++) {
        const mukca_contender *c = &contest->first[i];
        if (c->class >= MUKCA_EFFECT_COUNT) continue;
        bool listed = false;
        for (int t = 0; t < d->n_tested && !listed; t++)
            listed = (int)d->tested[t].effect == c->class && d->tested[t].joint == c->joint;
        if (listed) continue;
        const mukca_score *score = &contest->first_score[c->best];
        /* Log evidence grows as amplitude^2 information / 2 and must beat prior odds, Occam's
         * factor and the threshold: some 12 in all. */
        const double limit = sqrt(24 / fmax(score->information, 1e-12));
        const mukca_effect_site site = mukca_effect_table[c->class].site;
        const bool length = site == MUKCA_SITE_TIP || site == MUKCA_SITE_SOCKET;
        const bool testable = limit < (length ? 20e-3 : 10e-3);
        d->tested[d->n_tested++] =
            (mukca_tested){(mukca_effect_kind)c->class,
                           c->joint,
                           score->log_bayes,
                           c->log_odds,
                           limit,
                           testable,
                           testable ? NULL : mukca_untested_faint(c->class, c->joint)};
    }
    mukca_untested_add(d, &contest->m->recording, contest->all);
}

/* Beside a larger thing that nobody can name, smaller names are not to be trusted: only what
 * happened to the tool stays. */
static int drop_doubtful(mukca_diagnosis *d, int used)
{
    int kept = 0;
    for (int i = 0; i < used; i++)
        if (d->causes[i].effect.kind == MUKCA_EFFECT_TOOL_MOTION) d->causes[kept++] = d->causes[i];
    d->n_causes = kept;
    return kept;
}

/* Is a cause unknown, or a smooth function of the angle of a joint in which something unknown was
 * found, too, of about its weight: a part of that?  (A single bad row is neither.) */
static bool part_of_unknown(const mukca_regression *m, const standing *place, int cause)
{
    const mukca_candidate *h = &m->unknowns.cause[cause].candidate;
    const mukca_effect_kind kind = h->effect.kind;
    if (mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN) return true;
    if (h->kind != MUKCA_CANDIDATE_EFFECT ||
        !(kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY || kind == MUKCA_EFFECT_JOINT_SCALE ||
          kind == MUKCA_EFFECT_GEAR_HARMONIC))
        return false;
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *other = &m->unknowns.cause[c].candidate;
        if (mukca_candidate_class(other) == MUKCA_CLASS_UNKNOWN && other->joint == h->joint &&
            place[c].log_odds > 0.5 * place[cause].log_odds)
            return true;
    }
    return false;
}

void mukca_verdict_reach(mukca_diagnosis *d, mukca_competition *contest)
{
    mukca_regression *m = contest->m;
    standing place[MUKCA_MAX_ACCEPTED] = {0};
    mukca_cause sorted[MUKCA_MAX_CAUSES];
    double leading = -HUGE_VAL, unknown = -HUGE_VAL, known = -HUGE_VAL;
    const int n = m->unknowns.n_causes;
    for (int c = 0; c < n; c++) {
        if (m->unknowns.cause[c].candidate.kind == MUKCA_CANDIDATE_OUTLIER) {
            memset(&place[c], 0, sizeof place[c]);
            place[c].index = -1, place[c].log_odds = -HUGE_VAL;
            tell_spike(d, m, &m->unknowns.cause[c]);
            continue;
        }
        tell_cause(d, contest, c, &place[c]);
        leading = fmax(leading, place[c].log_odds);
    }
    for (int c = 0; c < n; c++) {
        double *of = part_of_unknown(m, place, c) ? &unknown : &known;
        *of = fmax(*of, place[c].log_odds);
    }
    /* Intervals need the factor of the full model. */
    mukca_regression_factor(m);
    for (int c = 0; c < n; c++)
        if (place[c].index >= 0) measure(&d->causes[place[c].index], m, c);

    int order[MUKCA_MAX_CAUSES], used = 0;
    for (int c = 0; c < n; c++)
        if (place[c].index >= 0) order[used++] = c;
    for (int i = 1; i < used; i++)
        for (int k = i; k > 0 && place[order[k]].log_odds > place[order[k - 1]].log_odds; k--) {
            const int swap = order[k];
            order[k] = order[k - 1], order[k - 1] = swap;
        }
    for (int i = 0; i < used; i++) sorted[i] = d->causes[place[order[i]].index];
    memcpy(d->causes, sorted, sizeof *sorted * (size_t)used);
    for (int i = 0; i < used; i++)
        if (d->causes[i].effect.kind == MUKCA_EFFECT_TOOL_MOTION) {
            const mukca_candidate *h = &m->unknowns.cause[order[i]].candidate;
            mukca_screening_add(d, m, MUKCA_FAULT_TOOL_MOTION, h->fault.first,
                                d->causes[i].amplitude);
        }
    const bool any_unknown = unknown > -HUGE_VAL;
    if (any_unknown && unknown >= known) used = drop_doubtful(d, used);
    bool ties = false;
    for (int i = 0; i < used; i++) ties |= d->causes[i].n_ties > 0 || d->causes[i].or_unknown;
    d->verdict = !(leading > -HUGE_VAL)            ? MUKCA_VERDICT_NONE
                 : any_unknown && unknown >= known ? MUKCA_VERDICT_UNKNOWN
                 : ties                            ? MUKCA_VERDICT_TIED
                                                   : MUKCA_VERDICT_NAMED;
    d->unexplained = any_unknown && used > 0;
    tell_where(d, m, place, n);
    tell_tested(d, contest);
}
