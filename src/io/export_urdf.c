/* The user's URDF with the origins of the chain patched in place; every other byte stays. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/number.h"
#include "io/export.h"
#include "io/urdf_text.h"

enum { VALUE_SIZE = 3 * 64 }; /* mukca_number_parse_list takes words of at most 63 letters */

/* text[start, stop) of the URDF becomes `replacement`, after a copy of `copied` bytes from `start`.
 */
typedef struct {
    size_t start, stop, copied;
    char replacement[2 * VALUE_SIZE + 32];
} edit;

typedef struct {
    mukca_urdf_text urdf;
    edit edits[2 * MUKCA_MAX_ELEMENTS];
    int n;
} patch;

/* Bytes of the value of an attribute inside tag[length], without its quotes; false where absent. */
static bool find_attribute(size_t *start, size_t *stop, const char *tag, size_t length,
                           const char *name)
{
    size_t at = strcspn(tag, " \t\r\n/>");
    while (at < length) {
        at += strspn(tag + at, " \t\r\n");
        size_t name_length = strcspn(tag + at, " \t\r\n=/>");
        if (name_length == 0) return false;
        const bool match = name_length == strlen(name) && strncmp(tag + at, name, name_length) == 0;
        const char *quote = tag + at + name_length;
        quote += strspn(quote, " \t\r\n=");
        const char *end = *quote ? strchr(quote + 1, *quote) : NULL;
        if (!end || end >= tag + length) return false;
        *start = (size_t)(quote + 1 - tag);
        *stop = (size_t)(end - tag);
        if (match) return true;
        at = (size_t)(end + 1 - tag);
    }
    return false;
}

/* Three numbers as text.  One that equals the nominal number is copied from the URDF's own text
 * `old[length]`. */
static void format_vector(char value[VALUE_SIZE], const double v[3], const double nominal[3],
                          const char *old, size_t length)
{
    char words[VALUE_SIZE];
    double read[3];
    snprintf(words, sizeof words, "%.*s", (int)length, old);
    const bool usable = length < sizeof words && mukca_number_parse_list(read, 3, words) &&
                        memcmp(read, nominal, sizeof read) == 0;
    value[0] = '\0';
    char *word = words, *rest;
    for (int i = 0; i < 3; i++) {
        char number[MUKCA_NUMBER_SIZE];
        const size_t used = strlen(value);
        mukca_number_format(number, v[i]);
        if (usable) word = strtok_r(i ? NULL : words, " \t\r\n", &rest);
        const bool keep = usable && word && memcmp(&v[i], &nominal[i], sizeof *v) == 0;
        snprintf(value + used, VALUE_SIZE - used, "%s%s", i ? " " : "", keep ? word : number);
    }
}

/* Set attribute `name` of an origin's tag to v, where it was `nominal`. */
static void set_attribute(patch *p, const mukca_urdf_joint *joint, const char *name,
                          const double v[3], const double nominal[3])
{
    const char *tag = p->urdf.text + joint->origin_start;
    const size_t length = joint->origin_stop - joint->origin_start;
    size_t start, stop;
    char value[VALUE_SIZE];
    edit *e = &p->edits[p->n];
    if (memcmp(v, nominal, 3 * sizeof *v) == 0) return;
    p->n++;
    if (find_attribute(&start, &stop, tag, length, name)) {
        format_vector(e->replacement, v, nominal, tag + start, stop - start);
    } else {
        start = length - (length >= 2 && tag[length - 2] == '/' ? 2 : 1);
        while (start && strchr(" \t\r\n", tag[start - 1])) start--;
        stop = start;
        format_vector(value, v, nominal, "", 0);
        snprintf(e->replacement, sizeof e->replacement, " %s=\"%s\"", name, value);
    }
    e->start = joint->origin_start + start;
    e->stop = joint->origin_start + stop;
}

/* A new origin behind the joint's tag, after the white space that follows the tag. */
static void insert_origin(patch *p, const mukca_urdf_joint *joint,
                          const mukca_export_origin *origin)
{
    static const double none[3] = {0, 0, 0};
    char xyz[VALUE_SIZE], rpy[VALUE_SIZE];
    edit *e = &p->edits[p->n++];
    format_vector(xyz, origin->xyz, none, "", 0);
    format_vector(rpy, origin->rpy, none, "", 0);
    e->start = e->stop = joint->tag_end;
    e->copied = strspn(p->urdf.text + joint->tag_end, " \t\r\n");
    snprintf(e->replacement, sizeof e->replacement, "<origin xyz=\"%s\" rpy=\"%s\"/>", xyz, rpy);
}

static mukca_status add_edits(patch *p, const mukca_export_input *input, int element,
                              mukca_error *error)
{
    const mukca_element *nominal = &input->chain->element[element];
    const mukca_urdf_joint *joint = mukca_urdf_text_joint(&p->urdf, nominal->name);
    mukca_export_origin origin;
    mukca_export_get_origin(&origin, input, element);
    if (memcmp(origin.xyz, nominal->xyz, sizeof origin.xyz) == 0 &&
        memcmp(origin.rpy, nominal->rpy, sizeof origin.rpy) == 0)
        return MUKCA_OK;
    if (!joint || !p->urdf.located)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: joint '%s' cannot be located in this encoding; save the file as "
                          "UTF-8",
                          mukca_file_shown(input->urdf_path), nominal->name);
    if (joint->has_origin) {
        set_attribute(p, joint, "xyz", origin.xyz, nominal->xyz);
        set_attribute(p, joint, "rpy", origin.rpy, nominal->rpy);
    } else {
        insert_origin(p, joint, &origin);
    }
    return MUKCA_OK;
}

/* By place; of two new attributes at the same place, xyz before rpy. */
static int compare_edits(const void *a, const void *b)
{
    const edit *x = a, *y = b;
    if (x->start != y->start) return x->start > y->start ? 1 : -1;
    return strcmp(y->replacement, x->replacement);
}

static mukca_status write_urdf(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    patch *p = calloc(1, sizeof *p);
    if (!p) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_status status = mukca_urdf_text_read(&p->urdf, input->urdf_path, error);
    if (status == MUKCA_OK && strcmp(p->urdf.sha256, input->chain->urdf_sha256) != 0)
        status = mukca_fail(error, MUKCA_INPUT, "%s: changed during the export; run it again",
                            mukca_file_shown(input->urdf_path));
    for (int k = 0; k < input->chain->n_elements && status == MUKCA_OK; k++)
        status = add_edits(p, input, k, error);
    if (status == MUKCA_OK) {
        size_t at = 0;
        qsort(p->edits, (size_t)p->n, sizeof *p->edits, compare_edits);
        for (int i = 0; i < p->n; i++) {
            const edit *e = &p->edits[i];
            fwrite(p->urdf.text + at, 1, e->start - at, stream);
            fwrite(p->urdf.text + e->start, 1, e->copied, stream);
            fputs(e->replacement, stream);
            at = e->stop;
        }
        fputs(p->urdf.text + at, stream);
    }
    mukca_urdf_text_free(&p->urdf);
    free(p);
    return status;
}

static bool holds(const mukca_effect *effect)
{
    (void)effect; /* a URDF has no place for effects */
    return false;
}

const mukca_export_format mukca_export_urdf = {.write = write_urdf, .holds = holds};
