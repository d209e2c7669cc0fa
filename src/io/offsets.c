/* The offsets table: rows, and writing them. */
#include "io/offsets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mukca/corrected.h"
#include "mukca/version.h"

void mukca_offsets_init(mukca_offsets *offsets, const mukca_chain *chain)
{
    memset(offsets, 0, sizeof *offsets);
    mukca_chain_theta(offsets->theta, chain);
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
        const mukca_effect_info *info = &mukca_effect_table[effect->kind];
        for (int t = 0; t < effect->terms; t++) {
            mukca_offset_row *row = &rows[n++];
            *row = (mukca_offset_row){
                .joint = effect->joint < 0
                             ? "-"
                             : chain->element[chain->joint_element[effect->joint]].name,
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

/* Text of one line: control characters would break the table. */
static void print_line(FILE *stream, const char *key, const char *text)
{
    fprintf(stream, "# %s", key);
    for (; *text; text++) fputc((unsigned char)*text < ' ' ? ' ' : *text, stream);
    fputc('\n', stream);
}

mukca_status mukca_offsets_write(FILE *stream, const mukca_offsets *offsets,
                                 const mukca_chain *chain, const mukca_dataset *data,
                                 const char *comments, mukca_error *error)
{
    char when[32];
    mukca_offset_row *rows = calloc(MUKCA_MAX_OFFSET_ROWS, sizeof *rows);
    if (!rows) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_offsets_time(when);
    fputs("# mukca " MUKCA_VERSION " offsets table\n", stream);
    print_line(stream, "robot: ", chain->robot);
    print_line(stream, "urdf_sha256: ", chain->urdf_sha256);
    print_line(stream, "base: ", chain->base);
    print_line(stream, "tip: ", chain->tip);
    for (int i = 0; data && i < data->n_files; i++) print_line(stream, "data: ", data->files[i]);
    print_line(stream, "created: ", when);
    mukca_chain_write_comments(stream, chain);
    for (int p = 0; p < offsets->n_placements; p++)
        print_line(stream, "placement: ", offsets->placements[p]);
    for (const char *line = comments; line && *line;) {
        size_t length = strcspn(line, "\n");
        fprintf(stream, "# %.*s\n", (int)length, line);
        line += length + (line[length] == '\n');
    }
    fputs(
        "# formula: calibrated = nominal + offset; T_parent_child(q) = [Rz(yaw) Ry(pitch) "
        "Rx(roll) R(axis, q), (x y z)] with the calibrated values in place of the URDF's origin\n",
        stream);
    fputs("joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable\tterm\n",
          stream);
    int n = mukca_offsets_rows(rows, offsets, chain);
    for (int i = 0; i < n; i++)
        fprintf(stream, "%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t%.17g\t%d\t%s\n", rows[i].joint,
                rows[i].parameter, rows[i].unit, rows[i].nominal, rows[i].calibrated,
                rows[i].offset, rows[i].sigma, rows[i].identifiable, rows[i].term);
    free(rows);
    return MUKCA_OK;
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
