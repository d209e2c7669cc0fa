/* Simple causes outside the catalogue.
 *
 * The catalogue is incomplete.  A missing cause, like most listed ones, is a simple function of one
 * argument, and acts on one joint or frame.  Therefore every argument is tried at every joint
 * angle, at every frame, as a shift or a rotation, and at the base (docs/method.md, section 10,
 * lists arguments and places).  The one distance of a placement may be wrong for any reason: a
 * single number distinguishes no causes.  They share the probability of a name that they could
 * replace.
 */
#include <math.h>
#include <string.h>

#include "diagnose/candidate.h"

enum { MOST_VALUES = 16 };

/* Functions of an argument, where there are more than one.  SEASON: bumps over the recording, three
 * for a wave of a fifth of it. */
static const int values[] = {[MUKCA_ARGUMENT_WAVE] = 2,    [MUKCA_ARGUMENT_CREEP] = 2,
                             [MUKCA_ARGUMENT_WEARING] = 2, [MUKCA_ARGUMENT_MOMENT] = 3,
                             [MUKCA_ARGUMENT_TIPPING] = 3, [MUKCA_ARGUMENT_SEASON] = MOST_VALUES};

static int values_of(mukca_argument argument)
{
    return values[argument] ? values[argument] : 1;
}

int mukca_unlisted_terms(const mukca_candidate *h)
{
    return values_of(h->of.argument) * (h->kind == MUKCA_CANDIDATE_UNLISTED_ANGLE ? 1 : 3);
}

/* What the functions of an argument need to know of the whole recording. */
typedef struct {
    double travel[2], time[2]; /* ranges of the joint's angle and of time */
    double mean[3], spread[3]; /* of the moment */
    double axis[3];            /* BASE: of the first joint, if it turns */
    double late[2], seconds;   /* CREEP: delayed loads and time of the row before */
} survey;

/* Time constants of CREEP, s: as of polymer gears and rubber buffers. */
static const double delays[2] = {30, 100};

/* Axis of the first joint in the base frame: a turn of the base about it is one of the joint. */
static void find_axis(double axis[3], const mukca_chain *chain)
{
    const int first = chain->joint_element[0];
    if (!mukca_joint_turns(chain->element[first].type)) return;
    memcpy(axis, chain->element[first].axis, 3 * sizeof *axis);
    for (int k = first; k >= 0; k--) {
        double R[9], x[3] = {axis[0], axis[1], axis[2]};
        mukca_rotation_from_rpy(R, chain->element[k].rpy);
        mukca_mat3_vec(axis, R, x);
    }
}

static void survey_rows(survey *s, const mukca_candidate *h, const mukca_recording *r)
{
    const int j = h->of.joint, n = r->chain->n_joints, rows = r->data->n_rows;
    const bool base = h->kind == MUKCA_CANDIDATE_UNLISTED_BASE;
    const double *moment = base ? r->total_base : r->total_moment + 3 * j;
    const int stride = base ? 3 : 3 * n;
    *s = (survey){.seconds = HUGE_VAL};
    if (base) find_axis(s->axis, r->chain);
    mukca_recording_travel(s->travel, r, j);
    mukca_recording_range(s->time, r, r->time, 1, 0);
    for (int k = 0; k < 3 && r->have_moments; k++) {
        for (int row = 0; row < rows; row++) s->mean[k] += moment[stride * row + k] / rows;
        for (int row = 0; row < rows; row++)
            s->spread[k] += pow(moment[stride * row + k] - s->mean[k], 2) / rows;
        s->spread[k] = sqrt(s->spread[k]) + 1e-9;
    }
}

/* The load as an elastic body with a delay sees it, which starts at rest with the file. */
static void delay(double value[2], survey *s, const mukca_recording *r, int row, double load)
{
    const double passed = r->time[row] - s->seconds;
    for (int k = 0; k < 2; k++) {
        if (passed >= 0)
            s->late[k] += (1 - exp(-passed / delays[k])) * (load - s->late[k]);
        else
            s->late[k] = load;
        value[k] = s->late[k];
    }
    s->seconds = r->time[row];
}

/* Moment on the base, or about the joint's origin; zero without masses. */
static const double *moment_of(const mukca_candidate *h, const mukca_joint_state *state)
{
    static const double none[3] = {0};
    const double *moment = h->kind == MUKCA_CANDIDATE_UNLISTED_BASE ? state->base_moment
                           : state->moment                          ? state->moment[h->of.joint]
                                                                    : NULL;
    return moment ? moment : none;
}

/* Functions of the argument at a row of the dataset. */
static void evaluate(double value[MOST_VALUES], const mukca_candidate *h, const mukca_recording *r,
                     int row, survey *s)
{
    const mukca_joint_state state = mukca_recording_state(r, row);
    const int j = h->of.joint;
    const double middle = 0.5 * (s->travel[0] + s->travel[1]), *moment = moment_of(h, &state);
    switch (h->of.argument) {
        case MUKCA_ARGUMENT_ANGLE:
            value[0] = state.q[j];
            break;
        case MUKCA_ARGUMENT_WAVE: {
            const double turn =
                mukca_joint_turns(r->chain->element[r->chain->joint_element[j]].type)
                    ? state.q[j]
                    : 2 * M_PI * (state.q[j] - middle) / fmax(s->travel[1] - s->travel[0], 1e-9);
            value[0] = sin(turn);
            value[1] = cos(turn);
            break;
        }
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
        case MUKCA_ARGUMENT_CREEP:
            delay(value, s, r, row, state.torque[j]);
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
            memcpy(value, moment, 3 * sizeof *moment);
            break;
        case MUKCA_ARGUMENT_TIPPING:
            for (int k = 0; k < 3; k++)
                value[k] = tanh(2 * (moment[k] - s->mean[k]) / s->spread[k]);
            break;
        case MUKCA_ARGUMENT_SEASON:
            for (int k = 0; k < MOST_VALUES; k++) {
                const double u = (state.time - s->time[0]) / fmax(s->time[1] - s->time[0], 1e-9);
                value[k] = exp(-0.5 * pow(u * (MOST_VALUES - 1) - k, 2));
            }
            break;
    }
}

void mukca_unlisted_fill(const mukca_candidate *h, const mukca_recording *r)
{
    const int axes = h->terms / values_of(h->of.argument), width = h->width_of_term;
    survey s;
    survey_rows(&s, h, r);
    for (int row = 0; row < r->data->n_rows; row++) {
        double value[MOST_VALUES];
        evaluate(value, h, r, row, &s);
        for (int t = 0; t < h->terms; t++)
            for (int i = 0; i < width; i++)
                h->basis[(row * h->terms + t) * width + i] =
                    (float)(value[t / axes] *
                            (width == 1 ? 1 : (i == t % 3) - s.axis[i] * s.axis[t % 3]));
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
