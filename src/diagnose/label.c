/* Labels of candidates. */
#include <math.h>

#include "diagnose/label.h"

/* Families of the arguments of unlisted causes. */
static const mukca_varies families[] = {[MUKCA_ARGUMENT_ANGLE] = MUKCA_VARIES_ANGLE,
                                        [MUKCA_ARGUMENT_WAVE] = MUKCA_VARIES_ANGLE,
                                        [MUKCA_ARGUMENT_HALF] = MUKCA_VARIES_ANGLE,
                                        [MUKCA_ARGUMENT_LOAD] = MUKCA_VARIES_LOAD,
                                        [MUKCA_ARGUMENT_SIDE] = MUKCA_VARIES_SIDE,
                                        [MUKCA_ARGUMENT_SOFTENING] = MUKCA_VARIES_LOAD,
                                        [MUKCA_ARGUMENT_MOVE] = MUKCA_VARIES_MOVE,
                                        [MUKCA_ARGUMENT_LAG] = MUKCA_VARIES_MOVE,
                                        [MUKCA_ARGUMENT_RUBBING] = MUKCA_VARIES_MOVE,
                                        [MUKCA_ARGUMENT_CREEP] = MUKCA_VARIES_LOAD,
                                        [MUKCA_ARGUMENT_WEARING] = MUKCA_VARIES_MOVE,
                                        [MUKCA_ARGUMENT_TIME] = MUKCA_VARIES_TIME,
                                        [MUKCA_ARGUMENT_PAYLOAD] = MUKCA_VARIES_LOAD,
                                        [MUKCA_ARGUMENT_PLACEMENT] = MUKCA_VARIES_PLACEMENT,
                                        [MUKCA_ARGUMENT_MOMENT] = MUKCA_VARIES_LOAD,
                                        [MUKCA_ARGUMENT_TIPPING] = MUKCA_VARIES_SIDE,
                                        [MUKCA_ARGUMENT_SEASON] = MUKCA_VARIES_TIME};

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
    l->family = (int)families[h->of.argument];
    l->from = l->to = h->joint;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME)
        l->from = l->to = frame_position(r, u, h->of.slot);
    if (l->family == MUKCA_VARIES_ANGLE && h->of.joint >= 0) l->from = l->to = h->of.joint;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED_BASE) l->from = l->to = MUKCA_POSITION_BASE;
    if (h->kind == MUKCA_CANDIDATE_UNLISTED_TILT) l->from = l->to = r->chain->n_joints;
    l->apart = h->kind == MUKCA_CANDIDATE_UNLISTED_PAIR;
    if (!l->apart) return;
    l->family = MUKCA_VARIES_PLACEMENT;
    l->from = l->to = h->placement;
}

mukca_label mukca_candidate_label(const mukca_candidate *h, const mukca_recording *r,
                                  const mukca_unknowns *u)
{
    mukca_label l = {.effect = -1 - (int)h->kind};
    if (mukca_candidate_class(h) < MUKCA_EFFECT_COUNT) {
        label_effect(&l, h, r);
    } else if (mukca_candidate_is_unlisted(h)) {
        label_unlisted(&l, h, r, u);
    } else {
        const bool angle = h->kind <= MUKCA_CANDIDATE_ANGLE_PRODUCT;
        l.family = angle ? MUKCA_VARIES_ANGLE : MUKCA_VARIES_TIME;
        l.from = l.to = angle ? h->of.joint : h->joint;
    }
    return l;
}
