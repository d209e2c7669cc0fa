/* Offsets tables in memory: their rows, and the placements of their effects. */
#include "arm/offsets.h"

#include <string.h>

void mukca_offsets_init(mukca_offsets *offsets, const mukca_chain *chain)
{
    memset(offsets, 0, sizeof *offsets);
    mukca_chain_theta(offsets->theta, chain);
    mukca_acceptance_init(&offsets->acceptance);
}

void mukca_offsets_set_placements(mukca_offsets *offsets, const mukca_dataset *data)
{
    int n = data->n_placements < MUKCA_MAX_PLACEMENTS ? data->n_placements : MUKCA_MAX_PLACEMENTS;
    offsets->n_placements = n;
    for (int p = 0; p < n; p++)
        memcpy(offsets->placements[p], data->placements[p].name, MUKCA_NAME_SIZE);
}

int mukca_offsets_rows(mukca_offset_row *rows, const mukca_offsets *offsets,
                       const mukca_chain *chain)
{
    double nominal[MUKCA_MAX_THETA];
    int n = 0;
    mukca_chain_theta(nominal, chain);
    for (int i = 0; i < MUKCA_PARAMETERS * chain->n_elements; i++) {
        if (!offsets->listed[i]) continue;
        const int parameter = i % MUKCA_PARAMETERS;
        rows[n++] = (mukca_offset_row){.joint = chain->element[i / MUKCA_PARAMETERS].name,
                                       .parameter = mukca_parameter_name[parameter],
                                       .unit = parameter < 3 ? "m" : "rad",
                                       .nominal = nominal[i],
                                       .calibrated = offsets->theta[i],
                                       .offset = offsets->theta[i] - nominal[i],
                                       .sigma = offsets->sigma[i],
                                       .identifiable = offsets->identifiable[i] != 0,
                                       .term = "-"};
    }
    for (int e = 0; e < offsets->n_effects; e++) {
        const mukca_effect *effect = &offsets->effects[e];
        const mukca_effect_info *info = mukca_effect_table[effect->kind];
        for (int t = 0; t < effect->terms; t++) {
            mukca_offset_row *row = &rows[n++];
            *row = (mukca_offset_row){
                .joint = effect->joint < 0 ? "-" : mukca_chain_joint_name(chain, effect->joint),
                .parameter = info->name,
                .unit = info->unit,
                .nominal = 0,
                .calibrated = effect->coefficient[t],
                .offset = effect->coefficient[t],
                .sigma = offsets->effect_sigma[e][t],
                .identifiable = true};
            mukca_effect_term_text(row->term, effect, t);
        }
    }
    return n;
}

void mukca_offsets_place_effects(mukca_effect *effects, const mukca_offsets *offsets,
                                 const mukca_dataset *data)
{
    for (int e = 0; e < offsets->n_effects; e++) {
        effects[e] = offsets->effects[e];
        if (effects[e].placement < 0) continue;
        const char *name = offsets->placements[effects[e].placement];
        effects[e].placement = -1;
        for (int p = 0; p < data->n_placements; p++)
            if (strcmp(data->placements[p].name, name) == 0) effects[e].placement = p;
    }
}

mukca_status mukca_offsets_parse(mukca_offsets *offsets, mukca_offsets_origin *origin,
                                 const mukca_chain *chain, const char *text, mukca_error *error)
{
    const mukca_offsets_target into = {.theta = offsets->theta,
                                       .listed = offsets->listed,
                                       .n_effects = &offsets->n_effects,
                                       .effects = offsets->effects,
                                       .acceptance = &offsets->acceptance,
                                       .rest = offsets};
    mukca_offsets_init(offsets, chain);
    return mukca_offsets_parse_into(&into, origin, chain, (mukca_bytes){text, strlen(text)}, error);
}
