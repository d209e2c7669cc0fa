/* The re-calibration as JSON (mukca.recalibrate/1). */
#include <math.h>

#include "cli/recalibrate.h"

static const char *const stage_key[MUKCA_STAGES] = {"before", "angles", "both"};

double cli_removed_percent(double before, double after)
{
    return before > 0 ? 100 * (1 - after / before) : 0;
}

/* A range below 1 mrad (or mm) is noise of an encoder at rest. */
bool cli_never_moved(const mukca_recalibration *f, int j)
{
    return f->highest[j] - f->lowest[j] < 1e-3;
}

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
                cli_json_numbers("max", cli_removed_percent(e[0].position.max, e[s].position.max),
                                 "mean",
                                 cli_removed_percent(e[0].position.mean, e[s].position.mean)));
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

static json_t *unknowns_json(const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT];
    json_t *array = json_array();
    for (int u = 0; u < f->n; u++) {
        const int k = f->unknown[u].element, j = k < 0 ? -1 : arm->element[k].joint;
        const bool zero = f->unknown[u].kind == MUKCA_UNKNOWN_ZERO;
        mukca_unknown_text(text, &f->unknown[u], arm);
        json_array_append_new(
            array, json_pack("{s:s, s:o, s:o, s:s, s:o, s:b}", "name", text, "joint",
                             cli_json_text(k < 0 ? NULL : arm->element[k].name), "value",
                             cli_json_real(f->value[u]), "unit",
                             mukca_unknown_is_angle(f->unknown[u].kind) ? "rad" : "m", "sigma",
                             cli_json_real(f->sigma[u]), "identifiable",
                             (int)(f->identifiable[u] && !(zero && cli_never_moved(f, j)))));
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

json_t *cli_recalibrate_json(const cli_call *call, const cli_recalibrated *r,
                             const mukca_offsets *offsets, const mukca_chain *chain)
{
    const mukca_recalibration *f = r->fit;
    const mukca_oracle *o = &r->oracle;
    json_t *models =
        json_pack("[{s:o, s:o, s:i, s:i, s:o, s:o, s:o, s:o, s:i}]", "train",
                  errors_json(f->errors, f->has_angles), "test",
                  r->tested ? errors_json(r->test, f->has_angles) : json_null(), "unknowns", f->n,
                  "rank", f->rank, "offsets", unknowns_json(f, &r->arm), "not_identifiable",
                  null_json(f, &r->arm), "base", cli_json_frame(&f->stage[MUKCA_WITH_BOTH].base),
                  "tool", cli_json_frame(&f->stage[MUKCA_WITH_BOTH].tool), "passes", f->passes);
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
    json_t *oracle = cli_json_numbers("tail", f->tail, "position_nominal_m", o->position_nominal,
                                      "position_left_m", o->position_left, "position_systematic_m",
                                      o->position_systematic, "rotation_nominal_rad",
                                      o->rotation_nominal, "rotation_left_rad", o->rotation_left,
                                      "rotation_systematic_rad", o->rotation_systematic);
    json_object_set_new(oracle, "huber_weights", json_boolean(r->robust != r->fit));
    json_object_set_new(root, "oracle", oracle);
    json_object_set_new(root, "models", models);
    json_object_set_new(root, "parameters", cli_json_offsets(offsets, chain));
    json_object_set_new(root, "acceptance", cli_json_acceptance(&offsets->acceptance));
    json_object_set_new(root, "elapsed_s", cli_json_real(cli_elapsed(call)));
    return root;
}
