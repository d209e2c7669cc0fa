/* Offsets tables as files. */
#include "io/offsets.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/text.h"
#include "mukca/version.h"

void mukca_offsets_time(char text[32])
{
    const char *fixed = getenv("SOURCE_DATE_EPOCH");
    char *end = NULL;
    time_t t = time(NULL);
    long long given = fixed ? strtoll(fixed, &end, 10) : 0;
    if (fixed && end != fixed && *end == '\0') t = (time_t)given;
    struct tm utc;
    if (!gmtime_r(&t, &utc) || strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0)
        snprintf(text, 32, "unknown");
}

/* Write the verdict in the format of mukca_acceptance_read. */
static void write_acceptance(FILE *stream, const mukca_acceptance *a)
{
    if (!a->given) return;
    fprintf(stream, "# accepted: %s%s\n", a->accepted ? "yes" : "no; ", a->reason);
    fprintf(stream, "# converged: %s\n", a->converged ? "yes" : "no");
    if (a->error_of[0]) mukca_offset_line(stream, "error_of: ", a->error_of);
    if (a->at_rest[0]) mukca_offset_line(stream, "joints_at_rest: ", a->at_rest);
    for (int i = 0; i < MUKCA_ACCEPTANCE_NUMBERS; i++)
        if (isfinite(a->number[i]))
            fprintf(stream, "# %s: %.6g\n", mukca_acceptance_key[i], a->number[i]);
}

/* Write all lines but that of the digest; rows[MUKCA_MAX_OFFSET_ROWS] is scratch. */
static void write_lines(FILE *stream, mukca_offset_row *rows, const mukca_offsets *offsets,
                        const mukca_chain *chain, const mukca_dataset *data, const char *comments)
{
    char when[32];
    mukca_offsets_time(when);
    mukca_offset_lines_names(stream, chain);
    for (int i = 0; data && i < data->n_files; i++)
        mukca_offset_line(stream, "data: ", data->files[i]);
    mukca_offset_line(stream, "created: ", when);
    mukca_offset_lines_chain(stream, chain);
    for (int p = 0; p < offsets->n_placements; p++)
        mukca_offset_line(stream, "placement: ", offsets->placements[p]);
    write_acceptance(stream, &offsets->acceptance);
    for (const char *line = comments; line && *line;) {
        size_t length = strcspn(line, "\n");
        fprintf(stream, "# %.*s\n", (int)length, line);
        line += length + (line[length] == '\n');
    }
    mukca_offset_lines_columns(stream);
    int n = mukca_offsets_rows(rows, offsets, chain);
    for (int i = 0; i < n; i++) mukca_offset_lines_row(stream, &rows[i]);
}

mukca_status mukca_offsets_write(FILE *stream, const mukca_offsets *offsets,
                                 const mukca_chain *chain, const mukca_dataset *data,
                                 const char *comments, mukca_error *error)
{
    static const char title[] = "# mukca " MUKCA_VERSION " offsets table\n";
    char *text = NULL;
    size_t size = 0;
    mukca_offset_row *rows = calloc(MUKCA_MAX_OFFSET_ROWS, sizeof *rows);
    FILE *memory = rows ? open_memstream(&text, &size) : NULL;
    if (memory) write_lines(memory, rows, offsets, chain, data, comments);
    const bool whole = memory && mukca_file_close(memory, &text);
    if (whole) {
        const uint64_t start = mukca_hash(MUKCA_HASH_START, title, sizeof title - 1);
        fprintf(stream, "%s# digest: %016" PRIx64 "\n%s", title, mukca_hash(start, text, size),
                text);
    }
    free(text);
    free(rows);
    return whole ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

mukca_status mukca_offsets_read(mukca_offsets *offsets, const mukca_chain *chain, const char *path,
                                const mukca_offsets_options *options, mukca_error *error)
{
    char *text;
    mukca_offsets_origin origin = {
        .name = mukca_file_shown(path), .accept = options->accept, .embedded = options->embedded};
    MUKCA_TRY(mukca_file_read(&text, path, error));
    mukca_status status = mukca_offsets_parse(offsets, &origin, chain, text, error);
    free(text);
    if (status != MUKCA_OK) return status;
    if (origin.other || origin.other_file)
        mukca_note_format(options->notes, "%s: made for another %s; its offsets are added to this",
                          origin.name, origin.other ? "URDF" : "factory file");
    if (origin.other_ends || origin.ignored)
        mukca_note_format(options->notes,
                          "%s: made for another base or tip than '%s' and '%s': its verdict does "
                          "not hold here, and %d rows are ignored",
                          origin.name, chain->base, chain->tip, origin.ignored);
    if (!offsets->acceptance.given)
        mukca_note_format(options->notes,
                          "%s: has no verdict (older, or made by hand); check it with mukca "
                          "evaluate",
                          origin.name);
    else if (!offsets->acceptance.accepted)
        mukca_note_format(options->notes, "%s: this calibration did not pass: %s", origin.name,
                          offsets->acceptance.reason);
    else if (!offsets->acceptance.intact)
        mukca_note_format(options->notes,
                          "%s: has no digest (older, or edited); check it with mukca evaluate",
                          origin.name);
    return MUKCA_OK;
}

void mukca_offsets_note_history(const mukca_offsets *offsets, const mukca_chain *chain,
                                const char *treatment, mukca_notes notes)
{
    for (const mukca_effect *e = offsets->effects; e < offsets->effects + offsets->n_effects; e++) {
        const char *joint = mukca_chain_joint_name(chain, e->joint);
        char variant[MUKCA_EFFECT_TEXT];
        double square = 0;
        if (!mukca_effect_of_history(e->kind)) continue;
        for (int t = 0; t < e->terms; t++) square += e->coefficient[t] * e->coefficient[t];
        mukca_effect_variant_text(variant, e);
        mukca_note_format(
            notes, "%s%s%s of %.60s, %.3g m%s, depends on time, moves or placement: %s",
            mukca_effect_table[e->kind]->name, *variant ? "@" : "", variant,
            joint ? joint : "the arm", 1e3 * sqrt(square), mukca_effect_unit(e, chain), treatment);
    }
}
