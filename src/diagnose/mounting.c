/* Is the arm mounted as the model says?  Gravity in another direction of the base frame. */
#include "diagnose/mounting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Log odds that another direction must lead by: one arm of a hundred hangs from a wall or a ceiling
 * without --gravity, five directions are tried, and 20 to 1 as for every cause. */
#define LEAD (4.6 + 1.6 + 3.0)
/* Within a factor of e. */
#define AS_PROBABLE 1.0
/* Directions nearer to the model's gravity than this cosine (some 30 degrees) are no other. */
static const double same_direction = 0.85;
enum { MOST_SAMPLES = 400 };

static bool is_elastic(const mukca_cause *cause)
{
    return mukca_effect_has((int)cause->effect.kind, MUKCA_TRAIT_ELASTIC);
}

/* Do elastic causes alone explain all of it? */
static bool all_elastic(const mukca_diagnosis *d)
{
    bool elastic = d->verdict != MUKCA_VERDICT_UNKNOWN && d->n_causes > 0 && !d->unexplained;
    for (int i = 0; i < d->n_causes; i++) elastic &= is_elastic(&d->causes[i]);
    return elastic;
}

/* Turn gravity to the k-th of +x, -x, +y ... of the base frame, where that may tell something;
 * false: it does not.  Springs of either sign fit as well under opposite directions: the second is
 * tried where the first leads, and that opposite to the model's where something is unknown. */
static bool is_worth_it(double gravity[3], int k, double lead_of_first,
                        const mukca_diagnosis *given)
{
    const double size =
        sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1] + gravity[2] * gravity[2]);
    const double cosine = (k % 2 ? -1 : 1) * gravity[k / 2] / size;
    if (!(cosine < same_direction)) return false;
    if (cosine < -same_direction ? given->verdict != MUKCA_VERDICT_UNKNOWN
                                 : k % 2 && !(lead_of_first > 0))
        return false;
    memset(gravity, 0, 3 * sizeof *gravity);
    gravity[k / 2] = k % 2 ? -size : size;
    return true;
}

/* Is a diagnosis under another gravity worth a notice?  It leads; or it explains by springs what
 * was unknown: under the opposite gravity the same function is as probable, but it is no spring of
 * negative stiffness. */
static bool is_notable(const mukca_diagnosis *other, const mukca_diagnosis *given, double score)
{
    if (other->n_causes && is_elastic(&other->causes[0]) && other->score > score + LEAD)
        return true;
    return given->verdict == MUKCA_VERDICT_UNKNOWN && all_elastic(other) &&
           other->score > score - AS_PROBABLE;
}

/* The samples that are compared: all, or some, evenly spread. */
static mukca_status thin(mukca_dataset *part, const mukca_dataset *data, mukca_error *error)
{
    const int step = 1 + (data->n_rows - 1) / MOST_SAMPLES;
    unsigned char *keep = calloc((size_t)data->n_rows + 1, 1);
    for (int r = 0; keep && r < data->n_rows; r += step) keep[r] = 1;
    const mukca_status status = keep ? mukca_dataset_subset(part, data, keep, error)
                                     : mukca_fail(error, MUKCA_MEMORY, "out of memory");
    free(keep);
    return status;
}

mukca_status mukca_mounting_compare(mukca_diagnosis *d, const mukca_chain *chain,
                                    const mukca_dataset *data,
                                    const mukca_diagnose_options *options, mukca_error *error)
{
    unsigned char others[MUKCA_EFFECT_COUNT];
    const mukca_diagnose_options fast = {.disabled = others,
                                         .free_base = options->free_base,
                                         .free_tool = options->free_tool,
                                         .mass_spread = options->mass_spread,
                                         .no_folds = true,
                                         .progress = options->progress,
                                         .progress_context = options->progress_context};
    mukca_dataset part = {0};
    if (d->verdict == MUKCA_VERDICT_NONE || d->verdict == MUKCA_VERDICT_UNTESTABLE ||
        !chain->n_masses || all_elastic(d))
        return MUKCA_OK; /* nothing to explain, no torques, or no doubt */
    for (int e = 0; e < MUKCA_EFFECT_COUNT; e++)
        others[e] = (options->disabled && options->disabled[e]) ||
                    (!mukca_effect_has(e, MUKCA_TRAIT_ELASTIC) &&
                     mukca_effect_table[e]->site != MUKCA_SITE_SOCKET);
    mukca_chain *turned = malloc(sizeof *turned);
    mukca_diagnosis *other = malloc(sizeof *other);
    mukca_status status = turned && other ? thin(&part, data, error)
                                          : mukca_fail(error, MUKCA_MEMORY,
                                                       "out of memory for %d rows", data->n_rows);
    double given = d->score, best = -HUGE_VAL, forward = -HUGE_VAL;
    for (int k = part.n_rows < data->n_rows ? -1 : 0; k < 6 && status == MUKCA_OK; k++) {
        *turned = *chain;
        if (k >= 0 && !is_worth_it(turned->gravity, k, forward - given, d)) continue;
        status = mukca_diagnose(other, turned, &part, &fast, error);
        if (status != MUKCA_OK) break;
        if (k < 0)
            given = other->score;
        else if (other->score > best && is_notable(other, d, given))
            best = other->score, memcpy(d->gravity, turned->gravity, sizeof d->gravity);
        forward = k % 2 == 0 ? other->score : -HUGE_VAL;
        mukca_diagnosis_free(other);
    }
    if (best > given + LEAD) {
        for (int i = 0; i < d->n_causes; i++)
            d->causes[i].or_unknown |=
                mukca_effect_table[d->causes[i].effect.kind]->site != MUKCA_SITE_SOCKET;
        if (d->verdict == MUKCA_VERDICT_NAMED) d->verdict = MUKCA_VERDICT_TIED;
    }
    mukca_dataset_free(&part);
    free(other);
    free(turned);
    return status;
}
