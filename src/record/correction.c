/* Joint angles of an elastic arm corrected to those of a rigid one.  A separate file because the
 * headers of fleet and capture each define a mukca_linearisation. */
#include "record/correction.h"

#include "fleet/correct.h"
#include "io/summary.h"

_Static_assert(MUKCA_FLEET_TERMS == 2 * MUKCA_MAX_JOINTS, "room for all elastic coefficients");

mukca_status mukca_correction_read(mukca_correction *c, const char *path, const mukca_chain *chain,
                                   mukca_error *error)
{
    mukca_traits traits;
    mukca_status status = mukca_traits_read(&traits, path, chain, error);
    if (status != MUKCA_OK) return status;
    c->chain = chain;
    c->n_arms = traits.n_arms;
    c->n_effects = mukca_traits_effects(c->effects, NULL, &traits);
    return MUKCA_OK;
}

void mukca_correction_apply(void *correction, double share, double *q)
{
    const mukca_correction *c = correction;
    mukca_effect effects[2 * MUKCA_MAX_JOINTS];
    if (!(share > 0)) return;
    for (int e = 0; e < c->n_effects; e++) {
        effects[e] = c->effects[e];
        effects[e].coefficient[0] *= share;
    }
    mukca_dataset sample = {.n_rows = 1, .n_joints = c->chain->n_joints};
    sample.q = q;
    mukca_traits_correct(&sample, c->chain, effects, c->n_effects);
}
