/* mukca recalibrate: joint zeros and link offsets from logged poses. */
#include "cli/recalibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accept/accept.h"
#include "cli/scores.h"

typedef struct {
    cli_common common;
    mukca_recalibrate_options fit;
} recalibrate_options;

static const cli_option options[] = {
    CLI_OPTION(recalibrate_options, fit.iterate, "iterate", CLI_FLAG, NULL,
               "repeat the linearisation until it converges"),
    CLI_OPTION(recalibrate_options, fit.joint, "joint", CLI_FLAG, NULL,
               "solve for angles and lengths together, not in two steps"),
    CLI_OPTION(recalibrate_options, fit.robust, "robust", CLI_FLAG, NULL,
               "give outliers less weight (Huber)"),
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
        cli_log(call, "mukca: note: the poses are those of link '%s', not of the tip '%s'\n", link,
                chain->tip);
    if (c->rotation_element != c->position_element)
        cli_log(call, "mukca: note: positions are those of '%s', orientations those of '%s'\n",
                link, chain->element[c->rotation_element].child);
    if (c->open) cli_note(call, "%s", c->open);
    r->options.base = c->base;
    r->options.tool = c->tool;
}

static void release(void *work)
{
    cli_recalibrated *r = work;
    for (int k = 0; k < 2; k++) mukca_dataset_free(&r->part[k]);
}

static mukca_recalibrate_task task_of(const cli_recalibrated *r, const mukca_dataset *log)
{
    return (mukca_recalibrate_task){.chain = &r->arm, .log = log, .options = &r->options};
}

/* Fit, test, and judge robustly against outliers.  Residuals with tails heavier than 1.5 times
 * those of normal noise (mukca_recalibration.tail) are fitted again with Huber weights for the
 * verdict. */
static mukca_status fit_and_judge(cli_call *call, cli_recalibrated *r)
{
    mukca_recalibrate_task task = task_of(r, r->log);
    const mukca_recalibrate_task test = task_of(r, r->test_log);
    mukca_recalibrate_options robust = r->options;
    mukca_status status = mukca_recalibrate(r->fit, &task, &call->error);
    if (status == MUKCA_OK && r->tested)
        status = mukca_recalibrate_test(r->test, r->fit->stage, MUKCA_STAGES, &test, &call->error);
    r->robust = r->fit;
    if (status == MUKCA_OK && r->fit->tail > 1.5 && !r->options.robust) {
        r->robust = MUKCA_TAKE(&call->pool, mukca_recalibration, 1);
        if (!r->robust) return cli_fail(call, MUKCA_MEMORY, "out of memory");
        robust.robust = true;
        task.options = &robust;
        status = mukca_recalibrate(r->robust, &task, &call->error);
    }
    return status;
}

/* Standard errors of the table's parameters, by differences: an angle changes roll, pitch and yaw.
 */
static void fill_offsets(mukca_offsets *out, const mukca_recalibration *fit,
                         const mukca_chain *chain, const mukca_chain *arm)
{
    const double step = 1e-6;
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    const mukca_pose_model *fitted = &fit->stage[MUKCA_WITH_BOTH];
    mukca_offsets_init(out, chain);
    mukca_pose_model_theta(out->theta, fitted, arm);
    for (int u = 0; u < fit->found.n; u++) {
        const mukca_unknown *x = &fit->found.unknown[u];
        const bool angle = mukca_unknown_is_angle(x->kind);
        mukca_pose_model moved = *fitted;
        if (!mukca_unknown_element(x, arm)) continue;
        mukca_pose_model_add(&moved, x, step);
        mukca_pose_model_theta(theta, &moved, arm);
        for (int i = angle ? 3 : x->axis; i <= (angle ? 5 : x->axis); i++) {
            const int at = MUKCA_PARAMETERS * x->element + i;
            const double by = (theta[at] - out->theta[at]) / step * fit->found.sigma[u];
            const bool known =
                fit->found.identifiable[u] && (!out->listed[at] || out->identifiable[at]);
            out->sigma[at] = known ? hypot(out->listed[at] ? out->sigma[at] : 0, by) : HUGE_VAL;
            out->identifiable[at] = known;
            out->listed[at] = 1;
        }
    }
}

/* Part of a log as samples in the arm's base: fitted tip plus residual; errors[2][n_rows] of the
 * nominal and the fitted model. */
static mukca_status take_part(mukca_dataset *part, double *errors, const mukca_recalibration *fit,
                              const mukca_recalibrate_task *task, mukca_error *error)
{
    const mukca_chain *arm = task->chain;
    const mukca_pose_model *model = &fit->stage[MUKCA_WITH_BOTH];
    const mukca_status status = mukca_part_take(part, task->log, MUKCA_MOST_SAMPLES, error);
    part->n_files = 1;
    part->n_targets = arm->element[arm->n_elements - 1].joint >= 0; /* its place is unknown */
    for (int i = 0; i < part->n_rows && status == MUKCA_OK; i++) {
        mukca_pose_look look;
        double q[MUKCA_MAX_JOINTS], local[3], *to = part->q + i * arm->n_joints,
                                              *at = part->position + 3 * i;
        mukca_pose_look_at(&look, &fit->stage[MUKCA_BEFORE], part, i);
        errors[i] = mukca_norm3(look.position);
        mukca_pose_look_at(&look, model, part, i);
        errors[part->n_rows + i] = mukca_norm3(look.position);
        for (int j = 0; j < arm->n_joints; j++) {
            to[j] += model->lag * look.velocity[j];
            q[j] = to[j] + model->zero[j];
        }
        mukca_fk_position(at, &model->geometry, q, NULL);
        mukca_mat3_tvec(local, model->base.R, look.position);
        for (int k = 0; k < 3; k++) at[k] += local[k];
        part->file[i] = 0;
    }
    for (int c = 0; c < MUKCA_COLUMNS; c++) { /* the others are not of the arm's base, or used */
        if (c == MUKCA_COLUMN_Q || c == MUKCA_COLUMN_POSITION) continue;
        free(part->column[c]);
        part->column[c] = NULL;
    }
    return status;
}

/* Judge by the errors on test data or, without these, their prediction from the log by generalised
 * cross-validation (Golub, Heath, Wahba 1979): the residual over 1 - unknowns / equations. */
static mukca_status judge_offsets(cli_call *call, cli_recalibrated *r)
{
    const mukca_recalibration *fit = r->fit;
    const int rows = r->log->n_rows, poses = r->tested ? r->test_log->n_rows : rows;
    const double spare = r->tested ? 1 : 1 - fit->found.rank / (3.0 * (rows + r->n_oriented));
    const mukca_recalibrate_task train = task_of(r, r->log), test = task_of(r, r->test_log);
    mukca_acceptance *a = &r->offsets.acceptance;
    mukca_dataset *part = r->part, *judged = part + r->tested;
    double *errors = MUKCA_TAKE(&call->pool, double, 2 * MUKCA_MOST_SAMPLES);
    if (!errors) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    snprintf(a->error_of, sizeof a->error_of, "%s, %d poses",
             r->tested ? "test data" : "generalized cross-validation", poses);
    a->converged = fit->converged;
    a->parameters = fit->found.n;
    a->identified = fit->found.rank;
    mukca_status status = take_part(part, errors, fit, &train, &call->error);
    if (status == MUKCA_OK && r->tested)
        status = take_part(judged, errors, fit, &test, &call->error);
    if (status != MUKCA_OK) return status;
    double *after = errors + judged->n_rows;
    for (int i = 0; i < judged->n_rows; i++) after[i] = spare > 0 ? after[i] / spare : (double)NAN;
    return mukca_accept(
        &r->offsets,
        &(mukca_accept_task){.change = {.chain = &r->arm,
                                        .to = &r->offsets,
                                        .data = part,
                                        .free_base = r->options.free_base},
                             .held = judged,
                             .before = errors,
                             .after = after,
                             .turn_rad = fit->errors[MUKCA_WITH_BOTH].rotation.median,
                             .training_m = NAN},
        &call->error);
}

/* Open the logs, and determine what they measure. */
static mukca_status open_logs(cli_call *call, cli_recalibrated *r)
{
    cli_session *in = call->session;
    mukca_status status = cli_load_data(call, &in->data, &in->model, &call->arguments);
    r->log = &in->data;
    r->test_log = &in->test;
    if (status == MUKCA_OK) status = mukca_pose_log_prepare(r->log, &call->error);
    if (status == MUKCA_OK && r->tested)
        status = cli_load_data(call, r->test_log, &in->model, &call->common->test);
    if (status == MUKCA_OK && r->tested) status = mukca_pose_log_prepare(r->test_log, &call->error);
    mukca_recalibrate_task task = task_of(r, r->log);
    task.chain = &in->model.chain;
    if (status == MUKCA_OK) status = mukca_pose_check_run(&r->check, &task, &call->error);
    if (status != MUKCA_OK) return status;
    use_check(call, r, &in->model.chain);
    for (int i = 0; i < r->log->n_rows; i++) r->n_oriented += mukca_pose_oriented(r->log, i);
    r->options.tilts = r->n_oriented == 0;
    return MUKCA_OK;
}

/* A log that does not fit the arm: print the mix-up of its columns or frames that explains it. */
static void explain_misfit(cli_call *call, const cli_recalibrated *r)
{
    cli_print_mismatch(call, r->log, r->options.free_base, r->options.free_tool);
}

static mukca_status run(cli_call *call)
{
    const recalibrate_options *o = call->options;
    cli_recalibrated *r = call->work;
    r->options = o->fit;
    r->options.free_base = o->common.free_base;
    r->options.free_tool = o->common.free_tool;
    r->options.stop = cli_interrupted;
    r->tested = call->common->test.n > 0;
    r->fit = MUKCA_TAKE(&call->pool, mukca_recalibration, 1);
    if (!r->fit) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    mukca_status status = open_logs(call, r);
    if (status == MUKCA_OK) status = fit_and_judge(call, r);
    if (status == MUKCA_INPUT && r->log->n_rows) explain_misfit(call, r);
    if (status != MUKCA_OK) return status;
    fill_offsets(&r->offsets, r->fit, &call->session->model.chain, &r->arm);
    status = judge_offsets(call, r);
    if (status == MUKCA_OK && !(r->robust->calibrated && r->offsets.acceptance.accepted))
        explain_misfit(call, r);
    if (status != MUKCA_OK || !r->robust->calibrated) return status;
    return cli_write_offsets(call, call->common->output, &r->offsets, &call->session->model.chain,
                             r->log, "method: recalibrate (poses)");
}

const cli_command cli_command_recalibrate = {
    .name = "recalibrate",
    .group = CLI_CALIBRATE,
    .summary = "joint zeros and link offsets from a log of measured poses",
    .synopsis = "DATA...",
    .description =
        "DATA are pose logs (tables with the joints and x_m y_m z_m, qw qx qy qz) or folders with "
        "hole_*_pose.csv. Step one fits the joint zeros to the orientations, step two the link "
        "offsets to the positions, each by a linear regression of least norm; what the log cannot "
        "distinguish from the place of the tool goes to the tool. -v lists all offsets and those "
        "that the log does not identify. Logs without orientations are solved in one step, tilts "
        "of the axes included.\n\n"
        "Poses that only repeat the nominal model are reported, with exit code 5; a table that is "
        "not accepted (see calibrate) with exit code 1. A lag between angles and poses is "
        "estimated and corrected.",
    .example =
        "  mukca simulate --urdf data/gen3.urdf --poses 1000 --perturb 1,2 \\\n"
        "      --noise 1e-4 | mukca recalibrate --urdf data/gen3.urdf - \\\n"
        "      --iterate",
    .with = CLI_WITH_MODEL | CLI_WITH_TEST | CLI_WITH_JSON | CLI_WITH_FRAMES | CLI_WITH_TABLES,
    .options = options,
    .options_size = sizeof(recalibrate_options),
    .reads = CLI_READS_MODEL,
    .run = run,
    .json = cli_recalibrate_json,
    .print = cli_recalibrate_print,
    .work_size = sizeof(cli_recalibrated),
    .release = release,
};
