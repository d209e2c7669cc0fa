/* Effects of time.  Joint drift: the zero of a joint changes, for example in a warming gear;
 * readback lag: the recorded angles are late. */
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "effect/catalogue.h"

static void drift_basis(double basis[][3], const mukca_basis_input *in)
{
    const double constant = in->effect->variant.time_constant, time = in->state->time;
    basis[0][0] = constant > 0 ? -expm1(-time / constant) : 1e-3 * time;
}

/* Sessions last 10 to 60 minutes; gears and castings warm up with time constants of 5 to 50
 * minutes. */
static bool drift_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    static const double constants[] = {0, 300, 1000, 3000};
    (void)survey;
    if (i >= 4) return false;
    effect->variant.time_constant = constants[i];
    return true;
}

static bool read_constant(mukca_effect_variant *variant, const char *text)
{
    return mukca_effect_read_number(&variant->time_constant, text, "s") &&
           variant->time_constant >= 0;
}

static void write_constant(char *text, size_t size, const mukca_effect_variant *variant)
{
    mukca_print(text, size, "%.10gs", variant->time_constant);
}

static const mukca_variant_ops time_constant = {
    .key = "time_constant",
    .expected = "@SECONDS, the time constant, or @0",
    .read = read_constant,
    .write = write_constant,
};

const mukca_effect_ops mukca_joint_drift_effect = {
    .info = {.name = "joint_drift",
             .title = "joint drift",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_TIME,
             .terms = 1,
             .unit = "rad",
             .needs = MUKCA_NEEDS_ORDER,
             .traits = MUKCA_TRAIT_OF_TIME,
             .sentence = "the joint's zero changes during the session, as in a warming gear",
             .remedy = "warm the arm up before recording and before use"},
    .basis = drift_basis,
    .variant = &time_constant,
    .candidate = drift_candidate,
};

/* ---- readback lag: the angles are delayed, along the last move or behind the command; the
 * readings of an arm that dwells settle ---- */

static void lag_direction(double *direction, int n_joints, const mukca_effect *effect,
                          const mukca_joint_state *state)
{
    const double *move = state->move;
    double largest = 0;
    if (effect->variant.to_command) {
        for (int j = 0; j < n_joints && state->command; j++)
            direction[j] = state->command[j] - state->q[j];
        return;
    }
    if (!move) return;
    for (int j = 0; j < n_joints; j++) largest = fmax(largest, fabs(move[j]));
    const double constant = effect->variant.time_constant;
    const double left = constant > 0 ? 1 + expm1(-state->repeat / constant) : 1;
    if (largest > 1e-9) /* rad; below: rounding */
        for (int j = 0; j < n_joints; j++) direction[j] = left * move[j] / largest;
}

/* The command is constant while the angle changes. */
static int lag_by_angle(double slope[][3], const mukca_basis_input *in, const double basis[][3])
{
    (void)basis;
    if (in->effect->variant.to_command && in->state->command) slope[0][0] = -1;
    return 0;
}

static bool read_direction(mukca_effect_variant *variant, const char *text)
{
    variant->to_command = strcmp(text, "command") == 0;
    return variant->to_command || strcmp(text, "move") == 0 ||
           (mukca_effect_read_number(&variant->time_constant, text, "readings") &&
            variant->time_constant > 0);
}

static void write_direction(char *text, size_t size, const mukca_effect_variant *variant)
{
    if (variant->time_constant > 0)
        mukca_print(text, size, "%.10greadings", variant->time_constant);
    else
        mukca_print(text, size, "%s", variant->to_command ? "command" : "move");
}

static const mukca_variant_ops direction = {
    .expected = "@move, @command, or @READINGS until it has settled",
    .read = read_direction,
    .write = write_direction,
};

static bool lag_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    static const double settling[] = {0, 1, 3, 10}; /* readings, from one to most of a dwell */
    const int moves = !survey->moved ? 0 : survey->dwelled ? 4 : 1;
    effect->variant.to_command = i >= moves;
    effect->variant.time_constant = i < moves ? settling[i] : 0;
    return i < moves + survey->commanded;
}

const mukca_effect_ops mukca_readback_lag_effect = {
    .info = {.name = "readback_lag",
             .title = "readback lag",
             .site = MUKCA_SITE_ANGLES,
             .varies_with = MUKCA_VARIES_MOVE,
             .terms = 1,
             .unit = "rad",
             .nonnegative = true, /* a reading can be late, not early */
             .needs = MUKCA_NEEDS_ORDER,
             .sentence = "the recorded angles lag behind the true ones, along the last move",
             .remedy = "let the arm stand still before each sample; check the time stamps of the "
                       "joint states"},
    .direction = lag_direction,
    .by_angle = lag_by_angle,
    .variant = &direction,
    .candidate = lag_candidate,
};
