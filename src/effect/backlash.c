/* Lost motion: backlash, with the side determined by gravity, and hysteresis, with the side
 * determined by the last move. */
#include <math.h>

#include "base/number.h"
#include "effect/catalogue.h"

static void backlash_basis(double basis[][3], const mukca_basis_input *in)
{
    const mukca_effect *effect = in->effect;
    if (in->state->torque)
        basis[0][0] = -0.5 * tanh(in->state->torque[effect->joint] / effect->variant.torque_scale);
}

/* Torque below which friction keeps a gear between its flanks, N m, by order of magnitude: small,
 * medium and large joints of arms up to 20 kg payload. */
static bool backlash_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    static const double scales[] = {0.3, 1, 3};
    const int j = effect->joint;
    const bool both_sides = (survey->joint[j].torque_low < 0 && survey->joint[j].torque_high > 0) ||
                            survey->joint[j].torque_least < 0.3 * survey->joint[j].torque_most;
    /* below its torque scale the joint never reaches an end of its free motion: the effect equals
     * that of a spring, and its size is not identifiable */
    if (i >= 3 || !mukca_survey_loads(survey, j) || !both_sides ||
        survey->joint[j].torque_most < scales[i])
        return false;
    effect->variant.torque_scale = scales[i];
    return true;
}

static bool read_torque(mukca_effect_variant *variant, const char *text)
{
    double millis;
    if (!mukca_effect_read_number(&millis, text, "mNm")) return false;
    variant->torque_scale = 1e-3 * millis;
    return variant->torque_scale > 0;
}

static void write_torque(char *text, size_t size, const mukca_effect_variant *variant)
{
    mukca_print(text, size, "%.10gmNm", 1e3 * variant->torque_scale);
}

static const mukca_variant_ops torque_scale = {
    .key = "torque_scale",
    .expected = "@TORQUE in mN m, above 0",
    .read = read_torque,
    .write = write_torque,
    .usual.torque_scale = 1,
};

const mukca_effect_ops mukca_backlash_effect = {
    .info = {.name = "backlash",
             .title = "backlash",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_SIDE,
             .terms = 1,
             .unit = "rad",
             .nonnegative = true,
             .needs = MUKCA_NEEDS_MASSES,
             .traits = MUKCA_TRAIT_PLAY,
             .sentence = "gravity decides at which end of the gear's free motion the joint rests",
             .remedy = "adjust the gear, or approach targets from one side"},
    .basis = backlash_basis,
    .variant = &torque_scale,
    .candidate = backlash_candidate,
    .untested = "gravity holds it on one side in all samples: record postures on both sides",
};

/* A move of some 20 mrad (1 degree) brings friction and windup fully to one side; a shorter one,
 * partly.  tanh is a smooth step of that width. */
static const double windup = 0.02;

static void hysteresis_basis(double basis[][3], const mukca_basis_input *in)
{
    if (in->state->move) basis[0][0] = -0.5 * tanh(in->state->move[in->effect->joint] / windup);
}

static bool hysteresis_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return survey->moved && mukca_survey_moved(effect, survey, i);
}

const mukca_effect_ops mukca_approach_hysteresis_effect = {
    .info = {.name = "approach_hysteresis",
             .title = "approach hysteresis",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_MOVE,
             .terms = 1,
             .unit = "rad",
             .nonnegative = true, /* friction holds the link back: it stops short of the motor */
             .needs = MUKCA_NEEDS_ORDER,
             .sentence = "the joint rests differently after moving up than after moving down",
             .remedy = "approach targets from one side; check friction and preload"},
    .basis = hysteresis_basis,
    .candidate = hysteresis_candidate,
};
