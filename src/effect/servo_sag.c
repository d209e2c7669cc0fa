/* Servo sag: a position controller without integral action balances gravity torque by an error of
 * the angle.  For arms recorded by command: readings do not contain it. */
#include "effect/catalogue.h"

/* rad/(N m): the reciprocal of the position gain.  Industrial drives have integral action and are
 * accurate to the encoder's resolution; users of cheap arms report 30 mrad at a few N m. */
static const mukca_effect_sizes sizes = {4, {30e-6, 100e-6, 300e-6, 1e-3, 3e-3, 10e-3}};

static bool candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && survey->by_command && mukca_survey_loads(survey, effect->joint);
}

const mukca_effect_ops mukca_servo_sag_effect = {
    .sizes = &sizes,
    .info = {.name = "servo_sag",
             .title = "servo sag",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             MUKCA_IN_URAD_PER_NM,
             .nonnegative = true,
             .needs = MUKCA_NEEDS_MASSES | MUKCA_NEEDS_COMMANDS,
             .traits = MUKCA_TRAIT_ELASTIC,
             .sentence = "the position controller holds gravity torque by an error between "
                         "command and angle",
             .remedy = "record the readings too; raise the position gain or add gravity "
                       "compensation or integral action, or compensate it"},
    .basis = mukca_effect_spring_basis,
    .candidate = candidate,
    .untested = "gravity loads it alike in all samples: record postures with other lever arms",
};
