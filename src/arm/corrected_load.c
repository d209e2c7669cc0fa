/* The corrected arm from an offsets table alone. */
#include <stdlib.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/file.h"
#include "mukca/corrected.h"

mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, mukca_error *error)
{
    mukca_offsets offsets;
    mukca_offsets_origin origin = {.name = "offsets table"};
    memset(model, 0, sizeof *model);
    mukca_status status = mukca_chain_parse(&model->chain, text, origin.name, error);
    if (status != MUKCA_OK) return status;
    status = mukca_offsets_parse(&offsets, &origin, &model->chain, text, error);
    if (status != MUKCA_OK) return status;
    if (origin.ignored > 0)
        return mukca_fail(error, MUKCA_INPUT, "%s: has rows of joints that its chain lacks",
                          origin.name);
    mukca_geometry_set(&model->geometry, &model->chain, offsets.theta);
    model->n_effects = offsets.n_effects;
    memcpy(model->effects, offsets.effects, sizeof model->effects);
    return MUKCA_OK;
}

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    char *text;
    mukca_status status = mukca_file_read(&text, path, error);
    if (status != MUKCA_OK) return status;
    status = mukca_corrected_parse(model, text, error);
    free(text);
    return status;
}
