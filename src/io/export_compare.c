/* Comparing an exported file with what would be exported now. */
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "io/export.h"

/* m, rad; the same bound below which an offset is not exported */
static const double tolerance = 1e-9;

void mukca_export_add_difference(mukca_export_difference *d, double position, double angle,
                                 const char *where, const char *what)
{
    d->compared++;
    if (!(position <= d->position && angle <= d->angle) || d->where[0] == '\0')
        snprintf(d->where, sizeof d->where, "%.80s%s%s", where, *what ? " " : "", what);
    if (!(position <= d->position)) d->position = position;
    if (!(angle <= d->angle)) d->angle = angle;
    d->agrees = d->agrees && position <= tolerance && angle <= tolerance;
}

void mukca_export_add_missing(mukca_export_difference *d, const char *what, const char *name)
{
    if (d->agrees) snprintf(d->where, sizeof d->where, "%s '%.80s' is missing", what, name);
    d->agrees = false;
}

double mukca_export_distance(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(mukca_dot3(d, d));
}

/* Behind the comment or string (names contain digits) that starts at `c`; `c` where none does. */
static const char *skip_words(const char *c, const char *const comment[2])
{
    const bool string = *c == '"';
    if (!string && strncmp(c, comment[0], strlen(comment[0])) != 0) return c;
    const char *mark = string ? "\"" : comment[1];
    const char *end = strstr(c + 1, mark);
    return end ? end + strlen(mark) : c + strlen(c);
}

/* The next number outside of comments and strings, moving *text behind it; false at the end. */
static bool next_number(double *value, const char **text, const char *const comment[2])
{
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789.+-";
    const char *c = *text;
    while (*c) {
        const char *behind = skip_words(c, comment);
        const size_t word = behind == c ? strspn(c, letters) : 0;
        char number[64];
        if (behind != c) {
            c = behind;
            continue;
        }
        if (word > 0 && word < sizeof number) {
            memcpy(number, c, word);
            number[word] = '\0';
            if (mukca_number_parse(value, number)) {
                *text = c + word;
                return true;
            }
        }
        c += word > 0 ? word : 1;
    }
    *text = c;
    return false;
}

void mukca_export_compare_numbers(mukca_export_difference *difference,
                                  const mukca_export_texts *texts, const char *const comment[2])
{
    const char *found = texts->found, *wanted = texts->wanted;
    for (int i = 1;; i++) {
        double a, b;
        char where[40];
        const bool more = next_number(&a, &found, comment), due = next_number(&b, &wanted, comment);
        if (!more && !due) return;
        snprintf(where, sizeof where, "number %d", i);
        if (more != due) {
            mukca_export_add_missing(difference, more ? "the table for" : "in the file,", where);
            return;
        }
        mukca_export_add_difference(difference, fabs(a - b), 0, where, "");
    }
}
