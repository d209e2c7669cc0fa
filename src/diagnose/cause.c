/* Description of an accepted cause: size, probability and rivals. */
#include "diagnose/cause.h"

#include <math.h>
#include <string.h>

#include "diagnose/resolution.h"

/* Ties: within half of MUKCA_TIE_MOST (20 to 1), or within all of it above this canonical
 * correlation (geometry projected out). */
#define TIE_CORRELATION 0.9
/* A probability too small to change a verdict. */
#define LITTLE 0.05
#define PI 3.14159265358979323846
/* Half width of a 95 % interval in standard errors. */
#define INTERVAL 1.959963984540054

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

/* The interval is by the delta method, from the posterior covariance. */
void mukca_cause_measure(mukca_cause *out, mukca_regression *m, int index)
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
    out->low = out->amplitude - INTERVAL * sigma;
    out->high = out->amplitude + INTERVAL * sigma;
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

static void add_tie(mukca_cause *out, mukca_tie tie)
{
    for (int t = 0; t < out->n_ties; t++)
        if (out->ties[t].effect == tie.effect && out->ties[t].joint == tie.joint) return;
    if (out->n_ties < MUKCA_MAX_TIES) out->ties[out->n_ties++] = tie;
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
static void tie_untested_flexibility(mukca_cause *out, const mukca_competition *contest)
{
    const unsigned char *disabled = contest->options->disabled;
    const bool withheld = disabled && disabled[MUKCA_EFFECT_JOINT_COMPLIANCE];
    if (contest->m->recording.have_torques || withheld || !resembles_flexibility(&out->effect))
        return;
    out->probability *= 0.5;
    if (out->n_ties < MUKCA_MAX_TIES) /* gravity loads the second joint most */
        out->ties[out->n_ties++] =
            (mukca_tie){.effect = MUKCA_EFFECT_JOINT_COMPLIANCE,
                        .joint = out->effect.joint >= 0 ? out->effect.joint
                                                        : contest->m->recording.chain->n_joints > 1,
                        .log_bayes_factor = NAN,
                        .correlation = NAN};
}

/* If the only two sockets of a placement are recorded one after the other, a moved tool or a zero
 * jump between them has exactly the effect of another distance: a tie. */
static void tie_moved_tool(mukca_cause *out, const mukca_recording *r)
{
    const mukca_socket_pair *pair = NULL;
    const int placement = out->effect.placement;
    int pairs = 0;
    if (out->effect.kind != MUKCA_EFFECT_SOCKET_DISTANCE || placement < 0) return;
    for (int p = 0; p < r->n_pairs; p++)
        if (r->groups[r->pairs[p].a].placement == placement) pair = &r->pairs[p], pairs++;
    if (pairs != 1) return;
    const mukca_group *a = &r->groups[pair->a], *b = &r->groups[pair->b];
    const int *row = r->order;
    if (row[a->start] < row[b->start + b->count - 1] &&
        row[b->start] < row[a->start + a->count - 1])
        return;
    out->probability *= 0.5;
    add_tie(out,
            (mukca_tie){
                .effect = MUKCA_EFFECT_TOOL_MOTION,
                .joint = -1,
                .log_bayes_factor = out->log_bayes_factor,
                .correlation = 1,
                .rival = {.kind = MUKCA_EFFECT_TOOL_MOTION, .joint = -1, .placement = placement}});
}

static void add_ties(mukca_cause *out, const mukca_competition *contest, int index)
{
    mukca_regression *m = contest->m;
    const mukca_candidate *cause = &m->unknowns.cause[index].candidate;
    const double best = contest->n_table ? contest->table[0].log_odds : 0;
    for (int i = 0; i < contest->n_table && out->n_ties < MUKCA_MAX_TIES; i++) {
        const mukca_contender *c = &contest->table[i];
        if (c->log_odds < best - MUKCA_TIE_MOST) break;
        if (c->class >= MUKCA_EFFECT_COUNT ||
            (c->class == (int)out->effect.kind && c->joint == out->effect.joint))
            continue;
        const mukca_candidate *rival = mukca_scan_candidate(contest->scan, c->best);
        const double correlation = mukca_scan_correlation(contest->scan, m, index, cause, rival);
        if (c->log_odds < best - 0.5 * MUKCA_TIE_MOST && !(correlation > TIE_CORRELATION)) continue;
        add_tie(out, (mukca_tie){.effect = (mukca_effect_kind)c->class,
                                 .joint = c->joint,
                                 .log_bayes_factor = contest->scan->score[c->best].log_bayes,
                                 .correlation = correlation,
                                 .rival = rival_effect(rival, &out->effect, cause->unit[0])});
    }
}

/* Probabilities of all contenders for the place of candidate h; *share receives its own.  Returns
 * the table's entry of h, or NULL. */
static const mukca_contender *find_standing(mukca_standing *standing, double *share,
                                            const mukca_competition *contest,
                                            const mukca_candidate *h)
{
    const int class = mukca_candidate_class(h);
    const double best = fmax(contest->n_table ? contest->table[0].log_odds : 0, 0);
    const mukca_contender *entry = NULL;
    double total = 0, own = 0;
    memset(standing, 0, sizeof *standing);
    for (int i = 0; i < contest->n_table; i++) {
        const mukca_contender *c = &contest->table[i];
        const mukca_candidate *member = mukca_scan_candidate(contest->scan, c->best);
        const double p = exp(c->log_odds - best);
        total += p;
        if (c->class == MUKCA_CLASS_UNKNOWN) standing->by_joint[c->joint] += p;
        if (c->class == class && c->joint == h->joint &&
            (!mukca_candidate_is_fault(h) || member->fault.group == h->fault.group)) {
            own += p;
            if (!entry) entry = c;
        }
    }
    total += exp(-best);
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) {
        standing->by_joint[j] /= total;
        standing->unknown += standing->by_joint[j];
    }
    standing->log_odds = entry ? entry->log_odds : -HUGE_VAL;
    *share = fmin(own / total, 1);
    return entry;
}

/* Score and rank all contenders for the place of a cause; share and return value as of
 * find_standing(). */
static const mukca_contender *compare(mukca_standing *standing, double *share,
                                      mukca_competition *contest, int index)
{
    const mukca_candidate *h = &contest->m->unknowns.cause[index].candidate;
    mukca_scan_run(
        contest->scan, contest->m, index,
        mukca_candidate_class(h) < MUKCA_EFFECT_COUNT ? MUKCA_SCAN_RIVALS : MUKCA_SCAN_CONTENDERS);
    mukca_competition_rank(contest);
    int others = 0;
    for (int i = 0; i < contest->n_table; i++)
        if (!mukca_competition_taken(contest, &contest->table[i], index))
            contest->table[others++] = contest->table[i];
    contest->n_table = others;
    return find_standing(standing, share, contest, h);
}

/* Fine ripple is selected from hundreds of orders, and can fit what smooth functions cannot: noise
 * in a joint's angle, and the rounding of angles to steps.  In evenly spaced postures rounding is
 * aliased to ripple of another order, with at most the amplitude of a sawtooth, step / pi. */
static void doubt_fine_ripple(mukca_cause *out, mukca_competition *contest, int index,
                              double log_odds)
{
    const mukca_candidate *h = &contest->m->unknowns.cause[index].candidate;
    const double *c = out->effect.coefficient;
    if (h->kind != MUKCA_CANDIDATE_EFFECT || h->effect.variant.order <= MUKCA_SMOOTH_ORDER) return;
    contest->tails.known = false;
    const double gain = mukca_heavy_tails_gain(&contest->tails, contest->m, index, h);
    out->probability /= 1 + exp(gain - log_odds);
    if (PI * hypot(c[0], c[1]) <
        mukca_resolution_step(contest->tails.scratch, &contest->m->recording, h->joint))
        mukca_cause_doubt(out);
}

bool mukca_cause_describe(mukca_cause *out, mukca_standing *standing, mukca_competition *contest,
                          int index)
{
    const mukca_recording *recording = &contest->m->recording;
    const mukca_accepted *cause = &contest->m->unknowns.cause[index];
    const mukca_candidate *h = &cause->candidate;
    double share;
    const mukca_contender *entry = compare(standing, &share, contest, index);
    if (standing->unknown > LITTLE && mukca_competition_leave_unlisted(contest))
        entry = compare(standing, &share, contest, index);
    if (!out || mukca_candidate_class(h) >= MUKCA_EFFECT_COUNT) return false;
    *out = (mukca_cause){
        .effect = fitted_effect(recording, cause),
        .socket = -1,
        .or_unknown = standing->unknown > MUKCA_UNKNOWN_SHARE,
        .log_bayes_factor = entry ? contest->scan->score[entry->best].log_bayes : -HUGE_VAL,
        .probability = share,
        .held_out = MUKCA_SHRINK_NONE};
    add_ties(out, contest, index);
    tie_untested_flexibility(out, contest);
    tie_moved_tool(out, recording);
    doubt_fine_ripple(out, contest, index, standing->log_odds);
    if (mukca_candidate_is_fault(h)) {
        out->socket = recording->groups[h->fault.group].socket;
        out->row = recording->data->row[h->fault.first];
        out->file = recording->data->file[h->fault.first];
        out->creep = h->kind == MUKCA_CANDIDATE_CREEP;
    }
    return true;
}

void mukca_cause_doubt(mukca_cause *cause)
{
    cause->or_unknown = true;
    cause->probability = fmin(cause->probability, 1 - MUKCA_UNKNOWN_SHARE);
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
