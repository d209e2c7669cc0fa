/* What changed between placements: a joint's zero, or the ball's place on the arm. */
#include "effect/catalogue.h"

static bool acts(const mukca_effect *effect, const mukca_joint_state *state)
{
    return effect->placement >= 0 && state->placement == effect->placement;
}

static void zero_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                       const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    basis[0][0] = acts(effect, state);
}

static const char *zero_faint(int joint)
{
    return joint == 0 ? "turns the whole placement, sockets and all: only a tracker can see it"
                      : NULL;
}

const mukca_effect_ops mukca_zero_jump_effect = {
    .sizes = &mukca_sizes_zero,
    .info = {.name = "zero_jump",
             .title = "zero jump",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             .unit = "rad",
             .display_factor = 1e3,
             .display_unit = "mrad",
             .needs = MUKCA_NEEDS_PLACEMENTS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT,
             .sentence = "the joint's zero differs in one placement from the others (slipped or "
                         "re-homed)",
             .remedy = "check homing and brake of the joint, then record this placement again"},
    .basis = zero_basis,
    .candidate = mukca_survey_placement,
    .faint = zero_faint,
};

static void shift_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    for (int i = 0; i < 3; i++) basis[i][i] = acts(effect, state);
}

static const char *const *shift_names(const mukca_effect_variant *variant)
{
    static const char *const names[] = {"x", "y", "z"};
    (void)variant;
    return names;
}

const mukca_effect_ops mukca_ball_shift_effect = {
    .sizes = &mukca_sizes_ball,
    .info = {.name = "ball_shift",
             .title = "ball shift",
             .site = MUKCA_SITE_TIP,
             .terms = 3,
             .unit = "m",
             .display_factor = 1e3,
             .display_unit = "mm",
             .needs = MUKCA_NEEDS_PLACEMENTS,
             .traits = MUKCA_TRAIT_PER_PLACEMENT,
             .sentence = "the ball sat differently on the arm in one placement (loose or "
                         "re-mounted)",
             .remedy = "fasten the ball and record this placement again"},
    .basis = shift_basis,
    .term_names = shift_names,
    .candidate = mukca_survey_placement,
};
