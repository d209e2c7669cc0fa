/* The user's URDF with the origins of the chain patched in place; every other byte stays. */
#include <stdlib.h>
#include <string.h>

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
static char *splice(const char *text, size_t length, size_t start, size_t stop, const char *middle)
{
    size_t size = length - (stop - start) + strlen(middle) + 1;
    char *out = malloc(size);
    if (out)
        snprintf(out, size, "%.*s%s%.*s", (int)start, text, middle, (int)(length - stop),
                 text + stop);
    return out;
}

/* The tag (freed) with an attribute set to three numbers. */
static char *set_attribute(char *tag, const char *name, const double v[3])
{
    char value[96], whole[128];
    size_t length = strlen(tag), start, stop;
    snprintf(value, sizeof value, "%.17g %.17g %.17g", v[0], v[1], v[2]);
    char *out;
    if (find_attribute(&start, &stop, tag, length, name)) {
        out = splice(tag, length, start, stop, value);
    } else {
        size_t end = length - (length >= 2 && tag[length - 2] == '/' ? 2 : 1);
        while (end && strchr(" \t\r\n", tag[end - 1])) end--;
        snprintf(whole, sizeof whole, " %s=\"%s\"", name, value);
        out = splice(tag, length, end, end, whole);
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
    double xyz[3], rpy[3], quaternion[4];
    mukca_export_origin(xyz, rpy, quaternion, input, element);
    bool moved = false, turned = false;
    for (int i = 0; i < 3; i++) {
        moved |= xyz[i] != nominal->xyz[i];
        turned |= rpy[i] != nominal->rpy[i];
    }
    if (!moved && !turned) return MUKCA_OK;
    if (!joint || !urdf->located)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: joint '%s' cannot be found byte by byte; save the file as UTF-8",
                          mukca_table_short_path(input->urdf_path), nominal->name);
    char *tag;
    if (joint->has_origin) {
        e->start = joint->origin_start;
        e->stop = joint->origin_stop;
        tag = splice(urdf->text + e->start, e->stop - e->start, 0, 0, "");
    } else { /* a new one, with the white space that follows the joint's tag before it */
        e->start = e->stop = joint->tag_end;
        const char *gap = urdf->text + joint->tag_end;
        size_t length = strspn(gap, " \t\r\n");
        tag = splice(gap, length, length, length, "<origin/>");
    }
    if (tag && (moved || !joint->has_origin)) tag = set_attribute(tag, "xyz", xyz);
    if (tag && (turned || !joint->has_origin)) tag = set_attribute(tag, "rpy", rpy);
    e->replacement = tag;
    return tag ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

static int by_start(const void *a, const void *b)
{
    const edit *x = a, *y = b;
    return (x->start > y->start) - (x->start < y->start);
}

mukca_status mukca_export_urdf(FILE *stream, const mukca_export_input *input, mukca_error *error)
{
    mukca_urdf_text urdf;
    edit edits[MUKCA_MAX_ELEMENTS] = {{0, 0, NULL}};
    int n = 0;
    mukca_status status = mukca_urdf_text_read(&urdf, input->urdf_path, error);
    if (status) return status;
    if (strcmp(urdf.sha256, input->chain->urdf_sha256) != 0)
        status = mukca_fail(error, MUKCA_INPUT, "%s: changed while it was in use",
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
    if (status == MUKCA_OK && input->offsets->n_effects && input->note)
        input->note(input->context,
                    "a URDF has no place for effects: only the geometry is exported");
    for (int k = 0; k < input->chain->n_elements; k++) free(edits[k].replacement);
    mukca_urdf_text_free(&urdf);
    return status;
}
