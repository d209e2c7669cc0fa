/* mukca calibrate: fit the arm's geometry to socket data or measured poses. */
#include <math.h>
#include <string.h>

#include "cli/calibrate.h"
#include "diagnose/recording.h"
#include "fit/align.h"
#include "fit/mismatch.h"
#include "fit/solver.h"

typedef struct {
    cli_common common;
    const char *free, *freeze;
    int solver, gradient;
    double lambda;
    bool regularise_tip, evidence;
} calibrate_options;

static const calibrate_options defaults = {.lambda = MUKCA_LAMBDA};

static const char *const solvers[] = {"slsqp", "lbfgs", "gauss-newton", NULL};
static const char *const gradients[] = {"fd", "analytic", NULL};

static const cli_option options[] = {
    CLI_OUTPUT_OPTION("write the offsets table"),
    CLI_OPTION(calibrate_options, free, "free", CLI_TEXT, "LIST",
               "fit these only: joints, parameters (x y z roll pitch yaw) or joint.parameter, with "
               "commas; a leading + adds them to the default set"),
    CLI_OPTION(calibrate_options, freeze, "freeze", CLI_TEXT, "LIST",
               "keep these nominal (same syntax)"),
    CLI_OPTION(calibrate_options, regularise_tip, "regularise-tip", CLI_FLAG, NULL,
               "regularise the last fixed joint, too"),
    CLI_RANGE_OPTION(
        calibrate_options, lambda, "lambda", CLI_NUMBER, "L", 0, INFINITY,
        "weight of the regularisation towards the nominal model, per placement (default: 1e-4)"),
    CLI_OPTION_AND(
        calibrate_options, evidence, "evidence", CLI_FLAG, NULL,
        "choose the priors by the evidence and give outliers less weight, instead of this cost "
        "(sockets)",
        .excludes = "free freeze regularise-tip lambda solver gradient free-base free-tool traits"),
    CLI_CHOICE_OPTION(calibrate_options, solver, "solver", "SOLVER", solvers,
                      "minimiser (default: slsqp)"),
    CLI_CHOICE_OPTION(calibrate_options, gradient, "gradient", "GRADIENT", gradients,
                      "central differences (default), or analytic"),
    {.name = NULL}};

/* Refuse sockets with identical samples: the joint states had stopped while recording. */
static mukca_status check_moving(cli_call *call, const mukca_dataset *d)
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
            return cli_fail(call, MUKCA_UNIDENTIFIABLE,
                            "placement '%s', socket '%s': all %d samples have the same joint "
                            "angles; the stream had stopped, record them again",
                            d->placements[d->sockets[s].placement].name, d->sockets[s].label, rows);
    }
    return MUKCA_OK;
}

static mukca_fit_options fit_options(const calibrate_options *o)
{
    return (mukca_fit_options){
        .selection = {o->free, o->freeze, o->regularise_tip},
        .free_base = o->common.free_base,
        .free_tool = o->common.free_tool,
        .by_evidence = o->evidence,
        .cost = {.lambda = o->lambda > 0 ? o->lambda : -1,
                 .gradient = o->gradient == 1 ? MUKCA_GRADIENT_ANALYTIC : MUKCA_GRADIENT_FD},
        .solver = mukca_solver_table[o->solver],
        .limits = {.stop = cli_stop}};
}

typedef struct {
    mukca_fit fit, other; /* the other one: by the evidence */
    mukca_offsets offsets;
    calibrate_result result;
    double
        nominal[MUKCA_MAX_THETA]; /* of the chain, with free frames aligned to the training data */
} calibrate_work;

static mukca_status judge(cli_call *call, const calibrate_result *r)
{
    const mukca_fit_options fitted = fit_options(call->options);
    mukca_fit_offsets(r->offsets, r->fit);
    return mukca_accept_fit(r->offsets, r->fit, &call->session->model.chain, r->train, r->test,
                            &fitted, &call->error);
}

/* Whether the fit is that of the paper, which the posterior can replace. */
static bool is_default(const calibrate_options *o)
{
    return !o->free && !o->freeze && !o->regularise_tip && o->lambda == MUKCA_LAMBDA &&
           !o->common.free_base && !o->common.free_tool && !o->common.traits;
}

/* Compare with the geometry by the evidence.  The priors of a long recording have no weight. */
static mukca_status compare_evidence(cli_call *call, calibrate_result *r)
{
    enum { MOST_ROWS = 5000 };
    const calibrate_options *o = call->options;
    mukca_fit *other = &((calibrate_work *)call->work)->other;
    const mukca_chain *chain = &call->session->model.chain;
    mukca_fit_options both[2] = {fit_options(o), fit_options(o)};
    both[1].by_evidence = true;
    if (o->evidence || !is_default(o) || !r->offsets->acceptance.accepted ||
        r->train->n_sockets == 0 || r->train->n_rows > MOST_ROWS)
        return MUKCA_OK;
    mukca_status status = mukca_fit_run(other, chain, r->train, &both[1], &call->error);
    if (status == MUKCA_OK)
        status = mukca_fit_compare(&r->evidence, (const mukca_fit *const[]){r->fit, other}, both,
                                   chain, r->train, r->test, &call->error);
    return status;
}

static mukca_status write_offsets(cli_call *call, const calibrate_result *r)
{
    char comments[256];
    snprintf(comments, sizeof comments,
             "mean error on %d training samples: %.4g m nominal, %.4g m calibrated",
             r->train->n_rows, r->scores.set[0].mean[CLI_NOMINAL].mae,
             r->scores.set[0].mean[CLI_CALIBRATED].mae);
    return cli_write_offsets(call, call->common->output, r->offsets, &r->fit->chain, r->train,
                             comments);
}

static void release(void *work)
{
    calibrate_work *w = work;
    mukca_fit_free(&w->fit);
    mukca_fit_free(&w->other);
}

/* Note that several pose logs share one frame and one target here. */
static void note_logs(cli_call *call, const mukca_dataset *data)
{
    const calibrate_options *o = call->options;
    if ((o->common.free_base || o->common.free_tool) && mukca_recording_number_logs(NULL, data) > 1)
        cli_note(call,
                 "several pose logs: one tracker's frame and one target for all; `mukca diagnose "
                 "-o` fits separate ones if the evidence supports them");
}

static mukca_status run(cli_call *call)
{
    const calibrate_options *o = call->options;
    const cli_session *s = call->session;
    calibrate_work *w = call->work;
    mukca_fit *fit = &w->fit;
    calibrate_result *r = &w->result;
    const mukca_fit_options wanted = fit_options(o);
    *r =
        (calibrate_result){.fit = fit, .train = &s->data, .test = &s->test, .offsets = &w->offsets};
    note_logs(call, r->train);
    mukca_columns_note(cli_note, call, &s->model.chain, r->train);
    if (o->evidence && r->train->n_sockets == 0)
        return cli_fail(call, MUKCA_USAGE,
                        "--evidence is for sockets; for pose logs: mukca diagnose -o");
    mukca_status status = check_moving(call, r->train);
    if (status == MUKCA_OK)
        status = mukca_fit_run(fit, &s->model.chain, r->train, &wanted, &call->error);
    if (status == MUKCA_OK && o->common.traits)
        status = calibrate_use_traits(call, r, fit, &s->traits, &wanted);
    if (status == MUKCA_OK && fit->identification.rank == 0)
        status = cli_fail(call, MUKCA_UNIDENTIFIABLE,
                          "the data identify no free parameter; record different postures");
    if (status == MUKCA_OK)
        status = mukca_frames_start(w->nominal, &fit->chain, r->train, o->common.free_base,
                                    o->common.free_tool, &call->error);
    r->scores = (cli_scores){.nominal_theta = w->nominal, .calibrated = true};
    if (status == MUKCA_OK)
        status = cli_scores_make(call, &r->scores, &fit->chain, fit->theta, NULL, "train");
    if (status == MUKCA_OK) status = judge(call, r);
    if (status == MUKCA_OK) status = compare_evidence(call, r);
    if (status != MUKCA_OK) return status;
    calibrate_add_traits(r->offsets, r);
    return write_offsets(call, r);
}

static json_t *as_json(const cli_call *call)
{
    const calibrate_options *o = call->options;
    const calibrate_result *r = &((const calibrate_work *)call->work)->result;
    return calibrate_json(r, o->evidence ? "posterior" : solvers[o->solver],
                          o->evidence ? NULL : gradients[o->gradient], cli_elapsed(call));
}

static mukca_status print(cli_call *call)
{
    const calibrate_result *r = &((const calibrate_work *)call->work)->result;
    calibrate_print(call, r);
    calibrate_print_traits(call, r);
    return r->offsets->acceptance.accepted ? MUKCA_OK : MUKCA_NEGATIVE;
}

const cli_command cli_command_calibrate = {
    .name = "calibrate",
    .group = CLI_CALIBRATE,
    .summary = "fit the geometry of the arm to socket data or measured poses",
    .synopsis = "DATA...",
    .description =
        "Each DATA is a session file, a folder with hole_0.csv and hole_1.csv, or a pose log (see "
        "mukca-formats(5)). The fit changes the origins of the joints so that all samples of a "
        "socket predict one position of the ball and the predicted distances between sockets agree "
        "with the given ones (the MUKCa cost). Regularisation towards the nominal model determines "
        "what the data do not. Pose logs are fitted to the measured poses.\n\n"
        "The offsets table lists for each parameter the nominal and the calibrated value, offset = "
        "calibrated - nominal in the units of the URDF's origin, the standard error from the data "
        "alone, and whether the data identify it.\n\n"
        "The table carries a verdict: it is accepted if the fit converged, the data fit the arm, "
        "and the calibrated arm is better than the nominal one by more than its own uncertainty: "
        "on held-out samples (--test, else cross-validation; readings of one posture count once), "
        "and at the tip, whose expected error is predicted from the samples. Test data must not "
        "contradict the training data, and the change of the tip must be plausible. The other "
        "commands refuse a table that is not accepted.\n\n"
        "--evidence fits the posterior mean instead of the minimum of this cost: the priors are "
        "chosen by the evidence, and outliers have less weight. Without it, the held-out errors of "
        "both are compared, and the better geometry is recommended.\n\n"
        "--traits corrects the recorded angles for the mean elasticity of the arm's fleet before "
        "the fit and adds it to the table, or half of it, or nothing, whichever fits the data "
        "best.\n\n"
        "Exit code 1: not accepted; 5: the data identify nothing.",
    .example =
        "  mukca calibrate --urdf data/demo/arm.urdf data/demo/train.tsv \\\n"
        "      --test data/demo/test.tsv -o build/demo/offsets.tsv --force",
    .with = CLI_WITH_MODEL | CLI_WITH_TEST | CLI_WITH_DISTANCE | CLI_WITH_DISTANCES |
            CLI_WITH_JSON | CLI_WITH_ANGLES | CLI_WITH_FRAMES | CLI_WITH_TRAITS | CLI_WITH_TABLES,
    .options = options,
    .options_size = sizeof(calibrate_options),
    .defaults = &defaults,
    .reads = CLI_READS_DATA,
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(calibrate_work),
    .release = release,
};
