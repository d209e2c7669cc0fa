/* Causes outside the catalogue: functions of an argument, of one shape, at one place.
 *
 * The catalogue is incomplete.  A missing cause, like most listed ones, is a function of one
 * argument, and acts on one joint or frame.  Therefore every argument is tried at every joint
 * angle, at every frame, as a shift or a rotation, and at the base: first with simple shapes, then
 * with any smooth one.  The one distance of a placement may be wrong for any reason: a single
 * number distinguishes no causes.  They share the probability of a name that they could replace.
 */
#include <math.h>
#include <string.h>

#include "diagnose/candidate.h"

/* Root of the summed squares of Gaussian bumps one width apart, pi^(1/4): divided by it, a function
 * with independent coefficients has their standard deviation. */
#define BUMP_NORM 1.33
/* 20 mrad: as of backlash and hysteresis. */
#define MOVE_WIDTH 0.02

enum {
    POWERS = 4, /* Chebyshev polynomials of another joint's angle, degree 1 to 4 */
    PRODUCT_DEGREE = 3,
    PRODUCTS = (PRODUCT_DEGREE + 1) * (PRODUCT_DEGREE + 2) / 2 - 1,
    JOINT_BUMPS = 10, /* over the whole recording */
    BASE_BUMPS = 16,  /* the same: three for a wave of a fifth of it, as of a stand in a room */
    ANGLE = 1 << MUKCA_PLACE_ANGLE,
    ANGLES = 1 << MUKCA_PLACE_ANGLES,
    LINK = 1 << MUKCA_PLACE_LINK,
    SHIFT = 1 << MUKCA_PLACE_SHIFT,
    TURN = 1 << MUKCA_PLACE_TURN,
    BASE = 1 << MUKCA_PLACE_BASE,
    SEAT = 1 << MUKCA_PLACE_SOCKET | 1 << MUKCA_PLACE_TOOL,
    DISTANCE = 1 << MUKCA_PLACE_DISTANCE
};

#define ROW(argument, shape, values, places, family, joints)                                   \
    {                                                                                          \
        MUKCA_ARGUMENT_##argument, MUKCA_SHAPE_##shape, values, places, MUKCA_VARIES_##family, \
            MUKCA_OF_##joints                                                                  \
    }

/* The masses' spread covers the loads of other joints; friction acts on its own joint. */
const mukca_unlisted_function mukca_unlisted_functions[MUKCA_UNLISTED_FUNCTIONS] = {
    ROW(ANGLE, BUMPS, 0, ANGLE, ANGLE, ITSELF),
    ROW(ANGLE, POWERS, POWERS, ANGLE, ANGLE, OTHERS),
    ROW(ANGLE, PRODUCTS, PRODUCTS, ANGLE, ANGLE, OTHERS),
    ROW(TIME, BUMPS, JOINT_BUMPS, ANGLE, TIME, ITSELF),
    ROW(ROW, STEP, 1, ANGLE, TIME, ITSELF),
    ROW(TIME, SATURATING, 1, SHIFT, TIME, ITSELF),
    ROW(ANGLE, LINEAR, 1, ANGLE, ANGLE, ANY),
    ROW(ANGLE, WAVE, 2, ANGLE, ANGLE, ANY),
    ROW(ANGLE, SIDE, 1, ANGLE, ANGLE, ANY),
    ROW(ANGLE, WAVE, 2, SHIFT | TURN, ANGLE, ITSELF),
    ROW(TORQUE, SPRING, 1, ANGLE, LOAD, ITSELF),
    ROW(MOMENT, SPRING, 1, LINK | BASE, LOAD, ITSELF),
    ROW(TORQUE, SIDE, 1, ANGLE, SIDE, ITSELF),
    ROW(TORQUE, SOFTENING, 1, ANGLE, LOAD, ITSELF),
    ROW(TORQUE, DELAYED, 2, ANGLE, LOAD, ITSELF),
    ROW(ACROSS, LINEAR, 2, ANGLE | BASE, LOAD, ITSELF),
    ROW(PAYLOAD, LINEAR, 1, ANGLE, LOAD, ITSELF),
    ROW(MOVE, SIDE, 1, ANGLE, MOVE, ANY),
    ROW(MOVE, LINEAR, 1, ANGLE, MOVE, ITSELF),
    ROW(MOVE, LINEAR, 1, ANGLES, MOVE, ITSELF),
    ROW(MOVE, RUBBING, 1, ANGLE, MOVE, ITSELF),
    ROW(MOVE, WEARING, 2, ANGLE, MOVE, ITSELF),
    ROW(TIME, LINEAR, 1, ANGLE | SHIFT | TURN | BASE, TIME, ITSELF),
    ROW(TIME, BUMPS, BASE_BUMPS, BASE, TIME, ITSELF),
    ROW(MOMENT, LINEAR, 3, SHIFT | TURN | BASE, LOAD, ITSELF),
    ROW(MOMENT, SIDE, 3, TURN | BASE, SIDE, ITSELF),
    ROW(PLACEMENT, LINEAR, 1, ANGLE | SHIFT | TURN | DISTANCE, PLACEMENT, ITSELF),
    ROW(TILT, LINEAR, 3, SEAT, ANGLE, ITSELF)};

int mukca_unlisted_site(const mukca_candidate *h)
{
    static const int sites[] = {
        [MUKCA_PLACE_ANGLE] = MUKCA_SITE_ANGLE,      [MUKCA_PLACE_ANGLES] = MUKCA_SITE_ANGLES,
        [MUKCA_PLACE_LINK] = MUKCA_SITE_ROTATION,    [MUKCA_PLACE_SHIFT] = MUKCA_SITE_FRAME,
        [MUKCA_PLACE_TURN] = MUKCA_SITE_FRAME,       [MUKCA_PLACE_BASE] = MUKCA_SITE_BASE,
        [MUKCA_PLACE_SOCKET] = MUKCA_SITE_SEAT,      [MUKCA_PLACE_TOOL] = MUKCA_SITE_SEAT,
        [MUKCA_PLACE_DISTANCE] = MUKCA_SITE_DISTANCE};
    return sites[h->unlisted.place];
}

bool mukca_unlisted_is_normalised(const mukca_candidate *h)
{
    return mukca_unlisted_functions[h->unlisted.function].shape >= MUKCA_SHAPE_BUMPS &&
           h->unlisted.place != MUKCA_PLACE_BASE;
}

/* What the functions need to know of the whole recording. */
typedef struct {
    double range[2], joint_range[2], time[2]; /* of the angles of the argument and of the joint */
    double centre[3], width[3];               /* SIDE: of the argument */
    double axis[3];                           /* BASE: of the first joint, if it turns */
    double late[2], seconds;                  /* DELAYED: loads and time of the row before */
} survey;

/* Is it a rotation about moments, with one coefficient each? */
static bool is_about_moments(const mukca_candidate *h)
{
    const mukca_unlisted_function *f = &mukca_unlisted_functions[h->unlisted.function];
    return (f->shape == MUKCA_SHAPE_SPRING || f->argument == MUKCA_ARGUMENT_ACROSS) &&
           h->unlisted.place != MUKCA_PLACE_ANGLE;
}

/* Axes of a place, each with a coefficient for each value of the function. */
static int axes_of(const mukca_candidate *h)
{
    if (is_about_moments(h)) return 1;
    const int site = mukca_unlisted_site(h);
    return site == MUKCA_SITE_FRAME || site == MUKCA_SITE_BASE ? 3 : 1;
}

void mukca_unlisted_set_shape(mukca_candidate *h, const mukca_recording *r)
{
    const int site = mukca_unlisted_site(h);
    int values = mukca_unlisted_functions[h->unlisted.function].values;
    double range[2];
    if (!values) {
        mukca_recording_range(range, r, r->q, r->chain->n_joints, h->joint < 0 ? 0 : h->joint);
        values = (int)fmin(ceil((range[1] - range[0]) / h->unlisted.measure) + 1, MUKCA_MOST_TERMS);
    }
    h->terms = values * axes_of(h);
    h->width_of_term =
        site == MUKCA_SITE_ANGLES ? r->chain->n_joints
        : site == MUKCA_SITE_ROTATION || site == MUKCA_SITE_BASE || site == MUKCA_SITE_SEAT ? 3
                                                                                            : 1;
}

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
    const int n = r->chain->n_joints, rows = r->data->n_rows, j = h->unlisted.argument;
    const bool base = h->unlisted.place == MUKCA_PLACE_BASE;
    const mukca_argument argument = mukca_unlisted_functions[h->unlisted.function].argument;
    *s = (survey){.width = {argument == MUKCA_ARGUMENT_MOVE ? MOVE_WIDTH : h->unlisted.measure},
                  .seconds = HUGE_VAL};
    if (base) find_axis(s->axis, r->chain);
    mukca_recording_range(s->time, r, r->time, 1, 0);
    if (argument == MUKCA_ARGUMENT_ANGLE) {
        mukca_recording_range(s->range, r, r->q, n, j);
        mukca_recording_range(s->joint_range, r, r->q, n, h->joint);
        s->centre[0] = 0.5 * (s->range[0] + s->range[1]);
        s->width[0] = 1e-9; /* a step */
    }
    for (int k = 0; k < 3 && argument == MUKCA_ARGUMENT_MOMENT; k++) {
        const double *moment = base ? r->total_base : r->total_moment + 3 * j;
        const int stride = base ? 3 : 3 * n;
        double square = 0;
        for (int row = 0; row < rows; row++) s->centre[k] += moment[stride * row + k] / rows;
        for (int row = 0; row < rows; row++)
            square += pow(moment[stride * row + k] - s->centre[k], 2) / rows;
        s->width[k] = 0.5 * sqrt(square) + 1e-9;
    }
}

/* The argument x[3] at a row. */
static void find_argument(double x[3], const mukca_candidate *h, const mukca_recording *r, int row,
                          const mukca_joint_state *state)
{
    const int j = h->unlisted.argument;
    switch (mukca_unlisted_functions[h->unlisted.function].argument) {
        case MUKCA_ARGUMENT_ANGLE:
            x[0] = state->q[j];
            break;
        case MUKCA_ARGUMENT_TORQUE:
            x[0] = state->torque[j];
            break;
        case MUKCA_ARGUMENT_ACROSS:
            memcpy(x, r->across + 2 * (row * r->chain->n_joints + j), 2 * sizeof *x);
            break;
        case MUKCA_ARGUMENT_PAYLOAD:
            x[0] = h->placement < 0 || state->placement == h->placement
                       ? r->torque[((row + 1) * r->n_bodies - 1) * r->chain->n_joints + j]
                       : 0;
            break;
        case MUKCA_ARGUMENT_MOMENT: {
            const bool base = h->unlisted.place == MUKCA_PLACE_BASE;
            memcpy(x, base ? state->base_moment : state->moment[j], 3 * sizeof *x);
            break;
        }
        case MUKCA_ARGUMENT_MOVE:
            x[0] = state->move[j];
            break;
        case MUKCA_ARGUMENT_TIME:
            x[0] = state->time;
            break;
        case MUKCA_ARGUMENT_ROW:
            x[0] = row;
            break;
        default:
            x[0] = state->placement == h->placement;
    }
}

/* The load as an elastic body with a delay sees it, which starts at rest with the file. */
static void delay(double value[2], survey *s, double time, double load)
{
    static const double delays[2] = {30, 100}; /* s: as of polymer gears and rubber buffers */
    const double passed = time - s->seconds;
    for (int k = 0; k < 2; k++) {
        s->late[k] =
            passed >= 0 ? s->late[k] + (1 - exp(-passed / delays[k])) * (load - s->late[k]) : load;
        value[k] = s->late[k];
    }
    s->seconds = time;
}

/* T[0 .. degree] of x in the range: Chebyshev polynomials by their recurrence. */
static void chebyshev(double *T, int degree, double x, const double range[2])
{
    T[0] = 1;
    T[1] = range[1] > range[0] ? (2 * x - range[0] - range[1]) / (range[1] - range[0]) : 0;
    for (int k = 2; k <= degree; k++) T[k] = 2 * T[1] * T[k - 1] - T[k - 2];
}

/* Gaussian bumps on a grid over the range. */
static void bumps(double *value, int n, double x, const double range[2], double width)
{
    for (int k = 0; k < n; k++)
        value[k] = exp(-0.5 * pow((x - range[0]) / width - k, 2)) / BUMP_NORM;
}

/* Functions of the argument at a row of the dataset. */
static void evaluate(double *value, int n, const mukca_candidate *h, const mukca_recording *r,
                     int row, survey *s)
{
    const mukca_joint_state state = mukca_recording_state(r, row);
    const mukca_unlisted_function *f = &mukca_unlisted_functions[h->unlisted.function];
    double x[3] = {0}, T[POWERS + 1] = {0}, joint[PRODUCT_DEGREE + 1] = {0};
    find_argument(x, h, r, row, &state);
    switch (f->shape) {
        case MUKCA_SHAPE_LINEAR:
        case MUKCA_SHAPE_SPRING:
            memcpy(value, x, sizeof *x * (size_t)n);
            break;
        case MUKCA_SHAPE_SIDE:
            for (int k = 0; k < n; k++) value[k] = tanh((x[k] - s->centre[k]) / s->width[k]);
            break;
        case MUKCA_SHAPE_WAVE:
            if (!mukca_joint_turns(
                    r->chain->element[r->chain->joint_element[h->unlisted.argument]].type))
                x[0] = 2 * M_PI * (x[0] - s->centre[0]) / fmax(s->range[1] - s->range[0], 1e-9);
            value[0] = sin(h->unlisted.measure * x[0]);
            value[1] = cos(h->unlisted.measure * x[0]);
            break;
        case MUKCA_SHAPE_SOFTENING:
            value[0] = x[0] * state.time;
            break;
        case MUKCA_SHAPE_DELAYED:
            delay(value, s, state.time, x[0]);
            break;
        case MUKCA_SHAPE_RUBBING:
            value[0] = tanh(x[0] / MOVE_WIDTH) * fabs(state.torque[h->unlisted.argument]);
            break;
        case MUKCA_SHAPE_WEARING: /* 300 and 3000 s: as of joint_drift */
            value[0] = tanh(x[0] / MOVE_WIDTH) * exp(-state.time / 300);
            value[1] = tanh(x[0] / MOVE_WIDTH) * exp(-state.time / 3000);
            break;
        case MUKCA_SHAPE_BUMPS:
            if (f->argument == MUKCA_ARGUMENT_ANGLE)
                bumps(value, n, x[0], s->range, h->unlisted.measure);
            else
                bumps(value, n, x[0], s->time, fmax(s->time[1] - s->time[0], 1e-9) / (n - 1));
            break;
        case MUKCA_SHAPE_POWERS:
            chebyshev(T, POWERS, x[0], s->range);
            memcpy(value, T + 1, sizeof *value * POWERS);
            break;
        case MUKCA_SHAPE_PRODUCTS: /* T_a T_b, 0 < a + b <= PRODUCT_DEGREE */
            chebyshev(T, PRODUCT_DEGREE, x[0], s->range);
            chebyshev(joint, PRODUCT_DEGREE, state.q[h->joint], s->joint_range);
            for (int a = 0; a <= PRODUCT_DEGREE; a++)
                for (int b = 0; a + b <= PRODUCT_DEGREE; b++)
                    if (a + b > 0) *value++ = T[a] * joint[b];
            break;
        case MUKCA_SHAPE_STEP:
            value[0] = x[0] >= h->unlisted.measure;
            break;
        case MUKCA_SHAPE_SATURATING:
            value[0] = 1 - exp(-(x[0] - s->time[0]) / h->unlisted.measure);
    }
}

/* One coefficient for all joints. */
static void fill_angles(mukca_candidate h, const mukca_recording *r)
{
    const int n = r->chain->n_joints;
    for (int j = 0; j < n; j++) {
        survey s;
        h.unlisted.argument = j;
        survey_rows(&s, &h, r);
        for (int row = 0; row < r->data->n_rows; row++) {
            double value[MUKCA_MOST_TERMS] = {0};
            evaluate(value, 1, &h, r, row, &s);
            h.basis[row * n + j] = (float)value[0];
        }
    }
}

/* Of a link, the moments across the axis of the joint behind it: along it, the joint turns. */
static void fill_moments(const mukca_candidate *h, const mukca_recording *r)
{
    const bool link = h->unlisted.place == MUKCA_PLACE_LINK;
    const int values = mukca_unlisted_functions[h->unlisted.function].values;
    const double *axis =
        link ? r->chain->element[r->chain->joint_element[h->joint]].axis : (double[3]){0};
    float *out = h->basis;
    for (int row = 0; row < r->data->n_rows; row++) {
        const mukca_joint_state state = mukca_recording_state(r, row);
        const double *moment = values > 1 ? r->across_base[row][0]
                               : link     ? state.moment[h->joint]
                                          : state.base_moment;
        const double along = link ? mukca_dot3(moment, axis) : 0;
        for (int i = 0; i < 3 * values; i++) *out++ = (float)(moment[i] - along * axis[i % 3]);
    }
}

void mukca_unlisted_fill(const mukca_candidate *h, const mukca_recording *r)
{
    const int axes = axes_of(h), values = h->terms / axes;
    float *out = h->basis;
    survey s;
    if (h->unlisted.place == MUKCA_PLACE_ANGLES) {
        fill_angles(*h, r);
        return;
    }
    if (is_about_moments(h)) {
        fill_moments(h, r);
        return;
    }
    survey_rows(&s, h, r);
    for (int row = 0; row < r->data->n_rows; row++) {
        double value[MUKCA_MOST_TERMS] = {0};
        evaluate(value, values, h, r, row, &s);
        for (int k = 0; k < values; k++)
            for (int a = 0; a < axes; a++)
                for (int i = 0; i < h->width_of_term; i++)
                    *out++ =
                        (float)(value[k] *
                                (h->width_of_term == 1 ? 1 : (i == a) - s.axis[i] * s.axis[a]));
    }
}
