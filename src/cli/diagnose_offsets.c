/* The offsets table of a diagnosis: geometry, and the causes that act on the arm. */
#include <math.h>
#include <string.h>

#include "cli/diagnose.h"
#include "fit/parameters.h"

/* A parameter counts as identifiable where the rows at least halve what was uncertain before. */
static void fill_geometry(mukca_offsets *o, const mukca_diagnosis *d, const mukca_chain *arm,
                          int shift)
{
    const int n = MUKCA_PARAMETERS * arm->n_elements;
    double theta[MUKCA_MAX_THETA];
    mukca_geometry_theta(theta, arm, &d->geometry);
    for (int i = 0; i < n; i++) {
        const int at = i + MUKCA_PARAMETERS * shift;
        if (!isfinite(d->theta_sigma[i])) continue;
        o->theta[at] = theta[i];
        o->sigma[at] = d->theta_sigma[i];
        o->listed[at] = 1;
        o->identifiable[at] = d->theta_sigma[i] < 0.5 * d->theta_prior[i];
    }
}

static void fill_tracker(mukca_offsets *o, const mukca_diagnosis *d)
{
    static const double zero[3] = {0, 0, 0};
    memcpy(o->theta, d->tracker.p, sizeof d->tracker.p);
    mukca_rotation_to_rpy(o->theta + 3, d->tracker.R, zero);
    for (int i = 0; i < MUKCA_PARAMETERS; i++) {
        o->sigma[i] = NAN;
        o->listed[i] = o->identifiable[i] = 1;
    }
}

mukca_status cli_diagnosis_offsets(mukca_offsets *o, mukca_chain *chain, int *left_out,
                                   const cli_diagnosed *r, bool free_base, mukca_error *error)
{
    const mukca_diagnosis *d = r->diagnosis;
    *left_out = 0;
    if (!d->theta_sigma)
        return mukca_fail(error, MUKCA_UNIDENTIFIABLE,
                          "no offsets to write: these rows are too few to fit anything");
    mukca_status status = mukca_chain_with_frames(chain, r->chain, free_base, false, error);
    if (status != MUKCA_OK) return status;
    mukca_offsets_init(o, chain);
    mukca_offsets_set_placements(o, r->data);
    fill_geometry(o, d, r->chain, free_base);
    if (free_base) fill_tracker(o, d);
    for (int i = 0; i < d->n_causes; i++) {
        const mukca_cause *c = &d->causes[i];
        const mukca_effect_info *info = &mukca_effect_table[c->effect.kind];
        if (info->site == MUKCA_SITE_SOCKET) continue;
        if ((info->needs & MUKCA_NEEDS_MASSES) && chain->n_masses == 0) {
            ++*left_out;
            continue;
        }
        mukca_effect *effect = &o->effects[o->n_effects];
        *effect = c->effect;
        for (int t = 0; t < effect->terms; t++) { /* a table knows the named masses only */
            effect->coefficient[t] *= c->load_scale;
            o->effect_sigma[o->n_effects][t] = c->sigma[t] * c->load_scale;
        }
        o->n_effects++;
    }
    return MUKCA_OK;
}
