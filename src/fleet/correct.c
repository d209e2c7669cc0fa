/* Correction of a recording for the traits of its model. */
#include "fleet/correct.h"

#include <math.h>

int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits)
{
    int n = 0;
    for (int i = 0; i < traits->n; i++) {
        const mukca_trait *t = &traits->list[i];
        if (!(t->mean > 0) || n == MUKCA_FLEET_TERMS) continue;
        if (sigma) sigma[n] = hypot(t->spread, t->error);
        effects[n] = t->effect;
        effects[n++].coefficient[0] = t->mean;
    }
    return n;
}

void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain,
                          const mukca_effect *effects, int n)
{
    static const mukca_displacement none = {0};
    mukca_geometry nominal;
    mukca_geometry_set(&nominal, chain, NULL);
    for (int row = 0; row < data->n_rows; row++) {
        double *q = data->q + (size_t)row * (size_t)data->n_joints, from[3], to[3];
        const mukca_joint_state state = {
            .q = q,
            .payload_kg = data->payload && isfinite(data->payload[row]) ? data->payload[row] : 0,
            .placement = -1};
        mukca_displacement d = {0};
        mukca_effects_displacement(&d, effects, n, chain, &nominal, q, &state);
        mukca_fk_position(from, &nominal, q, NULL);
        mukca_fk_position(to, &nominal, q, &d);
        for (int c = 0; c < 3; c++) to[c] -= from[c];
        mukca_linearisation_seat(q, to, data->n_joints, &nominal, &none);
    }
}
