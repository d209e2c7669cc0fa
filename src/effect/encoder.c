/* Errors of the angle that depend on angles: scale, coupling, encoder eccentricity and transmission
 * ripple. */
#include <math.h>
#include <stdio.h>

#include "effect/catalogue.h"

static void scale_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    basis[0][0] = state->q[effect->joint];
}

const mukca_effect_ops mukca_joint_scale_effect = {
    .info = {.name = "joint_scale",
             .title = "joint scale",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             .unit = "rad/rad",
             .display_factor = 1e3,
             .display_unit = "mrad/rad",
             .traits = MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the encoder counts a little too much or too little per turn",
             .remedy = "correct the encoder's counts per turn in the controller, or compensate it"},
    .basis = scale_basis,
    .candidate = mukca_survey_moved,
};

/* ---- coupling ---- */

static void coupling_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                           const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    basis[0][0] = state->q[effect->joint + effect->variant.neighbour];
}

static bool has_neighbour(const mukca_effect *effect, int n_joints)
{
    const int other = effect->joint + effect->variant.neighbour;
    return other >= 0 && other < n_joints;
}

/* The joint before, then the joint after, where these moved. */
static bool coupling_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    for (int side = -1; side <= 1; side += 2) {
        effect->variant.neighbour = side;
        if (has_neighbour(effect, survey->n_joints) &&
            survey->joint[effect->joint + side].range > MUKCA_LEAST_RANGE && i-- == 0)
            return true;
    }
    return false;
}

static const char *coupling_untested(const mukca_effect_survey *survey, int joint)
{
    (void)survey, (void)joint;
    return "no neighbour of it moved: record poses that turn them";
}

static bool read_neighbour(mukca_effect_variant *variant, const char *text)
{
    if (*text == '+') text++;
    return mukca_effect_read_integer(&variant->neighbour, text, -1, 1) && variant->neighbour;
}

static void write_neighbour(char *text, size_t size, const mukca_effect_variant *variant)
{
    snprintf(text, size, "%+d", variant->neighbour);
}

static bool usual_neighbour(mukca_effect *effect, int n_joints)
{
    effect->variant.neighbour = effect->joint + 1 < n_joints ? 1 : -1;
    return true;
}

static const mukca_variant_ops neighbour = {
    .key = "neighbour",
    .expected = "@+1 or @-1, a joint that exists",
    .read = read_neighbour,
    .write = write_neighbour,
    .usual = usual_neighbour,
    .fits = has_neighbour,
};

static void describe_coupling(char *text, size_t size, const mukca_effect *effect,
                              const mukca_chain *chain)
{
    const int other = effect->joint + effect->variant.neighbour;
    snprintf(text, size, " (driven by %s)", chain->element[chain->joint_element[other]].name);
}

const mukca_effect_ops mukca_joint_coupling_effect = {
    .info = {.name = "joint_coupling",
             .title = "joint coupling",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             .unit = "rad/rad",
             .display_factor = 1e3,
             .display_unit = "mrad/rad",
             .traits = MUKCA_TRAIT_OTHER_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "a neighbour's motion leaks into this joint (belt, differential or cable "
                         "drive)",
             .remedy = "correct the coupling ratio in the controller, or compensate it"},
    .basis = coupling_basis,
    .variant = &neighbour,
    .describe = describe_coupling,
    .candidate = coupling_candidate,
    .untested = coupling_untested,
};

/* ---- waves of the joint's angle ---- */

static const char *const *wave_names(const mukca_effect_variant *variant)
{
    static const char *const names[] = {"sin", "cos"};
    (void)variant;
    return names;
}

static void wave(double basis[MUKCA_MAX_TERMS][3], double angle)
{
    basis[0][0] = sin(angle), basis[1][0] = cos(angle);
}

static void eccentricity_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                               const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    wave(basis, state->q[effect->joint]);
}

static bool eccentricity_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return survey->joint[effect->joint].turns && mukca_survey_moved(effect, survey, i);
}

const mukca_effect_ops mukca_encoder_eccentricity_effect = {
    .info = {.name = "encoder_eccentricity",
             .title = "encoder eccentricity",
             .site = MUKCA_SITE_ANGLE,
             .terms = 2,
             .unit = "rad",
             .display_factor = 1e3,
             .display_unit = "mrad",
             .traits = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the encoder disk sits off centre: an error once per turn",
             .remedy = "calibrate the encoder in the controller, or compensate it"},
    .basis = eccentricity_basis,
    .term_names = wave_names,
    .candidate = eccentricity_candidate,
};

static void harmonic_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                           const double axis[3], const mukca_joint_state *state)
{
    (void)axis;
    wave(basis, effect->variant.order * state->q[effect->joint]);
}

static bool read_order(mukca_effect_variant *variant, const char *text)
{
    return mukca_effect_read_integer(&variant->order, text, 2, MUKCA_LAST_ORDER);
}

static void write_order(char *text, size_t size, const mukca_effect_variant *variant)
{
    snprintf(text, size, "%d", variant->order);
}

static bool no_order(mukca_effect *effect, int n_joints)
{
    (void)effect, (void)n_joints;
    return false;
}

static const mukca_variant_ops order = {
    .key = "order",
    .expected = "@ORDER, 2 to 400",
    .read = read_order,
    .write = write_order,
    .usual = no_order,
};

static void describe_harmonic(char *text, size_t size, const mukca_effect *effect,
                              const mukca_chain *chain)
{
    (void)chain;
    snprintf(text, size, " (%d per turn)", effect->variant.order);
}

/* No candidates: the diagnosis scans all orders at once. */
const mukca_effect_ops mukca_gear_harmonic_effect = {
    .sizes = &mukca_sizes_ripple,
    .info = {.name = "gear_harmonic",
             .title = "transmission ripple",
             .site = MUKCA_SITE_ANGLE,
             .terms = 2,
             .unit = "rad",
             .display_factor = 1e3,
             .display_unit = "mrad",
             .traits = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "gear ripple: an error that repeats `order` times per turn"},
    .basis = harmonic_basis,
    .variant = &order,
    .term_names = wave_names,
    .describe = describe_harmonic,
};
