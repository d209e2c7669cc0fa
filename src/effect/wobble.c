/* Axis wobble: the axis of a joint tilts as the joint turns (bearing run-out). */
#include <string.h>

#include "base/number.h"
#include "effect/catalogue.h"

static const char *const frame_name[] = {[MUKCA_WOBBLE_FIXED] = "fixed",
                                         [MUKCA_WOBBLE_TURNING] = "turning",
                                         [MUKCA_WOBBLE_CONE] = "cone"};

/* All variants.  Orders 0 and 1 of a cone are geometry: a tilt fixed in the frame before or after
 * the joint. */
static const mukca_effect_variant variants[] = {
    {.frame = MUKCA_WOBBLE_FIXED, .order = 1},   {.frame = MUKCA_WOBBLE_FIXED, .order = 2},
    {.frame = MUKCA_WOBBLE_TURNING, .order = 1}, {.frame = MUKCA_WOBBLE_TURNING, .order = 2},
    {.frame = MUKCA_WOBBLE_CONE, .order = -2},   {.frame = MUKCA_WOBBLE_CONE, .order = -1},
    {.frame = MUKCA_WOBBLE_CONE, .order = 2},    {.frame = MUKCA_WOBBLE_CONE, .order = 3}};

enum { VARIANTS = sizeof variants / sizeof *variants };

/* sin and cos of the angle times the order, about the two transverse axes u and v, in the frame
 * before or after the joint's rotation; a cone has one wave in two phases. */
static void wobble_basis(double basis[][3], const mukca_basis_input *in)
{
    const mukca_effect_variant *variant = &in->effect->variant;
    const double s = in->sine[0], c = in->cosine[0];
    double u[3], v[3];
    mukca_rotation_transverse(u, v, in->axis);
    if (variant->frame == MUKCA_WOBBLE_CONE) {
        for (int i = 0; i < 3; i++) {
            basis[0][i] = c * u[i] + s * v[i];
            basis[1][i] = c * v[i] - s * u[i];
        }
        return;
    }
    for (int i = 0; i < 3 && variant->frame == MUKCA_WOBBLE_TURNING; i++) { /* u x v = axis */
        const double along = u[i];
        u[i] = in->cosine[1] * along + in->sine[1] * v[i];
        v[i] = in->cosine[1] * v[i] - in->sine[1] * along;
    }
    for (int i = 0; i < 3; i++) {
        basis[0][i] = s * u[i], basis[1][i] = c * u[i];
        basis[2][i] = s * v[i], basis[3][i] = c * v[i];
    }
}

/* Terms are pairs of sine and cosine; in the turning frame the axes rotate, too. */
static int wobble_by_angle(double slope[][3], const mukca_basis_input *in, const double basis[][3])
{
    const mukca_effect_variant *variant = &in->effect->variant;
    const int order = variant->order;
    for (int t = 0; t < in->effect->terms; t++) {
        if (variant->frame == MUKCA_WOBBLE_TURNING) mukca_cross(slope[t], in->axis, basis[t]);
        for (int i = 0; i < 3; i++)
            slope[t][i] += t % 2 ? -order * basis[t - 1][i] : order * basis[t + 1][i];
    }
    return 0;
}

static const char *const *term_names(const mukca_effect_variant *variant)
{
    static const char *const waves[] = {"sin u", "cos u", "sin v", "cos v", NULL};
    static const char *const cone[] = {"u", "v", NULL};
    return variant->frame == MUKCA_WOBBLE_CONE ? cone : waves;
}

static void write_wobble(char *text, size_t size, const mukca_effect_variant *variant)
{
    mukca_print(text, size, variant->frame == MUKCA_WOBBLE_CONE ? "%s%+d" : "%s%d",
                frame_name[variant->frame], variant->order);
}

static bool read_wobble(mukca_effect_variant *variant, const char *text)
{
    char name[MUKCA_EFFECT_TEXT];
    for (int i = 0; i < VARIANTS; i++) {
        write_wobble(name, sizeof name, &variants[i]);
        if (strcmp(text, name) != 0) continue;
        *variant = variants[i];
        return true;
    }
    return false;
}

static const mukca_variant_ops motion = {
    .key = "motion",
    .expected = "@fixed1, fixed2, turning1, turning2, cone-2, cone-1, cone+2 or cone+3",
    .read = read_wobble,
    .write = write_wobble,
    .usual = {.frame = MUKCA_WOBBLE_FIXED, .order = 1},
};

static bool wobble_candidate(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    if (i >= VARIANTS || !mukca_survey_moved(effect, survey, 0)) return false;
    effect->variant = variants[i];
    return true;
}

/* rad: a pair of bearings 50 mm apart with 5 to 150 um of run-out. */
static const mukca_effect_sizes sizes = {.usual = 3, .sigma = {0.1e-3, 0.3e-3, 1e-3, 3e-3}};

const mukca_effect_ops mukca_axis_wobble_effect = {
    .sizes = &sizes,
    .info = {.name = "axis_wobble",
             .title = "axis wobble",
             .site = MUKCA_SITE_ROTATION,
             .varies_with = MUKCA_VARIES_ANGLE,
             .terms = 4,
             .unit = "rad",
             .traits = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_SMOOTH,
             .sentence = "the joint's axis tilts as the joint turns (bearing run-out)",
             .remedy = "check the seat and the preload of the bearing, or compensate it"},
    .basis = wobble_basis,
    .by_angle = wobble_by_angle,
    .variant = &motion,
    .variant_terms = term_names,
    .candidate = wobble_candidate,
};
