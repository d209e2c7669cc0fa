/* Offsets tables in memory: their rows, and the placements of their effects; the corrected arm from
 * a file. */
#include "arm/offsets.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "mukca/corrected.h"

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
    _Static_assert(sizeof rows->term == MUKCA_EFFECT_TEXT, "texts of terms");
    int n = 0;
    for (int i = 0; i < MUKCA_PARAMETERS * chain->n_elements; i++) {
        if (!offsets->listed[i]) continue;
        rows[n] = mukca_offset_row_parameter(chain, i, offsets->theta[i]);
        rows[n].sigma = offsets->sigma[i];
        rows[n++].identifiable = offsets->identifiable[i] != 0;
    }
    for (int e = 0; e < offsets->n_effects; e++) {
        const mukca_effect *effect = &offsets->effects[e];
        const mukca_effect_info *info = mukca_effect_table[effect->kind];
        for (int t = 0; t < effect->terms; t++) {
            mukca_offset_row *row = &rows[n++];
            *row = (mukca_offset_row){
                .joint = effect->joint < 0 ? "-" : mukca_chain_joint_name(chain, effect->joint),
                .parameter = info->name,
                .unit = mukca_effect_unit(effect, chain),
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

/* Check the factory file, whose hash identifies the robot of UR. */
static mukca_status check_kinematics(const mukca_offsets_origin *o, const mukca_chain *chain,
                                     mukca_error *error)
{
    const bool has_factory = o->embedded->kinematics_sha256[0], known = chain->kinematics_hash[0];
    if (!known || !o->embedded->kinematics_hash[0])
        return mukca_fail(
            error, MUKCA_INPUT, "%s: was made %s: its offsets are added to other origins; give %s",
            o->name, has_factory ? "with a factory file (--kinematics)" : "without --kinematics",
            has_factory ? "the same --kinematics FILE" : "no --kinematics");
    return mukca_fail(error, MUKCA_INPUT,
                      "%s: is of the robot %.40s, the factory file of %.40s: another robot, or a "
                      "file that was edited or made anew; give the file of the table "
                      "(--accept-other-arm takes any)",
                      o->name, o->embedded->kinematics_hash, chain->kinematics_hash);
}

static mukca_status check_origin(mukca_offsets_origin *o, const mukca_chain *chain,
                                 mukca_error *error)
{
    const char *sha = o->embedded->urdf_sha256;
    if (!sha[0])
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: no offsets table: the line `# urdf_sha256:` is missing", o->name);
    o->other = strcmp(sha, chain->urdf_sha256) != 0;
    o->other_file = strcmp(o->embedded->kinematics_sha256, chain->kinematics_sha256) != 0;
    o->other_ends = (o->embedded->base[0] && strcmp(o->embedded->base, chain->base) != 0) ||
                    (o->embedded->tip[0] && strcmp(o->embedded->tip, chain->tip) != 0);
    if (o->accept & MUKCA_ACCEPT_OTHER) return MUKCA_OK;
    if (o->other)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: was made for another URDF (robot '%.40s', SHA-256 %.12s..., not "
                          "%.12s...); --accept-other-arm applies its offsets nevertheless",
                          o->name, o->embedded->robot, sha, chain->urdf_sha256);
    return o->other_file ? check_kinematics(o, chain, error) : MUKCA_OK;
}

mukca_status mukca_offsets_parse(mukca_offsets *offsets, mukca_offsets_origin *origin,
                                 const mukca_chain *chain, const char *text, mukca_error *error)
{
    const mukca_offsets_target into = {.theta = offsets->theta,
                                       .listed = offsets->listed,
                                       .n_effects = &offsets->n_effects,
                                       .effects = offsets->effects,
                                       .acceptance = &offsets->acceptance,
                                       .rest = offsets,
                                       .check = origin->embedded ? NULL : check_origin};
    const size_t size = strlen(text);
    memset(offsets, 0, sizeof *offsets);
    if (origin->embedded) return mukca_offsets_parse_into(&into, origin, NULL, text, size, error);
    origin->embedded = malloc(sizeof *origin->embedded);
    if (!origin->embedded) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_status status = mukca_offsets_parse_into(&into, origin, chain, text, size, error);
    free(origin->embedded);
    origin->embedded = NULL;
    return status;
}

/* ---- the corrected arm from a file ---- */

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    char *text;
    MUKCA_TRY(mukca_file_read(&text, path, error));
    const mukca_status status =
        mukca_corrected_parse_named(model, text, strlen(text), mukca_file_shown(path), 0, error);
    free(text);
    return status;
}
