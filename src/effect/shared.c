/* What the families of effects share: reading variants, and candidates. */
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

bool mukca_survey_placement(mukca_effect *effect, const mukca_effect_survey *survey, int i)
{
    effect->placement = i;
    return survey->n_placements > 1 && i < survey->n_placements;
}

bool mukca_survey_loads(const mukca_effect_survey *survey, int joint)
{
    const double change = survey->joint[joint].torque_high - survey->joint[joint].torque_low;
    /* a load that varies less than this, N m, cannot be told from the joint's zero */
    return survey->torques && survey->joint[joint].torque_most > MUKCA_LEAST_TORQUE &&
           change > 0.01;
}
