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
static void load_weights(double *weight, const gap_model *m, const gap_hypothesis *h)
{
    memset(weight, 0, sizeof *weight * GAP_MAX_TERMS);
    for (int i = 0; i < m->n; i++) {
        const float *basis = h->basis + (size_t)m->order[i] * (size_t)(h->terms * h->width);
        for (int t = 0; t < h->terms; t++)
            for (int k = 0; k < h->width; k++)
                weight[t] += (double)basis[t * h->width + k] * (double)basis[k];
    }
    const double square = weight[0];
    for (int t = 0; t < h->terms; t++) weight[t] = square > 0 ? weight[t] / square : t == 0;
}

static void effect_coefficients(mukca_cause *out, const gap_model *m, const gap_cause *cause)
{
    const gap_hypothesis *h = &cause->hypothesis;
    mukca_effect *effect = &out->effect;
    *effect = h->effect;
    effect->terms =
        h->kind == GAP_EFFECT ? mukca_effect_terms(effect->kind, effect->variant) : h->terms;
    if (gap_hypothesis_by_mass(h)) {
        double weight[GAP_MAX_TERMS];
        load_weights(weight, m, h);
        for (int t = 0; t < h->terms; t++)
            effect->coefficient[0] += weight[t] * cause->coefficient[t];
        return;
    }
    for (int t = 0; t < effect->terms && t < MUKCA_MAX_TERMS; t++)
        effect->coefficient[t] = cause->coefficient[t];
}

/* Size of a cause and its 95 % interval from the posterior covariance (delta method). */
static void measure(mukca_cause *out, gap_model *m, int index)
{
    const gap_hypothesis *h = &m->cause[index].hypothesis;
    const int terms = out->effect.terms;
    int column = m->n_geometry;
    double direction[GAP_MAX_TERMS] = {1};
    for (int c = 0; c < index; c++) column += m->cause[c].hypothesis.terms;
    out->amplitude = out->effect.coefficient[0];
    if (terms > 1) {
        double square = 0;
        for (int t = 0; t < terms; t++)
            square += out->effect.coefficient[t] * out->effect.coefficient[t];
        out->amplitude = sqrt(square);
        for (int t = 0; t < terms; t++) {
            const double one = 1;
            direction[t] = square > 0 ? out->effect.coefficient[t] / out->amplitude : 0;
            out->sigma[t] = gap_model_standard_error(m, column + t, &one, 1);
        }
    } else if (gap_hypothesis_by_mass(h)) {
        load_weights(direction, m, h);
    }
    const double sigma = gap_model_standard_error(m, column, direction, h->terms);
    const double half = 1.959963984540054 * sigma;
    if (terms == 1) out->sigma[0] = sigma;
    out->low = out->amplitude - half;
    out->high = out->amplitude + half;
    if (terms > 1 || mukca_effect_table[out->effect.kind].nonnegative) out->low = fmax(out->low, 0);
}

/* The effect of a tied hypothesis, of a size that moves the joints about as much as the cause. */
static mukca_effect rival_effect(const gap_hypothesis *h, const mukca_effect *cause,
                                 const gap_hypothesis *of)
{
    mukca_effect rival = h->effect;
    double square = 0;
    for (int t = 0; t < cause->terms; t++) square += pow(cause->coefficient[t] * of->unit[0], 2);
    rival.terms = mukca_effect_terms(rival.kind, rival.variant);
    for (int t = 0; t < rival.terms; t++)
        rival.coefficient[t] = sqrt(square / rival.terms) / h->unit[0];
    return rival;
}

/* Without masses nobody knows the load, and what gravity bends looks like a smooth error of the
 * angle: such a name shares its place with the flexibility that cannot be tested. */
static void tie_untested_flexibility(mukca_cause *out, const gap_contest *contest)
{
    const gap_model *m = contest->m;
    const mukca_effect_kind kind = out->effect.kind;
    const unsigned char *disabled = contest->options->disabled;
    const bool smooth = kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY ||
                        kind == MUKCA_EFFECT_JOINT_SCALE || kind == MUKCA_EFFECT_JOINT_COUPLING ||
                        kind == MUKCA_EFFECT_AXIS_WOBBLE ||
                        (kind == MUKCA_EFFECT_GEAR_HARMONIC && out->effect.variant <= 3);
    if (m->have_torques || !smooth || out->n_ties == MUKCA_MAX_TIES ||
        (disabled && disabled[MUKCA_EFFECT_JOINT_COMPLIANCE]))
        return;
    out->ties[out->n_ties++] = (mukca_tie){.effect = MUKCA_EFFECT_JOINT_COMPLIANCE,
                                           .joint = out->effect.joint,
                                           .log_bayes_factor = NAN,
                                           .correlation = NAN};
}

static void add_ties(mukca_cause *out, gap_contest *contest, int index)
{
    gap_model *m = contest->m;
    const double best = contest->n_table ? contest->table[0].log_odds : 0;
    for (int i = 0; i < contest->n_table && out->n_ties < MUKCA_MAX_TIES; i++) {
        const gap_candidate *c = &contest->table[i];
        if (c->log_odds < best - 2 * TIE_ODDS) break;
        if (c->class >= MUKCA_EFFECT_COUNT) continue;
        if (c->class == (int)out->effect.kind && c->joint == out->effect.joint) continue;
        bool listed = false;
        for (int t = 0; t < out->n_ties; t++)
            listed |= (int)out->ties[t].effect == c->class && out->ties[t].joint == c->joint;
        if (listed) continue;
        const gap_hypothesis *cause = &m->cause[index].hypothesis;
        const gap_hypothesis *rival = gap_scan_hypothesis(contest->scan, c->best);
        const double correlation = gap_scan_correlation(contest->scan, m, index, cause, rival);
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
static void tell_cause(mukca_diagnosis *d, gap_contest *contest, int index, standing *place)
{
    gap_model *m = contest->m;
    const gap_hypothesis h = m->cause[index].hypothesis;
    gap_scan_run(contest->scan, m, index, GAP_SCAN_CONTENDERS);
    gap_compete_rank(contest);
    int others = 0;
    for (int i = 0; i < contest->n_table; i++)
        if (!gap_compete_taken(contest, &contest->table[i], index))
            contest->table[others++] = contest->table[i];
    contest->n_table = others;
    double total = 0, own = 0;
    const double best = fmax(contest->n_table ? contest->table[0].log_odds : 0, 0);
    const int class = gap_hypothesis_class(&h);
    const gap_candidate *mine = NULL;
    memset(place, 0, sizeof *place);
    place->index = -1;
    for (int i = 0; i < contest->n_table; i++) {
        const gap_candidate *c = &contest->table[i];
        const double p = exp(c->log_odds - best);
        total += p;
        const gap_hypothesis *member = gap_scan_hypothesis(contest->scan, c->best);
        if (c->class == GAP_CLASS_UNKNOWN) place->unknown_share[c->joint] += p;
        if (c->class == class && c->joint == h.effect.joint &&
            (class != MUKCA_EFFECT_TOOL_MOTION || member->group == h.group)) {
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
    effect_coefficients(out, m, &m->cause[index]);
    out->log_bayes_factor = mine ? contest->scan->score[mine->best].log_bayes : -HUGE_VAL;
    out->probability = fmin(own / total, 1);
    add_ties(out, contest, index);
    double unknown = 0;
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) unknown += place->unknown_share[j];
    out->or_unknown = unknown > UNKNOWN_SHARE;
    tie_untested_flexibility(out, contest);
    if (h.kind == GAP_STEP || h.kind == GAP_CREEP) {
        out->socket = m->groups[h.group].socket;
        out->row = m->data->row[h.row];
        out->file = m->data->file[h.row];
        out->creep = h.kind == GAP_CREEP;
    }
    place->index = d->n_causes++;
}

static void tell_spike(mukca_diagnosis *d, const gap_model *m, const gap_cause *cause)
{
    double size = 0;
    for (int c = 0; c < 3; c++) size += cause->coefficient[c] * cause->coefficient[c];
    if (sqrt(size) > 12 * m->sigma)
        for (int row = cause->hypothesis.row; row <= cause->hypothesis.last; row++)
            gap_fault_add(d, m, MUKCA_FAULT_OUTLIER, row, sqrt(size));
}

/* Where an unknown function of a joint's angle departs from its mean by half its largest. */
static void unknown_range(double range[2], const gap_model *m, const gap_cause *cause)
{
    const gap_hypothesis *h = &cause->hypothesis;
    const int n_joints = m->chain->n_joints;
    double mean = 0, largest = 0;
    for (int pass = 0; pass < 3; pass++)
        for (int i = 0; i < m->n; i++) {
            const int row = m->order[i];
            double value = 0;
            for (int t = 0; t < h->terms; t++)
                value += cause->coefficient[t] * (double)h->basis[row * h->terms + t];
            if (pass == 0) mean += value / m->n;
            if (pass == 1) largest = fmax(largest, fabs(value - mean));
            if (pass < 2 || fabs(value - mean) < 0.5 * largest) continue;
            if (h->driver < 0) continue;
            const double q = m->data->q[row * n_joints + h->driver];
            range[0] = fmin(range[0], q), range[1] = fmax(range[1], q);
        }
}

static void tell_where(mukca_diagnosis *d, const gap_model *m, const standing *place, int n)
{
    double share[MUKCA_MAX_JOINTS] = {0}, total = 0;
    const int n_joints = m->chain->n_joints;
    bool unknown = false;
    for (int c = 0; c < n; c++)
        unknown |= gap_hypothesis_class(&m->cause[c].hypothesis) == GAP_CLASS_UNKNOWN;
    for (int c = 0; c < n; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        if (unknown) {
            if (gap_hypothesis_class(h) == GAP_CLASS_UNKNOWN)
                for (int j = 0; j < n_joints; j++) share[j] += place[c].unknown_share[j];
        } else if (h->effect.joint >= 0) {
            share[h->effect.joint] += fmax(place[c].log_odds, 0);
        }
    }
    for (int j = 0; j < n_joints; j++) total += share[j];
    for (int j = 0; j < n_joints; j++) {
        if (!(share[j] > 0)) continue;
        mukca_where *w = &d->where[d->n_where++];
        *w = (mukca_where){j, share[j] / total, {HUGE_VAL, -HUGE_VAL}};
        for (int c = 0; c < n; c++)
            if (m->cause[c].hypothesis.kind == GAP_BUMPS &&
                m->cause[c].hypothesis.effect.joint == j)
                unknown_range(w->range_rad, m, &m->cause[c]);
        if (w->range_rad[0] > w->range_rad[1])
            for (int i = 0; i < m->n; i++) {
                const double q = m->data->q[m->order[i] * n_joints + j];
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
static void tell_tested(mukca_diagnosis *d, const gap_contest *contest)
{
    for (int i = 0; i < contest->n_first && d->n_tested < MUKCA_MAX_TESTED; i++) {
        const gap_candidate *c = &contest->first[i];
        if (c->class >= MUKCA_EFFECT_COUNT) continue;
        bool listed = false;
        for (int t = 0; t < d->n_tested && !listed; t++)
            listed = (int)d->tested[t].effect == c->class && d->tested[t].joint == c->joint;
        if (listed) continue;
        const gap_score *score = &contest->first_score[c->best];
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
                           testable ? NULL : gap_untested_faint(c->class, c->joint)};
    }
    gap_untested_add(d, contest->m, contest->all);
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
static bool part_of_unknown(const gap_model *m, const standing *place, int cause)
{
    const gap_hypothesis *h = &m->cause[cause].hypothesis;
    const mukca_effect_kind kind = h->effect.kind;
    if (gap_hypothesis_class(h) == GAP_CLASS_UNKNOWN) return true;
    if (h->kind != GAP_EFFECT ||
        !(kind == MUKCA_EFFECT_ENCODER_ECCENTRICITY || kind == MUKCA_EFFECT_JOINT_SCALE ||
          kind == MUKCA_EFFECT_GEAR_HARMONIC))
        return false;
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *other = &m->cause[c].hypothesis;
        if (gap_hypothesis_class(other) == GAP_CLASS_UNKNOWN &&
            other->effect.joint == h->effect.joint &&
            place[c].log_odds > 0.5 * place[cause].log_odds)
            return true;
    }
    return false;
}

void gap_tell(mukca_diagnosis *d, gap_contest *contest)
{
    gap_model *m = contest->m;
    standing place[GAP_MAX_CAUSES] = {0};
    mukca_cause sorted[MUKCA_MAX_CAUSES];
    double leading = -HUGE_VAL, unknown = -HUGE_VAL, known = -HUGE_VAL;
    const int n = m->n_causes;
    for (int c = 0; c < n; c++) {
        if (m->cause[c].hypothesis.kind == GAP_SPIKE) {
            memset(&place[c], 0, sizeof place[c]);
            place[c].index = -1, place[c].log_odds = -HUGE_VAL;
            tell_spike(d, m, &m->cause[c]);
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
    for (int i = 0; i < GAP_RHOS; i++)
        if (gap_rho[i] == m->rho) {
            gap_model_pack(&m->pack[i], m, m->rho);
            gap_model_prior(m->prior, m, -1);
            gap_model_evidence(m, &m->pack[i], m->prior, m->sigma, NULL);
        }
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
            const gap_hypothesis *h = &m->cause[order[i]].hypothesis;
            gap_fault_add(d, m, MUKCA_FAULT_TOOL_MOTION, h->row, d->causes[i].amplitude);
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
