/* The table of export formats; writing a file of any of them. */
#include "io/export.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "fit/refit.h"

const mukca_exporter mukca_exporters[] = {
#define ROW(name, endings, description) {#name, endings, &mukca_export_##name},
    MUKCA_EXPORT_LIST(ROW)
#undef ROW
        {NULL, NULL, NULL}};

int mukca_exporter_find(const char *path)
{
    const char *dot = path ? strrchr(mukca_file_name(path), '.') : NULL;
    const size_t length = dot ? strlen(dot) : 0;
    if (length < 2) return 0;
    for (int i = 0; mukca_exporters[i].name; i++) {
        const char *ending = strstr(mukca_exporters[i].endings, dot);
        if (ending && strchr(" ", ending[length])) return i;
    }
    return -1;
}

/* The model written if the format cannot represent the whole arm. */
typedef struct {
    mukca_export_input input;
    mukca_offsets offsets;
    mukca_refit refit;
} replacement;

static void note_loss(const mukca_export_input *input, const mukca_exporter *exporter,
                      const mukca_refit *refit)
{
    const mukca_acceptance *a = &input->offsets->acceptance;
    char held_out[120] = "";
    mukca_note_format(input->notes,
                      "%s: %s were fitted to the arm over %s; its tip differs by %.3f mm on "
                      "average, %.3f mm at most (without the fit: %.3f mm)",
                      exporter->name,
                      exporter->format->zeros_only ? "offsets of the joints alone" : "the origins",
                      input->postures ? "the postures given" : "its joint ranges",
                      1e3 * refit->mean, 1e3 * refit->largest, 1e3 * refit->mean_before);
    if (a->given && a->error_m > 0) /* independent errors add in quadrature */
        snprintf(held_out, sizeof held_out,
                 " (held-out error %.3f mm, of this export some %.3f mm)", 1e3 * a->error_m,
                 1e3 * hypot(a->error_m, refit->mean));
    mukca_note_format(input->notes,
                      "recommended: the table itself, by mukca compensate or export -f c%s",
                      held_out);
}

static bool holds(const mukca_export_format *format, const mukca_effect *effect)
{
    return format->holds_all || (format->holds && format->holds(effect));
}

/* Keep the effects that the format can represent and note the other functions of the posture.
 * Returns the needs of these. */
static int keep_held(mukca_offsets *kept, bool *lost, const mukca_export_input *input,
                     const mukca_exporter *exporter)
{
    const mukca_offsets *o = input->offsets;
    int needs = 0;
    *lost = exporter->format->zeros_only;
    kept->n_effects = 0;
    for (const mukca_effect *effect = o->effects; effect < o->effects + o->n_effects; effect++) {
        if (holds(exporter->format, effect)) {
            kept->effects[kept->n_effects++] = *effect;
            continue;
        }
        if (mukca_effect_of_history(effect->kind)) continue;
        *lost = true;
        const char *joint = mukca_chain_joint_name(input->chain, effect->joint);
        needs |= mukca_effect_table[effect->kind]->needs;
        mukca_note_format(
            input->notes, "%s of %.60s is not exported: the format %s cannot represent it",
            mukca_effect_table[effect->kind]->name, joint ? joint : "the arm", exporter->name);
    }
    return needs;
}

/* Fit the parameters that the format can represent to the whole arm. */
static mukca_status replace(replacement *r, const mukca_export_input *input,
                            const mukca_exporter *exporter)
{
    const bool zeros = exporter->format->zeros_only;
    r->offsets = *input->offsets;
    r->input = *input;
    r->input.offsets = &r->offsets;
    r->input.zeros = r->refit.zeros;
    bool lost;
    const int needs = keep_held(&r->offsets, &lost, input, exporter);
    const bool blind = (needs & MUKCA_NEEDS_MASSES) && input->chain->n_masses == 0;
    if (blind)
        mukca_note_format(input->notes,
                          "without link masses (--inertials FILE) the fit cannot approximate "
                          "deflection under gravity");
    const mukca_refit_task task = {.chain = input->chain,
                                   .arm = input->offsets,
                                   .held = r->offsets.effects,
                                   .n_held = r->offsets.n_effects,
                                   .zeros_only = zeros,
                                   .postures = input->postures,
                                   .n_postures = input->n_postures};
    MUKCA_TRY(mukca_refit_run(&r->refit, &task, input->error));
    memcpy(r->offsets.theta, r->refit.theta, sizeof r->offsets.theta);
    mukca_offsets_note_history(input->offsets, input->chain,
                               "not applied; its error is beyond any stated here", input->notes);
    if (lost && !blind) note_loss(input, exporter, &r->refit);
    return MUKCA_OK;
}

/* Print a comment if the table was not accepted; not in a format without comments. */
static void print_verdict(FILE *stream, const mukca_export_format *format,
                          const mukca_acceptance *a)
{
    const char *const xml[2] = {"<!--", "-->"};
    const char *const *comment = format->comment[0] ? format->comment : xml;
    if (!a->given || a->accepted || format->zeros_only) return;
    mukca_export_print(stream, "$s The offsets table was not accepted: $p $s\n", comment[0],
                       a->reason, comment[1]);
}

mukca_status mukca_export_write(FILE *stream, const mukca_exporter *exporter,
                                const mukca_export_input *input)
{
    const mukca_export_format *format = exporter->format;
    const mukca_offsets *o = input->offsets;
    bool whole = !format->zeros_only;
    for (int e = 0; e < o->n_effects; e++) whole = whole && holds(format, &o->effects[e]);
    replacement *r = NULL;
    mukca_status status = MUKCA_OK;
    if (!whole) {
        r = calloc(1, sizeof *r);
        if (!r) return mukca_fail(input->error, MUKCA_MEMORY, "out of memory");
        status = replace(r, input, exporter);
        input = &r->input;
    }
    if (status == MUKCA_OK) status = format->write(stream, input);
    if (status == MUKCA_OK) print_verdict(stream, format, &o->acceptance);
    free(r);
    return status;
}
