/* The report of `mukca recalibrate`: the tables of the paper, and the same as JSON. */
#include <math.h>
#include <string.h>

#include "cli/recalibrate.h"

static const char *const stage_text[MUKCA_STAGES] = {"before", "angular offsets", "both"};
static const char *const stage_key[MUKCA_STAGES] = {"before", "angles", "both"};

static double removed(double before, double after)
{
    return before > 0 ? 100 * (1 - after / before) : 0;
}

void cli_constant_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_constants *constants, int i,
                       const mukca_chain *chain)
{
    const mukca_unknown *u = &constants->unknown[i];
    if (constants->along_axis[i])
        snprintf(text, MUKCA_UNKNOWN_TEXT, "%s d%d", chain->element[u->element].name,
                 1 + chain->element[u->element].joint);
    else
        mukca_unknown_text(text, u, chain);
}

/* One data set: the paper's position table, then its orientation table. */
static void show_errors(cli_call *call, const char *title, const mukca_pose_errors *e,
                        bool has_angles)
{
    cli_answer(call, "%s (%ld poses)\n", title, e[MUKCA_BEFORE].position.n);
    cli_answer(call,
               "  position, mm         max   mean +- std       |x|    |y|    |z|  removed, %%\n"
               "                                                                 of max, mean\n");
    for (int s = 0; s < MUKCA_STAGES; s++) {
        const mukca_moments *p = &e[s].position;
        if (s == MUKCA_WITH_ANGLES && !has_angles) continue;
        cli_answer(call, "    %-15s %7.3f %6.3f +- %-6.3f %6.3f %6.3f %6.3f", stage_text[s],
                   1e3 * p->max, 1e3 * p->mean, 1e3 * mukca_moments_std(p),
                   1e3 * e[s].position_axis[0].mean, 1e3 * e[s].position_axis[1].mean,
                   1e3 * e[s].position_axis[2].mean);
        if (s != MUKCA_BEFORE)
            cli_answer(call, " %6.1f %6.1f", removed(e[MUKCA_BEFORE].position.max, p->max),
                       removed(e[MUKCA_BEFORE].position.mean, p->mean));
        cli_answer(call, "\n");
    }
    if (e[MUKCA_BEFORE].rotation.n == 0) return;
    cli_answer(call, "  orientation, mrad |ex|: max, mean +- std   |ey|                   |ez|\n");
    for (int s = 0; s < MUKCA_STAGES; s += MUKCA_WITH_BOTH) {
        cli_answer(call, "    %-8s", s == MUKCA_BEFORE ? "before" : "after");
        for (int a = 0; a < 3; a++)
            cli_answer(call, " %6.2f, %5.2f +-%5.2f", 1e3 * e[s].rotation_axis[a].max,
                       1e3 * e[s].rotation_axis[a].mean,
                       1e3 * mukca_moments_std(&e[s].rotation_axis[a]));
        cli_answer(call, "\n");
    }
}

static bool angular(mukca_unknown_kind kind)
{
    return kind == MUKCA_UNKNOWN_ZERO || kind == MUKCA_UNKNOWN_TILT ||
           kind == MUKCA_UNKNOWN_BASE_TURN || kind == MUKCA_UNKNOWN_TOOL_TURN;
}

static void show_unknowns(cli_call *call, const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT];
    cli_answer(call, "offsets (rank %d of %d; not alone: told only in combination with others)\n",
               f->rank, f->n);
    for (int u = 0; u < f->n; u++) {
        mukca_unknown_text(text, &f->unknown[u], arm);
        cli_answer(call, "    %-32s %+9.4f +- %-8.4f %s%s\n", text, 1e3 * f->value[u],
                   1e3 * f->sigma[u], angular(f->unknown[u].kind) ? "mrad" : "mm",
                   f->identifiable[u] ? "" : "  (not alone)");
    }
    if (f->n_null > 0)
        cli_answer(call,
                   "these data cannot tell (any multiple may be added; the least was taken)\n");
    for (int k = 0; k < f->n_null; k++) {
        int shown = 0, small = 0;
        cli_answer(call, "   ");
        for (int u = 0; u < f->n; u++) {
            if (f->null[k][u] == 0) continue;
            if (fabs(f->null[k][u]) < 0.01 || shown == 3) {
                small++;
                continue;
            }
            mukca_unknown_text(text, &f->unknown[u], arm);
            cli_answer(call, " %+.3g %s", f->null[k][u], text);
            shown++;
        }
        cli_answer(call, small ? " and %d more\n" : "\n", small);
    }
}

static bool never_moved(const mukca_recalibration *f, int j)
{
    return f->highest[j] - f->lowest[j] < 1e-3;
}

static void show_findings(cli_call *call, const cli_recalibrated *r)
{
    const mukca_recalibration *f = &r->fit[0];
    char text[MUKCA_UNKNOWN_TEXT], line[800];
    int used;
    for (int j = 0; j < r->arm.n_joints; j++)
        if (never_moved(f, j))
            cli_answer_wrapped(
                call,
                "joint '%s' never moved: its zero offset cannot be told from what is mounted "
                "before and behind it (not identifiable)",
                r->arm.element[r->arm.joint_element[j]].name);
    if (f->lag_found)
        cli_answer_wrapped(
            call,
            "the samples were taken while moving: joint angles are %.4g %s older than poses "
            "(%.0f standard errors); taken into account",
            f->in_rows ? f->lag : 1e3 * f->lag, f->in_rows ? "rows" : "ms", f->lag_score);
    if (!r->oracle.calibrated) return;
    cli_answer_wrapped(
        call, "the poses hold a calibration: %.4f mm (median) off nominal, %.4f mm after the fit",
        1e3 * r->oracle.position_nominal, 1e3 * r->oracle.position_left);
    if (r->constants.n == 0) return;
    used = snprintf(line, sizeof line, "%d constant%s explain%s the difference:", r->constants.n,
                    r->constants.n > 1 ? "s" : "", r->constants.n > 1 ? "" : "s");
    for (int c = 0; c < r->constants.n && used < (int)sizeof line; c++) {
        cli_constant_text(text, &r->constants, c, &r->arm);
        used += snprintf(line + used, sizeof line - (size_t)used, "%s %s %+.4f +- %.4f %s",
                         c > 0 ? "," : "", text, 1e3 * r->constants.value[c],
                         1e3 * r->constants.sigma[c],
                         angular(r->constants.unknown[c].kind) ? "mrad" : "mm");
    }
    cli_answer_wrapped(call, "%s; with these alone %.4f mm (median), %.4f mm (mean) are left", line,
                       1e3 * mukca_histogram_median(&r->constants.errors.position_histogram),
                       1e3 * r->constants.errors.position.mean);
}

void cli_recalibrate_show(cli_call *call, const cli_recalibrated *r)
{
    show_findings(call, r);
    for (int m = 0; m < r->n_models; m++) {
        const mukca_recalibration *f = &r->fit[m];
        if (r->n_models > 1)
            cli_answer(call, "%smodel %d: the log%s%s\n", cli_bold(stderr), m + 1,
                       m ? " and the work volume" : "", cli_plain(stderr));
        show_errors(call, "training", f->errors, f->has_angles);
        if (r->test) show_errors(call, "test", r->test[m], f->has_angles);
        show_unknowns(call, f, &r->arm);
    }
    if (!call->common->output) cli_answer(call, "-o offsets.tsv keeps the result.\n");
}

/* ---- JSON ---- */

static json_t *moments_json(const mukca_moments *m, const char *suffix)
{
    json_t *object = json_object();
    char key[16];
    const double values[3] = {m->max, m->mean, mukca_moments_std(m)};
    static const char *const names[3] = {"max", "mean", "std"};
    for (int i = 0; i < 3; i++) {
        snprintf(key, sizeof key, "%s_%s", names[i], suffix);
        json_object_set_new(object, key, cli_json_real(values[i]));
    }
    return object;
}

static json_t *axes_json(const mukca_moments axis[3], const char *suffix)
{
    json_t *array = json_array();
    for (int a = 0; a < 3; a++) json_array_append_new(array, moments_json(&axis[a], suffix));
    return array;
}

static json_t *errors_json(const mukca_pose_errors *e, bool has_angles)
{
    json_t *position = json_object(), *orientation = json_object(), *percent = json_object();
    for (int s = 0; s < MUKCA_STAGES; s++) {
        if (s == MUKCA_WITH_ANGLES && !has_angles) continue;
        json_t *object = moments_json(&e[s].position, "m");
        json_object_set_new(object, "median_m",
                            cli_json_real(mukca_histogram_median(&e[s].position_histogram)));
        json_object_set_new(object, "axes", axes_json(e[s].position_axis, "m"));
        json_object_set_new(position, stage_key[s], object);
        if (s != MUKCA_BEFORE)
            json_object_set_new(
                percent, stage_key[s],
                json_pack("{s:o, s:o}", "max",
                          cli_json_real(removed(e[0].position.max, e[s].position.max)), "mean",
                          cli_json_real(removed(e[0].position.mean, e[s].position.mean))));
        if (e[s].rotation.n == 0) continue;
        object = moments_json(&e[s].rotation, "rad");
        json_object_set_new(object, "median_rad",
                            cli_json_real(mukca_histogram_median(&e[s].rotation_histogram)));
        json_object_set_new(object, "axes", axes_json(e[s].rotation_axis, "rad"));
        json_object_set_new(orientation, stage_key[s], object);
    }
    return json_pack("{s:I, s:o, s:o, s:o}", "rows", (json_int_t)e[0].position.n, "position",
                     position, "orientation", orientation, "removed_percent", percent);
}

static json_t *frame_json(const mukca_frame *T)
{
    double q[4];
    mukca_rotation_to_quaternion(q, T->R);
    return json_pack("{s:o, s:o}", "position_m", cli_json_reals(T->p, 3), "quaternion",
                     cli_json_reals(q, 4));
}

static json_t *unknowns_json(const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT];
    json_t *array = json_array();
    for (int u = 0; u < f->n; u++) {
        const int k = f->unknown[u].element, j = k < 0 ? -1 : arm->element[k].joint;
        const bool zero = f->unknown[u].kind == MUKCA_UNKNOWN_ZERO;
        mukca_unknown_text(text, &f->unknown[u], arm);
        json_array_append_new(
            array,
            json_pack("{s:s, s:o, s:o, s:s, s:o, s:b}", "name", text, "joint",
                      cli_json_text(k < 0 ? NULL : arm->element[k].name), "value",
                      cli_json_real(f->value[u]), "unit", angular(f->unknown[u].kind) ? "rad" : "m",
                      "sigma", cli_json_real(f->sigma[u]), "identifiable",
                      (int)(f->identifiable[u] && !(zero && never_moved(f, j)))));
    }
    return array;
}

static json_t *null_json(const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT];
    json_t *array = json_array();
    for (int k = 0; k < f->n_null; k++) {
        json_t *terms = json_array();
        for (int u = 0; u < f->n; u++) {
            if (f->null[k][u] == 0) continue;
            mukca_unknown_text(text, &f->unknown[u], arm);
            json_array_append_new(terms, json_pack("{s:s, s:o}", "name", text, "coefficient",
                                                   cli_json_real(f->null[k][u])));
        }
        json_array_append_new(array, terms);
    }
    return array;
}

static json_t *constants_json(const cli_recalibrated *r)
{
    char text[MUKCA_UNKNOWN_TEXT];
    json_t *array = json_array();
    for (int c = 0; c < r->constants.n; c++) {
        cli_constant_text(text, &r->constants, c, &r->arm);
        json_array_append_new(array,
                              json_pack("{s:s, s:o, s:o, s:s}", "name", text, "value",
                                        cli_json_real(r->constants.value[c]), "sigma",
                                        cli_json_real(r->constants.sigma[c]), "unit",
                                        angular(r->constants.unknown[c].kind) ? "rad" : "m"));
    }
    return json_pack(
        "{s:o, s:o, s:o}", "list", array, "left_median_m",
        cli_json_real(r->constants.n
                          ? mukca_histogram_median(&r->constants.errors.position_histogram)
                          : (double)NAN),
        "left_mean_m",
        cli_json_real(r->constants.n ? r->constants.errors.position.mean : (double)NAN));
}

json_t *cli_recalibrate_json(const cli_call *call, const cli_recalibrated *r,
                             const mukca_offsets *offsets, const mukca_chain *chain)
{
    const mukca_recalibration *f = &r->fit[0];
    const mukca_oracle *o = &r->oracle;
    json_t *models = json_array();
    for (int m = 0; m < r->n_models; m++) {
        const mukca_recalibration *fit = &r->fit[m];
        json_array_append_new(
            models,
            json_pack("{s:o, s:o, s:i, s:i, s:o, s:o, s:o, s:o, s:i}", "train",
                      errors_json(fit->errors, fit->has_angles), "test",
                      r->test ? errors_json(r->test[m], fit->has_angles) : json_null(), "unknowns",
                      fit->n, "rank", fit->rank, "offsets", unknowns_json(fit, &r->arm),
                      "not_identifiable", null_json(fit, &r->arm), "base",
                      frame_json(&fit->stage[MUKCA_WITH_BOTH].base), "tool",
                      frame_json(&fit->stage[MUKCA_WITH_BOTH].tool), "passes", fit->passes));
    }
    json_t *root =
        json_pack("{s:s, s:s, s:{s:s, s:s, s:s}, s:I, s:I, s:{s:b, s:o, s:s, s:o}}", "schema",
                  "mukca.recalibrate/1", "verdict", o->calibrated ? "calibrated" : "nominal",
                  "frame", "position_link", r->arm.tip, "rotation_link",
                  chain->element[r->check.rotation_element].child, "quaternion",
                  r->check.order == MUKCA_QUATERNION_W_LAST ? "w last" : "w first", "rows",
                  (json_int_t)f->rows, "orientations", (json_int_t)f->rotations, "lag", "found",
                  (int)f->lag_found, "value", cli_json_real(f->lag), "unit",
                  f->in_rows ? "row" : "s", "standard_errors", cli_json_real(f->lag_score));
    if (!root) return NULL;
    json_object_set_new(
        root, "oracle",
        json_pack("{s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "huber_weights",
                  (int)(r->robust != r->fit), "tail", cli_json_real(f->tail), "position_nominal_m",
                  cli_json_real(o->position_nominal), "position_left_m",
                  cli_json_real(o->position_left), "position_systematic_m",
                  cli_json_real(o->position_systematic), "rotation_nominal_rad",
                  cli_json_real(o->rotation_nominal), "rotation_left_rad",
                  cli_json_real(o->rotation_left), "rotation_systematic_rad",
                  cli_json_real(o->rotation_systematic)));
    json_object_set_new(root, "constants", constants_json(r));
    json_object_set_new(root, "models", models);
    json_object_set_new(root, "parameters", cli_json_offsets(offsets, chain));
    json_object_set_new(root, "elapsed_s", cli_json_real(cli_elapsed(call)));
    return root;
}
