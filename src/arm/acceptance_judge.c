/* The verdict of an offsets table: conditions of acceptance. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "arm/acceptance.h"

/* Measurement noise above this, m, means that the samples are of another arm: five times that of
 * the worst published arm. */
static const double foreign_noise = 10e-3;

/* Test data contradict the others if their error is this multiple of that of the others, and more
 * than this part of the nominal model's.  Extrapolation from one placement to another reaches a
 * factor of 10, but then removes most of the error. */
static const double contradiction = 10, left = 0.5;

/* Largest ratio of the tip's displacement to its prior standard deviation.  A normal prior exceeds
 * 5 in one of 1.7 million arms: an error of URDF, labels or units is more probable. */
static const double most_sigma = 5;

void mukca_acceptance_refuse(mukca_acceptance *a, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(a->reason, sizeof a->reason, format, args);
    va_end(args);
    a->given = true;
    a->accepted = false;
}

void mukca_acceptance_judge(mukca_acceptance *a, const char *stop, double others_m)
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
    else if (a->error_m > contradiction * others_m && a->error_m > left * a->error_nominal_m)
        mukca_acceptance_refuse(a,
                                "test error %.4g mm, training error %.4g mm: the data contradict "
                                "each other; check for another arm, tool or tip",
                                1e3 * a->error_m, 1e3 * others_m);
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

void mukca_acceptance_sentence(char text[MUKCA_ACCEPTANCE_SENTENCE], const mukca_acceptance *a,
                               bool factory)
{
    const size_t size = MUKCA_ACCEPTANCE_SENTENCE;
    if (!a->given)
        snprintf(text, size, "no verdict (older, or made by hand)");
    else if (!a->accepted)
        snprintf(text, size, "not accepted: %s", a->reason);
    else if (!isfinite(a->error_m))
        snprintf(text, size, "accepted");
    else
        snprintf(text, size,
                 "accepted: held-out error %.3f mm (%s), %s model %.3f mm; the tip moves by up "
                 "to %.2f mm",
                 1e3 * a->error_m, a->error_of, factory ? "factory" : "nominal",
                 1e3 * a->error_nominal_m, 1e3 * a->tip_change_m);
}
