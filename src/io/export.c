/* The table of export formats; writing and checking a file of any of them. */
#include "io/export.h"

#include <stdlib.h>
#include <string.h>

#include "io/file.h"

const mukca_exporter mukca_exporters[] = {
#define ROW(name, endings, description) {#name, endings, description, &mukca_export_##name},
    MUKCA_EXPORT_LIST(ROW)
#undef ROW
        {NULL, NULL, NULL, NULL}};

int mukca_exporter_find(const char *path)
{
    const char *dot = path ? strrchr(path, '.') : NULL;
    const size_t length = dot ? strlen(dot) : 0;
    for (int i = 0; dot && mukca_exporters[i].name; i++)
        for (const char *at = mukca_exporters[i].endings; *at; at += at[0] == ' ') {
            const size_t ending = strcspn(at, " ");
            if (ending == length && strncmp(at, dot, length) == 0) return i;
            at += ending;
        }
    return 0;
}

mukca_status mukca_export_write(FILE *stream, const mukca_exporter *exporter,
                                const mukca_export_input *input, mukca_error *error)
{
    const mukca_export_format *format = exporter->format;
    const mukca_status status = format->write(stream, input, error);
    if (status != MUKCA_OK || !input->note || !format->holds) return status;
    for (int e = 0; e < input->offsets->n_effects; e++) {
        const mukca_effect *effect = &input->offsets->effects[e];
        const char *joint = mukca_export_joint(input, effect);
        char text[256];
        if (format->holds(effect)) continue;
        snprintf(text, sizeof text, "%s of %.60s is left out: the format %s cannot represent it",
                 mukca_effect_table[effect->kind]->name, joint ? joint : "the arm", exporter->name);
        input->note(input->context, text);
    }
    return MUKCA_OK;
}

/* What the exporter writes, as a string; free it. */
static mukca_status write_text(char **text, const mukca_exporter *exporter,
                               const mukca_export_input *input, mukca_error *error)
{
    size_t size;
    *text = NULL;
    FILE *stream = open_memstream(text, &size);
    if (!stream) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_status status = exporter->format->write(stream, input, error);
    if (fclose(stream) != 0 && status == MUKCA_OK)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    return status;
}

mukca_status mukca_export_check(mukca_export_difference *difference, const char *path,
                                const mukca_exporter *exporter, const mukca_export_input *input,
                                mukca_error *error)
{
    char *found = NULL, *wanted = NULL;
    size_t length;
    mukca_status status = mukca_file_read(&found, &length, path, MUKCA_FILE_LARGEST, error);
    if (status == MUKCA_OK) status = write_text(&wanted, exporter, input, error);
    const mukca_export_texts texts = {.path = path, .found = found, .wanted = wanted};
    if (status == MUKCA_OK)
        status = mukca_export_compare(difference, &texts, exporter->format->comment, error);
    free(found);
    free(wanted);
    return status;
}
