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

void mukca_acceptance_put_tip(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    if (!isfinite(a->error_here_low_m)) return;
    mukca_text_put(text,
                   "expected error %.2f mm [%.2f, %.2f] in the joint ranges of the samples, %.2f "
                   "mm [%.2f, %.2f] within the joint limits (%s model: %.2f mm and %.2f mm)",
                   1e3 * a->error_here_m, 1e3 * a->error_here_low_m, 1e3 * a->error_here_high_m,
                   1e3 * a->error_workspace_m, 1e3 * a->error_workspace_low_m,
                   1e3 * a->error_workspace_high_m, factory ? "factory" : "nominal",
                   1e3 * a->error_before_here_m, 1e3 * a->error_before_m);
    if (isfinite(a->error_here_unscaled_m))
        mukca_text_put(
            text,
            "; without the error of scale (socket distance known to 0.1 mm) %.2f mm and %.2f mm",
            1e3 * a->error_here_unscaled_m, 1e3 * a->error_workspace_unscaled_m);
}

void mukca_acceptance_put_basis(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    if (!isfinite(a->error_here_low_m)) return;
    mukca_text_put(text, "; %.0f different postures", a->postures);
    if (a->at_rest[0]) mukca_text_put(text, ", %s did not move", a->at_rest);
    mukca_text_put(text, "; tip: ");
    mukca_acceptance_put_tip(text, a, factory);
}

/* Relative change of all lengths that the distance of the sockets should explain: four standard
 * deviations, of 0.1 mm in 50 mm and of 0.2 % in the arm. */
static const double notable_size_change = 0.01;

/* The verdict after its first word. */
static void put_reason(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    if (!a->accepted)
        mukca_text_put(text, ": %s", a->reason);
    else if (isfinite(a->error_m))
        mukca_text_put(
            text, ": held-out error %.3f mm (%s), %s model %.3f mm; the tip moves by up to %.2f mm",
            1e3 * a->error_m, a->error_of, factory ? "factory" : "nominal",
            1e3 * a->error_nominal_m, 1e3 * a->tip_change_m);
    if (a->accepted && fabs(a->size_change) > notable_size_change)
        mukca_text_put(
            text,
            "; the arm becomes %.1f %% %s than the model: measure the sockets' distance again",
            1e2 * fabs(a->size_change), a->size_change > 0 ? "larger" : "smaller");
}

void mukca_acceptance_put_use(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    mukca_text_put(text, a->accepted ? "yes" : "no");
    put_reason(text, a, factory);
}

void mukca_acceptance_put(mukca_text *text, const mukca_acceptance *a, bool factory)
{
    mukca_text_put(text, !a->given     ? "no verdict (older, or made by hand)"
                         : a->accepted ? "accepted"
                                       : "not accepted");
    if (!a->given) return;
    put_reason(text, a, factory);
    mukca_acceptance_put_basis(text, a, factory);
}
