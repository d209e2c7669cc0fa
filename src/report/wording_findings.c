/* The wording of findings and verdict: what the error varies with, where, how large, how sure. */
#include <math.h>
#include <string.h>

#include "math/stats.h"
#include "report/wording.h"

#define put mukca_wording_put /* short for this file */

/* What each family is called, before its place. */
static const char *const families[MUKCA_VARIES_COUNT] = {
    [MUKCA_VARIES_LOAD] = "deflection under load",
    [MUKCA_VARIES_SIDE] = "play: differs with the side of the load",
    [MUKCA_VARIES_MOVE] = "depends on the direction of the last move",
    [MUKCA_VARIES_ANGLE] = "varies with the angle of",
    [MUKCA_VARIES_TIME] = "drifts with time",
    [MUKCA_VARIES_PLACEMENT] = "differs between placements"};

/* Alternatives on one line. */
enum { MOST_ALTERNATIVES = 3 };

const char *mukca_wording_position(const mukca_diagnosed *r, int position)
{
    return position < 0                    ? "base"
           : position < r->chain->n_joints ? mukca_chain_joint_name(r->chain, position)
                                           : "tool";
}

int mukca_wording_finding_placement(const mukca_finding *f)
{
    const mukca_finding_group *g = &f->group;
    if (g->apart) return g->from == g->to ? g->from : -1;
    return g->kind == MUKCA_GROUP_DETAIL && !mukca_effect_has(g->effect, MUKCA_TRAIT_ORDERS)
               ? g->low - 1
               : -1;
}

/* " at joint_2", ", base to joint_2"; nothing for the whole arm. */
static void put_place(char *text, const mukca_diagnosed *r, int from, int to)
{
    const int tool = r->chain->n_joints;
    if (from < 0 && to >= tool) return;
    if (from == to)
        put(text, " at %s%s", from < 0 || from >= tool ? "the " : "",
            mukca_wording_position(r, from));
    else
        put(text, ", %s to %s", mukca_wording_position(r, from), mukca_wording_position(r, to));
}

static void put_group(char *text, const mukca_finding *f, const mukca_diagnosed *r)
{
    const mukca_finding_group *g = &f->group;
    const bool noun =
        g->effect >= 0 || g->family == MUKCA_VARIES_LOAD || g->family == MUKCA_VARIES_SIDE;
    if (g->n_finer) put(text, noun ? "further " : "also "); /* beside finer findings */
    const char *joint = g->from == g->to && g->from >= 0 && g->from < r->chain->n_joints
                            ? mukca_chain_joint_name(r->chain, g->from)
                            : NULL;
    if (g->effect >= 0 && (joint || !mukca_effect_has_joint(g->effect))) {
        put(text, "%s",
            mukca_wording_effect(MUKCA_WORDS, (mukca_effect_kind)g->effect,
                                 mukca_effect_has_joint(g->effect) ? joint : NULL));
    } else if (g->effect >= 0) {
        put(text, "%s", mukca_effect_table[g->effect]->title);
        put_place(text, r, g->from, g->to);
    } else if (g->kind == MUKCA_GROUP_PLACE) {
        put(text, "an error of any kind");
        put_place(text, r, g->from, g->to);
    } else if (g->family == MUKCA_VARIES_ANGLE && g->to < r->chain->n_joints && g->from >= 0) {
        put(text, "%s %s%s%s", families[g->family], mukca_wording_position(r, g->from),
            g->from < g->to ? " to " : "", g->from < g->to ? mukca_wording_position(r, g->to) : "");
    } else if (g->family == MUKCA_VARIES_ANGLE) {
        put(text, "varies with the angles");
        put_place(text, r, g->from, g->to);
    } else {
        put(text, "%s", families[g->family]);
        if (!g->apart) put_place(text, r, g->from, g->to);
    }
}

/* ", time constant 300 to 1000 s" */
static void put_time_constant(char *text, const double range[2])
{
    if (isinf(range[0]))
        put(text, ", linear in time");
    else if (range[0] > 0)
        put(text, ", time constant %g", range[0]);
    if (isfinite(range[0]) && range[0] > 0)
        put(text,
            range[0] == range[1] ? " s"
            : isinf(range[1])    ? " s or more"
                                 : " to %g s",
            range[1]);
}

const char *mukca_wording_finding(char text[MUKCA_WORDING], const mukca_finding *f,
                                  const mukca_diagnosed *r)
{
    const int placement = mukca_wording_finding_placement(f), n_placements = r->data->n_placements;
    put_group(text, f, r);
    if (f->order[0] > 0 && f->order[0] == f->order[1]) put(text, ", order %d", f->order[0]);
    if (f->order[0] > 0 && f->order[0] < f->order[1])
        put(text, ", order %d [%d, %d]", f->alternatives[0].effect.variant.order, f->order[0],
            f->order[1]);
    put_time_constant(text, f->time_constant);
    if (placement >= 0)
        put(text, "%s placement %s", f->group.effect < 0 && f->group.apart ? ":" : " in",
            r->data->placements[placement].name);
    const int one = f->n_alternatives ? f->alternatives[0].effect.placement : -1;
    if (f->group.effect >= 0 && !f->group.apart && placement < 0 && one >= 0 && n_placements == 2)
        put(text, ", %s against %s", r->data->placements[one].name,
            r->data->placements[1 - one].name);
    return text;
}

const char *mukca_wording_estimate(char text[MUKCA_WORDING], const mukca_estimate *e, double factor,
                                   const char *prefix, const char *unit, int most)
{
    const double half = fmax(factor * 0.5 * (e->high - e->low), 1e-12);
    int digits = isfinite(half) ? (int)ceil(-log10(half)) + 1 : 3;
    digits = digits < 0 ? 0 : digits > most ? most : digits;
    put(text, "%.*f%s%s", digits, factor * e->value, *unit ? " " : "", prefix);
    for (; *unit; unit++) put(text, *unit == '*' ? "·" : "%c", *unit); /* for people */
    return put(text, " [%.*f, %.*f]", digits, factor * e->low, digits, factor * e->high);
}

static void put_estimate(char *text, const mukca_estimate *e, const mukca_effect *effect,
                         const mukca_diagnosed *r)
{
    const char *unit = mukca_effect_unit(effect, r->chain);
    const bool load = strchr(unit, 'N');
    if (effect->variant.to_command)
        mukca_wording_estimate(text, e, 100, "", "% of command minus reading", 4);
    else
        mukca_wording_estimate(text, e, load ? 1e6 : 1e3, load ? "u" : "m", unit, 4);
}

const char *mukca_wording_sureness(char text[MUKCA_WORDING], const mukca_finding_group *g)
{
    const double p = g->probability;
    const int n = g->n_halves, held = (int)rint(g->halves * n), against = (int)rint(g->against * n);
    put(text, "%s", p > 0.999 && held == n && !g->beside_unknown ? "certain (" : "sure (");
    if (p > 0.999)
        put(text, "> 99.9 %%, ");
    else
        put(text, "%.0f %%, ", floor(100 * p));
    if (held == n)
        put(text, "all halves)");
    else if (held + against >= n)
        put(text, "%d of %d halves)", held, n);
    else if (against)
        put(text, "%d of %d halves, %d against)", held, n, against);
    else
        put(text, "%d of %d halves, none against)", held, n);
    if (g->beside_unknown) put(text, ", or left by a larger cause outside the catalogue");
    return text;
}

const char *mukca_wording_certainty(char text[MUKCA_WORDING], const mukca_finding *f,
                                    const mukca_diagnosed *r)
{
    const mukca_alternative *first = f->alternatives;
    mukca_wording_sureness(text, &f->group);
    if (isfinite(f->coefficient.value)) {
        put(text, "; ");
        put_estimate(text, &f->coefficient, &f->quantity, r);
        if (f->n_alternatives > 1) put(text, " in all");
    } else if (f->n_alternatives && first->listed && isfinite(first->amplitude.value) &&
               f->group.effect >= 0) {
        put(text, "; ");
        put_estimate(text, &first->amplitude, &first->effect, r);
    }
    return text;
}

const char *mukca_wording_alternatives(char text[MUKCA_WORDING], const mukca_finding *f,
                                       const mukca_diagnosed *r)
{
    int n = 0;
    if (f->n_alternatives < 2 && f->group.effect >= 0) return text;
    if (f->order[0] > 0) return text; /* they differ in their orders */
    for (int i = 0; i < f->n_alternatives && n < MOST_ALTERNATIVES; i++) {
        const mukca_alternative *a = &f->alternatives[i];
        put(text, "%s", n++ ? ", " : "");
        if (a->listed) {
            const bool here = f->group.from == f->group.to && !f->group.apart;
            put(text, "%s",
                mukca_wording_effect(
                    MUKCA_WORDS, a->effect.kind,
                    here ? NULL : mukca_chain_joint_name(r->chain, a->effect.joint)));
            if (a->effect.placement >= 0)
                put(text, " in %s", r->data->placements[a->effect.placement].name);
        } else {
            put(text, "outside the catalogue");
            if (f->group.kind == MUKCA_GROUP_PLACE)
                put(text, " (%s)", mukca_varies_name[a->family]);
            if (f->group.from != f->group.to) put_place(text, r, a->from, a->to);
        }
        put(text, " %.0f %%", 100 * a->probability);
    }
    return text;
}

const char *mukca_wording_rest(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const double above = 1.1; /* an error of the mean of a few hundred samples */
    if (!isfinite(d->explained_m) || !isfinite(d->noise_floor_m)) return text;
    put(text, "%.3f mm held out (geometry alone %.3f), ", 1e3 * d->explained_m,
        1e3 * d->geometry_m);
    if (d->explained_m <= above * d->noise_floor_m)
        put(text, "the level of the noise");
    else
        put(text, "%.1f times the noise", d->explained_m / d->noise_floor_m);
    if (isfinite(d->test_geometry_m))
        put(text, "; test %.3f (%.3f)", 1e3 * d->test_explained_m, 1e3 * d->test_geometry_m);
    return text;
}

const char *mukca_wording_verdict(char text[MUKCA_WORDING], const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    const double common = sqrt(d->shared), individual = sqrt(1 - d->shared);
    if (d->verdict == MUKCA_VERDICT_UNTESTABLE)
        return put(text, "Nothing can be tested: %s", d->why);
    if (d->n_findings) {
        put(text, "Found: %s", mukca_wording_finding(MUKCA_WORDS, &d->findings[0], r));
        if (d->n_findings > 1)
            put(text, "; %d further finding%s", d->n_findings - 1, d->n_findings > 2 ? "s" : "");
        return text;
    }
    if (d->verdict == MUKCA_VERDICT_UNKNOWN) {
        mukca_wording_unexplained(text, r);
        text[0] = 'U';
        return text;
    }
    if (d->verdict == MUKCA_VERDICT_TIED)
        return put(text,
                   "Nothing for sure: there is more than noise, and these data do not say what");
    if (common > 2 * individual) /* of a posture's readings */
        return put(text,
                   "Nothing beyond the geometry; readings of a posture agree to %.3f mm, but "
                   "postures differ by %.3f mm: no cause explains it, nor does the noise of the "
                   "readings",
                   1e3 * individual * MUKCA_MEAN_NORM3 * d->sigma_m,
                   1e3 * common * MUKCA_MEAN_NORM3 * d->sigma_m);
    return put(text,
               "Nothing beyond the geometry: the remaining error agrees with the measurement "
               "noise and the uncertainty of the geometry");
}
