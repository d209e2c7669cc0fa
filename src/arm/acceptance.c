/* The verdict of an offsets table: its gates, and its comment lines. */
#include "arm/acceptance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

/* Measurement noise above this, m, means that the samples are not those of this arm: five times
 * what the worst published arm shows. */
static const double foreign_noise = 10e-3;

/* Displacement of the tip over its prior standard deviation.  A normal prior exceeds 5 once in 1.7
 * million arms: the URDF, the labels or the units are wrong instead. */
static const double most_sigma = 5;

const mukca_acceptance_number mukca_acceptance_numbers[] = {
#define NUMBER(key) {#key, offsetof(mukca_acceptance, key)},
    MUKCA_ACCEPTANCE_LIST(NUMBER)
#undef NUMBER
        {NULL, 0}};

static double *number(mukca_acceptance *a, int i)
{
    return (double *)(void *)((char *)a + mukca_acceptance_numbers[i].offset);
}

void mukca_acceptance_init(mukca_acceptance *a)
{
    memset(a, 0, sizeof *a);
    for (int i = 0; mukca_acceptance_numbers[i].key; i++) *number(a, i) = NAN;
}

void mukca_acceptance_refuse(mukca_acceptance *a, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(a->reason, sizeof a->reason, format, args);
    va_end(args);
    a->given = true;
    a->accepted = false;
}

void mukca_acceptance_judge(mukca_acceptance *a, const char *stop)
{
    a->given = a->accepted = true;
    a->reason[0] = '\0';
    if (a->determined == 0)
        mukca_acceptance_refuse(a,
                                "the samples determine none of %.0f parameter combinations better "
                                "than the regularisation; record postures that differ more",
                                a->parameters);
    else if (a->noise_m >= foreign_noise)
        mukca_acceptance_refuse(a,
                                "the samples do not fit this arm (by %.3g mm); check the URDF, the "
                                "tip, the columns, the socket labels and the distances",
                                1e3 * a->noise_m);
    else if (!a->converged)
        mukca_acceptance_refuse(a, "NOT CONVERGED (%s); check the data with mukca diagnose",
                                stop ? stop : "out of iterations");
    else if (!isfinite(a->error_m))
        mukca_acceptance_refuse(a, "no held-out error is known; record more samples");
    else if (a->error_m >= a->error_nominal_m)
        mukca_acceptance_refuse(a,
                                "held-out error %.4g mm, no better than the nominal model with "
                                "%.4g mm; record more samples",
                                1e3 * a->error_m, 1e3 * a->error_nominal_m);
    else if (!(a->tip_change_sigma <= most_sigma))
        mukca_acceptance_refuse(a,
                                "moves the tip by %.4g mm, %.1f standard deviations of its prior; "
                                "check the URDF and the samples",
                                1e3 * a->tip_change_m, a->tip_change_sigma);
}

/* The text after "# KEY: " of a line, else NULL. */
static const char *value_of(const char *line, const char *key)
{
    const size_t length = strlen(key);
    if (strncmp(line, "# ", 2) != 0 || strncmp(line + 2, key, length) != 0) return NULL;
    return strncmp(line + 2 + length, ": ", 2) == 0 ? line + length + 4 : NULL;
}

void mukca_acceptance_read(mukca_acceptance *a, const char *line)
{
    const char *text = value_of(line, "accepted");
    if (text && strcmp(text, "yes") == 0) {
        a->accepted = !a->given || a->accepted; /* one refusal is enough */
        a->given = true;
    } else if (text) {
        text += strncmp(text, "no; ", 4) == 0 ? 4 : 0;
        mukca_acceptance_refuse(a, "%s", text);
    } else if (strcmp(line, "# NOT CONVERGED") == 0) { /* release 0.1.0 */
        mukca_acceptance_refuse(a, "NOT CONVERGED");
    }
    text = value_of(line, "converged");
    if (text) a->converged = strcmp(text, "yes") == 0;
    text = value_of(line, "error_of");
    if (text) snprintf(a->error_of, sizeof a->error_of, "%.63s", text);
    for (int i = 0; mukca_acceptance_numbers[i].key; i++) {
        text = value_of(line, mukca_acceptance_numbers[i].key);
        if (text && !mukca_number_parse(number(a, i), text)) *number(a, i) = NAN;
    }
}
