/* calibrate --traits: correct the angles for the mean elasticity of the arm's fleet before the
 * fit. */
#include <math.h>
#include <string.h>

#include "cli/calibrate.h"
#include "fleet/fleet.h"

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

mukca_status calibrate_use_traits(cli_call *call, const mukca_fit_options *options)
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
    mukca_fit *with = MUKCA_TAKE(pool, mukca_fit, SHARES);
    double *recorded[2];
    int best = 0;
    for (int i = 0; i < 2; i++) {
        const size_t size = (size_t)data[i]->n_rows * (size_t)data[i]->n_joints;
        recorded[i] = MUKCA_TAKE(pool, double, size + 1);
        if (recorded[i] && size) memcpy(recorded[i], data[i]->q, size * sizeof *recorded[i]);
    }
    mukca_status status = pool->failed ? cli_fail(call, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    for (int k = 0; k < SHARES && status == MUKCA_OK; k++) {
        correct(s, recorded, traits, shares[k]);
        status = mukca_fit_run(&with[k], &s->model.chain, &s->data, options, &call->error);
        if (status != MUKCA_OK) break;
        const double evidence = log_evidence(&with[k], &w->fit);
        if (k == 0 || evidence > w->traits_evidence) best = k, w->traits_evidence = evidence;
    }
    if (status == MUKCA_OK) {
        const bool use = with[best].converged && w->traits_evidence > LEAST_EVIDENCE;
        w->traits_share = use ? shares[best] : 0;
        correct(s, recorded, traits, w->traits_share);
        if (use) w->fit = with[best];
    }
    return status;
}

void calibrate_add_traits(cli_call *call)
{
    calibrate_work *w = call->work;
    mukca_offsets *to = &w->offsets;
    double sigma[MUKCA_FLEET_TERMS];
    to->n_effects =
        mukca_traits_effects(to->effects, sigma, &call->session->traits, w->traits_share);
    for (int e = 0; e < to->n_effects; e++) to->effect_sigma[e][0] = sigma[e];
}

void calibrate_print_traits(cli_call *call)
{
    const calibrate_work *w = call->work;
    const mukca_traits *traits = &call->session->traits;
    mukca_effect elastic[MUKCA_FLEET_TERMS];
    if (!call->common->traits) return;
    if (mukca_traits_effects(elastic, NULL, traits, 1) == 0)
        cli_say(call, NULL, "Fleet: the traits of %d arms contain no elastic coefficient.",
                traits->n_arms);
    else
        cli_say(call, NULL,
                w->traits_share == 1
                    ? "Fleet: the elastic means of %d arms are in the table; the data agree (log "
                      "Bayes factor %.1f)."
                : w->traits_share > 0
                    ? "Fleet: half of the elastic means of %d arms is in the table: the data want "
                      "it (log Bayes factor %.1f), but not all."
                    : "Fleet: the data do not support the traits of %d arms (log Bayes factor "
                      "%.1f), which are not used.",
                traits->n_arms, w->traits_evidence);
}
