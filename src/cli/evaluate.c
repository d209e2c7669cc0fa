/* mukca evaluate: errors of a nominal or calibrated model on data. */
#include <math.h>
#include <unistd.h>

#include "accept/accept.h"
#include "cli/scores.h"
#include "fit/align.h"

typedef struct {
    cli_common common;
    double max_mae;
} evaluate_options;

static const cli_option options[] = {
    CLI_OPTION(evaluate_options, max_mae, "max-mae", CLI_POSITIVE, "M",
               "exit code 1 if the mean error (of --test, if given) is above this, m"),
    CLI_OUTPUT_OPTION("write the table there (default: standard output)"),
    {.name = NULL}};

typedef struct {
    cli_scores scores;
    bool read_by_eye; /* standard output is a terminal: no table with all digits */
} evaluate_work;

static mukca_status print(cli_call *call)
{
    const evaluate_options *o = call->options;
    const evaluate_work *w = call->work;
    const cli_session *s = call->session;
    const bool calibrated = w->scores.calibrated, factory = w->scores.has_factory;
    const mukca_score *mean = w->scores.set[w->scores.set[1].n > 0].mean;
    const double mae = mean[CLI_CALIBRATED].mae;
    char data[80];
    cli_describe_data(data, &s->data);
    cli_answer(call, "%s: %s; %s\n", s->model.chain.robot, data,
               calibrated && factory ? "nominal model, factory file and offsets table"
               : calibrated          ? "nominal model and offsets table"
               : factory             ? "nominal model and factory file"
                                     : "nominal model (no --offsets)");
    if (calibrated) {
        cli_print_acceptance(cli_answer_stream(call), &s->model.offsets.acceptance,
                             &s->model.chain);
        if (mukca_data_contradict(mae, s->model.offsets.acceptance.error_m, mean[CLI_NOMINAL].mae))
            cli_say(call, NULL,
                    "These data contradict the table: check for another arm, tool or tip.");
    }
    cli_scores_print(call, &w->scores, w->read_by_eye);
    if (mukca_poses_repeat(&s->data, w->scores.set[0].mean[CLI_NOMINAL].mae))
        cli_say(call, NULL,
                "The model predicts the poses without a fit: they are the controller's own, not "
                "measured.");
    else if (!calibrated && w->scores.set[0].mean[CLI_NOMINAL].mae > CLI_FAR_OFF)
        cli_print_mismatch(call, &s->data, false, false);
    else if (!calibrated)
        cli_say(call, "Next", "mukca calibrate with these data");
    if (!(o->max_mae > 0) || mae <= o->max_mae) return MUKCA_OK;
    return cli_fail(call, MUKCA_NEGATIVE, "mean error %.6g m is above --max-mae %g", mae,
                    o->max_mae);
}

static mukca_status write_table(cli_call *call, FILE *stream)
{
    evaluate_work *w = call->work;
    w->read_by_eye = isatty(STDOUT_FILENO) && !call->common->output && !call->common->quiet;
    if (w->read_by_eye)
        call->printed = false;
    else
        cli_scores_write(stream, &w->scores);
    return MUKCA_OK;
}

static json_t *as_json(const cli_call *call)
{
    const evaluate_work *w = call->work;
    const cli_scored *set = w->scores.set;
    const bool factory = w->scores.has_factory, tested = set[1].n > 0;
    const mukca_acceptance *acceptance =
        w->scores.calibrated ? &call->session->model.offsets.acceptance : NULL;
    return cli_json(KEY("acceptance", cli_json_acceptance(acceptance)),
                    KEY("data", cli_scores_json(&set[0], factory)),
                    KEY("test", cli_scores_json(&set[1], factory)),
                    KEY("mae_m", set[0].mean[CLI_CALIBRATED].mae),
                    KEY("test_mae_m", tested ? set[1].mean[CLI_CALIBRATED].mae : (double)NAN));
}

/* The arm with its offsets, on a chain with the additional frames of measured poses (zero if the
 * table has none). */
static mukca_status load_model(cli_call *call, cli_model *model)
{
    cli_arm arm = call->common->arm;
    const char *offsets = arm.offsets;
    arm.offsets = NULL;
    MUKCA_TRY(cli_load_model(call, model, &arm));
    if (!offsets) return MUKCA_OK;
    mukca_chain *chain = &model->chain;
    MUKCA_TRY(mukca_chain_with_frames(chain, chain, true, true, &call->error));
    MUKCA_TRY(cli_read_offsets(call, &model->offsets, NULL, chain, offsets));
    mukca_geometry_set(&model->geometry, chain, model->offsets.theta);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    evaluate_work *w = call->work;
    cli_session *s = call->session;
    cli_model *model = &s->model;
    const bool gate = ((const evaluate_options *)call->options)->max_mae > 0;
    MUKCA_TRY(load_model(call, model));
    MUKCA_TRY(cli_load_data(call, &s->data, model, &call->arguments));
    MUKCA_TRY(cli_load_data(call, &s->test, model, &call->common->test));
    MUKCA_TRY(cli_check_moving(call, &s->data, gate));
    MUKCA_TRY(cli_check_moving(call, &s->test, gate));
    w->scores.by_log = true;
    w->scores.calibrated = call->common->arm.offsets != NULL;
    return cli_scores_make(call, &w->scores, &model->chain, &model->offsets, "data");
}

const cli_command cli_command_evaluate = {
    .name = "evaluate",
    .group = CLI_CALIBRATE,
    .summary = "errors of a nominal or calibrated model on data",
    .synopsis = "DATA...",
    .description =
        "Prints the mean errors, and a table with one row per placement and per pose log (on a "
        "terminal only its consistency errors, mm); targets with names are placed on the tip by "
        "the data first. mae: mean distance of the predicted ball from the mean of its socket "
        "(pose logs: from the measured position). std: root of the mean square. distance_error: "
        "predicted minus given distance of the sockets. Each for the nominal model and, with "
        "--offsets, for the calibrated model with its effects. SI units.",
    .example =
        "  mukca evaluate --urdf data/demo/arm.urdf \\\n"
        "      --offsets build/demo/offsets.tsv data/demo/test.tsv",
    .with = CLI_WITH_DATA | CLI_WITH_OFFSETS | CLI_WITH_TEST | CLI_WITH_JSON,
    .options = options,
    .options_size = sizeof(evaluate_options),
    .targets = true,
    .any_table = true,
    .run = run,
    .table = write_table,
    .json = as_json,
    .print = print,
    .work_size = sizeof(evaluate_work),
};
