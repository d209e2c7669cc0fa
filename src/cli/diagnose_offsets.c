/* Offsets table of a diagnosis: geometry, and the causes that act on the arm. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "accept/accept.h"
#include "cli/diagnose.h"
#include "fit/align.h"

/* A parameter counts as identifiable if the data at least halve its prior uncertainty. */
static void fill_geometry(mukca_offsets *o, const mukca_applied *a, const mukca_chain *arm,
                          int shift)
{
    double theta[MUKCA_MAX_THETA];
    mukca_geometry_theta(theta, arm, &a->geometry);
    for (int i = 0; i < MUKCA_PARAMETERS * arm->n_elements; i++) {
        const int at = i + MUKCA_PARAMETERS * shift;
        if (!isfinite(a->theta_sigma[i])) continue;
        o->theta[at] = theta[i];
        o->sigma[at] = a->theta_sigma[i];
        o->listed[at] = 1;
        o->identifiable[at] = a->theta_sigma[i] < 0.5 * a->theta_prior[i];
    }
}

static void fill_tracker(mukca_offsets *o, const mukca_applied *a)
{
    static const double zero[3] = {0, 0, 0};
    memcpy(o->theta, a->tracker.p, sizeof a->tracker.p);
    mukca_rotation_to_rpy(o->theta + 3, a->tracker.R, zero);
    for (int i = 0; i < MUKCA_PARAMETERS; i++) {
        o->sigma[i] = NAN;
        o->listed[i] = o->identifiable[i] = 1;
    }
}

/* The distances of the judgement: where one is a cause, as the diagnosis measured it; in one
 * placement, that of another artefact. */
static bool correct_distances(mukca_dataset *data, mukca_pool *pool, const mukca_diagnosis *d)
{
    mukca_distance *distances = MUKCA_TAKE(pool, mukca_distance, data->n_distances + 1);
    const int other = mukca_dataset_artefacts(data);
    for (int k = 0; k < data->n_distances && !pool->failed; k++) distances[k] = data->distances[k];
    for (int i = 0; i < d->n_causes && !pool->failed; i++) {
        const mukca_cause *cause = &d->causes[i];
        const int placement = cause->effect.placement;
        if (mukca_effect_table[cause->effect.kind]->site != MUKCA_SITE_DISTANCE) continue;
        for (int k = 0; k < data->n_distances; k++) {
            if (placement >= 0 && placement != data->sockets[distances[k].a].placement) continue;
            distances[k].distance += cause->amplitude;
            distances[k].sigma = (cause->high - cause->low) / 4;
            if (placement >= 0) distances[k].artefact = other + k;
        }
    }
    data->distances = distances;
    return !pool->failed;
}

static mukca_status judge(cli_call *call, cli_diagnosis *analysis)
{
    const mukca_diagnosed *r = &analysis->result;
    const mukca_diagnosis *d = r->diagnosis;
    mukca_dataset data = *r->data;
    if (!correct_distances(&data, &call->pool, d))
        return cli_fail(call, MUKCA_MEMORY, "out of memory");
    const mukca_chain *chain = &analysis->chain;
    mukca_offsets *o = &analysis->offsets;
    mukca_acceptance *a = &o->acceptance;
    a->converged = true; /* otherwise nothing was fitted */
    a->noise_m = d->sigma_m;
    a->parameters = a->identified = 0;
    for (int i = 0; i < MUKCA_PARAMETERS * chain->n_elements; i++) {
        a->parameters += o->listed[i];
        a->identified += o->identifiable[i];
    }
    if (r->test)
        snprintf(a->error_of, sizeof a->error_of, "test data, %d samples", r->test->n_rows);
    else
        snprintf(a->error_of, sizeof a->error_of, "cross-validation, %d folds%s", d->folds,
                 d->n_faults ? ", without faulty samples" : "");
    return mukca_accept(
        o,
        &(mukca_accept_task){
            .change = {.chain = chain,
                       .to = o,
                       .data = &data,
                       .base_frame = d->chain->n_elements < chain->n_elements,
                       .tool_frame = analysis->options.free_tool && r->data->position,
                       .threads = analysis->options.threads},
            .held = !d->after_m ? NULL
                    : r->test   ? r->test
                                : r->data,
            .before = d->before_m,
            .after = d->after_m,
            .misfit = d->why,
            .training_m = r->test ? d->applied_m : (double)NAN},
        &call->error);
}

mukca_status cli_diagnosis_make_offsets(cli_call *call, cli_diagnosis *d)
{
    const mukca_diagnosed *r = &d->result;
    const mukca_applied *a = &d->diagnosis.applied;
    const bool base = d->options.free_base && r->data->position;
    mukca_offsets *o = &d->offsets;
    mukca_error *error = &call->error;
    int left_out = 0;
    if (!a->fitted)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "no offsets to write: these samples are too few to fit anything");
    MUKCA_TRY(mukca_chain_with_frames(&d->chain, d->diagnosis.chain, base, false, error));
    mukca_offsets_init(o, &d->chain);
    mukca_offsets_set_placements(o, r->data);
    fill_geometry(o, a, d->diagnosis.chain, base);
    if (base) fill_tracker(o, a);
    for (int e = 0; e < a->n_effects; e++) {
        if ((mukca_effect_table[a->effects[e].kind]->needs & MUKCA_NEEDS_MASSES) &&
            d->chain.n_masses == 0) {
            left_out++; /* found by measured efforts, which other samples lack */
            continue;
        }
        o->effects[o->n_effects] = a->effects[e];
        memcpy(o->effect_sigma[o->n_effects++], a->effect_sigma[e], sizeof a->effect_sigma[e]);
    }
    if (left_out && call->common->output)
        cli_note(call, "the table lacks the causes that need link masses; give --inertials FILE");
    return judge(call, d);
}
