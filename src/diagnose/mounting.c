/* Is the arm mounted as the model says?  Gravity in another direction of the base frame. */
#include "diagnose/mounting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/candidates.h"
#include "diagnose/screening.h"

/* Log odds that another direction must lead by: one arm of a hundred hangs from a wall or a ceiling
 * without --gravity, five directions are tried, and 20 to 1 as for every cause. */
#define LEAD (4.6 + 1.6 + 3.0)
/* Within a factor of e. */
#define AS_PROBABLE 1.0
/* Directions nearer to the model's gravity than this cosine (some 30 degrees) are no other. */
static const double same_direction = 0.85;

static bool is_elastic(const mukca_cause *cause)
{
    return mukca_effect_has((int)cause->effect.kind, MUKCA_TRAIT_ELASTIC);
}

/* May springs under another load look like it?  They move no socket. */
static bool has_load_as_rival(const mukca_cause *cause)
{
    const mukca_effect_site site = mukca_effect_table[cause->effect.kind]->site;
    return site != MUKCA_SITE_SOCKET && site != MUKCA_SITE_DISTANCE;
}

/* Do elastic causes alone explain all of it? */
static bool all_elastic(const mukca_diagnosis *d)
{
    bool elastic = d->verdict != MUKCA_VERDICT_UNKNOWN && d->n_causes > 0 && !d->unexplained;
    for (int i = 0; i < d->n_causes; i++) elastic &= is_elastic(&d->causes[i]);
    return elastic;
}

/* Turn gravity to the k-th of +x, -x, +y ... of the base frame, where that may tell something;
 * false: it does not.  The direction opposite to the model's is tried where something is unknown.
 */
static bool is_worth_it(double gravity[3], int k, const mukca_diagnosis *given)
{
    const double size =
        sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1] + gravity[2] * gravity[2]);
    const double cosine = (k % 2 ? -1 : 1) * gravity[k / 2] / size;
    if (!(cosine < same_direction)) return false;
    if (cosine < -same_direction && given->verdict != MUKCA_VERDICT_UNKNOWN) return false;
    memset(gravity, 0, 3 * sizeof *gravity);
    gravity[k / 2] = k % 2 ? -size : size;
    return true;
}

/* Is a diagnosis under another gravity worth a notice?  It leads; or it explains by springs what
 * was unknown: under the opposite gravity the same function is as probable, but it is no spring of
 * negative stiffness. */
static bool is_notable(const mukca_diagnosis *other, const mukca_diagnosis *given)
{
    if (other->n_causes && is_elastic(&other->causes[0]) && other->score > given->score + LEAD)
        return true;
    return given->verdict == MUKCA_VERDICT_UNKNOWN && all_elastic(other) &&
           other->score > given->score - AS_PROBABLE;
}

/* Log evidence of all springs at once, with exact masses, at their most probable sizes.  Springs
 * that are not needed cost little: what a search would accept of them is not much more probable. */
static mukca_status weigh_springs(double *evidence, const mukca_chain *chain,
                                  const mukca_dataset *data, const mukca_diagnose_options *springs,
                                  mukca_error *error)
{
    mukca_regression m;
    mukca_faults faults = {0};
    mukca_candidates all;
    const mukca_recording_options options = {.distance_sigma = MUKCA_DISTANCE_SIGMA,
                                             .free_base = springs->free_base,
                                             .free_tool = springs->free_tool};
    mukca_status status = mukca_regression_create(&m, chain, data, &options, error);
    if (status != MUKCA_OK) return status;
    mukca_screening_run(&faults, &m);
    status =
        mukca_candidates_list(&all, &m.pool, &m.recording, &m.unknowns, springs->disabled, error);
    for (int c = 0; c < all.count && status == MUKCA_OK; c++)
        if (mukca_candidate_class(&all.list[c]) < MUKCA_EFFECT_COUNT &&
            mukca_effect_has(mukca_candidate_class(&all.list[c]), MUKCA_TRAIT_ELASTIC))
            mukca_unknowns_add(&m.unknowns, &all.list[c]);
    if (status == MUKCA_OK) mukca_regression_fit(&m, 4, MUKCA_FIT_ALL);
    *evidence = status == MUKCA_OK ? mukca_regression_factor(&m) : 0;
    if (status == MUKCA_OK && m.pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    mukca_regression_free(&m);
    return status;
}

mukca_status mukca_mounting_compare(mukca_diagnosis *d, const mukca_chain *chain,
                                    const mukca_dataset *data,
                                    const mukca_diagnose_options *options, mukca_error *error)
{
    unsigned char others[MUKCA_EFFECT_COUNT];
    const mukca_diagnose_options springs = {.disabled = others,
                                            .free_base = options->free_base,
                                            .free_tool = options->free_tool,
                                            .mass_spread = options->mass_spread,
                                            .no_folds = true,
                                            .progress = options->progress,
                                            .progress_context = options->progress_context};
    if (d->verdict == MUKCA_VERDICT_NONE || d->verdict == MUKCA_VERDICT_UNTESTABLE ||
        !chain->n_masses || all_elastic(d))
        return MUKCA_OK; /* nothing to explain, no torques, or no doubt */
    for (int e = 0; e < MUKCA_EFFECT_COUNT; e++)
        others[e] = (options->disabled && options->disabled[e]) ||
                    (!mukca_effect_has(e, MUKCA_TRAIT_ELASTIC) &&
                     mukca_effect_table[e]->site != MUKCA_SITE_SOCKET);
    mukca_chain *turned = malloc(sizeof *turned);
    mukca_diagnosis *other = malloc(sizeof *other);
    mukca_status status = turned && other ? MUKCA_OK
                                          : mukca_fail(error, MUKCA_MEMORY,
                                                       "out of memory for %d rows", data->n_rows);
    double best = -HUGE_VAL, evidence = NAN, upright = 0;
    bool leads = true; /* the direction before, opposite to this one */
    if (status == MUKCA_OK) status = weigh_springs(&upright, chain, data, &springs, error);
    /* Worth a diagnosis: more probable than under the model's gravity, by half of what was found
     * beyond that; or than all that was found. */
    const double enough =
        fmin(fmax(upright + LEAD, 0.5 * (upright + d->score)), d->score - AS_PROBABLE);
    for (int k = 0; k < 6 && status == MUKCA_OK; k++) {
        if (k % 2 == 0) evidence = NAN, leads = true;
        *turned = *chain;
        if (!leads || !is_worth_it(turned->gravity, k, d)) continue;
        if (isnan(evidence)) /* springs of either sign: the same in the opposite direction */
            status = weigh_springs(&evidence, turned, data, &springs, error);
        if (status != MUKCA_OK || !(evidence > enough)) continue;
        status = mukca_diagnose(other, turned, data, &springs, error);
        if (status != MUKCA_OK) break;
        if (other->score > best && is_notable(other, d))
            best = other->score, memcpy(d->gravity, turned->gravity, sizeof d->gravity);
        leads = other->score > d->score - AS_PROBABLE;
        mukca_diagnosis_free(other);
    }
    if (best > d->score + LEAD) {
        for (int i = 0; i < d->n_causes; i++)
            d->causes[i].or_unknown |= has_load_as_rival(&d->causes[i]);
        if (d->verdict == MUKCA_VERDICT_NAMED) d->verdict = MUKCA_VERDICT_TIED;
    }
    free(other);
    free(turned);
    return status;
}
