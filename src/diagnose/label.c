/* Labels of candidates. */
#include <math.h>

#include "diagnose/findings.h"

/* Position of a frame of the geometry: of its joint, or the tool. */
static int frame_position(const mukca_recording *r, const mukca_unknowns *u, int slot)
{
    const int joint = r->chain->element[u->slot_element[slot]].joint;
    return joint < 0 ? r->chain->n_joints : joint;
}

static void label_effect(mukca_label *l, const mukca_candidate *h, const mukca_recording *r)
{
    const mukca_effect effect = mukca_candidate_effect(h);
    const int site = mukca_candidate_site(h), tool = r->chain->n_joints;
    double range[2];
    l->effect = (int)effect.kind;
    l->family = (int)mukca_effect_table[effect.kind]->varies_with;
    l->from = l->to = h->joint + effect.variant.neighbour; /* the joint whose angle it is */
    if (site == MUKCA_SITE_BASE) l->from = l->to = MUKCA_POSITION_BASE;
    if (site == MUKCA_SITE_TIP) l->from = l->to = tool;
    if (site == MUKCA_SITE_ANGLES) l->from = MUKCA_POSITION_BASE, l->to = tool;
    l->apart = site == MUKCA_SITE_SOCKET || site == MUKCA_SITE_DISTANCE;
    if (l->apart) l->from = l->to = h->placement;
    /* of two placements only the difference is known */
    if (!l->apart && h->placement >= 0 && r->data->n_placements > 2) l->detail = h->placement + 1;
    if (!mukca_effect_has(l->effect, MUKCA_TRAIT_ORDERS)) return;
    mukca_recording_travel(range, r, h->joint);
    l->detail = effect.variant.order;
    l->fine = l->detail > MUKCA_LONG_ORDER;
    l->blur = (int)fmax(ceil(2 * M_PI / fmax(range[1] - range[0], MUKCA_WAVE_TRAVEL)) - 1, 0);
}

static void label_unlisted(mukca_label *l, const mukca_candidate *h, const mukca_recording *r,
                           const mukca_unknowns *u)
{
    const mukca_unlisted_function *f = &mukca_unlisted_functions[h->unlisted.function];
    const int at[MUKCA_PLACES] = {[MUKCA_PLACE_ANGLE] = h->joint,
                                  [MUKCA_PLACE_LINK] = h->joint,
                                  [MUKCA_PLACE_SHIFT] = frame_position(r, u, h->unlisted.slot),
                                  [MUKCA_PLACE_TURN] = frame_position(r, u, h->unlisted.slot),
                                  [MUKCA_PLACE_BASE] = MUKCA_POSITION_BASE,
                                  [MUKCA_PLACE_SOCKET] = r->chain->n_joints,
                                  [MUKCA_PLACE_TOOL] = r->chain->n_joints,
                                  [MUKCA_PLACE_DISTANCE] = h->placement};
    l->family = (int)f->varies_with;
    l->apart = h->unlisted.place == MUKCA_PLACE_DISTANCE;
    if (h->unlisted.place == MUKCA_PLACE_ANGLES) {
        l->from = MUKCA_POSITION_BASE, l->to = r->chain->n_joints;
        return;
    }
    l->from = l->to =
        f->argument == MUKCA_ARGUMENT_ANGLE ? h->unlisted.argument : at[h->unlisted.place];
}

mukca_label mukca_candidate_label(const mukca_candidate *h, const mukca_recording *r,
                                  const mukca_unknowns *u)
{
    mukca_label l = {.effect = -1};
    if (h->kind == MUKCA_CANDIDATE_UNLISTED)
        label_unlisted(&l, h, r, u);
    else
        label_effect(&l, h, r);
    return l;
}
