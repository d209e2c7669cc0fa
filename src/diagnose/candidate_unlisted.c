/* Causes outside the catalogue as candidates: every function at every place. */
#include <math.h>

#include "diagnose/candidates.h"

enum {
    MOST_SLIPS = 64, /* slips tried per joint: half a step off, a slip in mid-recording loses at
                        most 3 % of its evidence */
    SLIP_ROWS = 3,   /* before and after it: else a few outliers */
    COMPARED_ROWS = 64
};

/* Square of the sine between functions that are the same: of single precision, with a margin. */
#define SAME 1e-6
/* Least range of a joint, rad or m: a smaller one shows no function of its angle. */
#define LEAST_RANGE 0.1

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

typedef struct {
    mukca_candidates *all;
    const mukca_unknowns *unknowns;
    const mukca_unlisted_function *function;
} lister;

/* Append a function with each of n measures. */
static void append_measures(const lister *l, mukca_candidate h, const double *measure, int n)
{
    for (int i = 0; i < n; i++) {
        h.unlisted.measure = measure[i];
        mukca_candidates_append(l->all, h);
    }
}

/* Append a function with each of its measures or placements. */
static void append_variants(const lister *l, mukca_candidate h)
{
    static const double widths[] = {0.03, 0.06, 0.12, 0.25, 0.5, 1}; /* rad */
    static const double time_constants[] = {300, 1000, 3000};        /* s, as of joint_drift */
    static const double torques[] = {0.3, 1, 3};                     /* N m, as of backlash */
    static const double once = 1; /* higher orders are listed where they promise */
    const mukca_recording *r = l->all->recording;
    const int rows = r->data->n_rows, placements = r->data->n_placements, *socket = r->data->socket;
    const double range = l->all->survey.joint[h.joint < 0 ? 0 : h.joint].range;
    const mukca_argument argument = l->function->argument;
    if (l->function->shape == MUKCA_SHAPE_BUMPS && argument == MUKCA_ARGUMENT_ANGLE) {
        for (int i = 0; l->all->survey.joint[h.joint].turns && i < COUNT(widths); i++)
            if (widths[i] <= 0.6 * range && ceil(range / widths[i]) + 1 <= MUKCA_MOST_TERMS)
                append_measures(l, h, &widths[i], 1);
    } else if (l->function->shape == MUKCA_SHAPE_STEP) {
        /* in the last socket, it is equivalent to a moved socket: tool_motion */
        int end = rows - SLIP_ROWS;
        while (end > 0 && socket[end - 1] >= 0 && socket[end - 1] == socket[rows - 1]) end--;
        for (int row = SLIP_ROWS; row < end; row += rows / MOST_SLIPS + 1)
            append_measures(l, h, &(double){row}, 1);
    } else if (l->function->shape == MUKCA_SHAPE_SIDE && argument == MUKCA_ARGUMENT_TORQUE) {
        append_measures(l, h, torques, COUNT(torques));
    } else if (l->function->shape == MUKCA_SHAPE_SATURATING) {
        append_measures(l, h, time_constants, COUNT(time_constants));
    } else if (l->function->shape == MUKCA_SHAPE_WAVE) {
        append_measures(l, h, &once, 1);
    } else if (argument == MUKCA_ARGUMENT_PLACEMENT || argument == MUKCA_ARGUMENT_PAYLOAD) {
        h.placement = argument == MUKCA_ARGUMENT_PAYLOAD ? -1 : 0;
        for (; h.placement < (placements > 1 ? placements : 0); h.placement++)
            mukca_candidates_append(l->all, h);
    } else {
        mukca_candidates_append(l->all, h);
    }
}

/* Has the recording what the function at this place needs? */
static bool is_testable(const lister *l, const mukca_candidate *h)
{
    const mukca_recording *r = l->all->recording;
    const mukca_unknowns *u = l->unknowns;
    const mukca_argument argument = l->function->argument;
    if (h->unlisted.place == MUKCA_PLACE_TURN && h->unlisted.slot + 1 == u->n_slots &&
        u->slot_width < 6)
        return false;
    if (argument == MUKCA_ARGUMENT_MOMENT || argument == MUKCA_ARGUMENT_ACROSS)
        return r->have_moments;
    if (argument == MUKCA_ARGUMENT_PAYLOAD) return r->have_torques && r->n_bodies;
    if (argument == MUKCA_ARGUMENT_ROW) /* a slip of the first joint is a moved socket */
        return u->slot_element[0] <= r->chain->joint_element[h->joint];
    if ((argument == MUKCA_ARGUMENT_TORQUE || l->function->shape == MUKCA_SHAPE_RUBBING) &&
        !r->have_torques)
        return false;
    return argument == MUKCA_ARGUMENT_TILT || h->unlisted.argument < 0 ||
           l->all->survey.joint[h->unlisted.argument].range >= LEAST_RANGE;
}

/* Append a function at a place, with each of its arguments. */
static void append_arguments(const lister *l, mukca_candidate h)
{
    const int n = l->all->recording->chain->n_joints;
    const bool others = l->function->joints != MUKCA_OF_ITSELF;
    if (l->function->argument == MUKCA_ARGUMENT_TIME || l->function->argument == MUKCA_ARGUMENT_ROW)
        h.unlisted.argument = -1;
    for (int k = 0; k < (others ? n : 1); k++) {
        if (others) h.unlisted.argument = k;
        if (l->function->joints == MUKCA_OF_OTHERS && k == h.joint) continue;
        if (is_testable(l, &h)) append_variants(l, h);
    }
}

/* Append a function at each joint, frame or axis of a place. */
static void append_at(const lister *l, mukca_candidate h)
{
    const mukca_recording *r = l->all->recording;
    const int n = r->chain->n_joints;
    switch (h.unlisted.place) {
        case MUKCA_PLACE_ANGLE:
        case MUKCA_PLACE_LINK:
            for (int j = 0; j < n; j++) {
                h.joint = h.unlisted.argument = j;
                append_arguments(l, h);
            }
            break;
        case MUKCA_PLACE_SHIFT:
        case MUKCA_PLACE_TURN:
            for (int slot = 0; slot < l->unknowns->n_slots; slot++) {
                const int joint = r->chain->element[l->unknowns->slot_element[slot]].joint;
                h.unlisted.slot = slot;
                h.joint = h.unlisted.argument = joint < 0 ? n - 1 : joint;
                append_arguments(l, h);
            }
            break;
        case MUKCA_PLACE_SOCKET:
        case MUKCA_PLACE_TOOL:
            h.joint = n - 1;
            for (int axis = 0; axis < 3; axis++) {
                h.unlisted.argument = axis;
                append_arguments(l, h);
            }
            break;
        case MUKCA_PLACE_DISTANCE:
            for (int p = 0; p < r->n_pairs; p++) {
                h.placement = r->groups[r->pairs[p].a].placement;
                mukca_candidates_append(l->all, h);
            }
            break;
        default:
            append_arguments(l, h);
    }
}

/* Are the functions of an effect and of another candidate the same, but for constants? */
static bool is_same(const mukca_candidate *e, const mukca_candidate *h, int rows)
{
    const size_t step = (size_t)rows / COMPARED_ROWS + 1, width = (size_t)h->width_of_term,
                 le = (size_t)e->terms * width, lh = (size_t)h->terms * width;
    for (size_t term = 0; term < (size_t)h->terms; term++) {
        double aa = 0, ab = 0, bb = 0;
        for (size_t i = term * width; i < (term + 1) * width; i++)
            for (size_t row = step; row < (size_t)rows; row += step) {
                const double x = (double)(e->basis[row * le + i] - e->basis[i]),
                             y = (double)(h->basis[row * lh + i] - h->basis[i]);
                aa += x * x, ab += x * y, bb += y * y;
            }
        if (!(ab * ab > (1 - SAME) * aa * bb && aa > 0)) return false;
    }
    return true;
}

void mukca_candidates_drop_listed(mukca_candidates *all)
{
    int kept = 0;
    for (int i = 0; i < all->count; i++) {
        const mukca_candidate *h = &all->list[i];
        bool listed = false;
        const mukca_candidate *e = all->list; /* the effects come first */
        for (; h->kind == MUKCA_CANDIDATE_UNLISTED && h->basis && !listed &&
               e->kind == MUKCA_CANDIDATE_EFFECT;
             e++)
            listed = e->joint == h->joint && e->basis && mukca_candidate_own_terms(e) == h->terms &&
                     mukca_candidate_site(e) == mukca_candidate_site(h) &&
                     is_same(e, h, all->recording->data->n_rows);
        if (!listed) all->list[kept++] = *h;
    }
    all->count = kept;
}

void mukca_candidates_append_unlisted(mukca_candidates *all, const mukca_unknowns *unknowns)
{
    for (int f = 0; f < MUKCA_UNLISTED_FUNCTIONS; f++)
        for (int place = 0; place < MUKCA_PLACES; place++) {
            const lister l = {all, unknowns, &mukca_unlisted_functions[f]};
            if (l.function->places >> place & 1)
                append_at(&l, (mukca_candidate){.kind = MUKCA_CANDIDATE_UNLISTED,
                                                .joint = -1,
                                                .placement = -1,
                                                .unlisted = {.function = f,
                                                             .place = (mukca_unlisted_place)place,
                                                             .argument = -1}});
        }
}
