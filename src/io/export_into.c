/* A user's MuJoCo model with the poses of the arm's bodies replaced in place; all other bytes are
 * unchanged. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/note.h"
#include "base/number.h"
#include "io/export.h"

/* A body is where the URDF has it up to rounded numbers and other versions of the arm. */
static const double most_metres = 2e-3, most_radians = 5e-3;

typedef struct {
    FILE *stream;
    const mukca_export_input *input;
    const char *at;                  /* written up to here */
    mukca_frame nominal, calibrated; /* from the last body to the present element */
    mukca_error *error;
} patch;

static const mukca_frame identity = {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1}};

static mukca_status fail(const patch *p, const char *body, const char *what)
{
    return mukca_fail(p->error, MUKCA_INPUT, "%s: body '%.60s' %s",
                      mukca_file_shown(p->input->into), body, what);
}

/* Equal names, or one with a prefix: "panda_link1" and "link1". */
static bool same_link(const char *link, const char *name, size_t length)
{
    const size_t whole = strlen(link), least = whole < length ? whole : length;
    const char *longer = whole > length ? link : name;
    const size_t prefix = whole > length ? whole - length : length - whole;
    return least > 0 && strncmp(link + whole - least, name + length - least, least) == 0 &&
           (prefix == 0 || longer[prefix - 1] == '_');
}

/* The start tag of the body of a link, NULL: none; *length up to its end. */
static const char *find_body(const char *text, size_t *length, const char *link)
{
    size_t start, stop;
    while ((text = strchr(text, '<'))) {
        const char *end = strncmp(text, "<!--", 4) == 0 ? strstr(text, "-->") : strchr(text, '>');
        if (!end) return NULL;
        *length = (size_t)(end + 1 - text);
        if (strncmp(text, "<body", 5) == 0 &&
            mukca_export_find_attribute(&start, &stop, text, *length, "name") &&
            same_link(link, text + start, stop - start))
            return text;
        text = end;
    }
    return NULL;
}

/* Read numbers of an attribute; without it they stay.  False: unreadable. */
static bool read_numbers(double *values, int n, const char *tag, size_t length, const char *key)
{
    char words[256];
    size_t start, stop;
    if (!mukca_export_find_attribute(&start, &stop, tag, length, key)) return true;
    snprintf(words, sizeof words, "%.*s", (int)(stop - start), tag + start);
    return stop - start < sizeof words && mukca_number_parse_list(values, n, words);
}

/* Whether the body is where the URDF has it. */
static mukca_status check(const patch *p, const char *tag, size_t length, const char *link)
{
    static const char *const others[] = {"euler", "axisangle", "xyaxes", "zaxis", NULL};
    double pos[3] = {0, 0, 0}, quat[4] = {1, 0, 0, 0}, R[9];
    size_t start, stop;
    for (int i = 0; others[i]; i++)
        if (mukca_export_find_attribute(&start, &stop, tag, length, others[i]))
            return fail(p, link, "has no quat; save the model from MuJoCo, which writes it");
    if (!read_numbers(pos, 3, tag, length, "pos") || !read_numbers(quat, 4, tag, length, "quat"))
        return fail(p, link, "has a pos or quat that is not numbers");
    mukca_rotation_from_quaternion(R, quat);
    for (int i = 0; i < 3; i++) pos[i] -= p->nominal.p[i];
    if (mukca_norm3(pos) < most_metres && mukca_rotation_between(R, p->nominal.R) < most_radians)
        return MUKCA_OK;
    return fail(p, link, "is not where the URDF has it; the model needs the URDF's frames");
}

/* Write the text up to the body's tag, and the tag with the calibrated pose. */
static mukca_status write_body(patch *p, const char *tag, size_t length, const char *link)
{
    double shift[3], quat[4];
    const char *end = tag + length - (tag[length - 2] == '/' ? 2 : 1);
    const mukca_status status = check(p, tag, length, link);
    if (status != MUKCA_OK) return status;
    fwrite(p->at, 1, (size_t)(tag - p->at), p->stream);
    for (const char *c = tag; c < end;) { /* without pos and quat */
        const size_t blank = strspn(c, " \t\r\n"), word = blank + strcspn(c + blank, " \t\r\n=/>");
        const char *quote = c + word + strspn(c + word, " \t\r\n=");
        const char *close = *quote == '"' || *quote == '\'' ? strchr(quote + 1, *quote) : NULL;
        const bool ours = blank && ((word - blank == 3 && strncmp(c + blank, "pos", 3) == 0) ||
                                    (word - blank == 4 && strncmp(c + blank, "quat", 4) == 0));
        const char *next = close ? close + 1 : c + (word ? word : 1);
        if (next > end) next = end;
        if (!ours) fwrite(c, 1, (size_t)(next - c), p->stream);
        c = next;
    }
    fputs(" pos=\"", p->stream);
    mukca_export_numbers(p->stream, p->calibrated.p, 3, " ");
    fputs("\" quat=\"", p->stream);
    mukca_rotation_to_quaternion(quat, p->calibrated.R);
    mukca_export_numbers(p->stream, quat, 4, " ");
    fputc('"', p->stream);
    p->at = end;
    for (int i = 0; i < 3; i++) shift[i] = p->calibrated.p[i] - p->nominal.p[i];
    mukca_note_format(p->input->note, p->input->context,
                      "body '%.60s': moved by %.3f mm, %.3f mrad", link, 1e3 * mukca_norm3(shift),
                      1e3 * mukca_rotation_between(p->calibrated.R, p->nominal.R));
    p->nominal = p->calibrated = identity;
    return MUKCA_OK;
}

static void append(mukca_frame *T, const double xyz[3], const double rpy[3])
{
    mukca_frame step;
    memcpy(step.p, xyz, sizeof step.p);
    mukca_rotation_from_rpy(step.R, rpy);
    mukca_frame_multiply(T, T, &step);
}

static mukca_status write_into(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    const mukca_chain *chain = input->chain;
    char *text;
    mukca_status status = mukca_file_read(&text, input->into, error);
    if (status != MUKCA_OK) return status;
    patch p = {stream, input, text, identity, identity, error};
    for (int k = 0; k < chain->n_elements && status == MUKCA_OK; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_export_origin origin;
        size_t length = 0;
        mukca_export_get_origin(&origin, input, k);
        append(&p.nominal, e->xyz, e->rpy);
        append(&p.calibrated, origin.xyz, origin.rpy);
        const char *tag = find_body(p.at, &length, e->child);
        if (tag)
            status = write_body(&p, tag, length, e->child);
        else if (e->joint >= 0)
            status = fail(&p, e->child, "is missing, or not in the order of the chain");
        else if (k + 1 == chain->n_elements)
            mukca_note_format(input->note, input->context,
                              "no body '%.60s': the offsets of %.60s are left out", e->child,
                              e->name);
    }
    if (status == MUKCA_OK) fputs(p.at, stream);
    free(text);
    return status;
}

const mukca_export_format mukca_export_into = {.write = write_into,
                                               .holds = mukca_export_holds_none};
