/* Simple causes outside the catalogue.
 *
 * The catalogue is incomplete.  A missing cause, like most listed ones, is a simple function of one
 * argument, and acts on one joint or frame.  Therefore every argument is tried at every joint angle
 * and at every frame, as a shift or a rotation.  The arguments: angle of a joint (linear, once per
 * turn, half of the travel), its load (linear, sign, times time, torque of an unknown payload), its
 * last move (direction, also times load or a decay; length), time, placement, and for frames the
 * moment, as of a link that bends along its length.  A ball that is not round or not held by its
 * socket, and a tool that rattles, move with the tilt of the tool.  The one distance of a placement
 * may be wrong for any reason: a single number distinguishes no causes.  They share the probability
 * of a name that they could replace.
 */
#include <math.h>
#include <string.h>

#include "diagnose/candidate.h"

static int values_of(mukca_argument argument)
{
    return argument == MUKCA_ARGUMENT_WAVE || argument == MUKCA_ARGUMENT_WEARING ? 2
           : argument == MUKCA_ARGUMENT_MOMENT                                   ? 3
                                                                                 : 1;
}

int mukca_unlisted_terms(const mukca_candidate *h)
{
    return values_of(h->of.argument) * (h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME ? 3 : 1);
}

/* Functions of the argument at a row of the dataset; `middle` of the joint's travel. */
static void evaluate(double value[3], const mukca_candidate *h, const mukca_recording *r, int row,
                     double middle)
{
    const mukca_joint_state state = mukca_recording_state(r, row);
    const int j = h->of.joint;
    switch (h->of.argument) {
        case MUKCA_ARGUMENT_ANGLE:
            value[0] = state.q[j];
            break;
        case MUKCA_ARGUMENT_WAVE:
            value[0] = sin(state.q[j]);
            value[1] = cos(state.q[j]);
            break;
        case MUKCA_ARGUMENT_HALF:
            value[0] = state.q[j] > middle ? 1 : -1;
            break;
        case MUKCA_ARGUMENT_LOAD:
            value[0] = state.torque[j];
            break;
        case MUKCA_ARGUMENT_SIDE: /* 1 N m and 20 mrad: as of backlash and hysteresis */
            value[0] = tanh(state.torque[j]);
            break;
        case MUKCA_ARGUMENT_SOFTENING:
            value[0] = state.torque[j] * state.time;
            break;
        case MUKCA_ARGUMENT_PAYLOAD:
            value[0] = h->placement < 0 || state.placement == h->placement
                           ? r->torque[((row + 1) * r->n_bodies - 1) * r->chain->n_joints + j]
                           : 0;
            break;
        case MUKCA_ARGUMENT_MOVE:
            value[0] = tanh(state.move[j] / 0.02);
            break;
        case MUKCA_ARGUMENT_LAG:
            value[0] = state.move[j];
            break;
        case MUKCA_ARGUMENT_RUBBING:
            value[0] = tanh(state.move[j] / 0.02) * fabs(state.torque[j]);
            break;
        case MUKCA_ARGUMENT_WEARING: /* 300 and 3000 s: as of joint_drift */
            value[0] = tanh(state.move[j] / 0.02) * exp(-state.time / 300);
            value[1] = tanh(state.move[j] / 0.02) * exp(-state.time / 3000);
            break;
        case MUKCA_ARGUMENT_TIME:
            value[0] = state.time;
            break;
        case MUKCA_ARGUMENT_PLACEMENT:
            value[0] = state.placement == h->placement;
            break;
        case MUKCA_ARGUMENT_MOMENT:
            memcpy(value, state.moment[j], sizeof state.moment[j]);
            break;
    }
}

void mukca_unlisted_fill(const mukca_candidate *h, const mukca_recording *r)
{
    const int n = values_of(h->of.argument), axes = h->terms / n;
    double travel[2];
    mukca_recording_travel(travel, r, h->of.joint);
    for (int row = 0; row < r->data->n_rows; row++) {
        double value[3];
        evaluate(value, h, r, row, 0.5 * (travel[0] + travel[1]));
        for (int t = 0; t < h->terms; t++) h->basis[row * h->terms + t] = (float)value[t / axes];
    }
}

/* v: vertical component of an axis of the tip.  In the tool: a shift to either side, by the sign of
 * v.  In the socket: upwards by v and v^2, as by an oval ball or its neck on the rim, and along the
 * axis by v. */
void mukca_unlisted_tilt(double *out, int ld, const mukca_candidate *h, const double *R,
                         const double gravity[3])
{
    const double g = fmax(sqrt(mukca_dot3(gravity, gravity)), 1e-9);
    const int k = h->of.joint;
    double v = 0;
    for (int c = 0; c < 3; c++) v -= R[3 * c + k] * gravity[c] / g;
    for (int c = 0; c < 3; c++, out += ld) {
        if (h->of.turns) {
            for (int t = 0; t < 3; t++) out[t] = v > 0 ? R[3 * c + t] : -R[3 * c + t];
            continue;
        }
        out[0] = -gravity[c] / g * v;
        out[1] = out[0] * v;
        out[2] = R[3 * c + k] * v;
    }
}
