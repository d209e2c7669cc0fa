/* A URDF as text: read, hashed and checked, its joints located with libxml2's SAX parser. */
#include "io/urdf.h"

#include <libxml/parser.h>
#include <libxml/parserInternals.h>
#include <sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/number.h"

/* Limits far beyond any real robot.  The depth also bounds the stack of urdfdom's recursive parser.
 * urdfdom is given the elements serialised again, as it would find elements in processing
 * instructions. */
enum { DEEPEST = 64, MOST_JOINTS = 4096 };

typedef struct {
    mukca_urdf_text *urdf;
    size_t length; /* of the text */
    xmlParserCtxtPtr parser;
    int depth;
    mukca_urdf_joint *joint; /* the open joint element, or NULL */
    FILE *elements;          /* stream that writes urdf->elements */
    mukca_status status;
    mukca_error *error;
    const char *path;
} scan;

static void stop(scan *s, mukca_status status)
{
    s->status = status;
    xmlStopParser(s->parser);
}

/* Bytes of the input consumed so far: during the callback of a start tag, up to its `>` or `/>`. */
static size_t position(const scan *s)
{
    const xmlParserInput *input = s->parser->input;
    return input->consumed + (size_t)(input->cur - input->base);
}

/* Copy the value of an attribute without namespace to value[size]; false: absent. */
static bool attribute(char *value, size_t size, const char *name, const xmlChar **attributes, int n)
{
    value[0] = '\0';
    for (int i = 0; i < n; i++) {
        const xmlChar *const *a = attributes + 5 * i;
        if (a[1] || strcmp((const char *)a[0], name) != 0) continue;
        size_t length = (size_t)(a[4] - a[3]);
        if (length >= size) length = size - 1;
        memcpy(value, a[3], length);
        value[length] = '\0';
        return true;
    }
    return false;
}

/* Append a zeroed joint; NULL: too many. */
static mukca_urdf_joint *new_joint(scan *s)
{
    mukca_urdf_text *urdf = s->urdf;
    if (urdf->n_joints == MOST_JOINTS) {
        stop(s, mukca_fail(s->error, MUKCA_INPUT, "%s: has more than %d joints", s->path,
                           (int)MOST_JOINTS));
        return NULL;
    }
    const size_t count = (size_t)urdf->n_joints + 1;
    mukca_urdf_joint *joints = realloc(urdf->joints, count * sizeof *joints);
    if (!joints) {
        stop(s, mukca_fail(s->error, MUKCA_MEMORY, "out of memory"));
        return NULL;
    }
    urdf->joints = joints;
    mukca_urdf_joint *joint = &joints[urdf->n_joints++];
    *joint = (mukca_urdf_joint){0};
    return joint;
}

/* Locate the bytes [start, end) of the current start tag; urdf->located becomes false if the
 * parser's byte count differs from that of the text. */
static void locate_tag(size_t *start, size_t *end, const scan *s, const char *name)
{
    const char *text = s->urdf->text;
    size_t at = position(s);
    const char *close = at < s->length ? strchr(text + at, '>') : NULL;
    while (close && at && text[at] != '<') at--;
    *start = at;
    *end = close ? (size_t)(close - text) + 1 : 0;
    if (!close || strncmp(text + at + 1, name, strlen(name)) != 0) s->urdf->located = false;
}

static void read_origin(scan *s, const xmlChar **attributes, int n)
{
    mukca_urdf_joint *joint = s->joint;
    char value[256];
    if (joint->has_origin) return; /* urdfdom uses the first */
    joint->has_origin = true;
    locate_tag(&joint->origin_start, &joint->origin_stop, s, "origin");
    if (attribute(value, sizeof value, "xyz", attributes, n))
        joint->bad_origin |= !mukca_number_parse_list(joint->xyz, 3, value);
    if (attribute(value, sizeof value, "rpy", attributes, n))
        joint->bad_origin |= !mukca_number_parse_list(joint->rpy, 3, value);
}

/* Refuse elements that no URDF for this program has. */
static void check_element(scan *s, const char *tag, const char *prefix, int depth, int line)
{
    if (depth == 0 && strcmp(tag, "robot") != 0)
        stop(s, mukca_fail(s->error, MUKCA_INPUT,
                           "%s:%d: the root element is <%.40s>, not <robot>; this is no URDF",
                           s->path, line, tag));
    else if (depth >= DEEPEST)
        stop(s, mukca_fail(s->error, MUKCA_INPUT,
                           "%s:%d: elements nested more than %d deep; this is no URDF", s->path,
                           line, (int)DEEPEST));
    else if (prefix && strcmp(prefix, "xacro") == 0)
        stop(s, mukca_fail(s->error, MUKCA_INPUT,
                           "%s:%d: contains xacro macros; expand them first: xacro IN > OUT.urdf",
                           s->path, line));
}

static void write_name(FILE *out, const xmlChar *prefix, const xmlChar *name)
{
    if (prefix) fprintf(out, "%s:", (const char *)prefix);
    fputs((const char *)name, out);
}

/* Write a start tag.  References in attributes are resolved and white space becomes blanks, as
 * urdfdom requires for numbers. */
static void write_start(FILE *out, const xmlChar *prefix, const xmlChar *name,
                        const xmlChar **attributes, int n)
{
    fputc('<', out);
    write_name(out, prefix, name);
    for (int i = 0; i < n; i++) {
        const xmlChar *const *a = attributes + 5 * i;
        fputc(' ', out);
        write_name(out, a[1], a[0]);
        fputs("=\"", out);
        for (const xmlChar *c = a[3]; c < a[4]; c++)
            if (*c < ' ' || strchr("&<>\"", *c))
                fprintf(out, "&#%d;", *c);
            else
                fputc(*c, out);
        fputc('"', out);
    }
    fputs(">\n", out);
}

static void start_element(void *context, const xmlChar *name, const xmlChar *prefix,
                          const xmlChar *uri, int n_namespaces, const xmlChar **namespaces,
                          int n_attributes, int n_defaulted, const xmlChar **attributes)
{
    (void)uri, (void)n_namespaces, (void)namespaces, (void)n_defaulted;
    scan *s = ((xmlParserCtxtPtr)context)->_private;
    const char *tag = (const char *)name;
    const int line = xmlSAX2GetLineNumber(context), depth = s->depth++;
    size_t start;
    check_element(s, tag, (const char *)prefix, depth, line);
    if (s->status != MUKCA_OK) return;
    write_start(s->elements, prefix, name, attributes, n_attributes);
    if (depth == 1 && strcmp(tag, "joint") == 0) {
        s->joint = new_joint(s);
        if (!s->joint) return;
        attribute(s->joint->name, sizeof s->joint->name, "name", attributes, n_attributes);
        locate_tag(&start, &s->joint->tag_end, s, "joint");
        s->joint->line = line;
    } else if (depth == 2 && s->joint && strcmp(tag, "origin") == 0) {
        read_origin(s, attributes, n_attributes);
    }
}

static void end_element(void *context, const xmlChar *name, const xmlChar *prefix,
                        const xmlChar *uri)
{
    (void)uri;
    scan *s = ((xmlParserCtxtPtr)context)->_private;
    fputs("</", s->elements);
    write_name(s->elements, prefix, name);
    fputs(">\n", s->elements);
    if (--s->depth == 1) s->joint = NULL;
}

/* Refuse document types: entities could hide elements and expand without limit. */
static void document_type(void *context, const xmlChar *name, const xmlChar *id, const xmlChar *uri)
{
    (void)name, (void)id, (void)uri;
    scan *s = ((xmlParserCtxtPtr)context)->_private;
    stop(s,
         mukca_fail(s->error, MUKCA_INPUT,
                    "%s:%d: has a document type (<!DOCTYPE ...>), which no URDF needs; remove it",
                    s->path, xmlSAX2GetLineNumber(context)));
}

/* A failed allocation in libxml2, which reports another error, or none; its functions have no
 * context. */
static bool failed;

static void *watch(void *memory)
{
    failed |= !memory;
    return memory;
}

static void *allocate(size_t size)
{
    return watch(malloc(size));
}

static void *grow(void *memory, size_t size)
{
    return watch(realloc(memory, size));
}

static char *duplicate(const char *text)
{
    return watch(strdup(text));
}

static void watch_memory(void)
{
    failed = false;
    xmlMemSetup(free, allocate, grow, duplicate);
}

static mukca_status scan_joints(mukca_urdf_text *urdf, const char *path, mukca_error *error)
{
    scan s = {.urdf = urdf, .length = strlen(urdf->text), .path = path, .error = error};
    xmlSAXHandler handler = {.initialized = XML_SAX2_MAGIC,
                             .internalSubset = document_type,
                             .startElementNs = start_element,
                             .endElementNs = end_element};
    size_t size;
    if (s.length == 0) return mukca_fail(error, MUKCA_INPUT, "%s: empty, or no XML", path);
    watch_memory();
    s.parser = xmlCreateMemoryParserCtxt(urdf->text, (int)s.length);
    if (!s.parser) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    s.elements = open_memstream(&urdf->elements, &size);
    if (!s.elements) {
        xmlFreeParserCtxt(s.parser);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    xmlSAXHandlerPtr old = s.parser->sax;
    s.parser->sax = &handler;
    s.parser->_private = &s;
    xmlCtxtUseOptions(s.parser,
                      XML_PARSE_NOENT | XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
    urdf->located = true;
    xmlParseDocument(s.parser);
    const char *encoding = (const char *)s.parser->encoding; /* others are converted */
    if (encoding && strcasecmp(encoding, "UTF-8") != 0 && strcasecmp(encoding, "US-ASCII") != 0)
        urdf->located = false;
    if (s.status == MUKCA_OK && !s.parser->wellFormed) {
        const xmlError *e = xmlCtxtGetLastError(s.parser);
        char text[120] = "is broken";
        if (e && e->message) snprintf(text, sizeof text, "%s", e->message);
        text[strcspn(text, "\n")] = '\0';
        s.status =
            mukca_fail(error, MUKCA_INPUT, "%s:%d: broken XML: %s", path, e ? e->line : 0, text);
    }
    if (!mukca_file_close(s.elements, &urdf->elements) || failed)
        s.status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    s.parser->sax = old;
    xmlFreeDoc(s.parser->myDoc);
    s.parser->myDoc = NULL;
    xmlFreeParserCtxt(s.parser);
    return s.status;
}

static mukca_status check(mukca_urdf_text *urdf, const char *path, mukca_error *error)
{
    if (!*urdf->text) return mukca_fail(error, MUKCA_INPUT, "%s: is empty", path);
    SHA256Data((const uint8_t *)urdf->text, strlen(urdf->text), urdf->sha256);
    mukca_status status = scan_joints(urdf, path, error);
    for (int i = 0; status == MUKCA_OK && i < urdf->n_joints; i++)
        if (urdf->joints[i].bad_origin)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s:%d: joint '%s': origin xyz and rpy must be three numbers each (a "
                              "xacro file: expand it first)",
                              path, urdf->joints[i].line, urdf->joints[i].name);
    return status;
}

mukca_status mukca_urdf_text_read(mukca_urdf_text *urdf, const char *path, mukca_error *error)
{
    *urdf = (mukca_urdf_text){0};
    mukca_status status = mukca_file_read(&urdf->text, path, error);
    if (status != MUKCA_OK) return status;
    status = check(urdf, mukca_file_shown(path), error);
    if (status != MUKCA_OK) mukca_urdf_text_free(urdf);
    return status;
}

void mukca_urdf_text_free(mukca_urdf_text *urdf)
{
    free(urdf->text);
    free(urdf->elements);
    free(urdf->joints);
    memset(urdf, 0, sizeof *urdf);
}

const mukca_urdf_joint *mukca_urdf_text_joint(const mukca_urdf_text *urdf, const char *name)
{
    for (int i = 0; i < urdf->n_joints; i++)
        if (strcmp(urdf->joints[i].name, name) == 0) return &urdf->joints[i];
    return NULL;
}
