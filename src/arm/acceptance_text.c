/* The verdict of an offsets table: refusal, and its sentence with the basis of the verdict. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "arm/acceptance.h"

void mukca_acceptance_refuse(mukca_acceptance *a, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(a->reason, sizeof a->reason, format, args);
    va_end(args);
    a->given = true;
    a->accepted = false;
}

void mukca_acceptance_basis(char text[MUKCA_ACCEPTANCE_SENTENCE], const mukca_acceptance *a,
                            bool factory)
{
    const char *before = factory ? "factory" : "nominal";
    text[0] = '\0';
    if (!isfinite(a->error_here_m)) return;
    snprintf(text, MUKCA_ACCEPTANCE_SENTENCE,
             "; %.0f different postures%s%s%s; expected error of the tip %.3f mm in their joint "
             "ranges (%s %.3f mm), %.3f mm within the joint limits (%s %.3f mm)",
             a->postures, a->at_rest[0] ? ", " : "", a->at_rest,
             a->at_rest[0] ? " did not move" : "", 1e3 * a->error_here_m, before,
             1e3 * a->error_before_here_m, 1e3 * a->error_workspace_m, before,
             1e3 * a->error_before_m);
}

void mukca_acceptance_sentence(char text[MUKCA_ACCEPTANCE_SENTENCE], const mukca_acceptance *a,
                               bool factory)
{
    const size_t size = MUKCA_ACCEPTANCE_SENTENCE;
    const char *before = factory ? "factory" : "nominal";
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
                 1e3 * a->error_m, a->error_of, before, 1e3 * a->error_nominal_m,
                 1e3 * a->tip_change_m);
    const size_t used = strlen(text);
    char basis[MUKCA_ACCEPTANCE_SENTENCE];
    mukca_acceptance_basis(basis, a, factory);
    if (a->given) snprintf(text + used, size - used, "%s", basis);
}
