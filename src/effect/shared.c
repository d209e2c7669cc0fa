/* Functions common to several effects: parsing of variants, candidates, prior sizes. */
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "effect/catalogue.h"

bool mukca_effect_read_number(double *value, const char *text, const char *unit)
{
    char number[MUKCA_EFFECT_TEXT];
    size_t length = strlen(text);
    const size_t tail = strlen(unit);
    if (length > tail && !strcmp(text + length - tail, unit)) length -= tail;
    if (length >= sizeof number) return false;
    memcpy(number, text, length);
    number[length] = '\0';
    return mukca_number_parse(value, number) && fabs(*value) <= MUKCA_NUMBER_LARGEST;
}

bool mukca_effect_read_integer(int *value, const char *text, int lowest, int highest)
{
    double number;
    if (!mukca_number_parse(&number, text) || number != floor(number)) return false;
    if (number < lowest || number > highest) return false;
    *value = (int)number;
    return true;
}

bool mukca_survey_moved(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    return i == 0 && !(survey->joint[effect->joint].range < MUKCA_LEAST_RANGE);
}

bool mukca_survey_loads(const mukca_effect_survey *survey, int joint)
{
    const double change = survey->joint[joint].torque_high - survey->joint[joint].torque_low;
    /* the effect of a load that varies less than this, N m, is absorbed by the joint's zero */
    return survey->torques && survey->joint[joint].torque_most > MUKCA_LEAST_TORQUE &&
           change > 0.01;
}

/* rad/(N m).  Torsional stiffness from makers' catalogues of strain wave gears: size 32 some 15,
 * size 25 some 32, size 14 some 210, size 11 some 450 urad/(N m).  Fits of published arms: Panda
 * joints 2 and 3 some 20, link bending before them 30 to 40, UR5 base 34, IRB 120 base 66, iiwa 7
 * joint 2 some 73.  Rare sizes: small wrists and printed arms.  An arm's own weight rarely deflects
 * a joint by more than 2 mm at the tip. */
const mukca_effect_sizes mukca_sizes_spring = {
    .usual = 4, .sigma = {10e-6, 30e-6, 100e-6, 300e-6, 1e-3, 3e-3, 10e-3}, .most = 3e-3};

/* rad, or rad per rad: an encoder disk of 20 mm radius with an eccentricity of 2 to 60 um has an
 * error of 0.1 to 3 mrad; strain wave gears have a backlash below 0.3 mrad, planetary ones up to 3
 * mrad. */
const mukca_effect_sizes mukca_sizes_angle = {.usual = 4,
                                              .sigma = {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3}};

/* m: a socket, from a nudge to a wrong label. */
const mukca_effect_sizes mukca_sizes_socket = {.usual = 4, .sigma = {0.2e-3, 1e-3, 5e-3, 20e-3}};
