/* The wording of findings of a motion: what the torque varies with, where, how large, how sure. */
#include "report/wording_motion.h"

#include <math.h>
#include <string.h>

#define put mukca_wording_put /* short for this file */

/* What each family is called, before its place. */
static const char *const families[MUKCA_TORQUE_FAMILIES] = {
    [MUKCA_TORQUE_GRAVITY] = "mass",
    [MUKCA_TORQUE_ACCELERATION] = "torque that varies with the acceleration",
    [MUKCA_TORQUE_DIRECTION] = "friction that depends on the direction",
    [MUKCA_TORQUE_VELOCITY] = "torque that varies with the velocity",
    [MUKCA_TORQUE_LOAD] = "friction that grows with the load",
    [MUKCA_TORQUE_ANGLE] = "torque that varies with the angle",
    [MUKCA_TORQUE_TIME] = "torque that drifts with time",
    [MUKCA_TORQUE_SHIFT] = "torques later or earlier than the angles",
    [MUKCA_TORQUE_TORQUE] = "scale or zero of the torque"};

enum { MOST_ALTERNATIVES = 3 };

const char *mukca_wording_runs(char text[MUKCA_WORDING], const mukca_motion *m)
{
    put(text, "%d run%s, %.0f s of motion", m->n_runs, m->n_runs == 1 ? "" : "s", m->seconds);
    if (m->n_reference) put(text, "; reference: %d", m->n_reference);
    if (m->n_test) put(text, "; test: %d", m->n_test);
    return text;
}

bool mukca_wording_torque_on_links(const mukca_finding_group *g)
{
    return g->effect >= 0 ? mukca_torque_table[g->effect].links
                          : g->family == MUKCA_TORQUE_GRAVITY || g->kind == MUKCA_GROUP_TIE;
}

const char *mukca_wording_torque_position(const mukca_chain *chain, bool link, int position)
{
    return link ? chain->element[chain->joint_element[position]].child
                : mukca_chain_joint_name(chain, position);
}

static void put_place(char *text, bool links, int from, int to, const mukca_chain *chain)
{
    if (from < 0)
        put(text, " of all joints alike");
    else if (from == to)
        put(text, " at %s", mukca_wording_torque_position(chain, links, from));
    else
        put(text, " at %s %s to %s", links ? "links" : "joints",
            mukca_wording_torque_position(chain, links, from),
            mukca_wording_torque_position(chain, links, to));
}

const char *mukca_wording_torque(char text[MUKCA_WORDING], const mukca_finding_group *g,
                                 const mukca_chain *chain)
{
    const bool tie = g->kind == MUKCA_GROUP_TIE;
    put(text, "%s%s", g->n_finer ? "further " : "", /* beside finer findings */
        g->effect >= 0   ? mukca_torque_table[g->effect].title
        : g->family >= 0 ? families[g->family]
        : tie            ? "mass"
                         : "torque of any kind");
    put_place(text, tie || mukca_wording_torque_on_links(g), g->apart ? -1 : g->from, g->to, chain);
    if (tie) {
        put(text, ", or torque gain");
        put_place(text, false, g->from, g->to, chain);
    }
    if (g->kind == MUKCA_GROUP_DETAIL && g->low < g->high)
        put(text, ", orders %d to %d", g->low > 1 ? g->low : 1, g->high);
    else if (g->kind == MUKCA_GROUP_DETAIL)
        put(text, ", order %d", g->low);
    return text;
}

const char *mukca_wording_torque_certainty(char text[MUKCA_WORDING], const mukca_motion_finding *f)
{
    mukca_wording_sureness(text, &f->group);
    if (!isfinite(f->coefficient.value)) return text;
    const char *unit = mukca_torque_table[f->group.effect].unit;
    const bool time = strcmp(unit, "s") == 0, none = strcmp(unit, "1") == 0;
    put(text, "; ");
    return mukca_wording_estimate(text, &f->coefficient, time ? 1e3 : 1, time ? "m" : "",
                                  none ? "" : unit, 6);
}

const char *mukca_wording_torque_alternatives(char text[MUKCA_WORDING],
                                              const mukca_motion_finding *f,
                                              const mukca_chain *chain)
{
    int outside = 0;
    if (f->n_alternatives < 2) return text;
    for (int i = 0; i < f->n_alternatives && i < MOST_ALTERNATIVES; i++) {
        const mukca_motion_alternative *a = &f->alternative[i];
        const bool listed = a->effect >= 0, one_place = f->group.from == f->group.to;
        if (!listed && one_place && !f->group.apart && outside++) continue; /* said */
        put(text, "%s%s", i ? ", " : "",
            listed ? mukca_torque_table[a->effect].title : "outside the catalogue");
        if (!one_place || f->group.apart)
            put_place(text,
                      listed ? mukca_torque_table[a->effect].links
                             : mukca_wording_torque_on_links(&f->group),
                      a->all ? -1 : a->from, a->to, chain);
        put(text, " %.0f %%", 100 * a->probability);
    }
    return text;
}
