/* mukca calibrate: fit the arm's geometry to socket data or measured poses. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/calibrate_say.h"
#include "fit/nlopt_adapter.h"
#include "io/output.h"

typedef struct {
    cli_common common;
    cli_list test;
    const char *free, *freeze, *trace;
    int solver, gradient, means;
    double lambda;
    bool regularise_tip, no_distortion, free_base, free_tool;
} calibrate_options;

static const calibrate_options defaults = {.lambda = MUKCA_LAMBDA};

static const char *const solvers[] = {"slsqp", "lbfgs", "gauss-newton", NULL};
static const char *const gradients[] = {"fd", "analytic", NULL};
static const char *const means[] = {"own", "nominal", NULL};

static const cli_option options[] = {
    {"test", 0, CLI_REST, "DATA...", "held-out data: never fitted, always reported", NULL,
     offsetof(calibrate_options, test)},
    CLI_OUTPUT_OPTION("write the offsets table there"),
    CLI_JSON_OPTION,
    {"trace", 0, CLI_TEXT, "FILE", "write consistency and distortion per iteration, a TSV", NULL,
     offsetof(calibrate_options, trace)},
    CLI_MODEL_OPTIONS,
    CLI_DISTANCE_OPTIONS,
    {"free", 0, CLI_TEXT, "LIST",
     "fit these only: joint, parameter (x y z roll pitch yaw) or joint.parameter, with commas; a "
     "leading + adds them to the default set",
     NULL, offsetof(calibrate_options, free)},
    {"freeze", 0, CLI_TEXT, "LIST", "keep these nominal; same words", NULL,
     offsetof(calibrate_options, freeze)},
    {"regularise-tip", 0, CLI_FLAG, NULL, "pull the last fixed joint to nominal, too", NULL,
     offsetof(calibrate_options, regularise_tip)},
    {"lambda", 0, CLI_NUMBER, "L", "pull to nominal, per placement (default: 1e-4)", NULL,
     offsetof(calibrate_options, lambda)},
    {"means", 0, CLI_CHOICE, "MEANS",
     "what a socket's rows are pulled to: its own mean (default), or its nominal mean, which is "
     "the "
     "older closed-chain method",
     means, offsetof(calibrate_options, means)},
    {"no-distortion", 0, CLI_FLAG, NULL, "leave the distance between sockets out of the cost", NULL,
     offsetof(calibrate_options, no_distortion)},
    {"free-base", 0, CLI_FLAG, NULL, "pose logs: fit the tracker's frame as joint base_frame, too",
     NULL, offsetof(calibrate_options, free_base)},
    {"free-tool", 0, CLI_FLAG, NULL,
     "pose logs: fit the target's offset (the last fixed joint; where there is none, tool_frame)",
     NULL, offsetof(calibrate_options, free_tool)},
    {"solver", 0, CLI_CHOICE, "SOLVER", "minimiser (default: slsqp)", solvers,
     offsetof(calibrate_options, solver)},
    {"gradient", 0, CLI_CHOICE, "GRADIENT",
     "central differences of each element (default), or analytic", gradients,
     offsetof(calibrate_options, gradient)},
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

/* What the trace needs at each iteration. */
typedef struct {
    FILE *stream;
    const mukca_fit *fit; /* its chain stands before the solver starts */
    const mukca_dataset *train, *test;
    mukca_score *scores;
    int iteration;
} tracer;

static void trace_scores(const tracer *t, const double *theta, const mukca_dataset *data)
{
    mukca_score mean = {.mae = NAN, .std = NAN, .distance_error = NAN};
    const mukca_model model = {.chain = &t->fit->chain, .theta = theta};
    if (data->n_rows > 0) mukca_evaluate(t->scores, &mean, &model, data);
    const double values[3] = {mean.mae, mean.std, mean.distance_error};
    for (int i = 0; i < 3; i++) {
        if (isfinite(values[i]))
            fprintf(t->stream, "\t%.17g", values[i]);
        else
            fputs("\t", t->stream);
    }
}

static void trace(void *context, const double *theta, const mukca_cost_value *value,
                  int evaluations)
{
    tracer *t = context;
    if (!t->stream) return;
    fprintf(t->stream, "%d\t%d\t%.17g", t->iteration++, evaluations, value->total);
    trace_scores(t, theta, t->train);
    trace_scores(t, theta, t->test);
    fputc('\n', t->stream);
}

static mukca_status check(cli_call *call)
{
    const calibrate_options *o = call->options;
    const cli_common *c = call->common;
    if (!(o->lambda >= 0))
        return mukca_fail(&call->error, MUKCA_USAGE, "--lambda %g: a weight cannot be negative",
                          o->lambda);
    if (mukca_output_same(o->trace, c->json) || mukca_output_same(o->trace, c->output))
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--trace and another output cannot both go to %s", o->trace);
    mukca_status status = cli_check_outputs(call);
    if (status == MUKCA_OK) status = cli_keep_inputs(call, o->trace);
    if (status == MUKCA_OK && o->trace)
        status = mukca_output_check(o->trace, c->force, &call->error);
    return status;
}

/* A socket whose rows are all the same was recorded from a stream that had stopped. */
static mukca_status check_alive(cli_call *call, const mukca_dataset *d)
{
    const size_t n = (size_t)d->n_joints;
    for (int s = 0; s < d->n_sockets; s++) {
        const double *first = NULL;
        int rows = 0;
        bool same = true;
        for (int i = 0; i < d->n_rows && same; i++) {
            if (d->socket[i] != s) continue;
            if (!first) first = d->q + (size_t)i * n;
            same = memcmp(d->q + (size_t)i * n, first, n * sizeof *first) == 0;
            rows++;
        }
        if (same && rows > 2)
            return mukca_fail(
                &call->error, MUKCA_UNIDENTIFIABLE,
                "placement '%s', socket '%s': all %d rows hold the same joint angles; "
                "the stream had stopped, record them again",
                d->placements[d->sockets[s].placement].name, d->sockets[s].label, rows);
    }
    return MUKCA_OK;
}

static mukca_status fit_data(cli_call *call, mukca_fit *fit, const cli_model *model,
                             const mukca_dataset *train, const mukca_dataset *test)
{
    const calibrate_options *o = call->options;
    mukca_output output = {0};
    mukca_status status = MUKCA_OK;
    const int room =
        train->n_placements > test->n_placements ? train->n_placements : test->n_placements;
    tracer t = {.fit = fit, .train = train, .test = test};
    const mukca_fit_options fit_options = {
        .selection = {o->free, o->freeze, o->regularise_tip},
        .free_base = o->free_base,
        .free_tool = o->free_tool,
        .cost = {.lambda = o->lambda > 0 ? o->lambda : -1,
                 .nominal_means = o->means == 1,
                 .no_distortion = o->no_distortion,
                 .gradient = o->gradient == 1 ? MUKCA_GRADIENT_ANALYTIC : MUKCA_GRADIENT_FD},
        .solver = mukca_solver_table[o->solver],
        .limits = {.stop = cli_stop, .progress = trace, .context = &t}};
    if (o->trace) {
        t.scores = calloc((size_t)room + 1, sizeof *t.scores);
        status = t.scores ? mukca_output_open(&output, o->trace, call->common->force, &call->error)
                          : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
        if (status != MUKCA_OK || !output.stream) goto out;
        t.stream = output.stream;
        fputs(
            "iteration\tevaluations\tcost_m2\ttrain_mae_m\ttrain_std_m\ttrain_distance_error_m\t"
            "test_mae_m\ttest_std_m\ttest_distance_error_m\n",
            t.stream);
    }
    status = mukca_fit_run(fit, &model->chain, train, &fit_options, &call->error);
    if (status == MUKCA_OK && o->trace) status = mukca_output_close(&output, &call->error);
out:
    mukca_output_abort(&output);
    free(t.scores);
    return status;
}

static mukca_status write_offsets(cli_call *call, const mukca_offsets *offsets,
                                  const calibrate_result *r)
{
    char comments[256];
    mukca_output output = {0};
    const cli_common *c = call->common;
    if (!c->output) return MUKCA_OK;
    snprintf(comments, sizeof comments,
             "mean error on %d training rows: %.4g m nominal, %.4g m calibrated%s",
             r->train->n_rows, r->train_scores.nominal_mean.mae,
             r->train_scores.calibrated_mean.mae, r->fit->converged ? "" : "\nNOT CONVERGED");
    mukca_status status = mukca_output_open(&output, c->output, c->force, &call->error);
    if (status == MUKCA_OK)
        status = mukca_offsets_write(output.stream, offsets, &r->fit->chain, r->train, comments,
                                     &call->error);
    if (status == MUKCA_OK) status = mukca_output_close(&output, &call->error);
    mukca_output_abort(&output);
    return status;
}

static mukca_status run(cli_call *call)
{
    const calibrate_options *o = call->options;
    cli_model *model = calloc(1, sizeof *model);
    mukca_offsets *offsets = calloc(1, sizeof *offsets);
    mukca_fit *fit = calloc(1, sizeof *fit);
    mukca_dataset train = {0}, test = {0};
    calibrate_result r = {.fit = fit, .train = &train, .test = &test};
    mukca_status status = MUKCA_OK;
    if (!model || !offsets || !fit) {
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    cli_catch_interrupts();
    status = check(call);
    if (status == MUKCA_OK) status = cli_load_model(call, model);
    if (status == MUKCA_OK) status = cli_load_data(call, &train, model, &call->arguments);
    if (status == MUKCA_OK) status = cli_load_test(call, &test, model, &o->test, &train);
    if (status == MUKCA_OK) status = check_alive(call, &train);
    if (status == MUKCA_OK) status = fit_data(call, fit, model, &train, &test);
    if (status == MUKCA_OK && fit->identification.rank == 0)
        status = mukca_fail(
            &call->error, MUKCA_UNIDENTIFIABLE,
            "these rows say nothing about the free parameters: record different postures");
    if (status == MUKCA_OK)
        status = cli_scores_make(call, &r.train_scores, &fit->chain, fit->theta, NULL, &train);
    if (status == MUKCA_OK && o->test.n > 0)
        status = cli_scores_make(call, &r.test_scores, &fit->chain, fit->theta, NULL, &test);
    if (status != MUKCA_OK) goto out;
    calibrate_fill_offsets(offsets, fit);
    status = write_offsets(call, offsets, &r);
    if (status == MUKCA_OK)
        status = cli_write_json(call, calibrate_json(&r, offsets, solvers[o->solver],
                                                     gradients[o->gradient], cli_elapsed(call)));
    if (status != MUKCA_OK) goto out;
    calibrate_say(call, &r);
    if (!fit->converged) status = MUKCA_NEGATIVE;
out:
    cli_scores_free(&r.train_scores);
    cli_scores_free(&r.test_scores);
    if (fit) mukca_fit_free(fit);
    mukca_dataset_free(&train);
    mukca_dataset_free(&test);
    free(fit);
    free(offsets);
    free(model);
    return status;
}

const cli_command cli_command_calibrate = {
    .name = "calibrate",
    .group = CLI_CALIBRATE,
    .summary = "fit the arm's geometry to rows with the ball in sockets",
    .synopsis = "DATA...",
    .min_arguments = 1,
    .max_arguments = -1,
    .description =
        "Each DATA is a session file, a folder with hole_0.csv and hole_1.csv, or a pose log (see "
        "mukca-formats(5)). The "
        "fit "
        "moves the origins of the chain's joints so that all rows of a socket put the ball in one "
        "place and the sockets come out their given distance apart (the MUKCa cost); a pull to "
        "nominal "
        "decides what the rows leave open. Measured poses are fitted as they are.\n\n"
        "The offsets table says for each parameter nominal, calibrated, offset = calibrated - "
        "nominal "
        "in the units of the URDF's own origin, the standard error that the rows alone give it, "
        "and "
        "whether they can tell it apart from the others (identifiable). Exit code 1: did not "
        "converge; "
        "5: the rows say nothing.",
    .example =
        "mukca calibrate --urdf data/demo/arm.urdf data/demo/train.tsv --test data/demo/test.tsv "
        "-o build/demo/offsets.tsv --force",
    .options = options,
    .options_size = sizeof(calibrate_options),
    .defaults = &defaults,
    .run = run,
};
