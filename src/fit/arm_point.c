/* Derivatives of an arm's tip by its geometry and effects. */
#include <string.h>

#include "effect/apply.h"
#include "fit/arm_posterior.h"
#include "model/prior.h"
#include "mukca/gravity.h"

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

/* Columns of the coefficients: the displacement by a small part of each sigma.  The loads are those
 * without deflections, which change them by some 1 %. */
static void add_effects(double *x, const mukca_arm_point *at, const mukca_geometry *geometry,
                        const mukca_joint_state *state, const mukca_displacement *displacement,
                        const mukca_frame *tip)
{
    const double part = 1.0 / 32;
    const int w = MUKCA_OWN + at->n + 1;
    mukca_gravity_load load;
    mukca_joint_state loaded = *state;
    mukca_chain_moments(&load, at->chain, geometry, state->q, NULL, state->payload_kg);
    loaded.torque = load.torque;
    loaded.moment = (const double(*)[3])load.moment;
    loaded.base_moment = load.base;
    for (int e = 0, c = at->parameters.n; e < at->n_effects; e++) {
        mukca_effect one = at->effects[e];
        memset(one.coefficient, 0, sizeof one.coefficient);
        for (int t = 0; t < one.terms; t++, c++) {
            mukca_displacement moved = *displacement;
            mukca_frame other;
            one.coefficient[t] = part * at->sigma[c];
            mukca_effect_displace(&moved, &one, at->chain, &loaded);
            one.coefficient[t] = 0;
            mukca_fk_pose(&other, geometry, state->q, &moved);
            for (int a = 0; a < 3; a++) x[a * w + MUKCA_OWN + c] += (other.p[a] - tip->p[a]) / part;
        }
    }
}

void mukca_arm_point_rows(double *x, const mukca_arm_point *at, const mukca_geometry *geometry,
                          const double *theta, const mukca_joint_state *state, int own)
{
    double J[3 * MUKCA_MAX_FREE];
    const int all = MUKCA_PARAMETERS * at->chain->n_elements, w = MUKCA_OWN + at->n + 1;
    mukca_displacement d;
    mukca_frame tip;
    mukca_fk_parameter_jacobian(J, NULL, geometry, theta, state->q);
    if (at->n_effects)
        mukca_effects_displacement(&d, at->effects, at->n_effects, at->chain, geometry, state->q,
                                   state);
    mukca_fk_pose(&tip, geometry, state->q, at->n_effects ? &d : NULL);
    for (int a = 0; a < 3; a++) {
        double *row = x + a * w, *to = row + MUKCA_OWN;
        if (own & MUKCA_OWN_SHIFT) row[a] += 1;
        if (own & MUKCA_OWN_TURN) {
            row[3 + (a + 1) % 3] += tip.p[(a + 2) % 3];
            row[3 + (a + 2) % 3] -= tip.p[(a + 1) % 3];
        }
        for (int k = 0; k < 3 && (own & MUKCA_OWN_TARGET); k++) row[6 + k] += tip.R[3 * a + k];
        for (int i = 0; i < at->parameters.n; i++)
            to[i] += J[a * all + at->parameters.index[i]] * at->sigma[i];
        to[at->n] -= tip.p[a];
    }
    if (at->n_effects) add_effects(x, at, geometry, state, &d, &tip);
}
