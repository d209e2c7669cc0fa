/* mukca evaluate: how well a nominal or calibrated model agrees with data. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scores.h"
#include "fit/frames.h"

typedef struct {
    cli_common common;
    double max_mae;
    bool matrix;
} evaluate_options;

static const cli_option options[] = {
    CLI_OFFSETS_OPTION,
    CLI_TEST_OPTION,
    CLI_OPTION(evaluate_options, max_mae, "max-mae", CLI_POSITIVE, "M",
               "exit code 1 if the mean error (of --test, if given) is above this, m"),
    CLI_OPTION(
        evaluate_options, matrix, "matrix", CLI_FLAG, NULL,
        "train on each placement, each pair and all, test on the others: a table of mean errors"),
    CLI_OUTPUT_OPTION("write the table there (default: standard output)"),
    CLI_JSON_OPTION,
    CLI_MODEL_OPTIONS,
    CLI_DISTANCE_OPTIONS,
    CLI_PAYLOAD_OPTION,
    CLI_ANGLES_OPTION,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

typedef struct {
    FILE *stream; /* NULL: JSON only */
    json_t *json; /* array */
    mukca_score *scores, *test_scores;
    unsigned char *train;
    double sum[3]; /* of the errors after training on one, on two, on all placements */
    int have[3], done;
} matrix;

/* Fit to the marked placements and write one line; *others is the mean error on the rest. */
static mukca_status matrix_line(double *others, cli_call *call, const matrix *m)
{
    const cli_session *s = call->session;
    const int n = s->data.n_placements;
    const bool tested = s->test.n_rows > 0;
    const mukca_split split = {
        .data = &s->data, .train = m->train, .extra = tested ? &s->test : NULL};
    char name[3 * MUKCA_NAME_SIZE] = "";
    int trained = 0, have = 0;
    double sum = 0;
    mukca_status status =
        mukca_evaluate_trained(m->scores, m->test_scores, &s->model.chain, &split, &call->error);
    if (status != MUKCA_OK) return status;
    json_t *errors = json_object();
    for (int i = 0, p = 0; p < n; p++) {
        const char *placement = s->data.placements[p].name;
        const size_t used = strlen(name);
        if (m->train[p])
            snprintf(name + used, sizeof name - used, trained++ ? "+%s" : "%s", placement);
        if (m->scores[i].placement != p) continue;
        if (!m->train[p]) sum += m->scores[i].mae, have++;
        json_object_set_new(errors, placement, cli_json_real(m->scores[i++].mae));
    }
    if (trained == n) snprintf(name, sizeof name, "all");
    for (int i = 0; tested && i <= s->test.n_placements && m->test_scores[i].rows > 0; i++)
        sum += m->test_scores[i].mae, have++;
    *others = have > 0 ? sum / have : (double)NAN;
    if (m->stream) {
        fprintf(m->stream, "%s\t%d", name, trained);
        cli_scores_write(m->stream, *others);
        for (int i = 0; i < n; i++) cli_scores_write(m->stream, m->scores[i].mae);
        fputc('\n', m->stream);
    }
    json_array_append_new(m->json,
                          json_pack("{s:s, s:i, s:o, s:o}", "train", name, "placements", trained,
                                    "others_mae_m", cli_json_real(*others), "mae_m", errors));
    return MUKCA_OK;
}

/* Train on placements a and b, or for size = 2 on all. */
static mukca_status train_on(cli_call *call, matrix *m, int size, int a, int b)
{
    const int n = call->session->data.n_placements, pairs = n * (n - 1) / 2;
    double others;
    if (cli_interrupted()) return MUKCA_INTERRUPTED;
    memset(m->train, size == 2, (size_t)n);
    m->train[a] = m->train[b] = 1;
    mukca_status status = matrix_line(&others, call, m);
    cli_progress(call, "training and testing", ++m->done, n + pairs + 1);
    if (status == MUKCA_OK && isfinite(others)) m->sum[size] += others, m->have[size]++;
    return status;
}

static mukca_status matrix_lines(cli_call *call, matrix *m)
{
    static const char *const names[3] = {"one placement", "two placements", "all placements"};
    const mukca_dataset *data = &call->session->data;
    const int n = data->n_placements;
    mukca_status status = MUKCA_OK;
    if (m->stream) {
        fputs("train\tplacements\tothers_mae_m", m->stream);
        for (int p = 0; p < n; p++) fprintf(m->stream, "\t%s_mae_m", data->placements[p].name);
        fputc('\n', m->stream);
    }
    for (int a = 0; a < n && status == MUKCA_OK; a++) status = train_on(call, m, 0, a, a);
    for (int a = 0; a < n; a++)
        for (int b = a + 1; b < n && status == MUKCA_OK; b++) status = train_on(call, m, 1, a, b);
    if (n > 2 && status == MUKCA_OK) status = train_on(call, m, 2, 0, 0);
    for (int i = 0; i < 3 && status == MUKCA_OK; i++)
        if (m->have[i])
            cli_answer(call, "Trained on %-15s mean error elsewhere %.3f mm\n", names[i],
                       1e3 * m->sum[i] / m->have[i]);
    return status;
}

static mukca_status run_matrix(cli_call *call, FILE *stream, json_t *json)
{
    const int n = call->session->data.n_placements, tests = call->session->test.n_placements;
    mukca_status status = MUKCA_OK;
    if (n < 2)
        return mukca_fail(&call->error, MUKCA_INPUT,
                          "--matrix needs two placements or more: one to train on, one to test on");
    matrix m = {.stream = stream,
                .json = json,
                .scores = calloc((size_t)n + 1, sizeof *m.scores),
                .test_scores = calloc((size_t)tests + 2, sizeof *m.test_scores),
                .train = calloc((size_t)n, 1)};
    if (m.scores && m.test_scores && m.train)
        status = matrix_lines(call, &m);
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
        cli_scores_write_header(output.stream);
        cli_scores_write_rows(output.stream, "data", &w->data, &s->data);
        cli_scores_write_rows(output.stream, "test", &w->test, &s->test);
    }
    status = mukca_output_finish(&output, status, &call->error);
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
    if (status == MUKCA_OK) status = cli_read_offsets(call, &model->offsets, chain, offsets);
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
    call->common->accept_failed = true; /* a table that did not pass is evaluated, too */
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
