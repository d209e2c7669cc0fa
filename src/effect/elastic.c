/* Elastic effects: springs that gravity's moment deflects. */
#include "effect/catalogue.h"

static void joint_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    if (state->torque) basis[0][0] = -state->torque[effect->joint];
}

static bool joint_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && mukca_survey_loads(survey, effect->joint);
}

static const char *joint_untested(const mukca_effect_survey *survey, int joint)
{
    return survey->joint[joint].torque_most < MUKCA_LEAST_TORQUE
               ? "gravity does not load it in these poses"
               : "gravity loads it alike in all rows: record poses with other lever arms";
}

const mukca_effect_ops mukca_joint_compliance_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "joint_compliance",
             .title = "joint compliance",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             .unit = "rad/(N*m)",
             .display_factor = 1e6,
             .display_unit = "urad/(N*m)",
             .nonnegative = true,
             .needs = MUKCA_NEEDS_MASSES,
             .traits = MUKCA_TRAIT_ELASTIC,
             .sentence =
                 "the joint's gear and bearing give way under gravity's torque about its axis"},
    .basis = joint_basis,
    .candidate = joint_candidate,
    .untested = joint_untested,
};

/* The part of the moment across the joint's axis. */
static void link_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                       const double axis[3], const mukca_joint_state *state)
{
    if (!state->moment) return;
    const double *moment = state->moment[effect->joint], along = mukca_dot3(moment, axis);
    for (int i = 0; i < 3; i++) basis[0][i] = along * axis[i] - moment[i];
}

static bool link_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && survey->moments && survey->joint[effect->joint].turns;
}

const mukca_effect_ops mukca_link_bending_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "link_bending",
             .title = "link bending",
             .site = MUKCA_SITE_ROTATION,
             .terms = 1,
             .unit = "rad/(N*m)",
             .display_factor = 1e6,
             .display_unit = "urad/(N*m)",
             .nonnegative = true,
             .needs = MUKCA_NEEDS_MASSES,
             .traits = MUKCA_TRAIT_ELASTIC,
             .sentence = "the link before the joint bends across the joint's axis under load",
             .remedy =
                 "compensate it with the offsets table; check the screws between link and joint"},
    .basis = link_basis,
    .candidate = link_candidate,
};

static void base_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                       const double axis[3], const mukca_joint_state *state)
{
    (void)effect, (void)axis;
    for (int i = 0; i < 3 && state->base_moment; i++) basis[0][i] = -state->base_moment[i];
}

static bool base_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    (void)effect;
    return i == 0 && survey->moments;
}

const mukca_effect_ops mukca_base_compliance_effect = {
    .sizes = &mukca_sizes_spring,
    .info = {.name = "base_compliance",
             .title = "base compliance",
             .site = MUKCA_SITE_BASE,
             .terms = 1,
             .unit = "rad/(N*m)",
             .display_factor = 1e6,
             .display_unit = "urad/(N*m)",
             .nonnegative = true,
             .needs = MUKCA_NEEDS_MASSES,
             .traits = MUKCA_TRAIT_ELASTIC,
             .sentence = "the base or its table tilts under the arm's weight",
             .remedy = "stiffen the base or its table, or compensate it"},
    .basis = base_basis,
    .candidate = base_candidate,
};
