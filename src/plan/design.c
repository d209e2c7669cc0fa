/* Unknowns of a plan, and the derivatives of an arm's tip by them. */
#include <math.h>
#include <string.h>

#include "arm/tip_change.h"
#include "model/prior.h"
#include "plan/choose.h"

/* Prior standard deviation of a cause relative to its stated size: wide, so that the data
 * dominate. */
static const double prior_cause = 30;

void mukca_plan_unknowns_set(mukca_plan_unknowns *at, const mukca_chain *chain, const double *theta,
                             const mukca_effect *effects, int n)
{
    const int tool = mukca_chain_tip_element(chain);
    memset(at, 0, sizeof *at);
    at->chain = chain;
    mukca_parameters_set(&at->parameters, chain, NULL, false);
    for (; at->n < at->parameters.n; at->n++) {
        const int k = at->parameters.index[at->n];
        at->sigma[at->n] = mukca_prior_sigma(&mukca_prior_expected, k % MUKCA_PARAMETERS,
                                             k / MUKCA_PARAMETERS == tool);
    }
    mukca_chain_theta(at->theta, chain);
    if (theta)
        memcpy(at->theta, theta, (size_t)(MUKCA_PARAMETERS * chain->n_elements) * sizeof *theta);
    mukca_geometry_set(&at->geometry, chain, at->theta);
    for (; at->n_effects < n; at->n_effects++) {
        mukca_effect *e = &at->effects[at->n_effects];
        double size = 0;
        *e = effects[at->n_effects];
        e->terms = mukca_effect_terms(e);
        for (int t = 0; t < e->terms; t++) size = hypot(size, e->coefficient[t]);
        for (int t = 0; t < e->terms; t++) at->sigma[at->n++] = prior_cause * size;
    }
}

/* Columns of the coefficients: the displacement by a small part of each sigma. */
static void add_effects(double *H, const mukca_plan_unknowns *at, const mukca_joint_state *state,
                        const double position[3])
{
    const double part = 1.0 / 32;
    for (int e = 0, c = at->parameters.n; e < at->n_effects; e++) {
        mukca_effect one = at->effects[e];
        memset(one.coefficient, 0, sizeof one.coefficient);
        for (int t = 0; t < one.terms; t++, c++) {
            mukca_frame tip;
            one.coefficient[t] = part * at->sigma[c];
            mukca_tip_pose(&tip, &one, 1, at->chain, &at->geometry, state);
            one.coefficient[t] = 0;
            for (int a = 0; a < 3; a++) H[a * (at->n + 1) + c] = (tip.p[a] - position[a]) / part;
        }
    }
}

void mukca_plan_derive(double *H, const mukca_plan_unknowns *at, const mukca_joint_state *state)
{
    double J[3 * MUKCA_MAX_FREE], position[3];
    const int all = MUKCA_PARAMETERS * at->chain->n_elements, size = at->n + 1;
    mukca_fk_parameter_jacobian(J, position, &at->geometry, at->theta, state->q);
    for (int a = 0; a < 3; a++) {
        for (int i = 0; i < at->parameters.n; i++)
            H[a * size + i] = J[a * all + at->parameters.index[i]] * at->sigma[i];
        H[a * size + at->n] = -position[a];
    }
    if (at->n_effects) add_effects(H, at, state, position);
}
