/* calibrate --traits: correct the angles for the mean elasticity of the arm's fleet before the
 * fit. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/calibrate.h"
#include "fleet/fleet.h"

/* Least log Bayes factor for the use of the traits: odds of 3 to 1; less is "not worth more than a
 * bare mention" (R. Kass, A. Raftery, Bayes factors, J. Am. Stat. Assoc. 90, 1995). */
#define LEAST_EVIDENCE 1.1

/* The data with their recorded angles. */
typedef struct {
    mukca_dataset *data[2];
    double *angles[2];
} recorded;

static size_t size_of(const mukca_dataset *data)
{
    return (size_t)data->n_rows * (size_t)data->n_joints;
}

static bool keep(recorded *r, cli_session *s)
{
    *r = (recorded){.data = {&s->data, &s->test}};
    for (int i = 0; i < 2; i++) {
        const size_t size = size_of(r->data[i]);
        r->angles[i] = malloc((size + 1) * sizeof *r->angles[i]);
        if (!r->angles[i]) return false;
        if (size) memcpy(r->angles[i], r->data[i]->q, size * sizeof *r->angles[i]);
    }
    return true;
}

/* Correct the recorded angles by a share of the traits' mean displacement. */
static void correct(const recorded *r, const mukca_chain *chain, const mukca_traits *traits,
                    double share)
{
    mukca_effect effects[MUKCA_FLEET_TERMS];
    const int n = mukca_traits_effects(effects, NULL, traits);
    for (int e = 0; e < n; e++) effects[e].coefficient[0] *= share;
    for (int i = 0; i < 2; i++) {
        const size_t size = size_of(r->data[i]);
        if (size) memcpy(r->data[i]->q, r->angles[i], size * sizeof *r->angles[i]);
        if (share > 0) mukca_traits_correct(r->data[i], chain, effects, n);
    }
}

/* Log Bayes factor between two fits with equal numbers of unknowns, from the residual variances. */
static double log_evidence(const mukca_fit *fit, const mukca_fit *other)
{
    const double freedom = fmax(fit->n_measured - fit->identification.rank, 1);
    return 0.5 * freedom * log(other->calibrated.total / fit->calibrated.total);
}

mukca_status calibrate_use_traits(cli_call *call, calibrate_result *r, mukca_fit *fit,
                                  const mukca_traits *traits, const mukca_fit_options *options)
{
    /* Fractions of the mean to try.  An arm with less than half the mean compliance fits best with
     * none of it; half fits best in between. */
    static const double shares[] = {1, 0.5};
    cli_session *s = call->session;
    const mukca_chain *chain = &s->model.chain;
    recorded as;
    mukca_fit *with = calloc(1, sizeof *with), *best = calloc(1, sizeof *best);
    mukca_status status = keep(&as, s) && with && best ? MUKCA_OK : MUKCA_MEMORY;
    r->traits = traits;
    if (status != MUKCA_OK) cli_fail(call, status, "out of memory");
    for (size_t k = 0; k < sizeof shares / sizeof *shares && status == MUKCA_OK; k++) {
        correct(&as, chain, traits, shares[k]);
        status = mukca_fit_run(with, chain, &s->data, options, &call->error);
        if (status != MUKCA_OK) break;
        const double evidence = log_evidence(with, fit);
        if (k == 0 || evidence > r->traits_evidence) {
            mukca_fit *const better = with;
            r->traits_evidence = evidence;
            r->traits_share = with->converged && evidence > LEAST_EVIDENCE ? shares[k] : 0;
            with = best, best = better;
        }
        mukca_fit_free(with);
    }
    if (status == MUKCA_OK) correct(&as, chain, traits, r->traits_share);
    if (status == MUKCA_OK && r->traits_share > 0) {
        mukca_fit_free(fit);
        *fit = *best;
    } else if (best) {
        mukca_fit_free(best);
    }
    free(with);
    free(best);
    free(as.angles[0]);
    free(as.angles[1]);
    return status;
}

void calibrate_add_traits(mukca_offsets *to, const calibrate_result *r)
{
    double sigma[MUKCA_FLEET_TERMS];
    if (!(r->traits_share > 0)) return;
    to->n_effects = mukca_traits_effects(to->effects, sigma, r->traits);
    for (int e = 0; e < to->n_effects; e++) {
        to->effects[e].coefficient[0] *= r->traits_share;
        to->effect_sigma[e][0] = sigma[e];
    }
}

void calibrate_print_traits(cli_call *call, const calibrate_result *r)
{
    mukca_effect elastic[MUKCA_FLEET_TERMS];
    if (!r->traits) return;
    if (mukca_traits_effects(elastic, NULL, r->traits) == 0) {
        cli_say(call, NULL, "Fleet: the traits of %d arms contain no elastic coefficient.",
                r->traits->n_arms);
        return;
    }
    cli_say(call, NULL,
            r->traits_share == 1 ? "Fleet: the elastic means of %d arms are in the table; the data "
                                   "agree (log Bayes factor %.1f)."
            : r->traits_share > 0 ? "Fleet: half of the elastic means of %d arms is in the table: "
                                    "the data want it (log Bayes factor %.1f), but not all."
                                  : "Fleet: the data do not support the traits of %d arms (log "
                                    "Bayes factor %.1f), which are not used.",
            r->traits->n_arms, r->traits_evidence);
}
