/* mukca calibrate: fit the arm's geometry to socket data or measured poses. */
#include <math.h>
#include <string.h>

#include "cli/calibrate.h"
#include "fit/align.h"
#include "fit/mismatch.h"
#include "fit/solver.h"

static const calibrate_options defaults = {.lambda = MUKCA_LAMBDA};

static const cli_option options[] = {
    CLI_OUTPUT_OPTION("write the offsets table"),
    CLI_OPTION(calibrate_options, free, "free", CLI_TEXT, "LIST",
               "fit these only: joints, parameters (x y z roll pitch yaw) or joint.parameter, with "
               "commas; a leading + adds them to the default set"),
    CLI_OPTION(calibrate_options, freeze, "freeze", CLI_TEXT, "LIST",
               "keep these nominal (same syntax)"),
    CLI_OPTION(calibrate_options, regularise_tip, "regularise-tip", CLI_FLAG, NULL,
               "regularise the last fixed joint, too"),
    CLI_OPTION(
        calibrate_options, lambda, "lambda", CLI_NUMBER, "L",
        "weight of the regularisation towards the nominal model, per placement (default: 1e-4)",
        .most = INFINITY),
    CLI_OPTION(calibrate_options, solver, "solver", CLI_CHOICE, "SOLVER",
               "minimiser (default: slsqp)", .choices = mukca_solver_name),
    CLI_OPTION(calibrate_options, gradient, "gradient", CLI_CHOICE, "GRADIENT",
               "central differences (default), or analytic", .choices = cli_gradients),
    {.name = NULL}};

static mukca_fit_options fit_options(const calibrate_options *o)
{
    return (mukca_fit_options){
        .selection = {o->free, o->freeze, o->regularise_tip},
        .free_base = o->common.free_base,
        .free_tool = o->common.free_tool,
        .cost = {.lambda = o->lambda > 0 ? o->lambda : -1, .gradient = (mukca_gradient)o->gradient},
        .solver = mukca_solver_table[o->solver],
        .limits = {.stop = cli_stop},
        .threads = o->common.threads};
}

/* ---- --traits ---- */

/* Least log Bayes factor for the use of the traits: odds of 3 to 1; less is "not worth more than a
 * bare mention" (R. Kass, A. Raftery, Bayes factors, J. Am. Stat. Assoc. 90, 1995). */
#define LEAST_EVIDENCE 1.1

/* Correct the recorded angles for a share of the traits' mean displacement. */
static void correct(cli_session *s, double *const recorded[2], const mukca_traits *traits,
                    double share)
{
    mukca_dataset *const data[2] = {&s->data, &s->test};
    for (int i = 0; i < 2; i++) {
        const size_t size = (size_t)data[i]->n_rows * (size_t)data[i]->n_joints;
        if (size) memcpy(data[i]->q, recorded[i], size * sizeof *recorded[i]);
        mukca_traits_correct(data[i], &s->model.chain, traits, share);
    }
}

/* Log Bayes factor between two fits with equal numbers of unknowns, from the residual variances. */
static double log_evidence(const mukca_fit *fit, const mukca_fit *other)
{
    const double freedom = fmax(fit->n_measured - fit->identification.rank, 1);
    return 0.5 * freedom * log(other->calibrated.total / fit->calibrated.total);
}

/* Fit again with the means of the traits, and with half of them; keep the fraction with the
 * strongest evidence in the residuals, and correct the data by it.  The offsets table then includes
 * these effects: the geometry is valid only with them. */
static mukca_status use_traits(cli_call *call, const mukca_fit_options *wanted)
{
    /* Fractions of the mean to try.  An arm with less than half the mean compliance fits best with
     * none of it; half fits best in between. */
    static const double shares[] = {1, 0.5};
    enum { SHARES = sizeof shares / sizeof *shares };
    cli_session *s = call->session;
    calibrate_work *w = call->work;
    const mukca_traits *traits = &s->traits;
    const mukca_dataset *const data[2] = {&s->data, &s->test};
    mukca_pool *pool = &call->pool;
    if (!call->common->traits) return MUKCA_OK;
    mukca_fit *with = MUKCA_TAKE(pool, mukca_fit, SHARES);
    double *recorded[2];
    int best = 0;
    for (int i = 0; i < 2; i++) {
        const size_t size = (size_t)data[i]->n_rows * (size_t)data[i]->n_joints;
        recorded[i] = MUKCA_TAKE(pool, double, size + 1);
        if (recorded[i] && size) memcpy(recorded[i], data[i]->q, size * sizeof *recorded[i]);
    }
    if (pool->failed) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    for (int k = 0; k < SHARES; k++) {
        correct(s, recorded, traits, shares[k]);
        MUKCA_TRY(mukca_fit_run(&with[k], &s->model.chain, &s->data, wanted, &call->error));
        const double evidence = log_evidence(&with[k], &w->fit);
        if (k == 0 || evidence > w->traits_evidence) best = k, w->traits_evidence = evidence;
    }
    const bool use = with[best].converged && w->traits_evidence > LEAST_EVIDENCE;
    w->traits_share = use ? shares[best] : 0;
    correct(s, recorded, traits, w->traits_share);
    if (use) w->fit = with[best];
    return MUKCA_OK;
}

/* List the effects that the geometry was fitted with in the offsets table. */
static void add_traits(cli_call *call)
{
    calibrate_work *w = call->work;
    mukca_offsets *to = &w->offsets;
    double sigma[MUKCA_FLEET_TERMS];
    to->n_effects =
        mukca_traits_effects(to->effects, sigma, &call->session->traits, w->traits_share);
    for (int e = 0; e < to->n_effects; e++) to->effect_sigma[e][0] = sigma[e];
}

/* ---- the command ---- */

static mukca_status judge_offsets(cli_call *call, const mukca_fit_options *wanted)
{
    calibrate_work *w = call->work;
    const cli_session *s = call->session;
    mukca_cross_validation held = {.held = &s->test};
    MUKCA_TRY(
        mukca_fit_cross_validate(&held, &w->fit, &s->model.chain, &s->data, wanted, &call->error));
    const mukca_status status =
        mukca_accept_fit(&w->offsets, &w->fit, &held, &s->data, wanted, &call->error);
    mukca_cross_validation_free(&held);
    return status;
}

static mukca_status write_offsets(cli_call *call, FILE *stream)
{
    const calibrate_work *w = call->work;
    const mukca_dataset *data = &call->session->data;
    char comments[256];
    snprintf(comments, sizeof comments,
             "mean error on %d training samples: %.4g m nominal, %.4g m calibrated", data->n_rows,
             w->scores.set[0].mean[CLI_NOMINAL].mae, w->scores.set[0].mean[CLI_CALIBRATED].mae);
    return mukca_offsets_write(stream, &w->offsets, &w->fit.chain, data, comments, &call->error);
}

static mukca_status run(cli_call *call)
{
    const calibrate_options *o = call->options;
    const cli_session *s = call->session;
    const mukca_chain *chain = &s->model.chain;
    const mukca_fit_options wanted = fit_options(o);
    calibrate_work *w = call->work;
    mukca_fit *fit = &w->fit;
    mukca_columns_note(cli_notes(call), chain, &s->data);
    MUKCA_TRY(cli_check_moving(call, &s->data, false));
    MUKCA_TRY(cli_check_moving(call, &s->test, false));
    MUKCA_TRY(mukca_fit_run(fit, chain, &s->data, &wanted, &call->error));
    MUKCA_TRY(use_traits(call, &wanted));
    if (fit->identification.rank == 0)
        return cli_fail(call, MUKCA_UNIDENTIFIABLE,
                        "the data identify no free parameter; record different postures");
    MUKCA_TRY(mukca_frames_start(w->nominal, &fit->chain, &s->data, o->common.free_base,
                                 o->common.free_tool, &call->error));
    w->scores = (cli_scores){.nominal_theta = w->nominal, .calibrated = true};
    mukca_fit_offsets(&w->offsets, fit);
    MUKCA_TRY(cli_scores_make(call, &w->scores, &fit->chain, &w->offsets, "train"));
    MUKCA_TRY(judge_offsets(call, &wanted));
    add_traits(call);
    return cli_write(call, o->common.output, write_offsets);
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
        "--traits corrects the recorded angles for the mean elasticity of the arm's fleet before "
        "the fit and adds it to the table, or half of it, or nothing, whichever fits the data "
        "best.\n\n"
        "Exit code 1: not accepted; 5: the data identify nothing.",
    .example =
        "  mukca calibrate --urdf data/demo/arm.urdf data/demo/train.tsv \\\n"
        "      --test data/demo/test.tsv -o build/demo/offsets.tsv --force",
    .with = CLI_WITH_MODEL | CLI_WITH_TEST | CLI_WITH_DISTANCE | CLI_WITH_DISTANCES | CLI_WITH_SD |
            CLI_WITH_JSON | CLI_WITH_ANGLES | CLI_WITH_FRAMES | CLI_WITH_TRAITS | CLI_WITH_TABLES |
            CLI_WITH_THREADS,
    .options = options,
    .options_size = sizeof(calibrate_options),
    .defaults = &defaults,
    .reads = CLI_READS_DATA,
    .run = run,
    .json = cli_calibration_json,
    .print = cli_calibration_print,
    .work_size = sizeof(calibrate_work),
};
