/* mukca recalibrate: geometry, joint zeros and link offsets from logged poses. */
#include "cli/recalibrate.h"

#include <stdio.h>

#include "cli/scores.h"

typedef struct {
    cli_common common;
    bool robust;
} recalibrate_options;

static const cli_option options[] = {CLI_OPTION(recalibrate_options, robust, "robust", CLI_FLAG,
                                                NULL, "leave out outliers (8 sigma)"),
                                     CLI_OUTPUT_OPTION("write the offsets table"),
                                     {.name = NULL}};

/* Note the findings in the first rows, and end the arm at the link that the poses refer to. */
static void use_check(cli_call *call, cli_recalibrated *r, const mukca_chain *chain)
{
    const mukca_pose_check *c = &r->check;
    r->arm = *chain;
    r->arm.n_elements = c->position_element + 1;
    const char *link = chain->element[c->position_element].child;
    snprintf(r->arm.tip, sizeof r->arm.tip, "%s", link);
    if (c->position_element != chain->n_elements - 1)
        cli_note(call, "the poses are those of link '%s', not of the tip '%s'", link, chain->tip);
    if (c->rotation_element != c->position_element)
        cli_note(call, "positions are those of '%s', orientations those of '%s'", link,
                 chain->element[c->rotation_element].child);
}

/* Orientations of the link of the positions. */
static void turn_orientations(mukca_dataset *log, const double turn[9])
{
    for (int i = 0; i < log->n_rows; i++) {
        double R[9], back[9];
        if (!mukca_pose_oriented(log, i)) continue;
        for (int k = 0; k < 9; k++) back[k] = turn[3 * (k % 3) + k / 3];
        mukca_rotation_from_quaternion(R, log->quaternion + 4 * i);
        mukca_mat3_mul(R, R, back);
        mukca_rotation_to_quaternion(log->quaternion + 4 * i, R);
    }
}

/* Open the logs, and determine what they measure. */
static mukca_status open_logs(cli_call *call, cli_recalibrated *r)
{
    cli_session *in = call->session;
    const cli_common *c = call->common;
    const mukca_chain *chain = &in->model.chain;
    r->log = &in->data;
    r->test_log = &in->test;
    mukca_status status = mukca_pose_log_prepare(r->log, &call->error);
    if (status == MUKCA_OK && r->tested) status = mukca_pose_log_prepare(r->test_log, &call->error);
    if (status == MUKCA_OK)
        status = mukca_pose_check_run(&r->check, chain, r->log, c->free_base || c->free_tool,
                                      &call->error);
    if (status != MUKCA_OK) return status;
    use_check(call, r, chain);
    if (r->check.rotation_element != r->check.position_element) {
        turn_orientations(r->log, r->check.turn);
        turn_orientations(r->test_log, r->check.turn);
    }
    for (int i = 0; i < r->log->n_rows; i++) r->n_oriented += mukca_pose_oriented(r->log, i);
    return MUKCA_OK;
}

/* Fit, and the errors of all stages on test data. */
static mukca_status fit_log(cli_call *call, cli_recalibrated *r)
{
    const recalibrate_options *o = call->options;
    const mukca_fit_options wanted = {.free_base = o->common.free_base,
                                      .free_tool = o->common.free_tool,
                                      .limits = {.stop = cli_stop}};
    mukca_recalibration *fit = r->fit;
    mukca_status status = mukca_recalibrate(fit, &r->arm, r->log, &wanted, o->robust, &call->error);
    if (status != MUKCA_OK || !r->tested) return status;
    mukca_pose_log_shift(r->test_log, fit->lag);
    for (int k = 0; k < MUKCA_STAGES && status == MUKCA_OK; k++)
        if (k != MUKCA_WITH_ANGLES || fit->has_angles)
            status = mukca_pose_errors_find(&r->test[k], &fit->stage[k], r->test_log, &call->error);
    return status;
}

/* The table of the fit, judged as that of calibrate; elements after the link of the poses stay
 * nominal. */
static mukca_status judge_offsets(cli_call *call, cli_recalibrated *r)
{
    const mukca_fit *all = &r->fit->all;
    const mukca_chain *chain = &call->session->model.chain;
    const int n = MUKCA_PARAMETERS * all->chain.n_elements;
    const recalibrate_options *o = call->options;
    mukca_dataset kept = {0}, *log = r->log;
    mukca_cross_validation held = {0};
    double nominal[MUKCA_MAX_THETA];
    mukca_status status = MUKCA_OK;
    mukca_fit_offsets(&r->offsets, all);
    if (o->robust && r->fit->trimmed) /* the samples that it was fitted to */
        status = mukca_pose_log_trim(&kept, &r->fit->stage[MUKCA_WITH_ALL],
                                     &r->fit->errors[MUKCA_WITH_ALL], r->log, &call->error);
    if (kept.n_rows) log = &kept;
    if (status == MUKCA_OK)
        status = mukca_fit_cross_validate(&held, all, &r->arm, log, r->test_log, &r->fit->options,
                                          &call->error);
    if (status == MUKCA_OK)
        status = mukca_accept_fit(&r->offsets, all, &held, log, &r->fit->options, &call->error);
    mukca_cross_validation_free(&held);
    mukca_dataset_free(&kept);
    if (status != MUKCA_OK) return status;
    r->chain = chain->n_elements > all->chain.n_elements ? chain : &all->chain;
    mukca_chain_theta(nominal, r->chain);
    for (int i = n; i < MUKCA_PARAMETERS * r->chain->n_elements; i++)
        r->offsets.theta[i] = nominal[i];
    return status;
}

static mukca_status run(cli_call *call)
{
    cli_recalibrated *r = call->work;
    const cli_common *c = call->common;
    r->tested = c->test.n > 0;
    r->fit = MUKCA_TAKE(&call->pool, mukca_recalibration, 1);
    if (!r->fit) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    mukca_status status = open_logs(call, r);
    if (status == MUKCA_OK) status = fit_log(call, r);
    const bool misfit = status == MUKCA_INPUT && r->log->n_rows;
    if (status == MUKCA_OK) status = judge_offsets(call, r);
    if (misfit || (status == MUKCA_OK && !(r->fit->calibrated && r->offsets.acceptance.accepted)))
        cli_print_mismatch(call, r->log, c->free_base, c->free_tool);
    if (status != MUKCA_OK || !r->fit->calibrated) return status;
    return cli_write_offsets(call, c->output, &r->offsets, r->chain, r->log,
                             "method: recalibrate (poses)");
}

const cli_command cli_command_recalibrate = {
    .name = "recalibrate",
    .group = CLI_CALIBRATE,
    .summary = "geometry and joint zeros from a log of measured poses",
    .synopsis = "DATA...",
    .description =
        "DATA are pose logs (tables with the joints and x_m y_m z_m, qw qx qy qz) or folders with "
        "hole_*_pose.csv. The table is that of calibrate: all parameters of the geometry, fitted "
        "to positions and orientations. Beside it stand the errors of two restrictions: joint "
        "zeros alone, fitted to the orientations, and joint zeros with link offsets, which a "
        "controller accepts; --json lists these offsets, and whether the log identifies them.\n\n"
        "Poses that only repeat the nominal model are reported, with exit code 5; a table that is "
        "not accepted (see calibrate) with exit code 1. A lag between angles and poses is "
        "estimated and corrected. The poses may be those of another link than the tip.",
    .example =
        "  mukca simulate --urdf data/gen3.urdf --poses 1000 --perturb 1,2 \\\n"
        "      --noise 1e-4 | mukca recalibrate --urdf data/gen3.urdf -",
    .with = CLI_WITH_MODEL | CLI_WITH_TEST | CLI_WITH_JSON | CLI_WITH_FRAMES | CLI_WITH_TABLES,
    .options = options,
    .options_size = sizeof(recalibrate_options),
    .reads = CLI_READS_DATA,
    .run = run,
    .json = cli_recalibrate_json,
    .print = cli_recalibrate_print,
    .work_size = sizeof(cli_recalibrated),
};
