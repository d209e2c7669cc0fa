/* Elastic coefficients shared by arms of one model, as causes of a regression. */
#include "fleet/summary.h"

int mukca_fleet_terms(int n_joints)
{
    return 2 * n_joints;
}

mukca_effect mukca_fleet_term(int i, int n_joints)
{
    const bool base = i == 2 * n_joints - 1;
    return (mukca_effect){.kind = i < n_joints ? MUKCA_EFFECT_JOINT_COMPLIANCE
                                  : base       ? MUKCA_EFFECT_BASE_COMPLIANCE
                                               : MUKCA_EFFECT_LINK_BENDING,
                          .joint = i < n_joints ? i
                                   : base       ? -1
                                                : i - n_joints + 1,
                          .placement = -1,
                          .terms = 1};
}

void mukca_fleet_strip(mukca_regression *m, int joint)
{
    for (int c = m->unknowns.n_causes - 1; c >= 0; c--) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        const int class = mukca_candidate_class(h);
        if (class == MUKCA_CLASS_UNKNOWN || mukca_effect_has(class, MUKCA_TRAIT_ELASTIC) ||
            (class == MUKCA_EFFECT_GEAR_HARMONIC && h->joint == joint))
            mukca_unknowns_drop(&m->unknowns, c);
    }
}

static bool add(mukca_regression *m, const mukca_effect *effect)
{
    mukca_candidate h = {.kind = MUKCA_CANDIDATE_EFFECT,
                         .joint = effect->joint,
                         .placement = effect->placement,
                         .effect = *effect};
    return mukca_candidate_prepare(&h, &m->pool, &m->recording) &&
           mukca_unknowns_add(&m->unknowns, &h);
}

bool mukca_fleet_add(mukca_regression *m, const mukca_fleet_prior *prior)
{
    mukca_unknowns *u = &m->unknowns;
    const int n = m->recording.chain->n_joints;
    const double spread = m->recording.options.mass_spread;
    bool ok = true;
    m->recording.options.mass_spread = 0; /* one coefficient instead of a factor per mass */
    for (int i = 0; i < mukca_fleet_terms(n) && ok; i++) {
        const mukca_effect effect = mukca_fleet_term(i, n);
        const bool load = effect.kind == MUKCA_EFFECT_JOINT_COMPLIANCE ? m->recording.have_torques
                                                                       : m->recording.have_moments;
        if (!load) continue;
        ok = add(m, &effect);
        if (!ok) break;
        mukca_accepted *cause = &u->cause[u->n_causes - 1];
        if (!(cause->candidate.unit[0] > MUKCA_LEAST_TORQUE)) {
            mukca_unknowns_drop(u, u->n_causes - 1);
            continue;
        }
        cause->known = true;
        cause->centre = cause->coefficient[0] = prior[i].mean;
        cause->scale = prior[i].sigma * cause->candidate.unit[0];
    }
    m->recording.options.mass_spread = spread;
    return ok;
}

int mukca_fleet_add_harmonic(mukca_regression *m, int joint, int order)
{
    const mukca_effect effect = {.kind = MUKCA_EFFECT_GEAR_HARMONIC,
                                 .joint = joint,
                                 .placement = -1,
                                 .variant.order = order};
    for (int c = 0; c < m->unknowns.n_causes; c++) {
        const mukca_candidate *h = &m->unknowns.cause[c].candidate;
        if (h->kind == MUKCA_CANDIDATE_EFFECT && mukca_effect_same(&h->effect, &effect)) return c;
    }
    return add(m, &effect) ? m->unknowns.n_causes - 1 : -1;
}
