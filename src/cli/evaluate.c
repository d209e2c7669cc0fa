/* mukca evaluate: how well a nominal or calibrated model agrees with data. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scores.h"

typedef struct {
    cli_common common;
    double max_mae;
    bool matrix;
} evaluate_options;

static const cli_option options[] = {
    CLI_OFFSETS_OPTION,
    CLI_TEST_OPTION,
    {"max-mae", 0, CLI_POSITIVE, "M",
     "exit code 1 if the mean error (of --test, if given) is above this, m", NULL,
     offsetof(evaluate_options, max_mae)},
    {"matrix", 0, CLI_FLAG, NULL,
     "train on each placement, each pair and all, test on the others: a table of mean errors", NULL,
     offsetof(evaluate_options, matrix)},
    CLI_OUTPUT_OPTION("write the table there (default: standard output)"),
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
    const mukca_split split = {
        .data = m->data, .train = m->train, .extra = tested ? m->test : NULL};
    mukca_status status =
        mukca_evaluate_trained(m->scores, m->test_scores, &m->model->chain, &split, &call->error);
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
    static const char *const names[3] = {"one placement", "two placements", "all placements"};
    for (int i = 0; i < 3; i++)
        if (have[i])
            cli_answer(call, "Trained on %-15s mean error elsewhere %.3f mm\n", names[i],
                       1e3 * sums[i] / have[i]);
    return MUKCA_OK;
}

static mukca_status run_matrix(cli_call *call, FILE *stream, json_t *json)
{
    const mukca_dataset *data = &call->session->data, *test = &call->session->test;
    matrix m = {.stream = stream,
                .json = json,
                .model = &call->session->model,
                .data = data,
                .test = test,
                .scores = calloc((size_t)data->n_placements + 1, sizeof *m.scores),
                .test_scores = calloc((size_t)test->n_placements + 2, sizeof *m.test_scores),
                .train = calloc((size_t)data->n_placements + 1, 1)};
    mukca_status status = MUKCA_OK;
    if (data->n_placements < 2)
        status =
            mukca_fail(&call->error, MUKCA_INPUT,
                       "--matrix needs two placements or more: one to train on, one to test on");
    else if (m.scores && m.test_scores && m.train)
        status = matrix_rows(call, &m);
    else
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    free(m.scores);
    free(m.test_scores);
    free(m.train);
    return status;
}

typedef struct {
    cli_scores data, test;
} evaluate_work;

static void print(cli_call *call, const evaluate_work *w)
{
    const cli_session *s = call->session;
    const evaluate_options *o = call->options;
    const bool calibrated = call->common->offsets != NULL, tested = w->test.n > 0;
    char data[80];
    cli_describe_data(data, &s->data);
    cli_answer(call, "%s: %s; %s\n", s->model.chain.robot, data,
               calibrated ? "nominal model and offsets table" : "nominal model (no --offsets)");
    cli_scores_print_header(call, calibrated);
    cli_scores_print(call, &w->data, "data", calibrated);
    if (tested) cli_scores_print(call, &w->test, "test", calibrated);
    if (!calibrated && !o->matrix)
        cli_answer_keyed(call, "Next", "mukca calibrate with these data");
}

static mukca_status verdict(cli_call *call, const evaluate_work *w)
{
    const evaluate_options *o = call->options;
    const double mae = w->test.n > 0 ? w->test.calibrated_mean.mae : w->data.calibrated_mean.mae;
    if (!(o->max_mae > 0) || mae <= o->max_mae) return MUKCA_OK;
    return mukca_fail(&call->error, MUKCA_NEGATIVE, "mean error %.6g m is above --max-mae %g", mae,
                      o->max_mae);
}

static mukca_status write_results(cli_call *call, const evaluate_work *w)
{
    const evaluate_options *o = call->options;
    const cli_session *s = call->session;
    const cli_common *c = call->common;
    mukca_output output = {0};
    json_t *json =
        json_pack("{s:s, s:o, s:o, s:o, s:o}", "schema", "mukca.evaluate/1", "data",
                  cli_scores_json(&w->data, &s->data), "test", cli_scores_json(&w->test, &s->test),
                  "mae_m", cli_json_real(w->data.calibrated_mean.mae), "test_mae_m",
                  w->test.n > 0 ? cli_json_real(w->test.calibrated_mean.mae) : json_null());
    mukca_status status = json ? MUKCA_OK : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK && (!c->json || c->output)) status = cli_output_open(call, &output);
    if (status == MUKCA_OK && o->matrix) {
        json_t *lines = json_array();
        status = run_matrix(call, output.stream, lines);
        json_object_set_new(json, "matrix", lines);
    } else if (status == MUKCA_OK && output.stream) {
        fputs(
            "set\tplacement\trows\tmae_nominal_m\tmae_m\tstd_nominal_m\tstd_m\t"
            "distance_error_nominal_m\tdistance_error_m\trotation_error_nominal_rad\t"
            "rotation_error_rad\n",
            output.stream);
        write_scores(output.stream, "data", &w->data, &s->data);
        write_scores(output.stream, "test", &w->test, &s->test);
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

static void release(void *work)
{
    evaluate_work *w = work;
    cli_scores_free(&w->data);
    cli_scores_free(&w->test);
}

static mukca_status run(cli_call *call)
{
    const evaluate_options *o = call->options;
    evaluate_work *w = call->work;
    cli_session *s = call->session;
    cli_model *model = &s->model;
    if (o->matrix && call->common->offsets)
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--matrix trains from the nominal model: leave out --offsets");
    mukca_status status = cli_check_outputs(call);
    if (status == MUKCA_OK) status = load_model(call, model);
    if (status == MUKCA_OK) status = cli_load_data(call, &s->data, model, &call->arguments);
    if (status == MUKCA_OK && call->common->test.n)
        status = cli_load_data(call, &s->test, model, &call->common->test);
    if (status == MUKCA_OK)
        status =
            cli_scores_make(call, &w->data, &model->chain, model->offsets.theta, model, &s->data);
    if (status == MUKCA_OK && s->test.n_rows > 0)
        status =
            cli_scores_make(call, &w->test, &model->chain, model->offsets.theta, model, &s->test);
    if (status == MUKCA_OK) status = write_results(call, w);
    if (status != MUKCA_OK) return status;
    print(call, w);
    return verdict(call, w);
}

const cli_command cli_command_evaluate = {
    .name = "evaluate",
    .group = CLI_CALIBRATE,
    .summary = "errors of a nominal or calibrated model on data",
    .synopsis = "DATA...",
    .min_arguments = 1,
    .max_arguments = -1,
    .description =
        "Prints a table with one row per placement. mae: mean distance of the predicted ball from "
        "the mean of its socket (pose logs: from the measured position). std: root of the mean "
        "square. distance_error: predicted minus given distance of the sockets. Each for the "
        "nominal model and, with --offsets, for the calibrated model with its effects. SI "
        "units.\n\n"
        "--matrix prints instead the errors on every placement after training on each placement, "
        "on each pair and on all, with the defaults of calibrate.",
    .example =
        "mukca evaluate --urdf data/demo/arm.urdf --offsets build/demo/offsets.tsv "
        "data/demo/test.tsv",
    .options = options,
    .options_size = sizeof(evaluate_options),
    .run = run,
    .work_size = sizeof(evaluate_work),
    .release = release,
};
