/* Elastic effects: springs deflected by gravity moments. */
#include "effect/catalogue.h"

/* One coefficient, which cannot be negative: the load is gravity's; of a flexible part. */
#define SPRING \
    .varies_with = MUKCA_VARIES_LOAD, .terms = 1, .nonnegative = true, .unit = "rad/(N*m)"
#define FLEXIBLE \
    SPRING, .traits = MUKCA_TRAIT_ELASTIC | MUKCA_TRAIT_FLEXIBLE, .needs = MUKCA_NEEDS_MASSES

static const char loaded_alike[] =
    "gravity loads it alike in all samples: record postures with other lever arms";

/* Of a spring at a joint: its negative torque. */
static void spring_basis(double basis[][3], const mukca_basis_input *in)
{
    if (in->state->torque) basis[0][0] = -in->state->torque[in->effect->joint];
}

static bool joint_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && mukca_survey_loads(survey, effect->joint);
}

const mukca_effect_ops mukca_joint_compliance_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "joint_compliance",
             .title = "joint compliance",
             .site = MUKCA_SITE_ANGLE,
             FLEXIBLE,
             .sentence = "the transmission deflects under gravity torque"},
    .basis = spring_basis,
    .candidate = joint_candidate,
    .untested = loaded_alike,
};

/* Moment component across the joint's axis. */
static void link_basis(double basis[][3], const mukca_basis_input *in)
{
    if (!in->state->moment) return;
    const double *moment = in->state->moment[in->effect->joint];
    const double along = mukca_dot3(moment, in->axis);
    for (int i = 0; i < 3; i++) basis[0][i] = along * in->axis[i] - moment[i];
}

/* Of a link, or of the base, which has no joint. */
static bool link_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && survey->moments && (effect->joint < 0 || survey->joint[effect->joint].turns);
}

const mukca_effect_ops mukca_link_bending_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "link_bending",
             .title = "link bending",
             .site = MUKCA_SITE_ROTATION,
             FLEXIBLE,
             .sentence = "the link before the joint bends under gravity torque",
             .remedy = "compensate it with the offsets table; check the screws between link and "
                       "joint"},
    .basis = link_basis,
    .candidate = link_candidate,
};

static void base_basis(double basis[][3], const mukca_basis_input *in)
{
    for (int i = 0; i < 3 && in->state->base_moment; i++) basis[0][i] = -in->state->base_moment[i];
}

const mukca_effect_ops mukca_base_compliance_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "base_compliance",
             .title = "base compliance",
             .site = MUKCA_SITE_BASE,
             FLEXIBLE,
             .sentence = "the base or its table tilts under the arm's weight",
             .remedy = "stiffen the base or its table, or compensate it"},
    .basis = base_basis,
    .candidate = link_candidate,
};

/* Servo sag: a position controller without integral action balances gravity torque by an error of
 * the angle.  For arms recorded by command: readings do not contain it. */

/* rad/(N m): the reciprocal of the position gain.  Industrial drives have integral action and are
 * accurate to the encoder's resolution; users of cheap arms report 30 mrad at a few N m. */
static const mukca_effect_sizes sizes = {.usual = 4,
                                         .sigma = {30e-6, 100e-6, 300e-6, 1e-3, 3e-3, 10e-3}};

const mukca_effect_ops mukca_servo_sag_effect = {
    .sizes = &sizes,
    .info = {.name = "servo_sag",
             .title = "servo sag",
             .site = MUKCA_SITE_ANGLE,
             SPRING,
             .traits = MUKCA_TRAIT_ELASTIC,
             .needs = MUKCA_NEEDS_MASSES | MUKCA_NEEDS_COMMANDS,
             .sentence = "the position controller holds gravity torque by an error between "
                         "command and angle",
             .remedy = "record the readings too; raise the position gain or add gravity "
                       "compensation or integral action, or compensate it"},
    .basis = spring_basis,
    .candidate = joint_candidate,
    .untested = loaded_alike,
};
