/* Result of a re-calibration: screen (verdict, the tables of the paper) and JSON
 * (mukca.recalibrate/1). */

#include "cli/recalibrate.h"

#include <string.h>

static const char *const stage_text[MUKCA_STAGES] = {"before", "angular offsets", "both",
                                                     "all parameters"};
static const char *const stage_key[MUKCA_STAGES] = {"before", "angles", "both", "all"};

/* True if joint j never moves in the log: a range below 1 mrad (or mm) is noise of an encoder at
 * rest. */
static bool never_moved(const cli_recalibrated *r, int j)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < r->log->n_rows; i++) {
        const double q = r->log->q[i * r->log->n_joints + j];
        low = fmin(low, q), high = fmax(high, q);
    }
    return high - low < 1e-3;
}

/* Unit of the lag. */
static bool is_timed(const cli_recalibrated *r)
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

/* Unknown i of joint zeros and link offsets: its value and standard error, m or rad. */
typedef struct {
    mukca_unknown name;
    double value, sigma;
    bool identifiable;
} unknown_value;

static unknown_value find_unknown(const cli_recalibrated *r, int i)
{
    const mukca_fit *fit = &r->fit->lengths;
    const mukca_identification *id = &fit->identification;
    unknown_value u = {.sigma = id->sigma[i], .identifiable = id->identifiable[i]};
    const int at = fit->parameters.index[i];
    mukca_split_arm_name(&u.name, &r->fit->split, &r->arm, fit, i);
    u.value = u.name.sign * (fit->theta[at] - r->fit->start[at]);
    if (u.name.element >= 0 && u.name.angle) {
        const int joint = r->arm.element[u.name.element].joint;
        u.identifiable &= joint < 0 || !never_moved(r, joint);
    }
    return u;
}

static void print_findings(cli_call *call, const cli_recalibrated *r, const mukca_acceptance *a)
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

mukca_status cli_recalibrate_print(cli_call *call)
{
    const cli_recalibrated *r = call->work;
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

static json_t *unknowns_json(const cli_recalibrated *r)
{
    json_t *array = json_array();
    for (int i = 0; i < r->fit->lengths.parameters.n; i++) {
        const unknown_value u = find_unknown(r, i);
        const char *joint = u.name.element < 0 ? NULL : r->arm.element[u.name.element].name;
        cli_json_append(array, KEY("name", u.name.text), KEY("joint", joint), KEY("value", u.value),
                        KEY("unit", u.name.angle ? "rad" : "m"), KEY("sigma", u.sigma),
                        KEY("identifiable", u.identifiable));
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

json_t *cli_recalibrate_json(const cli_call *call)
{
    const cli_recalibrated *r = call->work;
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
