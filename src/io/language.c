/* Targets in the languages of robot programs: patterns that find and print them. */
#include "io/language.h"

#include <ctype.h>
#include <string.h>

#include "base/number.h"
#include "io/rows.h"

enum { ROBOT_AXES = 6, PATTERN = 256, NUMBERS = 24 };

typedef enum { QUATERNION, ZYX, VECTOR } turn_kind;

/* Texts are patterns as well: # is a number, * any text within the same brackets (nothing where a
 * target is printed), a blank some blanks; before other characters there may be blanks. */
struct mukca_language {
    const char *open, *next, *close; /* of a joint target; `next` before the first external axis */
    char label[2];                   /* letter before the number of a robot's or external axis */
    const char *empty[2];            /* values of axes that the arm lacks; NULL: left out */
    const char *line[2];             /* around a target that is a line of its own */
    const char *const *after;        /* texts that a target must follow; NULL: any */
    const char *pose;
    const char *joint_move; /* the moves that take a joint target; NULL: those of poses as well */
    turn_kind turn;
    double angle, length; /* rad and m of its units */
    int decimals;         /* 0.02 urad, 1 nm */
    char comment;         /* begins one */
};

#define DEGREE (3.14159265358979323846 / 180)

/* Other lists of six numbers in URScript are forces or speeds; waypoints NAME_q are written by the
 * teach pendant. */
static const char *const moves[] = {"movej(", "movel(", "movep(", "servoj(", "_q=", "_q =", NULL};

static const mukca_language rapid = {.open = "[[",
                                     .next = "],[",
                                     .close = "]]",
                                     .empty = {"0", "9E9"},
                                     .line = {"", ""},
                                     .pose = "[[#,#,#],[#,#,#,#],[#,#,#,#],[#,#,#,#,#,#]]",
                                     .joint_move = "MoveAbsJ, and declare them as jointtarget",
                                     .turn = QUATERNION,
                                     .angle = DEGREE,
                                     .length = 1e-3,
                                     .decimals = 6,
                                     .comment = '!'};

static const mukca_language krl = {.open = "{*",
                                   .next = ",",
                                   .close = "*}",
                                   .label = {'A', 'E'},
                                   .line = {"", ""},
                                   .pose = "{*X #,Y #,Z #,A #,B #,C #*}",
                                   .joint_move = "PTP, and declare them as E6AXIS",
                                   .turn = ZYX,
                                   .angle = DEGREE,
                                   .length = 1e-3,
                                   .decimals = 6,
                                   .comment = ';'};

static const mukca_language urscript = {.open = "[",
                                        .next = ",",
                                        .close = "]",
                                        .line = {"movej(", ")"},
                                        .after = moves,
                                        .pose = "p[#,#,#,#,#,#]",
                                        .turn = VECTOR,
                                        .angle = 1,
                                        .length = 1,
                                        .decimals = 9,
                                        .comment = '#'};

const mukca_language *const mukca_languages[] = {
#define ADDRESS(name, description) &(name),
    MUKCA_LANGUAGE_LIST(ADDRESS)
#undef ADDRESS
};

/* The text of a joint target with # for each axis. */
static void joint_pattern(char pattern[PATTERN], const mukca_language *l, const mukca_chain *chain)
{
    const int n = l->empty[0] ? 2 * ROBOT_AXES : chain->n_joints;
    int used = snprintf(pattern, PATTERN, "%s", l->open);
    for (int axis = 0; axis < n; axis++) {
        const bool external = axis >= ROBOT_AXES;
        const char *separator = axis == 0 ? "" : axis == ROBOT_AXES ? l->next : ",";
        used += snprintf(pattern + used, (size_t)(PATTERN - used), "%s", separator);
        if (l->label[0])
            used += snprintf(pattern + used, (size_t)(PATTERN - used), "%c%d ", l->label[external],
                             axis - (external ? ROBOT_AXES : 0) + 1);
        pattern[used++] = '#';
    }
    snprintf(pattern + used, (size_t)(PATTERN - used), "%s", l->close);
}

typedef struct {
    int n;
    double value[NUMBERS];
    size_t span[NUMBERS][2];
} numbers;

/* Match a number at line[at]; returns its end, 0: none. */
static size_t match_number(numbers *found, const char *line, size_t at)
{
    char text[64];
    const size_t length = strspn(line + at, "+-0123456789.eE");
    if (length == 0 || length >= sizeof text || found->n == NUMBERS) return 0;
    const bool plus = line[at] == '+';
    memcpy(text, line + at + plus, length - plus);
    text[length - plus] = '\0';
    if (!mukca_number_parse(&found->value[found->n], text)) return 0;
    found->span[found->n][0] = at;
    found->span[found->n++][1] = at + length;
    return at + length;
}

/* Match the pattern at line[at]; returns the end of the match, 0: none. */
static size_t match(numbers *found, const char *pattern, const char *line, size_t at)
{
    for (const char *p = pattern; *p; p++) {
        if (*p == ' ') {
            if (!isblank((unsigned char)line[at])) return 0;
            continue;
        }
        if (*p == '*') { /* up to where the rest matches */
            const numbers so_far = *found;
            for (;; at++) {
                const size_t end = match(found, p + 1, line, at);
                if (end) return end;
                *found = so_far;
                if (!line[at] || strchr("{}[]", line[at])) return 0;
            }
        }
        const bool in_word =
            p > pattern && isalnum((unsigned char)*p) && isalnum((unsigned char)p[-1]);
        while (!in_word && isblank((unsigned char)line[at])) at++;
        if (*p == '#') {
            at = match_number(found, line, at);
            if (at == 0) return 0;
        } else if (line[at++] != *p) {
            return 0;
        }
    }
    return at;
}

/* Does line[at] follow one of the texts? */
static bool follows(const mukca_language *l, const char *line, size_t at)
{
    if (!l->after) return true;
    while (at > 0 && isblank((unsigned char)line[at - 1])) at--;
    for (const char *const *text = l->after; *text; text++) {
        const size_t length = strlen(*text);
        if (at >= length && strncmp(line + at - length, *text, length) == 0) return true;
    }
    return false;
}

static bool is_linear(const mukca_chain *chain, int joint)
{
    return chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC;
}

static bool take_pose(mukca_frame *pose, const mukca_language *l, const double *v)
{
    double turn[4] = {v[3] * l->angle, v[4] * l->angle, v[5] * l->angle};
    for (int i = 0; i < 3; i++) pose->p[i] = v[i] * l->length;
    if (l->turn == ZYX) {
        const double rpy[3] = {turn[2], turn[1], turn[0]};
        mukca_rotation_from_rpy(pose->R, rpy);
    } else if (l->turn == VECTOR) {
        mukca_rotation_exp(pose->R, turn);
    } else {
        memcpy(turn, v + 3, sizeof turn);
        if (!mukca_rows_normalise(turn)) return false;
        mukca_rotation_from_quaternion(pose->R, turn);
    }
    return true;
}

bool mukca_language_find(mukca_program_target *t, const mukca_language *l, const mukca_chain *chain,
                         bool pose, const char *line, size_t from)
{
    char pattern[PATTERN];
    joint_pattern(pattern, l, chain);
    for (size_t at = from; line[at] && line[at] != l->comment; at++) {
        numbers found = {0};
        const char *const wanted = pose ? l->pose : pattern;
        if (line[at] != *wanted || !follows(l, line, at)) continue;
        t->end = match(&found, wanted, line, at);
        if (t->end == 0 || (pose && !take_pose(&t->pose, l, found.value))) continue;
        t->begin = at;
        for (int j = 0; j < chain->n_joints && !pose; j++) {
            t->q[j] = found.value[j] * (is_linear(chain, j) ? l->length : l->angle);
            memcpy(t->number[j], found.span[j], sizeof t->number[j]);
        }
        return true;
    }
    return false;
}

const char *mukca_language_joint_move(const mukca_language *language)
{
    return language ? language->joint_move : NULL;
}

static void print_value(FILE *stream, const mukca_language *l, const mukca_chain *chain, int j,
                        double q)
{
    fprintf(stream, "%.*f", l->decimals, q / (is_linear(chain, j) ? l->length : l->angle));
}

void mukca_language_print(FILE *stream, const mukca_language *l, const mukca_chain *chain,
                          const double *q, bool alone)
{
    char pattern[PATTERN];
    int axis = 0;
    joint_pattern(pattern, l, chain);
    if (alone) fputs(l->line[0], stream);
    for (const char *p = pattern; *p; p++) {
        if (*p != '#') {
            if (*p != '*') fputc(*p, stream);
        } else if (axis < chain->n_joints) {
            print_value(stream, l, chain, axis, q[axis]);
            axis++;
        } else {
            fputs(l->empty[axis++ >= ROBOT_AXES], stream);
        }
    }
    if (alone) fputs(l->line[1], stream);
}

void mukca_language_replace(FILE *stream, const mukca_language *l, const mukca_chain *chain,
                            const mukca_program_target *t, const char *line, const double *q)
{
    size_t at = t->begin;
    for (int j = 0; j < chain->n_joints; j++) {
        fwrite(line + at, 1, t->number[j][0] - at, stream);
        print_value(stream, l, chain, j, q[j]);
        at = t->number[j][1];
    }
    fwrite(line + at, 1, t->end - at, stream);
}
