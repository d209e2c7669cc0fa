/* Targets in robot programs: patterns of whole lines, one set per language. */
#include "io/language.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "base/text.h"

enum { ROBOT_AXES = 6, MOST_AXES = 12, PATTERN = 320, NUMBERS = 24, LINES = 16 };

/* Patterns: ? is a number, * any text without brackets and semicolons, @ a joint target, a blank
 * one or more blanks; other characters may be preceded by blanks. */
struct mukca_language {
    const char *open, *next, *close; /* of a joint target; `next` before the first external axis */
    char label[2]; /* letters before the number of a robot axis and of an external axis */
    bool all_axes; /* a target has values for axes that the arm lacks, too */
    /* Lines of programs, in addition to a target alone.  None may start a motion elsewhere: what is
     * not listed here is unknown. */
    const char *lines[LINES];
    double angle, length; /* rad and m per unit of the language */
    int decimals;         /* printed: 0.02 urad, 1 nm */
    char comment;         /* first character of a comment */
};

#define DEGREE (M_PI / 180)

static const mukca_language rapid = {
    .open = "[[",
    .next = "],[",
    .close = "]]",
    .all_axes = true,
    .lines = {"MoveAbsJ@*;", "MODULE *", "ENDMODULE", "PROC *()", "ENDPROC", "WaitTime *;",
              "Set *;", "Reset *;", "SetDO *;", "WaitDI *;", "AccSet *;", "WHILE *DO", "ENDWHILE"},
    .angle = DEGREE,
    .length = 1e-3,
    .decimals = 6,
    .comment = '!'};

static const mukca_language krl = {
    .open = "{*",
    .next = ",",
    .close = "*}",
    .label = {'A', 'E'},
    .lines = {"PTP@*", "SPTP@*", "&*", "DEF *()", "END", "INI", "BAS(*)", "WAIT SEC *", "$OUT[*]=*",
              "LOOP", "ENDLOOP"},
    .angle = DEGREE,
    .length = 1e-3,
    .decimals = 6,
    .comment = ';'};

static const mukca_language urscript = {
    .open = "[",
    .next = ",",
    .close = "]",
    .lines = {"movej(@*)", "movel(@*)", "movep(@*)", "servoj(@*)", "def *():", "end",
              "while *:", "sleep(*)", "sync()", "textmsg(*)", "set_digital_out(*)",
              "set_standard_digital_out(*)", "set_tcp(p[*])"},
    .angle = 1,
    .length = 1,
    .decimals = 9,
    .comment = '#'};

const mukca_language *const mukca_languages[] = {
#define ADDRESS(name, description) &(name),
    MUKCA_LANGUAGE_LIST(ADDRESS)
#undef ADDRESS
};

/* The numbers of a line; the text of each is line[span[0] .. span[1]). */
typedef struct {
    int n;
    double value[NUMBERS];
    size_t span[NUMBERS][2];
} number_list;

/* Form the pattern of a joint target with ? for each axis. */
static void joint_pattern(mukca_text *pattern, const mukca_language *l, const mukca_chain *chain)
{
    const int n = l->all_axes ? MOST_AXES : chain->n_joints;
    mukca_text_put(pattern, "%s", l->open);
    for (int axis = 0; axis < n; axis++) {
        const bool external = axis >= ROBOT_AXES;
        const char *separator = axis == 0 ? "" : axis == ROBOT_AXES ? l->next : ",";
        mukca_text_put(pattern, l->label[0] ? "%s%c%d ?" : "%s?", separator, l->label[external],
                       axis - (external ? ROBOT_AXES : 0) + 1);
    }
    mukca_text_put(pattern, "%s", l->close);
}

/* Read a number at line[at]; returns its end, 0: no number. */
static size_t read_number(double *value, const char *line, size_t at)
{
    char text[64];
    const size_t length = strspn(line + at, "+-0123456789.eE");
    if (length == 0 || length >= sizeof text) return 0;
    memcpy(text, line + at, length);
    text[length] = '\0';
    return mukca_number_parse(value, text) ? at + length : 0;
}

static size_t skip_blanks(const char *line, size_t at)
{
    while (isblank((unsigned char)line[at])) at++;
    return at;
}

/* Whether the pattern matches all of line + at, but for a comment; collects the numbers. */
static bool matches(number_list *found, const char *pattern, const char *line, size_t at,
                    char comment)
{
    for (const char *p = pattern; *p; p++) {
        if (*p == '*') { /* up to the first position from which the rest matches */
            const int n = found->n;
            for (;; at++) {
                if (matches(found, p + 1, line, at, comment)) return true;
                found->n = n;
                if (!line[at] || line[at] == comment || strchr("{}[]();", line[at])) return false;
            }
        }
        const bool in_word =
            p > pattern && isalnum((unsigned char)*p) && isalnum((unsigned char)p[-1]);
        if (*p != ' ' && !in_word) at = skip_blanks(line, at);
        if (*p == '?') {
            const size_t end =
                found->n < NUMBERS ? read_number(&found->value[found->n], line, at) : 0;
            if (end == 0) return false;
            found->span[found->n][0] = at;
            found->span[found->n++][1] = at = end;
        } else if (*p == ' ' ? !isblank((unsigned char)line[at])
                             : toupper((unsigned char)line[at]) != toupper((unsigned char)*p)) {
            return false;
        } else {
            at++;
        }
    }
    at = skip_blanks(line, at);
    return !line[at] || line[at] == comment || (line[at] == '\r' && !line[at + 1]);
}

static bool is_linear(const mukca_chain *chain, int joint)
{
    return chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC;
}

mukca_program_line mukca_language_read(mukca_program_target *t, const mukca_language *l,
                                       const mukca_chain *chain, const char *line)
{
    char joints[PATTERN] = "", pattern[PATTERN + 32];
    mukca_text text = MUKCA_TEXT(joints);
    number_list found = {0};
    joint_pattern(&text, l, chain);
    if (matches(&found, "", line, 0, l->comment)) return MUKCA_LINE_OTHER;
    bool known = matches(&found, joints, line, 0, l->comment), target = known;
    for (int i = 0; !known && l->lines[i]; i++) {
        const char *form = l->lines[i], *slot = strchr(form, '@');
        const int before = (int)(slot ? (size_t)(slot - form) : strlen(form));
        snprintf(pattern, sizeof pattern, "%.*s%s%s", before, form, slot ? joints : "",
                 slot ? slot + 1 : "");
        found.n = 0;
        known = matches(&found, pattern, line, 0, l->comment);
        target = slot != NULL;
    }
    if (!known) return MUKCA_LINE_UNKNOWN;
    if (!target) return MUKCA_LINE_OTHER;
    for (int j = 0; j < chain->n_joints; j++)
        t->q[j] = found.value[j] * (is_linear(chain, j) ? l->length : l->angle);
    memcpy(t->number, found.span, (size_t)chain->n_joints * sizeof *t->number);
    return MUKCA_LINE_TARGET;
}

int mukca_language_axes(const mukca_language *language)
{
    return language->all_axes || language->label[0] ? MOST_AXES : MUKCA_MAX_JOINTS;
}

void mukca_language_replace(FILE *stream, const mukca_language *l, const mukca_chain *chain,
                            const char *line, const mukca_program_target *t, const double *q)
{
    size_t at = 0;
    for (int j = 0; j < chain->n_joints; j++) {
        fwrite(line + at, 1, t->number[j][0] - at, stream);
        fprintf(stream, "%.*f", l->decimals, q[j] / (is_linear(chain, j) ? l->length : l->angle));
        at = t->number[j][1];
    }
    fputs(line + at, stream);
}
