/* Next postures of a diagnosis: those that distinguish its tied causes. */
#include "diagnose/next_poses.h"

#include <math.h>
#include <string.h>

#include "model/dataset_subset.h"

static bool settled_by_poses(const mukca_effect *effect)
{
    return !mukca_effect_has((int)effect->kind, MUKCA_TRAIT_RECORDING_FAULT);
}

/* Is one of the two an error of the commands, the other of the arm?  Readings distinguish them,
 * postures do not. */
static bool settled_by_readings(const mukca_effect *a, const mukca_effect *b)
{
    return (mukca_effect_table[a->kind]->needs ^ mukca_effect_table[b->kind]->needs) &
           MUKCA_NEEDS_COMMANDS;
}

bool mukca_next_poses_need_readings(const mukca_cause *cause)
{
    for (int t = 0; t < cause->n_ties; t++)
        if (settled_by_readings(&cause->effect, &cause->ties[t].rival)) return true;
    return false;
}

bool mukca_next_poses_tie(mukca_next_poses *next, mukca_plan_options *options,
                          mukca_effect effects[2], const mukca_diagnosis *d)
{
    next->cause = next->tie = -1;
    for (int c = 0; c < d->n_causes; c++) {
        const mukca_cause *cause = &d->causes[c];
        for (int t = 0; settled_by_poses(&cause->effect) && t < cause->n_ties; t++) {
            const mukca_tie *tie = &cause->ties[t];
            if (!isfinite(tie->log_bayes_factor) || !settled_by_poses(&tie->rival) ||
                settled_by_readings(&cause->effect, &tie->rival))
                continue;
            next->cause = c;
            next->tie = t;
            effects[0] = cause->effect;
            effects[1] = tie->rival;
            options->effects = effects;
            options->n_effects = 2;
            options->noise = d->sigma_m;
            options->measured = cause->log_bayes_factor - tie->log_bayes_factor;
            return true;
        }
    }
    return false;
}

mukca_status mukca_next_poses_choose(mukca_next_poses *next, const mukca_diagnosis *d,
                                     const mukca_chain *chain, const mukca_dataset *data,
                                     bool (*stop)(void *context), mukca_error *error)
{
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    mukca_effect effects[2];
    mukca_plan_options options = {.rows = MUKCA_NEXT_POSES, .poses_only = true, .stop = stop};
    memset(next, 0, sizeof *next);
    if (data->n_distances) options.distance_sigma = mukca_distance_sigma(&data->distances[0]);
    if (!mukca_next_poses_tie(next, &options, effects, d)) return MUKCA_OK;
    const int n = mukca_plan_sockets(next->sockets, MUKCA_PLAN_MAX_SOCKETS, &d->geometry, data);
    const mukca_plan_task task = {
        .chain = chain, .theta = theta, .data = data, .sockets = next->sockets, .n_sockets = n};
    if (n == 0) return MUKCA_OK;
    mukca_geometry_theta(theta, chain, &d->geometry);
    mukca_error none;
    const mukca_status status = mukca_plan_run(&next->plan, &task, &options, &none);
    if (status == MUKCA_MEMORY || status == MUKCA_INTERRUPTED) {
        if (error) *error = none;
        return status;
    }
    if (status != MUKCA_OK) memset(&next->plan, 0, sizeof next->plan); /* no suitable posture */
    return MUKCA_OK;
}

void mukca_next_poses_free(mukca_next_poses *next)
{
    mukca_plan_free(&next->plan);
}
