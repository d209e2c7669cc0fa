/* Mounting of the arm: gravity in a direction other than the model's. */
#include "diagnose/mounting.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"
#include "diagnose/cause.h"
#include "diagnose/regression.h"
#include "diagnose/scan.h"
#include "infer/sets.h"

/* Log odds by which another direction must lead: one arm in a hundred hangs from a wall or a
 * ceiling without --gravity, five directions are tested, and 20 to 1 as for every cause. */
#define LEAD (4.6 + 1.6 + 3.0)
/* Log odds of about equal probability: within a factor of e. */
#define AS_PROBABLE 1.0
/* Directions closer to the model's gravity than this cosine (some 30 degrees) are the same. */
static const double same_direction = 0.85;

static bool is_elastic(const mukca_cause *cause)
{
    return mukca_effect_has((int)cause->effect.kind, MUKCA_TRAIT_ELASTIC);
}

/* May elastic effects under another load imitate it?  Not if it moves sockets. */
static bool has_load_as_rival(const mukca_cause *cause)
{
    const mukca_effect_site site = mukca_effect_table[cause->effect.kind]->site;
    return site != MUKCA_SITE_SOCKET && site != MUKCA_SITE_DISTANCE;
}

/* Do elastic causes alone explain everything? */
static bool all_elastic(const mukca_diagnosis *d)
{
    bool elastic = d->verdict != MUKCA_VERDICT_UNKNOWN && d->n_causes > 0 && !d->unexplained;
    for (int i = 0; i < d->n_causes; i++) elastic &= is_elastic(&d->causes[i]);
    return elastic;
}

/* Set gravity to the k-th of +x, -x, +y ... of the base frame; false: this direction is not worth
 * testing.  The direction opposite to the model's is tested if the verdict is unknown. */
static bool is_worth_testing(double gravity[3], int k, const mukca_diagnosis *given)
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

/* Is a diagnosis under another gravity worth reporting?  It leads; or it explains an unknown
 * function by elastic causes: under the opposite gravity this function is as probable, but as a
 * spring it would need negative stiffness. */
static bool is_notable(const mukca_diagnosis *other, const mukca_diagnosis *given)
{
    if (other->n_causes && is_elastic(&other->causes[0]) && other->score > given->score + LEAD)
        return true;
    return given->verdict == MUKCA_VERDICT_UNKNOWN && all_elastic(other) &&
           other->score > given->score - AS_PROBABLE;
}

/* Data common to all directions of gravity. */
typedef struct {
    mukca_regression *m;
    const mukca_unknowns *bare; /* without causes */
    const unsigned char *disabled;
} comparison;

/* Log posterior of the best set of elastic effects under the gravity of the recording, with exact
 * masses. */
static mukca_status weigh_springs(double *evidence, const comparison *c, mukca_error *error)
{
    enum { BUDGET = 20 };
    mukca_regression *m = c->m;
    mukca_pool pool = {0};
    mukca_candidates springs;
    mukca_question question;
    mukca_scan scan;
    mukca_sets sets;
    mukca_status status =
        mukca_candidates_list_springs(&springs, &pool, &m->recording, c->disabled, error);
    int *index = MUKCA_TAKE(&pool, int, springs.count + 1);
    mukca_unknowns_assign(&m->unknowns, c->bare);
    mukca_regression_freeze(m); /* another load has other columns */
    for (int i = 0; i < springs.count && index; i++) index[i] = i;
    if (status == MUKCA_OK &&
        !(mukca_scan_create(&scan, &pool, m, &springs) &&
          mukca_scan_aim(&scan, m->unknowns.family) &&
          mukca_scan_question(&question, &scan, &pool, index, springs.count) &&
          mukca_sets_create(&sets, &pool, &question)))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the springs");
    if (status == MUKCA_OK) {
        mukca_sets_explore(&sets, BUDGET, true);
        *evidence = scan.evidence + sets.set[sets.best].value;
    }
    mukca_pool_free(&pool);
    return status;
}

/* Evidence that justifies a diagnosis in another direction: elastic effects are more probable there
 * than under the model's gravity (`upright`), by half of the evidence beyond that; or more probable
 * than all causes found. */
static double enough_for(double upright, double score)
{
    return fmin(fmax(upright + LEAD, 0.5 * (upright + score)), score - AS_PROBABLE);
}

static void load(mukca_regression *m, const mukca_chain *chain)
{
    m->recording.chain = chain;
    mukca_recording_load(&m->recording);
}

mukca_status mukca_mounting_compare(void *context, mukca_regression *m, mukca_diagnosis *d,
                                    mukca_error *error)
{
    const mukca_diagnose_options *options = context;
    const mukca_chain *chain = m->recording.chain;
    unsigned char others[MUKCA_EFFECT_COUNT];
    const mukca_diagnose_options springs = {.disabled = others,
                                            .free_base = options->free_base,
                                            .free_tool = options->free_tool,
                                            .mass_spread = options->mass_spread,
                                            .no_folds = true,
                                            .progress = options->progress,
                                            .progress_context = options->progress_context};
    if (d->verdict == MUKCA_VERDICT_NONE || !chain->n_masses || all_elastic(d))
        return MUKCA_OK; /* nothing to explain, no torques, or no doubt */
    for (int e = 0; e < MUKCA_EFFECT_COUNT; e++)
        others[e] = (options->disabled && options->disabled[e]) ||
                    (!mukca_effect_has(e, MUKCA_TRAIT_ELASTIC) &&
                     mukca_effect_table[e]->site != MUKCA_SITE_SOCKET);
    mukca_chain *turned = MUKCA_TAKE(&m->pool, mukca_chain, 1);
    mukca_diagnosis *other = MUKCA_TAKE(&m->pool, mukca_diagnosis, 1);
    mukca_unknowns bare;
    m->unknowns.n_causes = 0;
    m->recording.options.mass_spread = 0;
    if (!mukca_unknowns_clone(&bare, &m->pool, &m->unknowns) || m->pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for the springs");
    const comparison c = {.m = m, .bare = &bare, .disabled = others};
    double best = -HUGE_VAL, evidence = NAN, upright;
    bool leads = true; /* the preceding, opposite direction leads */
    mukca_status status = weigh_springs(&upright, &c, error);
    for (int k = 0; k < 6 && status == MUKCA_OK; k++) {
        if (k % 2 == 0) evidence = NAN, leads = true;
        *turned = *chain;
        if (!leads || !is_worth_testing(turned->gravity, k, d)) continue;
        if (isnan(evidence)) {
            load(m, turned);
            status = weigh_springs(&evidence, &c, error);
        }
        if (status != MUKCA_OK || !(evidence > enough_for(upright, d->score))) continue;
        status = mukca_diagnose(other, turned, m->recording.data, &springs, error);
        if (status != MUKCA_OK) break;
        if (other->score > best && is_notable(other, d))
            best = other->score, memcpy(d->gravity, turned->gravity, sizeof d->gravity);
        leads = other->score > d->score - AS_PROBABLE;
        mukca_diagnosis_free(other);
    }
    if (best > d->score + LEAD) {
        for (int i = 0; i < d->n_causes; i++)
            if (has_load_as_rival(&d->causes[i])) mukca_cause_doubt(&d->causes[i]);
        if (d->verdict == MUKCA_VERDICT_NAMED) d->verdict = MUKCA_VERDICT_TIED;
    }
    return status;
}
