/* Next postures of a diagnosis: those that split a finding. */
#include "diagnose/next_poses.h"

#include <math.h>
#include <string.h>

#include "model/dataset_subset.h"

/* Is one of the two an error of the commands, the other of the arm?  Readings distinguish them,
 * postures do not. */
static bool settled_by_readings(const mukca_effect *a, const mukca_effect *b)
{
    return (mukca_effect_table[a->kind]->needs ^ mukca_effect_table[b->kind]->needs) &
           MUKCA_NEEDS_COMMANDS;
}

bool mukca_next_poses_need_readings(const mukca_finding *f)
{
    const mukca_alternative *a = f->alternatives;
    for (int k = 1; k < f->n_alternatives; k++)
        if (a[0].listed && a[k].listed && settled_by_readings(&a[0].effect, &a[k].effect))
            return true;
    return false;
}

/* The two most probable alternatives of a finding that postures can distinguish. */
static bool find_pair(int pair[2], const mukca_finding *f)
{
    int n = 0;
    for (int k = 0; k < f->n_alternatives && n < 2; k++) {
        const mukca_alternative *a = &f->alternatives[k];
        const mukca_effect *e = &a->effect, *first = n ? &f->alternatives[pair[0]].effect : NULL;
        if (!a->listed || mukca_effect_has((int)e->kind, MUKCA_TRAIT_RECORDING_FAULT)) continue;
        if (first &&
            (settled_by_readings(first, e) || (first->kind == e->kind && first->joint == e->joint)))
            continue;
        pair[n++] = k;
    }
    return n == 2;
}

bool mukca_next_poses_pair(mukca_next_poses *next, mukca_plan_options *options,
                           mukca_effect effects[2], const mukca_diagnosis *d, int finding)
{
    next->finding = -1;
    for (int i = finding < 0 ? 0 : finding; i < d->n_findings; i++) {
        const mukca_alternative *a = d->findings[i].alternatives;
        int *pair = next->pair;
        if (find_pair(pair, &d->findings[i])) {
            next->finding = i;
            for (int k = 0; k < 2; k++) effects[k] = a[pair[k]].effect;
            options->effects = effects;
            options->n_effects = 2;
            options->noise = d->sigma_m;
            options->measured = log(a[pair[0]].probability / a[pair[1]].probability);
            return true;
        }
        if (finding >= 0) return false;
    }
    return false;
}

mukca_status mukca_next_poses_choose(mukca_next_poses *next, const mukca_diagnosis *d,
                                     const mukca_chain *chain, const mukca_dataset *data,
                                     bool (*stop)(void *context), mukca_error *error)
{
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_effect effects[2];
    mukca_geometry geometry; /* of theta, as `plan` has it: postures depend on its last digits */
    mukca_plan_options options = {.rows = MUKCA_NEXT_POSES, .poses_only = true, .stop = stop};
    memset(next, 0, sizeof *next);
    if (data->n_distances) options.distance_sigma = mukca_distance_sigma(&data->distances[0]);
    if (!mukca_next_poses_pair(next, &options, effects, d, -1)) return MUKCA_OK;
    mukca_geometry_theta(theta, chain, &d->geometry);
    mukca_geometry_set(&geometry, chain, theta);
    const int n =
        mukca_plan_sockets(next->sockets, MUKCA_PLAN_MAX_SOCKETS, &next->left_out, &geometry, data);
    const mukca_plan_task task = {
        .chain = chain, .theta = theta, .data = data, .sockets = next->sockets, .n_sockets = n};
    if (n == 0) return MUKCA_OK;
    mukca_error none;
    const mukca_status status = mukca_plan_run(&next->plan, &task, &options, &none);
    if (status == MUKCA_MEMORY || status == MUKCA_INTERRUPTED) {
        if (error) *error = none;
        return status;
    }
    if (status != MUKCA_OK) memset(&next->plan, 0, sizeof next->plan); /* no suitable posture */
    return MUKCA_OK;
}
