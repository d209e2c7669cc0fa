/* The corrected arm from an offsets table alone. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arm/offsets.h"
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
    if (origin.left_out > 0)
        return mukca_fail(error, MUKCA_INPUT, "%s: has rows of joints that its chain lacks",
                          origin.name);
    mukca_geometry_set(&model->geometry, &model->chain, offsets.theta);
    model->n_effects = offsets.n_effects;
    memcpy(model->effects, offsets.effects, sizeof model->effects);
    return MUKCA_OK;
}

mukca_status mukca_text_load(char **text, const char *path, mukca_error *error)
{
    enum { LARGEST = 1 << 22 }; /* the longest table has some 500 rows of 200 bytes */
    const bool standard = strcmp(path, "-") == 0;
    FILE *file = standard ? stdin : fopen(path, "rb");
    if (!file)
        return mukca_fail(error, MUKCA_INPUT, "%.100s: cannot read: %s", path, strerror(errno));
    *text = calloc(1, LARGEST);
    const size_t length = *text ? fread(*text, 1, LARGEST - 1, file) : 0;
    mukca_status status = MUKCA_OK;
    if (!*text)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    else if (ferror(file))
        status = mukca_fail(error, MUKCA_INPUT, "%.100s: cannot read: %s", path, strerror(errno));
    else if (length == LARGEST - 1 || strlen(*text) != length)
        status = mukca_fail(error, MUKCA_INPUT, "%.100s: is no offsets table", path);
    if (!standard) fclose(file);
    if (status != MUKCA_OK) {
        free(*text);
        *text = NULL;
    }
    return status;
}

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    char *text;
    mukca_status status = mukca_text_load(&text, path, error);
    if (status != MUKCA_OK) return status;
    status = mukca_corrected_parse(model, text, error);
    free(text);
    return status;
}
