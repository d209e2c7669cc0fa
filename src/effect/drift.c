/* Joint drift: the zero of a joint changes with time, for example in a warming gear. */
#include <math.h>

#include "base/print.h"
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

static void describe(char *text, size_t size, const mukca_effect *effect, const mukca_chain *chain)
{
    const double constant = effect->variant.time_constant;
    (void)chain;
    if (constant > 0)
        mukca_print(text, size, " (settles within %d min)", (int)((constant + 30) / 60));
    else
        mukca_print(text, size, " (per 1000 s)");
}

const mukca_effect_ops mukca_joint_drift_effect = {
    .info = {.name = "joint_drift",
             .title = "joint drift",
             .site = MUKCA_SITE_ANGLE,
             .terms = 1,
             MUKCA_IN_MRAD,
             .needs = MUKCA_NEEDS_ORDER,
             .traits = MUKCA_TRAIT_OF_TIME,
             .sentence = "the joint's zero changes during the session, as in a warming gear",
             .remedy = "warm the arm up before recording and before use"},
    .basis = drift_basis,
    .variant = &time_constant,
    .describe = describe,
    .candidate = drift_candidate,
};
