/* mukca recalibrate: geometry, joint zeros and link offsets from logged poses. */
#include <stdio.h>
#include <string.h>

#include "accept/accept.h"
#include "cli/scores.h"
#include "recalibrate/recalibrate.h"

typedef struct {
    cli_common common;
    bool robust;
} recalibrate_options;

static const cli_option options[] = {CLI_OPTION(recalibrate_options, robust, "robust", CLI_FLAG,
                                                NULL, "leave out outliers (8 sigma)"),
                                     CLI_OUTPUT_OPTION("write the offsets table"),
                                     {.name = NULL}};

typedef struct {
    mukca_chain arm;               /* up to the link that the poses refer to */
    mukca_dataset *log, *test_log; /* of the session */
    int n_oriented;                /* rows of the log with an orientation */
    mukca_pose_check check;
    mukca_recalibration *fit;
    bool tested; /* --test */
    mukca_pose_errors test[MUKCA_STAGES];
    mukca_offsets offsets;    /* with verdict */
    const mukca_chain *chain; /* of these */
} recalibrate_work;

/* Note the findings in the first rows, and end the arm at the link that the poses refer to. */
static void use_check(cli_call *call, recalibrate_work *r, const mukca_chain *chain)
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
        double R[9], back[9], turned[9];
        if (!mukca_pose_oriented(log, i)) continue;
        for (int k = 0; k < 9; k++) back[k] = turn[3 * (k % 3) + k / 3];
        mukca_rotation_from_quaternion(R, log->quaternion + 4 * i);
        mukca_mat3_mul(turned, R, back);
        mukca_rotation_to_quaternion(log->quaternion + 4 * i, turned);
    }
}

/* Open the logs, and determine what they measure. */
static mukca_status open_logs(cli_call *call, recalibrate_work *r)
{
    cli_session *in = call->session;
    const cli_common *c = call->common;
    const mukca_chain *chain = &in->model.chain;
    r->log = &in->data;
    r->test_log = &in->test;
    MUKCA_TRY(mukca_pose_log_prepare(r->log, &call->error));
    if (r->tested) MUKCA_TRY(mukca_pose_log_prepare(r->test_log, &call->error));
    MUKCA_TRY(
        mukca_pose_check_run(&r->check, chain, r->log, c->free_base || c->free_tool, &call->error));
    use_check(call, r, chain);
    if (r->check.rotation_element != r->check.position_element) {
        turn_orientations(r->log, r->check.turn);
        turn_orientations(r->test_log, r->check.turn);
    }
    for (int i = 0; i < r->log->n_rows; i++) r->n_oriented += mukca_pose_oriented(r->log, i);
    return MUKCA_OK;
}

/* Fit, and the errors of all stages on test data. */
static mukca_status fit_log(cli_call *call, recalibrate_work *r)
{
    const recalibrate_options *o = call->options;
    const mukca_fit_options wanted = {.free_base = o->common.free_base,
                                      .free_tool = o->common.free_tool,
                                      .limits = {.stop = cli_stop}};
    mukca_recalibration *fit = r->fit;
    MUKCA_TRY(mukca_recalibrate(fit, &r->arm, r->log, &wanted, o->robust, &call->error));
    if (!r->tested) return MUKCA_OK;
    mukca_pose_log_shift(r->test_log, fit->lag);
    for (int k = 0; k < MUKCA_STAGES; k++) {
        if (k == MUKCA_WITH_ANGLES && !fit->has_angles) continue;
        MUKCA_TRY(mukca_pose_errors_find(&r->test[k], &fit->stage[k], r->test_log, &call->error));
    }
    return MUKCA_OK;
}

/* The table of the fit, judged as that of calibrate; elements after the link of the poses stay
 * nominal. */
static mukca_status judge_offsets(cli_call *call, recalibrate_work *r)
{
    const mukca_fit *all = &r->fit->all;
    const mukca_chain *chain = &call->session->model.chain;
    const int n = MUKCA_PARAMETERS * all->chain.n_elements;
    const recalibrate_options *o = call->options;
    mukca_dataset kept = {0}, *log = r->log;
    mukca_cross_validation held = {.held = r->test_log};
    double nominal[MUKCA_MAX_THETA];
    mukca_status status = MUKCA_OK;
    mukca_fit_offsets(&r->offsets, all);
    if (o->robust && r->fit->trimmed) /* the samples that it was fitted to */
        status = mukca_pose_log_trim(&kept, &r->fit->stage[MUKCA_WITH_ALL],
                                     &r->fit->errors[MUKCA_WITH_ALL], r->log, &call->error);
    if (kept.n_rows) log = &kept;
    if (status == MUKCA_OK)
        status = mukca_fit_cross_validate(&held, all, &r->arm, log, &r->fit->options, &call->error);
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

static mukca_status write_offsets(cli_call *call, FILE *stream)
{
    const recalibrate_work *r = call->work;
    return mukca_offsets_write(stream, &r->offsets, r->chain, r->log, "method: recalibrate (poses)",
                               &call->error);
}

static mukca_status run(cli_call *call)
{
    recalibrate_work *r = call->work;
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
    return cli_write(call, c->output, write_offsets);
}

/* ---- screen: the verdict, the tables of the paper ---- */

static const char *const stage_text[MUKCA_STAGES] = {"before", "angular offsets", "both",
                                                     "all parameters"};
static const char *const stage_key[MUKCA_STAGES] = {"before", "angles", "both", "all"};

/* True if joint j never moves in the log: a range below 1 mrad (or mm) is noise of an encoder at
 * rest. */
static bool never_moved(const recalibrate_work *r, int j)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < r->log->n_rows; i++) {
        const double q = r->log->q[i * r->log->n_joints + j];
        low = fmin(low, q), high = fmax(high, q);
    }
    return high - low < 1e-3;
}

/* Unit of the lag. */
static bool is_timed(const recalibrate_work *r)
{
    return r->log->time && isfinite(r->log->time[0]);
}

static void print_moments(cli_call *call, const mukca_moments *m)
{
    cli_answer(call, "  %8.3f %7.3f +- %6.3f", 1e3 * m->max, 1e3 * m->mean,
               1e3 * mukca_moments_std(m));
}

/* The errors of one data set after each stage. */
static void print_errors(cli_call *call, const char *title, const mukca_pose_errors *e,
                         bool has_angles)
{
    const bool turns = e[MUKCA_BEFORE].rotation.length.n > 0;
    cli_answer(call, "%s (%ld poses)\n%*s%s\n", title, e[MUKCA_BEFORE].position.length.n, 46,
               "position, mm: max, mean +- std", turns ? "            orientation, mrad" : "");
    for (int s = 0; s < MUKCA_STAGES; s++) {
        if (s == MUKCA_WITH_ANGLES && !has_angles) continue;
        cli_answer(call, "  %-15s", stage_text[s]);
        print_moments(call, &e[s].position.length);
        if (turns) print_moments(call, &e[s].rotation.length);
        cli_answer(call, "\n");
    }
}

static void print_findings(cli_call *call, const recalibrate_work *r, const mukca_acceptance *a)
{
    const mukca_recalibration *f = r->fit;
    cli_answer(call, "%s: %d measured poses\n", r->arm.robot, r->log->n_rows);
    cli_print_acceptance(cli_answer_stream(call), a, &r->arm);
    cli_say(call, "Result",
            "the poses contain a calibration: median position error %.4f mm nominal, %.4f mm after "
            "the fit",
            1e3 * f->position.nominal, 1e3 * f->position.left);
    for (int j = 0; j < r->arm.n_joints; j++)
        if (never_moved(r, j))
            cli_say(call, NULL,
                    "joint '%s' never moved: its zero offset is not identifiable; it is "
                    "indistinguishable from the links before and after it",
                    mukca_chain_joint_name(&r->arm, j));
    if (f->lag != 0)
        cli_say(call, NULL,
                "Lag: the joint angles are %.4g %s older than the poses (%.0f standard errors); "
                "corrected",
                is_timed(r) ? 1e3 * f->lag : f->lag, is_timed(r) ? "ms" : "rows", f->lag_score);
}

static mukca_status print(cli_call *call)
{
    const recalibrate_work *r = call->work;
    const mukca_acceptance *a = &r->offsets.acceptance;
    const char *output = call->common->output;
    if (!r->fit->calibrated)
        return cli_fail(
            call, MUKCA_UNIDENTIFIABLE,
            "no calibration in these poses: their median error is %.4f mm with the "
            "nominal model, %.4f mm after a fit, no gain beyond their noise; no offsets "
            "table is written; check that angles and poses are of the same samples, use "
            "another tracker, or calibrate from sockets",
            1e3 * r->fit->position.nominal, 1e3 * r->fit->position.left);
    print_findings(call, r, a);
    print_errors(call, "Training data", r->fit->errors, r->fit->has_angles);
    if (r->tested) print_errors(call, "Test data", r->test, r->fit->has_angles);
    cli_say(call, "Offsets", "%d of %d combinations identified", r->fit->all.identification.rank,
            r->fit->all.parameters.n);
    if (output)
        cli_say(call, "Written", "%s%s", output,
                a->accepted ? "" : " (other commands refuse this table)");
    else if (a->accepted)
        cli_say(call, "Next", "-o offsets.tsv saves the result");
    return a->accepted ? MUKCA_OK : MUKCA_NEGATIVE;
}

/* ---- JSON ---- */

static json_t *moments_json(const mukca_moments *m, bool angle)
{
    return cli_json(KEY(angle ? "max_rad" : "max_m", m->max),
                    KEY(angle ? "mean_rad" : "mean_m", m->mean),
                    KEY(angle ? "std_rad" : "std_m", mukca_moments_std(m)));
}

/* Moments of the errors of one stage, their median, and the moments by axis. */
static json_t *stage_json(const mukca_vector_errors *e, bool angle)
{
    json_t *object = moments_json(&e->length, angle), *axes = json_array();
    for (int a = 0; a < 3; a++) json_array_append_new(axes, moments_json(&e->axis[a], angle));
    json_object_update_new(
        object, cli_json(KEY(angle ? "median_rad" : "median_m", e->median), KEY("axes", axes)));
    return object;
}

static json_t *errors_json(const mukca_pose_errors *e, bool has_angles)
{
    json_t *position = json_object(), *orientation = json_object();
    for (int s = 0; s < MUKCA_STAGES; s++) {
        if (s == MUKCA_WITH_ANGLES && !has_angles) continue;
        json_object_set_new(position, stage_key[s], stage_json(&e[s].position, false));
        if (e[s].rotation.length.n > 0)
            json_object_set_new(orientation, stage_key[s], stage_json(&e[s].rotation, true));
    }
    return cli_json(KEY("rows", e[MUKCA_BEFORE].position.length.n), KEY("position", position),
                    KEY("orientation", orientation));
}

/* Joint zeros and link offsets, with standard errors. */
static json_t *unknowns_json(const recalibrate_work *r)
{
    const mukca_fit *fit = &r->fit->lengths;
    json_t *array = json_array();
    for (int i = 0; i < fit->parameters.n; i++) {
        mukca_unknown u;
        const int at = fit->parameters.index[i];
        mukca_split_arm_name(&u, &r->fit->split, &r->arm, fit, i);
        const mukca_element *e = u.element < 0 ? NULL : &r->arm.element[u.element];
        const bool still = e && u.angle && e->joint >= 0 && never_moved(r, e->joint);
        cli_json_append(array, KEY("name", u.text), KEY("joint", e ? e->name : NULL),
                        KEY("value", u.sign * (fit->theta[at] - r->fit->start[at])),
                        KEY("unit", u.angle ? "rad" : "m"),
                        KEY("sigma", fit->identification.sigma[i]),
                        KEY("identifiable", (bool)(fit->identification.identifiable[i] && !still)));
    }
    return array;
}

/* A frame of the fit: the base's in that of the poses, or the target's. */
static json_t *frame_json(const mukca_fit *fit, bool base)
{
    const int k = base ? 0 : fit->chain.n_elements - 1;
    mukca_frame T;
    if (!mukca_element_is_frame(&fit->chain.element[k])) return NULL;
    mukca_rotation_from_rpy(T.R, fit->theta + MUKCA_PARAMETERS * k + 3);
    memcpy(T.p, fit->theta + MUKCA_PARAMETERS * k, sizeof T.p);
    return cli_json_frame(&T);
}

static json_t *as_json(const cli_call *call)
{
    const recalibrate_work *r = call->work;
    const mukca_chain *chain = &call->session->model.chain;
    const mukca_recalibration *f = r->fit;
    json_t *model = cli_json(
        KEY("train", errors_json(f->errors, f->has_angles)),
        KEY("test", r->tested ? errors_json(r->test, f->has_angles) : NULL),
        KEY("unknowns", f->lengths.parameters.n), KEY("rank", f->lengths.identification.rank),
        KEY("offsets", unknowns_json(r)), KEY("base", frame_json(&f->all, true)),
        KEY("tool", frame_json(&f->all, false)), KEY("passes", f->all.outcome.evaluations));
    return cli_json(
        KEY("verdict", f->calibrated ? "calibrated" : "nominal"),
        KEY("frame",
            cli_json(KEY("position_link", r->arm.tip),
                     KEY("rotation_link", chain->element[r->check.rotation_element].child))),
        KEY("rows", r->log->n_rows), KEY("orientations", r->n_oriented),
        KEY("lag",
            cli_json(KEY("found", (bool)(f->lag != 0)), KEY("value", f->lag),
                     KEY("unit", is_timed(r) ? "s" : "row"), KEY("standard_errors", f->lag_score))),
        KEY("oracle", cli_json(FIELD(f, tail), KEY("position_nominal_m", f->position.nominal),
                               KEY("position_left_m", f->position.left),
                               KEY("position_systematic_m", f->position.systematic),
                               KEY("rotation_nominal_rad", f->rotation.nominal),
                               KEY("rotation_left_rad", f->rotation.left),
                               KEY("rotation_systematic_rad", f->rotation.systematic),
                               KEY("without_outliers", f->trimmed))),
        KEY("models", json_pack("[o]", model)),
        KEY("parameters", cli_json_offsets(&r->offsets, r->chain)),
        KEY("acceptance", cli_json_acceptance(&r->offsets.acceptance)),
        KEY("elapsed_s", cli_elapsed(call)));
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
    .json = as_json,
    .print = print,
    .work_size = sizeof(recalibrate_work),
};
