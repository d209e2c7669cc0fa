/* Simple causes that nobody listed: the rivals of a name when its probability is computed.
 *
 * The catalogue is not complete.  What it lacks is, as what it has, mostly a simple function of one
 * argument that acts at one place.  So every argument that an arm has is tried at every place: the
 * angle of a joint (linear, and once per turn), its load (linear, and its side), its last move,
 * time, and the placement; at the angle of each joint and at each frame, which shifts or turns.
 * These candidates are never accepted.  They share the probability of a name that they could
 * replace.
 */
#include "diagnose/unlisted.h"

#include <math.h>

static int values_of(mukca_argument argument)
{
    return argument == MUKCA_ARGUMENT_WAVE ? 2 : 1;
}

int mukca_unlisted_terms(const mukca_candidate *h)
{
    return values_of(h->simple.argument) * (h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME ? 3 : 1);
}

/* The argument's functions at a row. */
static void evaluate(double value[2], const mukca_candidate *h, const mukca_recording *r, int row)
{
    const mukca_joint_state state = mukca_recording_state(r, row);
    const int j = h->simple.other;
    switch (h->simple.argument) {
        case MUKCA_ARGUMENT_ANGLE:
            value[0] = state.q[j];
            break;
        case MUKCA_ARGUMENT_WAVE:
            value[0] = sin(state.q[j]);
            value[1] = cos(state.q[j]);
            break;
        case MUKCA_ARGUMENT_LOAD:
            value[0] = state.torque[j];
            break;
        case MUKCA_ARGUMENT_SIDE: /* 1 N m and 20 mrad: as of backlash and hysteresis */
            value[0] = tanh(state.torque[j]);
            break;
        case MUKCA_ARGUMENT_MOVE:
            value[0] = tanh(state.move[j] / 0.02);
            break;
        case MUKCA_ARGUMENT_TIME:
            value[0] = state.time;
            break;
        case MUKCA_ARGUMENT_PLACEMENT:
            value[0] = state.placement == h->placement;
            break;
    }
}

void mukca_unlisted_fill(const mukca_candidate *h, const mukca_recording *r)
{
    const int n = values_of(h->simple.argument), axes = h->terms / n;
    for (int row = 0; row < r->data->n_rows; row++) {
        double value[2];
        evaluate(value, h, r, row);
        for (int t = 0; t < h->terms; t++) h->basis[row * h->terms + t] = (float)value[t / axes];
    }
}
