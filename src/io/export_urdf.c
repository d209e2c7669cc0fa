/* The user's URDF with the origins of the chain patched in place; every other byte stays. */
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "io/export.h"
#include "io/table.h"
#include "io/urdf_text.h"

/* text[start, stop) becomes `replacement`. */
typedef struct {
    size_t start, stop;
    char *replacement;
} edit;

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

/* A new string: text[0, start) + middle + text[stop, length). */
static char *splice(const char *text, size_t length, const edit *e, const char *middle)
{
    size_t size = length - (e->stop - e->start) + strlen(middle) + 1;
    char *out = malloc(size);
    if (out)
        snprintf(out, size, "%.*s%s%.*s", (int)e->start, text, middle, (int)(length - e->stop),
                 text + e->stop);
    return out;
}

enum { VALUE_SIZE = 3 * 64 }; /* mukca_number_parse_list takes words of at most 63 letters */

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

/* The tag (freed) with attribute `name` set to v, where it was `nominal`; NULL: out of memory. */
static char *set_attribute(char *tag, const char *name, const double v[3], const double nominal[3])
{
    char value[VALUE_SIZE], whole[VALUE_SIZE + 16], *out;
    edit at = {0};
    const size_t length = strlen(tag);
    if (find_attribute(&at.start, &at.stop, tag, length, name)) {
        format_vector(value, v, nominal, tag + at.start, at.stop - at.start);
        out = splice(tag, length, &at, value);
    } else {
        size_t end = length - (length >= 2 && tag[length - 2] == '/' ? 2 : 1);
        while (end && strchr(" \t\r\n", tag[end - 1])) end--;
        format_vector(value, v, nominal, "", 0);
        snprintf(whole, sizeof whole, " %s=\"%s\"", name, value);
        at = (edit){.start = end, .stop = end};
        out = splice(tag, length, &at, whole);
    }
    free(tag);
    return out;
}

/* The edit for one element; MUKCA_OK with an empty edit where nothing changed. */
static mukca_status make_edit(edit *e, const mukca_urdf_text *urdf, const mukca_export_input *input,
                              int element, mukca_error *error)
{
    const mukca_element *nominal = &input->chain->element[element];
    const mukca_urdf_joint *joint = mukca_urdf_text_joint(urdf, nominal->name);
    mukca_export_origin origin;
    mukca_export_get_origin(&origin, input, element);
    const bool moved = memcmp(origin.xyz, nominal->xyz, sizeof origin.xyz) != 0,
               turned = memcmp(origin.rpy, nominal->rpy, sizeof origin.rpy) != 0;
    if (!moved && !turned) return MUKCA_OK;
    if (!joint || !urdf->located)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: joint '%s' cannot be located in this encoding; save the file as "
                          "UTF-8",
                          mukca_table_short_path(input->urdf_path), nominal->name);
    const edit nothing = {0};
    char *tag;
    if (joint->has_origin) {
        e->start = joint->origin_start;
        e->stop = joint->origin_stop;
        tag = splice(urdf->text + e->start, e->stop - e->start, &nothing, "");
    } else { /* a new one, with the white space that follows the joint's tag before it */
        e->start = e->stop = joint->tag_end;
        const char *space = urdf->text + joint->tag_end;
        const size_t length = strspn(space, " \t\r\n");
        tag = splice(space, length, &(edit){.start = length, .stop = length}, "<origin/>");
    }
    if (tag && (moved || !joint->has_origin))
        tag = set_attribute(tag, "xyz", origin.xyz, nominal->xyz);
    if (tag && (turned || !joint->has_origin))
        tag = set_attribute(tag, "rpy", origin.rpy, nominal->rpy);
    e->replacement = tag;
    return tag ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

static int by_start(const void *a, const void *b)
{
    const edit *x = a, *y = b;
    return (x->start > y->start) - (x->start < y->start);
}

static mukca_status write_urdf(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    mukca_urdf_text urdf;
    edit edits[MUKCA_MAX_ELEMENTS] = {{0, 0, NULL}};
    int n = 0;
    mukca_status status = mukca_urdf_text_read(&urdf, input->urdf_path, error);
    if (status) return status;
    if (strcmp(urdf.sha256, input->chain->urdf_sha256) != 0)
        status = mukca_fail(error, MUKCA_INPUT, "%s: changed during the export; run it again",
                            mukca_table_short_path(input->urdf_path));
    for (int k = 0; k < input->chain->n_elements && status == MUKCA_OK; k++) {
        status = make_edit(&edits[n], &urdf, input, k, error);
        if (edits[n].replacement) n++;
    }
    if (status == MUKCA_OK) {
        size_t at = 0;
        qsort(edits, (size_t)n, sizeof *edits, by_start);
        for (int i = 0; i < n; i++) {
            fwrite(urdf.text + at, 1, edits[i].start - at, stream);
            fputs(edits[i].replacement, stream);
            at = edits[i].stop;
        }
        fwrite(urdf.text + at, 1, urdf.length - at, stream);
    }
    for (int k = 0; k < input->chain->n_elements; k++) free(edits[k].replacement);
    mukca_urdf_text_free(&urdf);
    return status;
}

static bool holds(const mukca_effect *effect)
{
    (void)effect; /* a URDF has no place for effects */
    return false;
}

const mukca_export_format mukca_export_urdf = {.write = write_urdf, .holds = holds};
