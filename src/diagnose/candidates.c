/* The list of candidate causes for a recording, with their prior odds. */
#include "diagnose/candidates.h"

#include <math.h>
#include <string.h>

#include "diagnose/logs.h"

enum { MOST_ORDERS = 40 }; /* of the orders of a joint that are added later */

/* Prior probability that a flexible part, or a servo, deflects by more than an error: each one
 * deflects, listed or not, and of the some 24 of an arm (joints, links, base) published recordings
 * show one to three. */
#define SHOWS (1.0 / 20)

double mukca_candidates_order_prior(const mukca_candidates *all, const mukca_candidate *h,
                                    int order)
{
    if (h->kind == MUKCA_CANDIDATE_UNLISTED)
        return h->log_prior - log(order * log(MUKCA_LAST_ORDER));
    return log(mukca_effect_catalogue[h->effect.kind]->order_prior(order)) -
           log(all->survey.n_joints) - log(all->classes);
}

/* Parts of the classes, each with a share of its class: effects, those of outliers and of the
 * tool's motions, smooth functions outside the catalogue of a joint's own angle and of anything
 * else.  The simple functions at one site are a part, too; they are a class of their own. */
typedef enum {
    SINGLE = MUKCA_EFFECT_COUNT,
    BURST,
    CREEP,
    BETWEEN,
    STEP,
    OWN_ANGLE,
    OTHER,
    SIMPLE,
    PARTS = SIMPLE + MUKCA_SITE_SEAT + 1
} part;

/* Is it a smooth function of a joint's own angle, at that joint? */
static bool is_of_own_angle(const mukca_candidate *h)
{
    const mukca_unlisted_function *f = &mukca_unlisted_functions[h->unlisted.function];
    return f->argument == MUKCA_ARGUMENT_ANGLE && f->shape != MUKCA_SHAPE_SIDE &&
           h->unlisted.place == MUKCA_PLACE_ANGLE && h->unlisted.argument == h->joint;
}

static part part_of(const mukca_candidate *h, const mukca_recording *r)
{
    if (h->kind == MUKCA_CANDIDATE_EFFECT) return (part)h->effect.kind;
    if (h->kind == MUKCA_CANDIDATE_OUTLIER) return h->fault.last == h->fault.first ? SINGLE : BURST;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED && is_of_own_angle(h)) return OWN_ANGLE;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED && mukca_unlisted_is_normalised(h)) return OTHER;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED && h->unlisted.place == MUKCA_PLACE_ANGLES)
        return (part)(SIMPLE + MUKCA_SITE_ANGLE); /* one more joint: all of them */
    if (h->kind == MUKCA_CANDIDATE_UNLISTED) return (part)(SIMPLE + mukca_candidate_site(h));
    if (h->fault.shape == MUKCA_FAULT_GROWING) return CREEP;
    return h->fault.first == r->order[r->groups[h->fault.group].start] ? BETWEEN : STEP;
}

/* Prior odds: those of flexible parts; else equal per class, then as the parts' shares, then per
 * joint, then per variant.  Half of the outliers are bursts, a quarter of tool motions creep,
 * another quarter happens between two sockets, half of the smooth functions outside the catalogue
 * have another argument than the joint's own angle alone. */
static void set_priors(mukca_candidates *all)
{
    int variants[PARTS][MUKCA_MAX_JOINTS + 1] = {{0}}, joints[PARTS] = {0}, sites = 0;
    double part_share[PARTS];
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) /* whether or not a long wave is listed */
        all->enabled[kind] =
            mukca_effect_has(kind, MUKCA_TRAIT_ORDERS) && !(all->disabled && all->disabled[kind]);
    for (int i = 0; i < all->count; i++) {
        const mukca_candidate *h = &all->list[i];
        const part p = part_of(h, all->recording);
        all->enabled[mukca_candidate_class(h)] = true;
        if (mukca_candidate_is_flexible(h)) continue;
        joints[p] += !variants[p][h->joint + 1]++;
    }
    for (int c = 0; c < MUKCA_CLASSES; c++) all->classes += all->enabled[c];
    for (int p = SIMPLE; p < PARTS; p++) sites += joints[p] > 0;
    for (int p = 0; p < PARTS; p++) part_share[p] = p < SIMPLE ? 1 : 1.0 / sites;
    part_share[SINGLE] = part_share[BURST] = part_share[OWN_ANGLE] = part_share[OTHER] = 0.5;
    part_share[CREEP] = joints[CREEP] ? 0.25 : 0;
    part_share[BETWEEN] = joints[BETWEEN] ? 0.25 : 0;
    part_share[STEP] -= part_share[CREEP] + part_share[BETWEEN];
    for (int i = 0; i < all->count; i++) {
        mukca_candidate *h = &all->list[i];
        const int class = mukca_candidate_class(h);
        const part p = part_of(h, all->recording);
        h->log_prior =
            mukca_effect_has(class, MUKCA_TRAIT_ORDERS)
                ? mukca_candidates_order_prior(all, h, h->effect.variant.order)
            : mukca_candidate_is_flexible(h)
                ? log(SHOWS)
                : log(part_share[p] / (joints[p] * variants[p][h->joint + 1] * all->classes));
    }
}

/* If commands are fitted and readings are recorded, too, their difference measures a sag directly:
 * independent data, with evidence that is added to the prior odds. */
static void add_sag_evidence(mukca_candidates *all)
{
    const mukca_recording *recording = all->recording;
    const double most =
        20; /* log odds: certain, but not enough for a sag without effect on the ball */
    mukca_streams streams;
    if (!recording->data->by_command || !recording->data->reading) return;
    mukca_streams_compare(&streams, recording);
    for (int i = 0; i < all->count; i++) {
        mukca_candidate *h = &all->list[i];
        if (h->kind != MUKCA_CANDIDATE_EFFECT ||
            !(mukca_effect_table[h->effect.kind]->needs & MUKCA_NEEDS_COMMANDS))
            continue;
        const double evidence = streams.joint[h->joint].log_bayes_factor;
        if (isfinite(evidence)) h->log_prior += fmin(evidence, most);
    }
}

static mukca_status no_memory(const mukca_recording *recording, mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the candidates of %d rows",
                      recording->data->n_rows);
}

mukca_status mukca_candidates_list(mukca_candidates *all, const mukca_unknowns *unknowns,
                                   mukca_error *error)
{
    const int n = all->recording->chain->n_joints;
    mukca_candidates_append_faults(all);
    mukca_candidates_append_unlisted(all, unknowns);
    all->capacity = all->count + MOST_ORDERS * n;
    mukca_candidate *list = MUKCA_TAKE(all->pool, mukca_candidate, all->capacity);
    if (all->pool->failed) return no_memory(all->recording, error);
    mukca_candidates_fill(all, NULL);
    mukca_candidates_drop_listed(all);
    memcpy(list, all->list, sizeof *list * (size_t)all->count);
    all->list = list;
    set_priors(all);
    add_sag_evidence(all);
    return MUKCA_OK;
}

mukca_status mukca_candidates_add_order(mukca_candidates *all, mukca_candidate h, int order,
                                        mukca_error *error)
{
    h.log_prior = mukca_candidates_order_prior(all, &h, order);
    if (h.kind == MUKCA_CANDIDATE_UNLISTED)
        h.unlisted.measure = order;
    else
        h.effect.variant.order = order;
    if (all->count == all->capacity) return MUKCA_OK;
    if (!mukca_candidate_prepare(&h, all->pool, all->recording))
        return no_memory(all->recording, error);
    all->list[all->count++] = h;
    return MUKCA_OK;
}
