/* Scores of a model on data, nominal and calibrated. */
#include "cli/scores.h"

#include <math.h>
#include <stdlib.h>

mukca_status cli_scores_make(cli_call *call, cli_scores *scores, const mukca_chain *chain,
                             const double *theta, const cli_model *model, const mukca_dataset *data)
{
    const size_t room = (size_t)data->n_placements + 1;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    int n_effects = 0;
    if (model && model->offsets.n_effects > 0) {
        n_effects = model->offsets.n_effects;
        mukca_offsets_place_effects(effects, &model->offsets, data);
    }
    const mukca_model before = {.chain = chain}, after = {.chain = chain,
                                                          .theta = theta,
                                                          .effects = effects,
                                                          .n_effects = n_effects};
    scores->nominal = calloc(room, sizeof *scores->nominal);
    scores->calibrated = calloc(room, sizeof *scores->calibrated);
    if (scores->nominal && scores->calibrated &&
        mukca_evaluate(scores->nominal, &scores->nominal_mean, &before, data) >= 0)
        scores->n = mukca_evaluate(scores->calibrated, &scores->calibrated_mean, &after, data);
    else
        scores->n = -1;
    if (scores->n >= 0) return MUKCA_OK;
    cli_scores_free(scores);
    return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
}

void cli_scores_free(cli_scores *scores)
{
    free(scores->nominal);
    free(scores->calibrated);
    *scores = (cli_scores){0};
}

void cli_scores_write(FILE *stream, double value)
{
    fputc('\t', stream);
    if (isfinite(value)) fprintf(stream, "%.17g", value);
}

const char *cli_scores_name(const mukca_score *score, const mukca_dataset *data)
{
    return score->placement < 0 ? "poses" : data->placements[score->placement].name;
}

/* The figures of a score, by column and JSON key. */
static const struct {
    const char *nominal, *calibrated;
    size_t offset;
} figures[] = {
    {"mae_nominal_m", "mae_m", offsetof(mukca_score, mae)},
    {"std_nominal_m", "std_m", offsetof(mukca_score, std)},
    {"distance_error_nominal_m", "distance_error_m", offsetof(mukca_score, distance_error)},
    {"rotation_error_nominal_rad", "rotation_error_rad", offsetof(mukca_score, rotation_error)}};
enum { FIGURES = sizeof figures / sizeof *figures, ROTATION = FIGURES - 1 };

static double figure(const mukca_score *score, int k)
{
    return *(const double *)(const void *)((const char *)score + figures[k].offset);
}

void cli_scores_write_header(FILE *stream)
{
    fputs("set\tplacement\trows", stream);
    for (int k = 0; k < FIGURES; k++)
        fprintf(stream, "\t%s\t%s", figures[k].nominal, figures[k].calibrated);
    fputc('\n', stream);
}

void cli_scores_write_rows(FILE *stream, const char *set, const cli_scores *scores,
                           const mukca_dataset *data)
{
    for (int i = 0; i < scores->n; i++) {
        const mukca_score *after = &scores->calibrated[i];
        fprintf(stream, "%s\t%s\t%d", set, cli_scores_name(after, data), after->rows);
        for (int k = 0; k < FIGURES; k++) {
            cli_scores_write(stream, figure(&scores->nominal[i], k));
            cli_scores_write(stream, figure(after, k));
        }
        fputc('\n', stream);
    }
}

json_t *cli_scores_json(const cli_scores *scores, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int i = 0; i < scores->n; i++) {
        const mukca_score *before = &scores->nominal[i], *after = &scores->calibrated[i];
        json_t *object =
            json_pack("{s:s, s:i}", "placement", cli_scores_name(after, data), "rows", after->rows);
        for (int k = 0; k < FIGURES; k++) {
            if (k == ROTATION && !isfinite(figure(after, k))) continue;
            json_object_set_new(object, figures[k].nominal, cli_json_real(figure(before, k)));
            json_object_set_new(object, figures[k].calibrated, cli_json_real(figure(after, k)));
        }
        json_array_append_new(array, object);
    }
    return array;
}

/* `kind`, `set`: "distortion", "train". */
static void print_line(cli_call *call, const char *kind, const char *set, double factor,
                       double nominal, const double *calibrated)
{
    char name[40];
    snprintf(name, sizeof name, "%s, %s", kind, set);
    cli_answer(call, "  %-24s %12.3f", name, factor * nominal);
    if (calibrated) cli_answer(call, " %12.3f", factor * *calibrated);
    if (calibrated && nominal > 0)
        cli_answer(call, " %+11.2f %%", 100 * (*calibrated / nominal - 1));
    cli_answer(call, "\n");
}

void cli_scores_print_header(cli_call *call, bool calibrated)
{
    cli_answer(call, "  %-24s %12s%s\n", "Error", "nominal", calibrated ? "   calibrated" : "");
}

void cli_scores_print(cli_call *call, const cli_scores *scores, const char *set, bool calibrated)
{
    const mukca_score *a = &scores->nominal_mean, *b = &scores->calibrated_mean;
    const bool sockets = isfinite(a->distance_error);
    print_line(call, sockets ? "consistency mm" : "position mm", set, 1e3, a->mae,
               calibrated ? &b->mae : NULL);
    if (sockets)
        print_line(call, "distortion mm", set, 1e3, a->distance_error,
                   calibrated ? &b->distance_error : NULL);
    if (isfinite(a->rotation_error))
        print_line(call, "rotation mrad", set, 1e3, a->rotation_error,
                   calibrated ? &b->rotation_error : NULL);
}
