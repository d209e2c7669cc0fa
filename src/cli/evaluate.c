/* mukca evaluate: errors of a nominal or calibrated model on data. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/scores.h"
#include "fit/align.h"
#include "fit/evaluate.h"

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
    CLI_TABLE_OPTIONS,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

typedef struct {
    cli_call *call;
    FILE *stream;  /* NULL: JSON only */
    json_t *json;  /* JSON array */
    double sum[3]; /* of the errors after training on one, two and all placements */
    int have[3];
} matrix;

/* Write one line of the table. */
static bool write_line(void *context, const mukca_cross_training *t, double share)
{
    matrix *m = context;
    const mukca_dataset *data = &m->call->session->data;
    const int size = t->placements == data->n_placements && t->placements > 2 ? 2
                     : t->placements > 1                                      ? 1
                                                                              : 0;
    json_t *errors = json_object();
    if (isfinite(t->mean)) m->sum[size] += t->mean, m->have[size]++;
    if (m->stream) fprintf(m->stream, "%s\t%d", t->name, t->placements);
    if (m->stream) cli_scores_write(m->stream, t->mean);
    for (int p = 0, i = 0; p < data->n_placements; p++) {
        const bool scored = i < t->n && t->scores[i].placement == p;
        const double mae = scored ? t->scores[i++].mae : (double)NAN;
        if (m->stream) cli_scores_write(m->stream, mae);
        if (scored) json_object_set_new(errors, data->placements[p].name, cli_json_real(mae));
    }
    if (m->stream) fputc('\n', m->stream);
    json_array_append_new(
        m->json, json_pack("{s:s, s:i, s:o, s:o}", "train", t->name, "placements", t->placements,
                           "others_mae_m", cli_json_real(t->mean), "mae_m", errors));
    return cli_show_progress(m->call, share, "training and testing");
}

static mukca_status write_matrix(cli_call *call, FILE *stream, json_t *json)
{
    static const char *const names[3] = {"one placement", "two placements", "all placements"};
    const cli_session *s = call->session;
    matrix m = {.call = call, .stream = stream, .json = json};
    if (s->data.n_placements < 2)
        return mukca_fail(&call->error, MUKCA_INPUT,
                          "--matrix needs two placements or more: one to train on, one to test on");
    if (stream) {
        fputs("train\tplacements\tothers_mae_m", stream);
        for (int p = 0; p < s->data.n_placements; p++)
            fprintf(stream, "\t%s_mae_m", s->data.placements[p].name);
        fputc('\n', stream);
    }
    mukca_status status =
        mukca_cross_training_run(&s->model.chain, &s->data, &s->test, write_line, &m, &call->error);
    for (int i = 0; i < 3 && status == MUKCA_OK; i++)
        if (m.have[i])
            cli_answer(call, "Trained on %-15s mean error elsewhere %.3f mm\n", names[i],
                       1e3 * m.sum[i] / m.have[i]);
    return status;
}

typedef struct {
    cli_scores data, test;
    bool read_by_eye; /* standard output is a terminal: no table with all digits */
} evaluate_work;

static void print(cli_call *call, const evaluate_work *w)
{
    const cli_session *s = call->session;
    const evaluate_options *o = call->options;
    const bool calibrated = call->common->offsets != NULL, tested = w->test.n > 0;
    char data[80];
    cli_describe_data(data, &s->data);
    cli_answer(call, "%s: %s; %s\n", s->model.chain.robot, data,
               calibrated && w->data.has_factory ? "nominal model, factory file and offsets table"
               : calibrated                      ? "nominal model and offsets table"
               : w->data.has_factory             ? "nominal model and factory file"
                                                 : "nominal model (no --offsets)");
    if (calibrated) {
        char verdict_text[MUKCA_ACCEPTANCE_SENTENCE];
        mukca_acceptance_sentence(verdict_text, &s->model.offsets.acceptance, w->data.has_factory);
        cli_answer_wrapped(call, "Table %s.", verdict_text);
    }
    cli_scores_print_header(call, calibrated);
    cli_scores_print(call, &w->data, "data", calibrated);
    if (w->read_by_eye) cli_scores_print_rows(call, &w->data, &s->data, calibrated);
    if (tested) cli_scores_print(call, &w->test, "test", calibrated);
    if (tested && w->read_by_eye) cli_scores_print_rows(call, &w->test, &s->test, calibrated);
    if (!calibrated && w->data.nominal_mean.mae > CLI_FAR_OFF)
        cli_print_mismatch(call, &s->data, false, false);
    else if (!calibrated && !o->matrix)
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
        json_pack("{s:s, s:o, s:o, s:o, s:o, s:o}", "schema", "mukca.evaluate/1", "acceptance",
                  cli_json_acceptance(c->offsets ? &s->model.offsets.acceptance : NULL), "data",
                  cli_scores_json(&w->data, &s->data), "test", cli_scores_json(&w->test, &s->test),
                  "mae_m", cli_json_real(w->data.calibrated_mean.mae), "test_mae_m",
                  w->test.n > 0 ? cli_json_real(w->test.calibrated_mean.mae) : json_null());
    mukca_status status = json ? MUKCA_OK : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK && (!c->json || c->output) && !w->read_by_eye)
        status = cli_output_open(call, &output);
    if (status == MUKCA_OK && o->matrix) {
        json_t *lines = json_array();
        status = write_matrix(call, output.stream, lines);
        json_object_set_new(json, "matrix", lines);
    } else if (status == MUKCA_OK && output.stream) {
        cli_scores_write_header(output.stream, c->kinematics != NULL);
        cli_scores_write_rows(output.stream, "data", &w->data, &s->data);
        cli_scores_write_rows(output.stream, "test", &w->test, &s->test);
    }
    status = mukca_output_finish(&output, status, &call->error);
    if (status == MUKCA_OK) return cli_write_json(call, json);
    json_decref(json);
    return status;
}

/* The arm with its offsets, on a chain with the additional frames of measured poses (zero if the
 * table has none). */
static mukca_status load_model(cli_call *call, cli_model *model)
{
    cli_common *c = call->common;
    const char *offsets = c->offsets;
    c->offsets = NULL;
    mukca_status status = cli_load_model(call, model);
    c->offsets = offsets;
    if (status != MUKCA_OK || !offsets) return status;
    mukca_chain *chain = &model->chain;
    status = mukca_chain_with_frames(chain, chain, true, true, &call->error);
    if (status == MUKCA_OK) status = cli_read_offsets(call, &model->offsets, NULL, chain, offsets);
    if (status != MUKCA_OK) return status;
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
                          "--matrix trains from the nominal model: omit --offsets");
    call->common->accept_failed = call->common->accept_edited =
        true; /* also evaluate a table that was not accepted */
    mukca_status status = cli_check_outputs(call);
    w->read_by_eye = isatty(STDOUT_FILENO) && !o->matrix && !call->common->output &&
                     !call->common->json && !call->common->quiet;
    if (status == MUKCA_OK) status = load_model(call, model);
    if (status == MUKCA_OK) status = cli_load_data(call, &s->data, model, &call->arguments);
    if (status == MUKCA_OK && call->common->test.n)
        status = cli_load_data(call, &s->test, model, &call->common->test);
    w->data.by_log = s->data.n_files > 1 || s->data.n_targets > 1;
    w->test.by_log = s->test.n_files > 1 || s->test.n_targets > 1;
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
        "Prints the mean errors, and a table with one row per placement and per pose log (on a "
        "terminal only its consistency errors, mm); targets with names are placed "
        "on the tip by the data first. mae: mean distance of the predicted ball from "
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
    .targets = true,
    .run = run,
    .work_size = sizeof(evaluate_work),
    .release = release,
};
