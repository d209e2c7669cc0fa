/* The result of a calibration as JSON. */
#include <math.h>

#include "cli/calibrate.h"

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
            json_array_append_new(direction,
                                  cli_json("joint:s parameter:s weight:f",
                                           fit->chain.element[at / MUKCA_PARAMETERS].name,
                                           mukca_parameter_name[at % MUKCA_PARAMETERS], weight));
        }
        json_array_append_new(directions, direction);
    }
    return directions;
}

static json_t *frame_json(const calibrate_result *r, bool base)
{
    mukca_frame T;
    return calibrate_frame(&T, r, base) ? cli_json_frame(&T) : NULL;
}

json_t *calibrate_json(const calibrate_result *r, const char *solver, const char *gradient,
                       double elapsed)
{
    const mukca_fit *fit = r->fit;
    const mukca_cost_value *before = &fit->nominal, *after = &fit->calibrated;
    const mukca_difference *e = &r->evidence;
    json_t *root = cli_json(
        "schema:s converged:b solver{name:s gradient:s evaluations:i iterations:i status:s "
        "to_gain:f} cost{nominal{total:f inconsistency:f distortion:f regularisation:f} "
        "calibrated{total:f inconsistency:f distortion:f regularisation:f}} train:o test:o "
        "parameters:o rank:i free:i noise_m:f observability:f null_space:o sigma_samples:i "
        "acceptance:o frames{base:o target:o} traits:o by_evidence:o elapsed_s:f",
        "mukca.calibrate/1", fit->converged, solver, gradient, fit->outcome.evaluations,
        fit->outcome.iterations, mukca_stop_text(fit->outcome.stop), fit->to_gain, before->total,
        before->inconsistency, before->distortion, before->regularisation, after->total,
        after->inconsistency, after->distortion, after->regularisation,
        cli_scores_json(&r->train_scores, r->train), cli_scores_json(&r->test_scores, r->test),
        cli_json_offsets(r->offsets, &fit->chain), fit->identification.rank, fit->parameters.n,
        fit->identification.noise, fit->identification.observability, null_space_json(fit),
        fit->n_part > 0 ? fit->n_part : r->train->n_rows,
        cli_json_acceptance(&r->offsets->acceptance), frame_json(r, true), frame_json(r, false),
        NULL, NULL, elapsed);
    if (r->traits)
        cli_json_set(root, "traits{used:b share:f arms:i log_bayes_factor:f}", r->traits_share > 0,
                     r->traits_share, r->traits->n_arms, r->traits_evidence);
    if (e->postures)
        cli_json_set(root, "by_evidence{error_m:f instead_of_m:f difference_sigma_m:f}", e->after_m,
                     e->before_m, e->sigma_m);
    return root;
}
