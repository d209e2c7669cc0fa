/* Derivatives of an arm's tip by its geometry and effects. */
#include <string.h>

#include "fit/arm_posterior.h"
#include "model/prior.h"

void mukca_arm_point_init(mukca_arm_point *at, const mukca_chain *chain, const double *theta)
{
    const int tool = mukca_chain_tip_element(chain);
    memset(at, 0, sizeof *at);
    at->chain = chain;
    mukca_parameters_set(&at->parameters, chain, NULL, false);
    at->n = at->parameters.n;
    for (int i = 0; i < at->n; i++) {
        const int k = at->parameters.index[i];
        at->sigma[i] = mukca_prior_sigma(&mukca_prior_expected, k % MUKCA_PARAMETERS,
                                         k / MUKCA_PARAMETERS == tool);
    }
    mukca_chain_theta(at->theta, chain);
    mukca_arm_point_move(at, theta ? theta : at->theta);
}

void mukca_arm_point_move(mukca_arm_point *at, const double *theta)
{
    memmove(at->theta, theta,
            (size_t)(MUKCA_PARAMETERS * at->chain->n_elements) * sizeof *at->theta);
    mukca_geometry_set(&at->geometry, at->chain, at->theta);
}

/* Columns of the coefficients. */
static void add_effects(double *x, const mukca_arm_point *at, const mukca_geometry *geometry,
                        const mukca_joint_state *state, const mukca_frame *tip,
                        const mukca_frame *rigid)
{
    const int n = at->n_effects, w = MUKCA_OWN + at->n + 1;
    mukca_effect with[MUKCA_MAX_EFFECTS];
    memcpy(with, at->effects, (size_t)n * sizeof *with);
    for (int e = 0, c = at->parameters.n; e < n; e++) {
        const bool alone = e >= n - at->n_alone;
        const mukca_effect *all = alone ? &with[e] : with;
        const int count = alone ? 1 : n;
        if (alone) memset(with[e].coefficient, 0, sizeof with[e].coefficient);
        for (int t = 0; t < with[e].terms; t++, c++) {
            double *value = &with[e].coefficient[t], kept = *value;
            mukca_frame low = alone ? *rigid : *tip, high;
            *value = kept + (at->span > 0 ? at->span : 1) * at->sigma[c];
            mukca_tip_pose(&high, all, count, at->chain, geometry, state);
            *value = kept - at->span * at->sigma[c];
            if (at->span > 0) mukca_tip_pose(&low, all, count, at->chain, geometry, state);
            *value = kept;
            for (int a = 0; a < 3; a++)
                x[a * w + MUKCA_OWN + c] +=
                    (high.p[a] - low.p[a]) / (at->span > 0 ? 2 * at->span : 1);
        }
    }
}

void mukca_arm_point_rows(double *x, const mukca_arm_point *at, const mukca_geometry *geometry,
                          const double *theta, const mukca_joint_state *state, int own)
{
    double J[3 * MUKCA_MAX_FREE], position[3];
    const int all = MUKCA_PARAMETERS * at->chain->n_elements, w = MUKCA_OWN + at->n + 1;
    mukca_frame rigid, tip;
    mukca_fk_parameter_jacobian(J, position, geometry, theta, state->q);
    mukca_fk_pose(&rigid, geometry, state->q, NULL); /* as the derivatives */
    mukca_tip_pose(&tip, at->effects, at->n_effects, at->chain, geometry, state);
    for (int a = 0; a < 3; a++) {
        double *row = x + a * w, *to = row + MUKCA_OWN;
        if (own & MUKCA_OWN_SHIFT) row[a] += 1;
        if (own & MUKCA_OWN_TURN) {
            row[3 + (a + 1) % 3] += rigid.p[(a + 2) % 3];
            row[3 + (a + 2) % 3] -= rigid.p[(a + 1) % 3];
        }
        for (int k = 0; k < 3 && (own & MUKCA_OWN_TARGET); k++) row[6 + k] += rigid.R[3 * a + k];
        for (int i = 0; i < at->parameters.n; i++)
            to[i] += J[a * all + at->parameters.index[i]] * at->sigma[i];
        to[at->n] -= tip.p[a];
    }
    add_effects(x, at, geometry, state, &tip, &rigid);
}
