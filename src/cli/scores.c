/* Scores of a model on data, nominal and calibrated. */
#include "cli/scores.h"
#include "base/file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "base/utf8.h"
#include "fit/mismatch.h"

/* Copy the parameters of the URDF to those of a chain that may have additional elements (frames of
 * pose logs). */
static void take_urdf_theta(double *theta, const mukca_chain *chain, const mukca_chain *urdf)
{
    for (int k = 0; k < chain->n_elements; k++) {
        const int from = mukca_chain_find_element(urdf, chain->element[k].name);
        if (from < 0) continue;
        memcpy(theta + MUKCA_PARAMETERS * k, urdf->element[from].xyz, 3 * sizeof *theta);
        memcpy(theta + MUKCA_PARAMETERS * k + 3, urdf->element[from].rpy, 3 * sizeof *theta);
    }
}

mukca_status cli_scores_make(cli_call *call, cli_scores *scores, const mukca_chain *chain,
                             const double *theta, const cli_model *model, const mukca_dataset *data)
{
    const size_t room = mukca_evaluate_room(data);
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    int n_effects = 0;
    if (model && model->offsets.n_effects > 0) {
        n_effects = model->offsets.n_effects;
        mukca_offsets_place_effects(effects, &model->offsets, data);
    }
    double urdf[MUKCA_MAX_THETA];
    const bool factory = call->common->kinematics != NULL;
    mukca_chain_theta(urdf, chain);
    if (scores->nominal_theta)
        memcpy(urdf, scores->nominal_theta,
               MUKCA_PARAMETERS * (size_t)chain->n_elements * sizeof *urdf);
    if (factory) take_urdf_theta(urdf, chain, &call->session->model.urdf);
    const mukca_model before = {
        .chain = chain, .theta = factory ? urdf : scores->nominal_theta, .by_log = scores->by_log};
    const mukca_model middle = {
        .chain = chain, .theta = scores->nominal_theta, .by_log = scores->by_log};
    const mukca_model after = {.chain = chain,
                               .theta = theta,
                               .effects = effects,
                               .n_effects = n_effects,
                               .by_log = scores->by_log};
    scores->has_factory = factory;
    scores->nominal = calloc(room, sizeof *scores->nominal);
    scores->factory = calloc(room, sizeof *scores->factory);
    scores->calibrated = calloc(room, sizeof *scores->calibrated);
    if (scores->nominal && scores->factory && scores->calibrated &&
        mukca_evaluate(scores->nominal, &scores->nominal_mean, &before, data) >= 0 &&
        (!factory || mukca_evaluate(scores->factory, &scores->factory_mean, &middle, data) >= 0))
        scores->n = mukca_evaluate(scores->calibrated, &scores->calibrated_mean, &after, data);
    else
        scores->n = -1;
    if (scores->n >= 0) return MUKCA_OK;
    cli_scores_free(scores);
    return cli_fail(call, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
}

void cli_scores_free(cli_scores *scores)
{
    free(scores->nominal);
    free(scores->factory);
    free(scores->calibrated);
    *scores = (cli_scores){0};
}

/* Write a tab and the number, empty if not finite. */
static void write_number(FILE *stream, double value)
{
    fputc('\t', stream);
    if (isfinite(value)) fprintf(stream, "%.17g", value);
}

enum { NAME = 192 };

/* "panda/front"; "poses" for all pose logs, "log.csv" or "log.csv:target" for one. */
static const char *find_name(char name[NAME], const mukca_score *score, const mukca_dataset *data)
{
    if (score->placement >= 0) return data->placements[score->placement].name;
    if (score->file < 0) return "poses";
    snprintf(name, NAME, "%.100s%s%s", mukca_file_name(data->files[score->file]),
             score->target < 0 ? "" : ":", score->target < 0 ? "" : data->targets[score->target]);
    mukca_utf8_mend(name);
    return name;
}

/* The figures of a score, by column and JSON key. */
static const struct {
    const char *nominal, *calibrated, *factory;
    size_t offset;
} figures[] = {{"mae_nominal_m", "mae_m", "mae_factory_m", offsetof(mukca_score, mae)},
               {"std_nominal_m", "std_m", "std_factory_m", offsetof(mukca_score, std)},
               {"distance_error_nominal_m", "distance_error_m", "distance_error_factory_m",
                offsetof(mukca_score, distance_error)},
               {"rotation_error_nominal_rad", "rotation_error_rad", "rotation_error_factory_rad",
                offsetof(mukca_score, rotation_error)}};
enum { FIGURES = sizeof figures / sizeof *figures, ROTATION = FIGURES - 1 };

static double figure(const mukca_score *score, int k)
{
    return *(const double *)(const void *)((const char *)score + figures[k].offset);
}

void cli_scores_write_header(FILE *stream, bool factory)
{
    fputs("set\tplacement\trows", stream);
    for (int k = 0; k < FIGURES; k++)
        fprintf(stream, "\t%s\t%s", figures[k].nominal, figures[k].calibrated);
    for (int k = 0; k < FIGURES && factory; k++) fprintf(stream, "\t%s", figures[k].factory);
    fputc('\n', stream);
}

void cli_scores_write_rows(FILE *stream, const char *set, const cli_scores *scores,
                           const mukca_dataset *data)
{
    for (int i = 0; i < scores->n; i++) {
        char name[NAME];
        const mukca_score *after = &scores->calibrated[i];
        fprintf(stream, "%s\t%s\t%d", set, find_name(name, after, data), after->rows);
        for (int k = 0; k < FIGURES; k++) {
            write_number(stream, figure(&scores->nominal[i], k));
            write_number(stream, figure(after, k));
        }
        for (int k = 0; k < FIGURES && scores->has_factory; k++)
            write_number(stream, figure(&scores->factory[i], k));
        fputc('\n', stream);
    }
}

json_t *cli_scores_json(const cli_scores *scores, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int i = 0; i < scores->n; i++) {
        char name[NAME], keys[96];
        const mukca_score *before = &scores->nominal[i], *after = &scores->calibrated[i];
        json_t *object = cli_json("placement:s rows:i", find_name(name, after, data), after->rows);
        for (int k = 0; k < FIGURES; k++) {
            if (k == ROTATION && !isfinite(figure(after, k))) continue;
            snprintf(keys, sizeof keys, "%s:f %s:f", figures[k].nominal, figures[k].calibrated);
            json_object_update_new(object, cli_json(keys, figure(before, k), figure(after, k)));
            snprintf(keys, sizeof keys, "%s:f", figures[k].factory);
            if (scores->has_factory)
                json_object_update_new(object, cli_json(keys, figure(&scores->factory[i], k)));
        }
        json_array_append_new(array, object);
    }
    return array;
}

/* A figure of the models in mm or mrad; of[1], the factory's, may be NULL. */
static void print_figures(cli_call *call, const char *name, int k, const mukca_score *const of[3],
                          bool calibrated)
{
    const double nominal = figure(of[0], k), after = figure(of[2], k);
    cli_answer(call, "  %-24s %12.3f", name, 1e3 * nominal);
    if (of[1]) cli_answer(call, " %12.3f", 1e3 * figure(of[1], k));
    if (calibrated) cli_answer(call, " %12.3f", 1e3 * after);
    if (calibrated && nominal > 0) cli_answer(call, " %+11.2f %%", 100 * (after / nominal - 1));
    cli_answer(call, "\n");
}

/* A mean over all placements; `kind`, `set`: "distortion", "train". */
static void print_line(cli_call *call, const cli_scores *scores, int k, const char *kind,
                       const char *set, bool calibrated)
{
    char name[40];
    snprintf(name, sizeof name, "%s, %s", kind, set);
    print_figures(call, name, k,
                  (const mukca_score *const[]){&scores->nominal_mean,
                                               scores->has_factory ? &scores->factory_mean : NULL,
                                               &scores->calibrated_mean},
                  calibrated);
}

void cli_scores_print_header(cli_call *call, bool calibrated)
{
    cli_answer(call, "  %-24s %12s%s%s\n", "Error", "nominal",
               call->common->kinematics ? "      factory" : "", calibrated ? "   calibrated" : "");
}

void cli_scores_print(cli_call *call, const cli_scores *scores, const char *set, bool calibrated)
{
    enum { MAE, STD, DISTANCE };
    const bool sockets = isfinite(scores->nominal_mean.distance_error);
    print_line(call, scores, MAE, sockets ? "consistency mm" : "position mm", set, calibrated);
    if (sockets) print_line(call, scores, DISTANCE, "distortion mm", set, calibrated);
    if (isfinite(scores->nominal_mean.rotation_error))
        print_line(call, scores, ROTATION, "rotation mrad", set, calibrated);
}

void cli_scores_print_rows(cli_call *call, const cli_scores *scores, const mukca_dataset *data,
                           bool calibrated)
{
    char name[NAME], indented[32];
    for (int i = 0; i < scores->n && scores->n > 1; i++) {
        snprintf(indented, sizeof indented, "  %.24s",
                 find_name(name, &scores->calibrated[i], data));
        print_figures(call, indented, 0,
                      (const mukca_score *const[]){&scores->nominal[i],
                                                   scores->has_factory ? &scores->factory[i] : NULL,
                                                   &scores->calibrated[i]},
                      calibrated);
    }
}

void cli_print_mismatch(cli_call *call, const mukca_dataset *data, bool free_base, bool free_tool)
{
    const mukca_chain *chain = &call->session->model.chain;
    mukca_mismatch m;
    mukca_error error; /* only a hint: omitted if out of memory */
    char text[400] = "";
    mukca_text what = MUKCA_TEXT(text);
    if (mukca_mismatch_find(&m, chain, data, free_base, free_tool, &error) != MUKCA_OK || !m.found)
        return;
    for (int j = 0; j < chain->n_joints; j++)
        if (m.reversed >> j & 1)
            mukca_text_put(&what, "%s%s", what.used ? ", " : "with the opposite sign of ",
                           mukca_chain_joint_name(chain, j));
    if (m.exchanged[0] >= 0)
        mukca_text_put(&what, "with the columns of %s and %s exchanged",
                       mukca_chain_joint_name(chain, m.exchanged[0]),
                       mukca_chain_joint_name(chain, m.exchanged[1]));
    if (m.shifted >= 0)
        mukca_text_put(&what, "with %+.0f degrees added to %s", m.shift * 180 / M_PI,
                       mukca_chain_joint_name(chain, m.shifted));
    if (m.coupled >= 0)
        mukca_text_put(
            &what, "with %s %s %s (as where the controller counts %s from the horizontal)",
            mukca_chain_joint_name(chain, m.with), m.sign > 0 ? "added to" : "subtracted from",
            mukca_chain_joint_name(chain, m.coupled), mukca_chain_joint_name(chain, m.coupled));
    cli_say(call, NULL,
            "The data would agree with the nominal model to %.3f mm instead of %.3f mm %s: check "
            "these columns%s and the URDF.",
            1e3 * m.after_m, 1e3 * m.before_m, text,
            m.reversed && data->n_sockets == 0
                ? ", the order of x, y and z (an exchange mirrors the arm)"
                : "");
}
