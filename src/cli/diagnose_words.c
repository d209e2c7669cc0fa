/* How a diagnosis names and measures causes for people. */
#include "cli/diagnose_words.h"

#include <math.h>
#include <string.h>

const char *cli_joint_name(const mukca_chain *chain, int joint)
{
    return joint < 0 ? "" : chain->element[chain->joint_element[joint]].name;
}

bool cli_joint_slides(const mukca_chain *chain, int joint)
{
    return joint >= 0 && chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC;
}

const char *cli_effect_unit(mukca_effect_kind kind, const mukca_chain *chain, int joint)
{
    const mukca_effect_info *info = &mukca_effect_table[kind];
    if (info->site != MUKCA_SITE_ANGLE || !cli_joint_slides(chain, joint)) return info->unit;
    return strcmp(info->unit, "rad/(N*m)") == 0 ? "m/N"
           : strcmp(info->unit, "rad/rad") == 0 ? "m/m"
                                                : "m";
}

void cli_effect_words(char text[CLI_WORDS], mukca_effect_kind kind, const mukca_chain *chain,
                      int joint)
{
    snprintf(text, CLI_WORDS, "%s%s%s", mukca_effect_table[kind].name, joint < 0 ? "" : " at ",
             cli_joint_name(chain, joint));
}

void cli_cause_words(char text[CLI_WORDS], const mukca_cause *cause, const mukca_chain *chain,
                     const mukca_dataset *data)
{
    const mukca_effect *e = &cause->effect;
    cli_effect_words(text, e->kind, chain, e->joint);
    const size_t used = strlen(text), room = CLI_WORDS - used;
    char *end = text + used;
    switch (e->kind) {
        case MUKCA_EFFECT_GEAR_HARMONIC:
            snprintf(end, room, ", %d per turn", e->variant);
            break;
        case MUKCA_EFFECT_JOINT_COUPLING:
            snprintf(end, room, ", driven by %s", cli_joint_name(chain, e->joint + e->variant));
            break;
        case MUKCA_EFFECT_JOINT_DRIFT:
            if (e->variant > 0)
                snprintf(end, room, ", settling within %d min", (e->variant + 30) / 60);
            else
                snprintf(end, room, ", per 1000 s");
            break;
        case MUKCA_EFFECT_READBACK_LAG:
            snprintf(end, room, e->variant ? ", towards the commanded angles" : ", all joints");
            break;
        case MUKCA_EFFECT_ZERO_JUMP:
        case MUKCA_EFFECT_BALL_SHIFT:
            if (e->placement >= 0)
                snprintf(end, room, " in placement %s", data->placements[e->placement].name);
            break;
        default:
            break;
    }
}

/* "44.6 [37.4, 51.8] unit" of values times a factor, three digits of the value. */
static int print_interval(char *text, size_t room, const mukca_cause *c, double factor,
                          const char *unit)
{
    const double value = factor * c->amplitude, low = factor * c->low, high = factor * c->high;
    const double half = fmax(fabs(high - value), 1e-12);
    int digits = (int)ceil(-log10(half)) + 1; /* two figures of the half width */
    digits = digits < 0 ? 0 : digits > 4 ? 4 : digits;
    return snprintf(text, room, "%.*f [%.*f, %.*f] %s", digits, value, digits, low, digits, high,
                    unit);
}

void cli_cause_size(char text[CLI_WORDS], const mukca_cause *cause, const mukca_chain *chain)
{
    const char *unit = cli_effect_unit(cause->effect.kind, chain, cause->effect.joint);
    int used;
    if (cause->effect.kind == MUKCA_EFFECT_READBACK_LAG && cause->effect.variant) {
        print_interval(text, CLI_WORDS, cause, 100, "% of command minus reading");
    } else if (strcmp(unit, "rad/(N*m)") == 0 || strcmp(unit, "m/N") == 0) {
        const bool turns = unit[0] == 'r';
        used = print_interval(text, CLI_WORDS, cause, 1e6, turns ? "urad/(N*m)" : "um/N");
        if (cause->amplitude > 0)
            snprintf(text + used, (size_t)(CLI_WORDS - used), ", stiffness %.3g %s",
                     1e-3 / cause->amplitude, turns ? "kN*m/rad" : "kN/m");
    } else if (strcmp(unit, "rad/rad") == 0) {
        used = print_interval(text, CLI_WORDS, cause, 1e3, "mrad/rad");
        snprintf(text + used, (size_t)(CLI_WORDS - used), ", %.2g arcmin over 90 degrees",
                 CLI_ARCMIN * M_PI_2 * cause->amplitude);
    } else if (strcmp(unit, "rad") == 0) {
        used = print_interval(text, CLI_WORDS, cause, CLI_ARCMIN, "arcmin");
        snprintf(text + used, (size_t)(CLI_WORDS - used), ", %.3g mrad", 1e3 * cause->amplitude);
    } else {
        print_interval(text, CLI_WORDS, cause, 1e3, strcmp(unit, "m/m") == 0 ? "mm/m" : "mm");
    }
}
