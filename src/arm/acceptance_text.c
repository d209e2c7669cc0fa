/* The verdict of an offsets table: refusal, and its sentence with the basis of the verdict. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "arm/acceptance.h"
#include "base/text.h"

void mukca_acceptance_refuse(mukca_acceptance *a, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(a->reason, sizeof a->reason, format, args);
    va_end(args);
    a->given = true;
    a->accepted = false;
}

static const char *why(const mukca_acceptance *a)
{
    return a->given ? a->reason : "no verdict (older, or made by hand)";
}

/* Whether the table has frames of the measurement only, as of a hand-eye calibration. */
static bool frames_only(const mukca_acceptance *a)
{
    return a->accepted && a->tip_change_m <= 0 && a->largest_offset_m <= 0;
}

void mukca_acceptance_put_tip(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    if (!isfinite(a->error_here_low_m) || frames_only(a)) return;
    const double wider = 1.5; /* less is within the interval of the first number */
    mukca_text_put(text, "expected error %.2f mm [%.2f, %.2f], %s model %.2f mm",
                   1e3 * a->error_here_m, 1e3 * a->error_here_low_m, 1e3 * a->error_here_high_m,
                   factory ? "factory" : "nominal", 1e3 * a->error_before_here_m);
    if (a->error_workspace_m > wider * a->error_here_m)
        mukca_text_put(text, "; %.2f mm beyond the joint ranges of the samples",
                       1e3 * a->error_workspace_m);
    /* of what makes it large, the larger part */
    const double lacking = isfinite(a->error_lacking_m) ? a->error_lacking_m : 0;
    if (lacking > 0 && !(a->error_here_distance_m > lacking))
        mukca_text_put(text, "; %.2f mm of it effects that the table lacks", 1e3 * lacking);
    else if (a->error_here_distance_m > 0)
        mukca_text_put(text, "; %.2f mm of it the sockets' distance",
                       1e3 * a->error_here_distance_m);
    if (a->at_rest[0]) mukca_text_put(text, "; %s did not move", a->at_rest);
}

/* Relative change of all lengths that the measurement should explain, the distance of the sockets
 * or the scale of the poses: eleven published arms differ less from their models. */
static const double notable_size_change = 0.0055; /* 0.6 % if rounded */

void mukca_acceptance_put_use(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    mukca_text_put(text, "%s%s", a->accepted ? "yes" : "no: ", a->accepted ? "" : why(a));
    if (frames_only(a))
        mukca_text_put(text, ", frames only; the arm stays nominal: held-out error %.3f mm (%s)",
                       1e3 * a->error_m, a->error_of);
    else if (a->accepted && isfinite(a->error_m))
        mukca_text_put(
            text, ": held-out error %.3f mm (%s), %s model %.3f mm; the tip moves by up to %.2f mm",
            1e3 * a->error_m, a->error_of, factory ? "factory" : "nominal",
            1e3 * a->error_nominal_m, 1e3 * a->tip_change_m);
    if (a->accepted && fabs(a->size_change) > notable_size_change)
        mukca_text_put(text, "; the arm becomes %.1f %% %s than the model: check %s",
                       1e2 * fabs(a->size_change), a->size_change > 0 ? "larger" : "smaller",
                       isfinite(a->error_here_distance_m)
                           ? "--distance first: a wrong distance of the sockets scales the arm"
                           : "the scale and the units of the measured poses first");
}

void mukca_acceptance_put_brief(mukca_text *text, const mukca_acceptance *a)
{
    mukca_text_put(text, "%saccepted%s%s", a->accepted ? "" : "not ", a->accepted ? "" : ": ",
                   a->accepted ? "" : why(a));
    if (frames_only(a))
        mukca_text_put(text, ", frames only; the arm stays nominal");
    else if (a->accepted && isfinite(a->error_here_low_m))
        mukca_text_put(text, "; expected error of the tip %.2f mm [%.2f, %.2f]",
                       1e3 * a->error_here_m, 1e3 * a->error_here_low_m,
                       1e3 * a->error_here_high_m);
}
