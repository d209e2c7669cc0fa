/* Scores of a model on data, nominal beside calibrated. */
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

const char *cli_scores_name(const mukca_score *score, const mukca_dataset *data)
{
    return score->placement < 0 ? "poses" : data->placements[score->placement].name;
}

json_t *cli_scores_json(const cli_scores *scores, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int i = 0; i < scores->n; i++) {
        const mukca_score *a = &scores->nominal[i], *b = &scores->calibrated[i];
        json_t *object = json_pack(
            "{s:s, s:i, s:o, s:o, s:o, s:o, s:o, s:o}", "placement", cli_scores_name(b, data),
            "rows", b->rows, "mae_nominal_m", cli_json_real(a->mae), "mae_m", cli_json_real(b->mae),
            "std_nominal_m", cli_json_real(a->std), "std_m", cli_json_real(b->std),
            "distance_error_nominal_m", cli_json_real(a->distance_error), "distance_error_m",
            cli_json_real(b->distance_error));
        if (object && isfinite(b->rotation_error)) {
            json_object_set_new(object, "rotation_error_nominal_rad", json_real(a->rotation_error));
            json_object_set_new(object, "rotation_error_rad", json_real(b->rotation_error));
        }
        json_array_append_new(array, object);
    }
    return array;
}

void cli_millimetres(char text[24], double metres)
{
    const double mm = 1e3 * metres;
    snprintf(text, 24,
             !isfinite(mm)                 ? "-"
             : fabs(mm) >= 0.01 || mm == 0 ? "%.3f mm"
                                           : "%.2g mm",
             mm);
}

static void say_line(cli_call *call, const char *kind, const char *what, double nominal,
                     const double *calibrated)
{
    char name[40], text[24];
    snprintf(name, sizeof name, "%s, %s", kind, what);
    cli_millimetres(text, nominal);
    cli_answer(call, "  %-18s %12s", name, text);
    if (calibrated) {
        cli_millimetres(text, *calibrated);
        cli_answer(call, " %12s", text);
        if (nominal > 0) cli_answer(call, "  %+8.2f %%", 100 * (*calibrated / nominal - 1));
    }
    cli_answer(call, "\n");
}

void cli_scores_say_header(cli_call *call, bool calibrated)
{
    cli_answer(call, "%s  %-18s %12s%s%s\n", cli_bold(stderr), "", "nominal",
               calibrated ? "   calibrated" : "", cli_plain(stderr));
}

void cli_scores_say(cli_call *call, const cli_scores *scores, const char *what, bool calibrated)
{
    const mukca_score *a = &scores->nominal_mean, *b = &scores->calibrated_mean;
    say_line(call, "error", what, a->mae, calibrated ? &b->mae : NULL);
    if (isfinite(a->distance_error))
        say_line(call, "distance", what, a->distance_error, calibrated ? &b->distance_error : NULL);
    if (isfinite(a->rotation_error)) {
        cli_answer(call, "  rotation, %-8s %9.3f mrad", what, 1e3 * a->rotation_error);
        if (calibrated) cli_answer(call, " %7.3f mrad", 1e3 * b->rotation_error);
        cli_answer(call, "\n");
    }
}
