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
                             const double *theta, const mukca_offsets *offsets,
                             const mukca_dataset *data)
{
    const size_t room = mukca_evaluate_room(data);
    const bool factory = call->common->kinematics != NULL;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    double urdf[MUKCA_MAX_THETA];
    if (offsets) mukca_offsets_place_effects(effects, offsets, data);
    mukca_chain_theta(urdf, chain);
    if (scores->nominal_theta)
        memcpy(urdf, scores->nominal_theta,
               MUKCA_PARAMETERS * (size_t)chain->n_elements * sizeof *urdf);
    if (factory) take_urdf_theta(urdf, chain, &call->session->model.urdf);
    const mukca_model models[CLI_MODELS] = {
        [CLI_NOMINAL] = {.chain = chain, .theta = urdf, .by_log = scores->by_log},
        [CLI_FACTORY] = {.chain = chain, .theta = scores->nominal_theta, .by_log = scores->by_log},
        [CLI_CALIBRATED] = {.chain = chain,
                            .theta = theta,
                            .effects = effects,
                            .n_effects = offsets ? offsets->n_effects : 0,
                            .by_log = scores->by_log}};
    scores->has_factory = factory;
    for (int m = 0; m < CLI_FACTORY + factory && scores->n >= 0; m++) {
        scores->of[m] = calloc(room, sizeof *scores->of[m]);
        scores->n =
            scores->of[m] ? mukca_evaluate(scores->of[m], &scores->mean[m], &models[m], data) : -1;
    }
    if (scores->n >= 0) return MUKCA_OK;
    cli_scores_free(scores);
    return cli_fail(call, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
}

void cli_scores_free(cli_scores *scores)
{
    for (int m = 0; m < CLI_MODELS; m++) free(scores->of[m]);
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
    const char *key[CLI_MODELS];
    size_t offset;
} figures[] = {{{"mae_nominal_m", "mae_m", "mae_factory_m"}, offsetof(mukca_score, mae)},
               {{"std_nominal_m", "std_m", "std_factory_m"}, offsetof(mukca_score, std)},
               {{"distance_error_nominal_m", "distance_error_m", "distance_error_factory_m"},
                offsetof(mukca_score, distance_error)},
               {{"rotation_error_nominal_rad", "rotation_error_rad", "rotation_error_factory_rad"},
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
        fprintf(stream, "\t%s\t%s", figures[k].key[CLI_NOMINAL], figures[k].key[CLI_CALIBRATED]);
    for (int k = 0; k < FIGURES && factory; k++)
        fprintf(stream, "\t%s", figures[k].key[CLI_FACTORY]);
    fputc('\n', stream);
}

void cli_scores_write_rows(FILE *stream, const char *set, const cli_scores *scores,
                           const mukca_dataset *data)
{
    for (int i = 0; i < scores->n; i++) {
        char name[NAME];
        const mukca_score *after = &scores->of[CLI_CALIBRATED][i];
        fprintf(stream, "%s\t%s\t%d", set, find_name(name, after, data), after->rows);
        for (int k = 0; k < FIGURES; k++) {
            write_number(stream, figure(&scores->of[CLI_NOMINAL][i], k));
            write_number(stream, figure(after, k));
        }
        for (int k = 0; k < FIGURES && scores->has_factory; k++)
            write_number(stream, figure(&scores->of[CLI_FACTORY][i], k));
        fputc('\n', stream);
    }
}

json_t *cli_scores_json(const cli_scores *scores, const mukca_dataset *data)
{
    json_t *array = json_array();
    for (int i = 0; i < scores->n; i++) {
        char name[NAME];
        const mukca_score *after = &scores->of[CLI_CALIBRATED][i];
        json_t *object =
            cli_json(KEY("placement", find_name(name, after, data)), FIELD(after, rows));
        for (int k = 0; k < FIGURES; k++) {
            if (k == ROTATION && !isfinite(figure(after, k))) continue;
            for (int m = 0; m < CLI_FACTORY + scores->has_factory; m++)
                json_object_set_new(object, figures[k].key[m],
                                    cli_json_real(figure(&scores->of[m][i], k)));
        }
        json_array_append_new(array, object);
    }
    return array;
}

/* A figure of the models in mm or mrad, of a placement (-1: mean over all). */
static void print_figures(cli_call *call, const char *name, int k, const cli_scores *s, int row,
                          bool calibrated)
{
    double value[CLI_MODELS] = {0};
    for (int m = 0; m < CLI_FACTORY + s->has_factory; m++)
        value[m] = figure(row < 0 ? &s->mean[m] : &s->of[m][row], k);
    cli_answer(call, "  %-24s %12.3f", name, 1e3 * value[CLI_NOMINAL]);
    if (s->has_factory) cli_answer(call, " %12.3f", 1e3 * value[CLI_FACTORY]);
    if (calibrated) cli_answer(call, " %12.3f", 1e3 * value[CLI_CALIBRATED]);
    if (calibrated && value[CLI_NOMINAL] > 0)
        cli_answer(call, " %+11.2f %%", 100 * (value[CLI_CALIBRATED] / value[CLI_NOMINAL] - 1));
    cli_answer(call, "\n");
}

void cli_scores_print_header(cli_call *call, bool calibrated)
{
    cli_answer(call, "  %-24s %12s%s%s\n", "Error", "nominal",
               call->common->kinematics ? "      factory" : "", calibrated ? "   calibrated" : "");
}

void cli_scores_print(cli_call *call, const cli_scores *scores, const char *set, bool calibrated)
{
    const bool sockets = isfinite(scores->mean[CLI_NOMINAL].distance_error);
    const char *const kinds[FIGURES] = {sockets ? "consistency mm" : "position mm", NULL,
                                        "distortion mm", "rotation mrad"};
    for (int k = 0; k < FIGURES; k++) {
        char name[40];
        if (!kinds[k] || !isfinite(figure(&scores->mean[CLI_NOMINAL], k))) continue;
        snprintf(name, sizeof name, "%s, %s", kinds[k], set);
        print_figures(call, name, k, scores, -1, calibrated);
    }
}

void cli_scores_print_rows(cli_call *call, const cli_scores *scores, const mukca_dataset *data,
                           bool calibrated)
{
    char name[NAME], indented[32];
    for (int i = 0; i < scores->n && scores->n > 1; i++) {
        snprintf(indented, sizeof indented, "  %.24s",
                 find_name(name, &scores->of[CLI_CALIBRATED][i], data));
        print_figures(call, indented, 0, scores, i, calibrated);
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
