/* mukca evaluate: how well a nominal or calibrated model agrees with data. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scores.h"
#include "io/output.h"

typedef struct {
    cli_common common;
    cli_list test;
    double max_mae;
    bool matrix;
} evaluate_options;

static const cli_option options[] = {
    CLI_OFFSETS_OPTION,
    {"test", 0, CLI_REST, "DATA...", "held-out data, reported apart; never trained on by --matrix",
     NULL, offsetof(evaluate_options, test)},
    {"max-mae", 0, CLI_POSITIVE, "M",
     "exit with 1 where the mean error (of --test, if given) is above this, m", NULL,
     offsetof(evaluate_options, max_mae)},
    {"matrix", 0, CLI_FLAG, NULL,
     "train on each placement, each pair and all, and test on the others: a table of mean errors",
     NULL, offsetof(evaluate_options, matrix)},
    CLI_OUTPUT_OPTION("where to write the table (default: standard output)"),
    CLI_JSON_OPTION,
    CLI_MODEL_OPTIONS,
    CLI_DISTANCE_OPTIONS,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

static void write_number(FILE *stream, double value)
{
    if (isfinite(value))
        fprintf(stream, "\t%.17g", value);
    else
        fputs("\t", stream);
}

static void write_scores(FILE *stream, const char *set, const cli_scores *scores,
                         const mukca_dataset *data)
{
    for (int i = 0; i < scores->n; i++) {
        const mukca_score *a = &scores->nominal[i], *b = &scores->calibrated[i];
        const double values[] = {a->mae,
                                 b->mae,
                                 a->std,
                                 b->std,
                                 a->distance_error,
                                 b->distance_error,
                                 a->rotation_error,
                                 b->rotation_error};
        fprintf(stream, "%s\t%s\t%d", set, cli_scores_name(b, data), b->rows);
        for (size_t v = 0; v < sizeof values / sizeof *values; v++) write_number(stream, values[v]);
        fputc('\n', stream);
    }
}

/* One line of the matrix: trained on the marked placements. */
typedef struct {
    char name[3 * MUKCA_NAME_SIZE];
    int trained; /* placements; the others are the test */
    double others;
} matrix_line;

typedef struct {
    FILE *stream; /* NULL: JSON only */
    json_t *json; /* array, or NULL */
    const cli_model *model;
    const mukca_dataset *data, *test;
    mukca_score *scores, *test_scores;
    unsigned char *train;
} matrix;

/* Fit, and write one line; `others` is the mean error on what was not trained on. */
static mukca_status matrix_row(cli_call *call, matrix_line *line, const matrix *m)
{
    const bool tested = m->test->n_rows > 0;
    mukca_status status =
        mukca_evaluate_trained(m->scores, m->test_scores, &m->model->chain, m->data, m->train,
                               tested ? m->test : NULL, NULL, &call->error);
    if (status != MUKCA_OK) return status;
    double sum = 0;
    int have = 0;
    json_t *errors = json_object();
    line->name[0] = '\0';
    line->trained = 0;
    for (int i = 0, p = 0; p < m->data->n_placements; p++) {
        const char *name = m->data->placements[p].name;
        if (m->train[p]) {
            const size_t used = strlen(line->name);
            snprintf(line->name + used, sizeof line->name - used, "%s%s", used ? "+" : "", name);
            line->trained++;
        }
        if (m->scores[i].placement != p) continue;
        if (!m->train[p]) sum += m->scores[i].mae, have++;
        json_object_set_new(errors, name, cli_json_real(m->scores[i].mae));
        i++;
    }
    if (line->trained == m->data->n_placements) snprintf(line->name, sizeof line->name, "all");
    for (int i = 0; tested && i <= m->test->n_placements && m->test_scores[i].rows > 0; i++)
        sum += m->test_scores[i].mae, have++;
    line->others = have > 0 ? sum / have : (double)NAN;
    if (m->stream) {
        fprintf(m->stream, "%s\t%d", line->name, line->trained);
        write_number(m->stream, line->others);
        for (int i = 0; i < m->data->n_placements; i++) write_number(m->stream, m->scores[i].mae);
        fputc('\n', m->stream);
    }
    if (m->json)
        json_array_append_new(m->json, json_pack("{s:s, s:i, s:o, s:O}", "train", line->name,
                                                 "placements", line->trained, "others_mae_m",
                                                 cli_json_real(line->others), "mae_m", errors));
    json_decref(errors);
    return MUKCA_OK;
}

static mukca_status matrix_rows(cli_call *call, const matrix *m)
{
    const int n = m->data->n_placements, lines = n + n * (n - 1) / 2 + 1;
    double sums[3] = {0};
    int have[3] = {0}, done = 0;
    if (m->stream) {
        fputs("train\tplacements\tothers_mae_m", m->stream);
        for (int p = 0; p < n; p++) fprintf(m->stream, "\t%s_mae_m", m->data->placements[p].name);
        fputc('\n', m->stream);
    }
    for (int size = 1; size <= 3; size++) {
        if (size == 3 && n <= 2) break;
        for (int a = 0; a < n; a++)
            for (int b = size == 2 ? a + 1 : a; b < (size == 2 ? n : a + 1); b++) {
                matrix_line line;
                if (size == 3 && a > 0) continue;
                memset(m->train, size == 3, (size_t)n);
                m->train[a] = m->train[b] = 1;
                mukca_status status =
                    cli_interrupted() ? MUKCA_INTERRUPTED : matrix_row(call, &line, m);
                if (status != MUKCA_OK) return status;
                cli_progress(call, "training and testing", ++done, lines);
                if (isfinite(line.others)) sums[size - 1] += line.others, have[size - 1]++;
            }
    }
    static const char *const names[3] = {"one placement", "two", "all"};
    const char *before = "Mean error elsewhere, trained on";
    for (int i = 0; i < 3; i++) {
        char text[24];
        if (have[i] == 0) continue;
        cli_millimetres(text, sums[i] / have[i]);
        cli_answer(call, "%s %s: %s", before, names[i], text);
        before = ", on";
    }
    cli_answer(call, "\n");
    return MUKCA_OK;
}

static mukca_status run_matrix(cli_call *call, FILE *stream, json_t *json, const cli_model *model,
                               const mukca_dataset *data, const mukca_dataset *test)
{
    matrix m = {.stream = stream, .json = json, .model = model, .data = data, .test = test};
    mukca_status status = MUKCA_OK;
    if (data->n_placements < 2)
        return mukca_fail(
            &call->error, MUKCA_INPUT,
            "--matrix needs two placements or more, to train on one and test on another");
    m.scores = calloc((size_t)data->n_placements + 1, sizeof *m.scores);
    m.test_scores = calloc((size_t)test->n_placements + 2, sizeof *m.test_scores);
    m.train = calloc((size_t)data->n_placements, 1);
    if (m.scores && m.test_scores && m.train)
        status = matrix_rows(call, &m);
    else
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    free(m.scores);
    free(m.test_scores);
    free(m.train);
    return status;
}

static void say(cli_call *call, const cli_model *model, const cli_scores *data,
                const cli_scores *test)
{
    const cli_common *c = call->common;
    const evaluate_options *o = call->options;
    cli_answer(call, "%s: %s\n", model->chain.robot,
               c->offsets ? "nominal model, and with the offsets of the table"
                          : "nominal model (no --offsets)");
    cli_scores_say_header(call, c->offsets != NULL);
    cli_scores_say(call, data, "data", c->offsets != NULL);
    if (test->n > 0) cli_scores_say(call, test, "test", c->offsets != NULL);
    if (!c->offsets && !o->matrix)
        cli_answer(call,
                   "Next: `mukca calibrate` on these data, then --offsets to see what it gains.\n");
}

static mukca_status verdict(cli_call *call, const cli_scores *data, const cli_scores *test)
{
    const evaluate_options *o = call->options;
    const double mae = test->n > 0 ? test->calibrated_mean.mae : data->calibrated_mean.mae;
    if (!(o->max_mae > 0) || mae <= o->max_mae) return MUKCA_OK;
    return mukca_fail(&call->error, MUKCA_NEGATIVE, "mean error %.6g m is above --max-mae %g", mae,
                      o->max_mae);
}

static mukca_status write_results(cli_call *call, const cli_model *model, const cli_scores *scores,
                                  const mukca_dataset *data, const cli_scores *test_scores,
                                  const mukca_dataset *test)
{
    const evaluate_options *o = call->options;
    const cli_common *c = call->common;
    mukca_output output = {0};
    const bool json_only = c->json && !c->output;
    json_t *json = json_pack(
        "{s:s, s:o, s:o, s:o, s:o}", "schema", "mukca.evaluate/1", "data",
        cli_scores_json(scores, data), "test", cli_scores_json(test_scores, test), "mae_m",
        cli_json_real(scores->calibrated_mean.mae), "test_mae_m",
        test_scores->n > 0 ? cli_json_real(test_scores->calibrated_mean.mae) : json_null());
    mukca_status status = json ? MUKCA_OK : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK && !json_only) status = cli_output_open(call, &output);
    if (status == MUKCA_OK && o->matrix) {
        json_t *lines = json_array();
        status = run_matrix(call, output.stream, lines, model, data, test);
        json_object_set_new(json, "matrix", lines);
    } else if (status == MUKCA_OK && output.stream) {
        fputs(
            "set\tplacement\trows\tmae_nominal_m\tmae_m\tstd_nominal_m\tstd_m\t"
            "distance_error_nominal_m\tdistance_error_m\trotation_error_nominal_rad\t"
            "rotation_error_rad\n",
            output.stream);
        write_scores(output.stream, "data", scores, data);
        write_scores(output.stream, "test", test_scores, test);
    }
    if (status == MUKCA_OK && output.stream) status = mukca_output_close(&output, &call->error);
    mukca_output_abort(&output);
    if (status == MUKCA_OK) return cli_write_json(call, json);
    json_decref(json);
    return status;
}

/* The arm with its offsets, on a chain that can take the frames that a fit of measured poses adds
 * (zero where the table has none). */
static mukca_status load_model(cli_call *call, cli_model *model)
{
    cli_common *c = call->common;
    const char *offsets = c->offsets;
    double turn[9], gravity[3];
    c->offsets = NULL;
    mukca_status status = cli_load_model(call, model);
    c->offsets = offsets;
    if (status != MUKCA_OK || !offsets) return status;
    mukca_chain *chain = &model->chain;
    status = mukca_chain_with_frames(chain, chain, true, true, &call->error);
    if (status == MUKCA_OK)
        status = mukca_offsets_read(&model->offsets, chain, offsets, c->force, cli_note, call,
                                    &call->error);
    if (status != MUKCA_OK) return status;
    mukca_rotation_from_rpy(turn,
                            model->offsets.theta + 3); /* of the base in the tracker's frame */
    memcpy(gravity, chain->gravity, sizeof gravity);
    mukca_mat3_vec(chain->gravity, turn, gravity);
    mukca_geometry_set(&model->geometry, chain, model->offsets.theta);
    return cli_check_effects(call, model);
}

static mukca_status run(cli_call *call)
{
    const evaluate_options *o = call->options;
    cli_model *model = calloc(1, sizeof *model);
    mukca_dataset data = {0}, test = {0};
    cli_scores scores = {0}, test_scores = {0};
    mukca_status status = MUKCA_OK;
    if (!model) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    cli_catch_interrupts();
    if (o->matrix && call->common->offsets)
        status = mukca_fail(&call->error, MUKCA_USAGE,
                            "--matrix trains from the nominal model: leave out --offsets");
    if (status == MUKCA_OK) status = cli_check_outputs(call);
    if (status == MUKCA_OK) status = load_model(call, model);
    if (status == MUKCA_OK) status = cli_load_data(call, &data, model, &call->arguments);
    if (status == MUKCA_OK && o->test.n > 0) status = cli_load_data(call, &test, model, &o->test);
    if (status == MUKCA_OK)
        status = cli_scores_make(call, &scores, &model->chain, model->offsets.theta, model, &data);
    if (status == MUKCA_OK && o->test.n > 0)
        status =
            cli_scores_make(call, &test_scores, &model->chain, model->offsets.theta, model, &test);
    if (status == MUKCA_OK)
        status = write_results(call, model, &scores, &data, &test_scores, &test);
    if (status == MUKCA_OK) {
        say(call, model, &scores, &test_scores);
        status = verdict(call, &scores, &test_scores);
    }
    cli_scores_free(&scores);
    cli_scores_free(&test_scores);
    mukca_dataset_free(&data);
    mukca_dataset_free(&test);
    free(model);
    return status;
}

const cli_command cli_command_evaluate = {
    .name = "evaluate",
    .group = CLI_CALIBRATE,
    .summary = "the errors of a model on data, nominal and calibrated",
    .synopsis = "DATA...",
    .min_arguments = 1,
    .max_arguments = -1,
    .description =
        "Prints a table with one row per placement: mae is the mean distance of a row's ball from "
        "the "
        "mean of its socket (from the measurement, for pose logs), std the root of the mean "
        "square, "
        "distance_error how far the sockets come out from their given distance; each nominal and, "
        "with "
        "--offsets, calibrated, effects included. SI units.\n\n"
        "--matrix prints instead what training on each placement, on each pair and on all of them "
        "gives "
        "on every placement, each fit with the defaults of calibrate.",
    .example =
        "mukca evaluate --urdf data/demo/arm.urdf --offsets build/demo/offsets.tsv "
        "data/demo/test.tsv",
    .options = options,
    .options_size = sizeof(evaluate_options),
    .run = run,
};
