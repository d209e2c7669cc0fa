/* The wording of a fleet. */
#include "report/fleet_page.h"

#include <math.h>
#include <stdio.h>

static const double per = MUKCA_WORDING_PER_SPRING;

void mukca_wording_fleet_effect(char text[MUKCA_WORDING], const mukca_effect *e,
                                const mukca_fleet *f)
{
    mukca_wording_effect(text, e->kind, e->joint < 0 ? NULL : f->model.joint[e->joint]);
}

void mukca_wording_fleet_trait(char text[MUKCA_WORDING], const mukca_trait *t, const mukca_fleet *f)
{
    char effect[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_wording_fleet_effect(effect, &t->effect, f);
    mukca_wording_probability(probability, t->probability);
    if (t->effect.variant.order)
        snprintf(text, MUKCA_WORDING, "%.200s, %d per turn, seen in %d of %d arms, %.60s", effect,
                 t->effect.variant.order, t->arms, f->n_arms, probability);
    else
        snprintf(text, MUKCA_WORDING,
                 "%.200s, %.3g " MUKCA_WORDING_SPRING
                 " [%.3g, %.3g], arms differ by %.2g (%.0f %%), %.60s",
                 effect, per * t->value, per * t->low, per * t->high, per * t->spread,
                 100 * t->spread / t->value, probability);
}

void mukca_wording_fleet_departure(char text[MUKCA_WORDING], const mukca_departure *d,
                                   const mukca_fleet *f)
{
    char effect[MUKCA_WORDING], probability[MUKCA_WORDING], ratio[64];
    mukca_wording_fleet_effect(effect, &d->effect, f);
    mukca_wording_probability(probability, d->probability);
    if (!isfinite(d->ratio))
        snprintf(ratio, sizeof ratio, "unlike");
    else if (d->ratio >= 1)
        snprintf(ratio, sizeof ratio, "%.1f times softer than", d->ratio);
    else
        snprintf(ratio, sizeof ratio, "stiffer (%.1f of the deflection) than", d->ratio);
    snprintf(text, MUKCA_WORDING,
             "%.64s: %.200s %s %d sisters, %.3g " MUKCA_WORDING_SPRING
             " [%.3g, %.3g] against %.3g, %.60s",
             f->arm[d->arm].name, effect, ratio, f->n_arms - 1, per * d->value, per * d->low,
             per * d->high, per * d->mean, probability);
}
