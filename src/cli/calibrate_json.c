/* The result of a calibration as JSON. */
#include <math.h>

#include "cli/calibrate.h"

static json_t *cost_json(const mukca_cost_value *v)
{
    return cli_json_numbers("total", v->total, "inconsistency", v->inconsistency, "distortion",
                            v->distortion, "regularisation", v->regularisation);
}

static json_t *null_space_json(const mukca_fit *fit)
{
    const int n = fit->parameters.n;
    json_t *directions = json_array();
    for (int r = 0; r < n - fit->identification.rank; r++) {
        json_t *direction = json_array();
        for (int i = 0; i < n; i++) {
            const int at = fit->parameters.index[i];
            const double weight = fit->null_space[r * n + i];
            if (fabs(weight) < 1e-6) continue;
            json_array_append_new(
                direction,
                json_pack("{s:s, s:s, s:f}", "joint",
                          fit->chain.element[at / MUKCA_PARAMETERS].name, "parameter",
                          mukca_parameter_name[at % MUKCA_PARAMETERS], "weight", weight));
        }
        json_array_append_new(directions, direction);
    }
    return directions;
}

static json_t *frame_json(const calibrate_result *r, bool base)
{
    mukca_frame T;
    return calibrate_frame(&T, r, base) ? cli_json_frame(&T) : json_null();
}

json_t *calibrate_json(const calibrate_result *r, const char *solver, const char *gradient,
                       double elapsed)
{
    const mukca_fit *fit = r->fit;
    json_t *traits = json_null();
    if (r->traits)
        traits = json_pack("{s:b, s:f, s:i, s:o}", "used", r->traits_share > 0, "share",
                           r->traits_share, "arms", r->traits->n_arms, "log_bayes_factor",
                           cli_json_real(r->traits_evidence));
    return json_pack(
        "{s:s, s:b, s:{s:s, s:s, s:i, s:i, s:s, s:o}, s:{s:o, s:o}, s:o, s:o, s:o, s:i, s:i, s:o, "
        "s:o, "
        "s:o, s:i, s:o, s:{s:o, s:o}, s:o, s:o, s:f}",
        "schema", "mukca.calibrate/1", "converged", (int)fit->converged, "solver", "name", solver,
        "gradient", gradient, "evaluations", fit->outcome.evaluations, "iterations",
        fit->outcome.iterations, "status", mukca_stop_text(fit->outcome.stop), "to_gain",
        cli_json_real(fit->to_gain), "cost", "nominal", cost_json(&fit->nominal), "calibrated",
        cost_json(&fit->calibrated), "train", cli_scores_json(&r->train_scores, r->train), "test",
        cli_scores_json(&r->test_scores, r->test), "parameters",
        cli_json_offsets(r->offsets, &fit->chain), "rank", fit->identification.rank, "free",
        fit->parameters.n, "noise_m", cli_json_real(fit->identification.noise), "observability",
        cli_json_real(fit->identification.observability), "null_space", null_space_json(fit),
        "sigma_samples", fit->n_part > 0 ? fit->n_part : r->train->n_rows, "acceptance",
        cli_json_acceptance(&r->offsets->acceptance), "frames", "base", frame_json(r, true),
        "target", frame_json(r, false), "traits", traits, "by_evidence",
        r->evidence.postures
            ? cli_json_numbers("error_m", r->evidence.after_m, "instead_of_m", r->evidence.before_m,
                               "difference_sigma_m", r->evidence.sigma_m)
            : json_null(),
        "elapsed_s", elapsed);
}
