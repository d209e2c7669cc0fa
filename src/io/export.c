/* The table of export formats; writing and checking a file of any of them. */
#include "io/export.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/note.h"

const mukca_exporter mukca_exporters[] = {
#define ROW(name, endings, description) {#name, endings, description, &mukca_export_##name},
    MUKCA_EXPORT_LIST(ROW)
#undef ROW
        {NULL, NULL, NULL, NULL}};

int mukca_exporter_find(const char *path)
{
    const char *slash = path ? strrchr(path, '/') : NULL;
    const char *dot = path ? strrchr(slash ? slash : path, '.') : NULL;
    const size_t length = dot ? strlen(dot) : 0;
    if (length < 2) return 0;
    for (int i = 0; mukca_exporters[i].name; i++)
        for (const char *at = mukca_exporters[i].endings; *at; at += at[0] == ' ') {
            const size_t ending = strcspn(at, " ");
            if (ending == length && strncmp(at, dot, length) == 0) return i;
            at += ending;
        }
    return -1;
}

mukca_status mukca_export_write(FILE *stream, const mukca_exporter *exporter,
                                const mukca_export_input *input, mukca_error *error)
{
    const mukca_export_format *format = exporter->format;
    const mukca_offsets *o = input->offsets;
    const mukca_status status = format->write(stream, input, error);
    if (status != MUKCA_OK || !format->holds) return status;
    for (const mukca_effect *effect = o->effects; effect < o->effects + o->n_effects; effect++)
        if (!format->holds(effect)) {
            const char *joint = mukca_export_joint(input, effect);
            mukca_note_format(input->note, input->context,
                              "%s of %.60s is not exported: the format %s cannot represent it",
                              mukca_effect_table[effect->kind]->name, joint ? joint : "the arm",
                              exporter->name);
        }
    return MUKCA_OK;
}

mukca_status mukca_export_check(mukca_export_difference *difference, const char *path,
                                const mukca_exporter *exporter, const mukca_export_input *input,
                                mukca_error *error)
{
    char *found = NULL, *wanted = NULL;
    size_t size;
    mukca_status status = mukca_file_read(&found, path, error);
    if (status != MUKCA_OK) return status;
    FILE *stream = open_memstream(&wanted, &size);
    if (stream) status = exporter->format->write(stream, input, error);
    if (!mukca_file_close(stream, &wanted))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK) {
        *difference = (mukca_export_difference){.agrees = true};
        if (exporter->format->comment[0])
            mukca_export_compare_text(difference, found, wanted, exporter->format->comment);
        else
            status = mukca_export_compare_xml(difference, found, wanted);
        if (status == MUKCA_INPUT)
            mukca_fail(error, status, "%s: not well-formed XML; export it again",
                       mukca_file_shown(path));
        else if (status != MUKCA_OK)
            mukca_fail(error, status, "out of memory");
        if (difference->compared == 0) difference->agrees = false;
    }
    free(found);
    free(wanted);
    return status;
}
