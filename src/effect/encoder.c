/* Angle errors that are functions of angles: scale, coupling, encoder eccentricity and transmission
 * ripple. */

#include "base/number.h"
#include "effect/catalogue.h"

/* Proportional to the joint's own angle, or to a neighbour's. */
static void linear_basis(double basis[][3], const mukca_basis_input *in)
{
    basis[0][0] = in->state->q[in->effect->joint + in->effect->variant.neighbour];
}

static int linear_by_angle(double slope[][3], const mukca_basis_input *in, const double basis[][3])
{
    (void)basis;
    slope[0][0] = 1;
    return in->effect->variant.neighbour;
}

const mukca_effect_ops mukca_joint_scale_effect = {
    .info = {.name = "joint_scale",
             .title = "joint scale",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_ANGLE,
             .terms = 1,
             .unit = "rad/rad",
             .traits = MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the encoder counts a little too much or too little per turn",
             .remedy = "correct the encoder's counts per turn in the controller, or compensate it"},
    .basis = linear_basis,
    .by_angle = linear_by_angle,
    .candidate = mukca_survey_moved,
};

/* Default: the next joint; for the last joint, the preceding one. */
static bool complete_neighbour(mukca_effect *effect, int n_joints)
{
    int *side = &effect->variant.neighbour;
    if (*side == 0) *side = effect->joint + 1 < n_joints ? 1 : -1;
    return effect->joint + *side >= 0 && effect->joint + *side < n_joints;
}

/* The preceding joint, then the next one, if they moved. */
static bool coupling_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    for (int side = -1; side <= 1; side += 2) {
        effect->variant.neighbour = side;
        if (complete_neighbour(effect, survey->n_joints) &&
            survey->joint[effect->joint + side].range > MUKCA_LEAST_RANGE && i-- == 0)
            return true;
    }
    return false;
}

static bool read_neighbour(mukca_effect_variant *variant, const char *text)
{
    return mukca_effect_read_integer(&variant->neighbour, text, -1, 1) && variant->neighbour;
}

static void write_neighbour(char *text, size_t size, const mukca_effect_variant *variant)
{
    mukca_print(text, size, "%+d", variant->neighbour);
}

static const mukca_variant_ops neighbour = {
    .key = "neighbour",
    .expected = "@+1 or @-1, a joint that exists",
    .read = read_neighbour,
    .write = write_neighbour,
    .complete = complete_neighbour,
};

const mukca_effect_ops mukca_joint_coupling_effect = {
    .info = {.name = "joint_coupling",
             .title = "joint coupling",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_ANGLE,
             .terms = 1,
             .unit = "rad/rad",
             .traits = MUKCA_TRAIT_OTHER_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the motion of a neighbouring joint also turns this joint (belt, "
                         "differential or cable drive)",
             .remedy = "correct the coupling ratio in the controller, or compensate it"},
    .basis = linear_basis,
    .by_angle = linear_by_angle,
    .variant = &neighbour,
    .candidate = coupling_candidate,
    .untested = "no neighbour of it moved: record postures that turn them",
};

/* sin and cos of the joint's angle times the order; eccentricity has order 1 */
static void wave_basis(double basis[][3], const mukca_basis_input *in)
{
    basis[0][0] = in->sine[0], basis[1][0] = in->cosine[0];
}

static int wave_by_angle(double slope[][3], const mukca_basis_input *in, const double basis[][3])
{
    const int order = in->effect->variant.order > 1 ? in->effect->variant.order : 1;
    slope[0][0] = order * basis[1][0], slope[1][0] = -order * basis[0][0];
    return 0;
}

const mukca_effect_ops mukca_encoder_eccentricity_effect = {
    .info = {.name = "encoder_eccentricity",
             .title = "encoder eccentricity",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_ANGLE,
             .terms = 2,
             .unit = "rad",
             .traits = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_OWN_ANGLE | MUKCA_TRAIT_SMOOTH,
             .sentence = "the encoder disk is off centre: an error once per turn",
             .remedy = "calibrate the encoder in the controller, or compensate it"},
    .basis = wave_basis,
    .by_angle = wave_by_angle,
    .term_name = {"sin", "cos"},
    .candidate = mukca_survey_moved,
};

static bool read_order(mukca_effect_variant *variant, const char *text)
{
    return mukca_effect_read_integer(&variant->order, text, 2, MUKCA_LAST_ORDER);
}

static void write_order(char *text, size_t size, const mukca_effect_variant *variant)
{
    mukca_print(text, size, "%d", variant->order);
}

static const mukca_variant_ops orders = {
    .key = "order",
    .expected = "@ORDER, 2 to 400",
    .read = read_order,
    .write = write_order,
    .required = true,
};

/* Ratios of strain wave and cycloidal gears in cobots, their doubles (two lobes a turn), and
 * encoder line counts that alias onto low orders; low orders; all others. */
static double harmonic_prior(int order)
{
    static const int usual[] = {50,  51,  80,  81,  100, 101, 102, 120, 121, 128,
                                160, 161, 200, 202, 240, 242, 256, 320, 322};
    const int n_usual = (int)(sizeof usual / sizeof *usual);
    double p = 0.3 / (MUKCA_LAST_ORDER - 1);
    if (order <= 6) p += 0.4 / 5;
    for (int i = 0; i < n_usual; i++)
        if (usual[i] == order) p += 0.3 / n_usual;
    return p;
}

/* Ripple of a gear has its ratio, half or double of it as order. */
static int gear_of(int order)
{
    const int least_ratio = 20; /* of a strain-wave or cycloidal gear, halved */
    if (order < least_ratio) return 0;
    while (order % 2 == 0) order /= 2;
    return order;
}

static bool harmonic_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    effect->variant.order = 2 + i;
    return !(survey->joint[effect->joint].range < MUKCA_WAVE_TRAVEL) &&
           effect->variant.order <= MUKCA_LONG_ORDER;
}

/* rad: makers state a transmission accuracy of 0.5 to 2 arcmin for strain wave gears. */
static const mukca_effect_sizes ripple_sizes = {
    .usual = 4, .sigma = {0.03e-3, 0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

const mukca_effect_ops mukca_gear_harmonic_effect = {
    .sizes = &ripple_sizes,
    .info = {.name = "gear_harmonic",
             .title = "transmission ripple",
             .site = MUKCA_SITE_ANGLE,
             .varies_with = MUKCA_VARIES_ANGLE,
             .terms = 2,
             .unit = "rad",
             .traits = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_ORDERS | MUKCA_TRAIT_OWN_ANGLE |
                       MUKCA_TRAIT_SMOOTH,
             .sentence =
                 "gear ripple: an error that repeats with each tooth or each turn of the gear"},
    .basis = wave_basis,
    .by_angle = wave_by_angle,
    .variant = &orders,
    .term_name = {"sin", "cos"},
    .candidate = harmonic_candidate,
    .order_prior = harmonic_prior,
    .gear = gear_of,
};
