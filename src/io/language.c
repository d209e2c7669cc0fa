/* Targets in robot programs: patterns that find and print them, one set per language. */
#include "io/language.h"

#include <ctype.h>
#include <string.h>

#include "base/number.h"
#include "io/pattern.h"
#include "io/rows.h"

enum { ROBOT_AXES = 6, MOST_AXES = 12, PATTERN = 256 };

typedef enum { QUATERNION, ZYX, VECTOR } turn_kind;

/* Patterns: # is a number, * any text within the same brackets (empty in a printed target), a blank
 * one or more blanks; other characters may be preceded by blanks. */
struct mukca_language {
    const char *open, *next, *close; /* of a joint target; `next` before the first external axis */
    char label[2];        /* letters before the number of a robot axis and of an external axis */
    const char *empty[2]; /* values printed for axes that the arm lacks; NULL: omitted */
    const char *line[2];  /* text before and after a target on a line of its own */
    const char *const *after; /* texts that may precede a target; NULL: any */
    const char *pose; /* pattern of a pose; NULL: X, Y, Z, A, B, C in any order, some omitted */
    turn_kind turn;
    double angle, length; /* rad and m per unit of the language */
    int decimals;         /* printed: 0.02 urad, 1 nm */
    char comment;         /* first character of a comment */
};

#define DEGREE (3.14159265358979323846 / 180)

/* Calls and assignments whose lists of six numbers are targets; others in URScript are forces or
 * speeds.  The teach pendant writes waypoints as NAME_q. */
static const char *const moves[] = {"movej(", "movel(", "movep(", "movec(", "servoj(",
                                    "_q=",    "_q =",   "_p=",    "_p =",   NULL};

static const mukca_language rapid = {.open = "[[",
                                     .next = "],[",
                                     .close = "]]",
                                     .empty = {"0", "9E9"},
                                     .line = {"", ""},
                                     .pose = "[[#,#,#],[#,#,#,#],[#,#,#,#],[#,#,#,#,#,#]]",
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

/* Form the pattern of a joint target with # for each axis. */
static void joint_pattern(char pattern[PATTERN], const mukca_language *l, const mukca_chain *chain)
{
    const int n = l->empty[0] ? MOST_AXES : chain->n_joints;
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

/* Whether one of the permitted texts precedes line[at]. */
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

/* Whether line[at] is the second argument of a move such as movec, directly after the first. */
static bool is_second(const mukca_program_reader *r, size_t at)
{
    return r->found && r->line[r->at] == ',' && strspn(r->line + r->at, ", \t") == at - r->at;
}

static bool is_linear(const mukca_chain *chain, int joint)
{
    return chain->element[chain->joint_element[joint]].type == MUKCA_PRISMATIC;
}

static bool convert_pose(mukca_frame *pose, const mukca_language *l, const double *v)
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

/* Read the word at line[at] in capitals, truncated to word[16]; returns its end. */
static size_t read_word(char word[16], const char *line, size_t at)
{
    size_t n = 0;
    for (; isalnum((unsigned char)line[at]) || line[at] == '_'; at++)
        if (n < 15) word[n++] = (char)toupper((unsigned char)line[at]);
    word[n] = '\0';
    return at;
}

/* Index of a KRL component in its target: X Y Z A B C, or A1 ... A6 E1 ...; -1: none. */
static int component(const mukca_program_reader *r, const char *key)
{
    static const char poses[] = "XYZABC";
    const char *letter = *key ? strchr(poses, *key) : NULL;
    double number;
    if (r->pose) return letter && !key[1] ? (int)(letter - poses) : -1;
    if ((*key != 'A' && *key != 'E') || !mukca_number_parse(&number, key + 1)) return -1;
    if (!(number >= 1 && number <= ROBOT_AXES)) return -1;
    const int axis = (int)number - 1 + (*key == 'E' ? ROBOT_AXES : 0);
    return axis < r->chain->n_joints ? axis : -1;
}

/* Match {TYPE: KEY value, ...}; returns the end, 0: no match, or no component of a target. */
static size_t match_components(mukca_program_target *t, const mukca_program_reader *r, size_t at)
{
    const char *line = r->line;
    char key[16];
    bool any = false;
    size_t end = read_word(key, line, mukca_pattern_skip_blanks(line, at + 1));
    end = mukca_pattern_skip_blanks(line, end);
    if (line[end] == ':') at = end;
    do {
        double value;
        at = mukca_pattern_skip_blanks(
            line, read_word(key, line, mukca_pattern_skip_blanks(line, at + 1)));
        end = mukca_pattern_number(&value, line, at);
        const int k = component(r, key);
        if (k >= 0 && (end == 0 || t->number[k][1])) return 0;
        if (k >= 0) t->number[k][0] = at, t->number[k][1] = end, t->value[k] = value;
        any |= k >= 0;
        at = end ? end : at + strcspn(line + at, ",{}");
        at = mukca_pattern_skip_blanks(line, at);
    } while (line[at] == ',');
    return any && line[at] == '}' ? at + 1 : 0;
}

/* Whether an aggregate is a target: not a frame of tool, base or load, nor an offset to another
 * position. */
static bool is_target(const mukca_program_reader *r, size_t begin, size_t end)
{
    const char *data = strstr(r->line, "_DATA["), *system = strchr(r->line, '$');
    size_t before = begin;
    while (before > 0 && isblank((unsigned char)r->line[before - 1])) before--;
    return !r->relative && (before == 0 || r->line[before - 1] != ':') &&
           r->line[mukca_pattern_skip_blanks(r->line, end)] != ':' &&
           !(data && data < r->line + begin) && !(system && system < r->line + begin);
}

/* Set the omitted components to those of the last move. */
static void carry_over(mukca_program_target *t, mukca_program_reader *r)
{
    const int n = r->pose ? ROBOT_AXES : r->chain->n_joints;
    for (int k = 0; k < n; k++) {
        if (t->number[k][1]) continue;
        t->partial = true;
        t->value[k] = r->last[k];
    }
    t->incomplete = t->partial && !(r->moves && r->known);
    if (!r->moves) return;
    r->known = !t->incomplete;
    memcpy(r->last, t->value, sizeof r->last);
}

/* Match a target at line[at]. */
static bool match_target(mukca_program_target *t, mukca_program_reader *r, const char *pattern,
                         size_t at)
{
    const mukca_language *l = r->language;
    *t = (mukca_program_target){.begin = at};
    if (l->label[0]) {
        t->end = match_components(t, r, at);
        if (t->end == 0 || !is_target(r, at, t->end)) return false;
        carry_over(t, r);
        return true;
    }
    mukca_pattern_numbers found = {0};
    t->end = mukca_pattern_match(&found, pattern, r->line, at);
    const int n = r->pose ? MUKCA_POSE_NUMBERS : r->chain->n_joints;
    memcpy(t->value, found.value, (size_t)n * sizeof *t->value);
    memcpy(t->number, found.span, (size_t)n * sizeof *t->number);
    return t->end > 0;
}

void mukca_program_line(mukca_program_reader *r, const char *line)
{
    static const char *const words[] = {"PTP", "LIN", "CIRC", "SPTP", "SLIN", "SPL", "SCIRC", NULL};
    char word[16];
    r->line = line;
    r->at = 0;
    r->moves = r->relative = r->found = false;
    if (!r->language->label[0]) return;
    read_word(word, line, mukca_pattern_skip_blanks(line, 0));
    char *suffix = strstr(word, "_REL");
    r->relative = suffix != NULL;
    if (suffix) *suffix = '\0';
    for (const char *const *w = words; *w; w++) r->moves |= strcmp(*w, word) == 0;
}

bool mukca_program_next(mukca_program_target *t, mukca_program_reader *r)
{
    const mukca_language *l = r->language;
    const char *line = r->line;
    char joints[PATTERN];
    joint_pattern(joints, l, r->chain);
    const char *const pattern = r->pose && l->pose ? l->pose : joints;
    for (size_t at = r->at; line[at] && line[at] != l->comment; at++) {
        if (line[at] != *pattern || !(follows(l, line, at) || is_second(r, at))) continue;
        if (!match_target(t, r, pattern, at)) continue;
        if (!t->incomplete && r->pose && !convert_pose(&t->pose, l, t->value)) continue;
        for (int j = 0; j < r->chain->n_joints && !r->pose; j++)
            t->q[j] = t->value[j] * (is_linear(r->chain, j) ? l->length : l->angle);
        r->at = t->end;
        r->found = true;
        return true;
    }
    if (!r->found) r->known = r->known && !r->moves; /* the line moves to an unknown position */
    return false;
}

int mukca_language_axes(const mukca_language *language)
{
    return language->empty[0] || language->label[0] ? MOST_AXES : MUKCA_MAX_JOINTS;
}

static void print_value(FILE *stream, const mukca_language *l, const mukca_chain *chain, int j,
                        double q)
{
    fprintf(stream, "%.*f", l->decimals, q / (is_linear(chain, j) ? l->length : l->angle));
}

void mukca_language_print(FILE *stream, const mukca_language *l, const mukca_chain *chain,
                          const double *q)
{
    char pattern[PATTERN];
    int axis = 0;
    joint_pattern(pattern, l, chain);
    fputs(l->line[0], stream);
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
    fputs(l->line[1], stream);
}

/* Print the target's text with its numbers replaced by value[n], followed by the omitted
 * components. */
static void replace(FILE *stream, const mukca_program_reader *r, const mukca_program_target *t,
                    const double *value, int n)
{
    const mukca_language *l = r->language;
    size_t at = t->begin;
    for (;;) { /* in order of their position in the text */
        int next = -1;
        for (int k = 0; k < n; k++)
            if (t->number[k][1] > at && (next < 0 || t->number[k][0] < t->number[next][0]))
                next = k;
        if (next < 0) break;
        fwrite(r->line + at, 1, t->number[next][0] - at, stream);
        const bool quaternion = r->pose && l->turn == QUATERNION && next >= 3;
        fprintf(stream, "%.*f", quaternion ? 9 : l->decimals, value[next]); /* 1 nrad */
        at = t->number[next][1];
    }
    if (t->partial) fwrite(r->line + at, 1, t->end - 1 - at, stream);
    for (int k = 0; k < n && t->partial; k++) {
        if (t->number[k][1]) continue;
        if (r->pose)
            fprintf(stream, ",%c", "XYZABC"[k]);
        else
            fprintf(stream, ",%c%d", l->label[k >= ROBOT_AXES], k % ROBOT_AXES + 1);
        fprintf(stream, " %.*f", l->decimals, value[k]);
    }
    if (t->partial) at = t->end - 1;
    fwrite(r->line + at, 1, t->end - at, stream);
}

void mukca_language_replace(FILE *stream, const mukca_program_reader *r,
                            const mukca_program_target *t, const double *q)
{
    double value[MUKCA_MAX_JOINTS];
    for (int j = 0; j < r->chain->n_joints; j++)
        value[j] = q[j] / (is_linear(r->chain, j) ? r->language->length : r->language->angle);
    replace(stream, r, t, value, r->chain->n_joints);
}

void mukca_language_replace_pose(FILE *stream, const mukca_program_reader *r,
                                 const mukca_program_target *t, const mukca_frame *pose)
{
    const mukca_language *l = r->language;
    double value[MUKCA_POSE_NUMBERS] = {0}, *turn = value + 3;
    for (int i = 0; i < 3; i++) value[i] = pose->p[i] / l->length;
    if (l->turn == QUATERNION) {
        mukca_rotation_to_quaternion(turn, pose->R);
        double same = 0;
        for (int i = 0; i < 4; i++) same += turn[i] * t->value[3 + i];
        for (int i = 0; i < 4 && same < 0; i++) turn[i] = -turn[i];
    } else if (l->turn == ZYX) {
        double near[3], rpy[3];
        for (int i = 0; i < 3; i++) near[i] = t->value[5 - i] * l->angle;
        mukca_rotation_to_rpy(rpy, pose->R, near);
        for (int i = 0; i < 3; i++) turn[i] = rpy[2 - i] / l->angle;
    } else {
        mukca_rotation_log(turn, pose->R);
        for (int i = 0; i < 3; i++) turn[i] /= l->angle;
    }
    replace(stream, r, t, value, l->turn == QUATERNION ? 7 : 6);
}
