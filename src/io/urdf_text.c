/* A URDF as text: read, hashed and checked, its joints listed with libxml2. */
#include "io/urdf.h"

#include <libxml/parser.h>
#include <libxml/tree.h>
#include <sha2.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/list.h"
#include "base/number.h"

/* Limits far beyond any real robot.  The depth also bounds the stack of urdfdom's recursive parser.
 * urdfdom is given the elements serialised again, as it would find elements in processing
 * instructions. */
enum { DEEPEST = 64, MOST_JOINTS = 4096 };

typedef struct {
    mukca_urdf_text *urdf;
    const char *path;
    mukca_status status; /* of the first failure */
    mukca_error *error;
} scan;

static bool is(const xmlNode *node, const char *name)
{
    return strcmp((const char *)node->name, name) == 0 && !(node->ns && node->ns->prefix);
}

/* Read three numbers of an attribute, which may be absent. */
static mukca_status read_numbers(const scan *s, double *values, const xmlNode *origin,
                                 const char *key, const mukca_urdf_joint *joint)
{
    char *text = (char *)xmlGetNoNsProp(origin, (const xmlChar *)key);
    const bool good = !text || mukca_number_parse_list(values, 3, text);
    xmlFree(text);
    if (good) return MUKCA_OK;
    return mukca_fail(s->error, MUKCA_INPUT,
                      "%s:%d: joint '%s': origin xyz and rpy must be three numbers each "
                      "(a xacro file: expand it first)",
                      s->path, joint->line, joint->name ? joint->name : "");
}

static mukca_status read_joint(const scan *s, const xmlNode *node)
{
    mukca_urdf_text *urdf = s->urdf;
    if (urdf->n_joints == MOST_JOINTS)
        return mukca_fail(s->error, MUKCA_INPUT, "%s: has more than %d joints", s->path,
                          (int)MOST_JOINTS);
    mukca_urdf_joint *joint = mukca_list_append(&urdf->joints, &urdf->n_joints, sizeof *joint);
    if (!joint) return mukca_fail(s->error, MUKCA_MEMORY, "out of memory");
    joint->name = (char *)xmlGetNoNsProp(node, (const xmlChar *)"name");
    joint->line = (int)xmlGetLineNo(node);
    const xmlNode *origin = node->children;
    while (origin && !(origin->type == XML_ELEMENT_NODE && is(origin, "origin")))
        origin = origin->next;
    if (!origin) return MUKCA_OK; /* urdfdom uses the first */
    MUKCA_TRY(read_numbers(s, joint->xyz, origin, "xyz", joint));
    return read_numbers(s, joint->rpy, origin, "rpy", joint);
}

/* Refuse elements that no URDF for this program has. */
static mukca_status check_element(const scan *s, const xmlNode *node, int depth)
{
    const char *name = (const char *)node->name;
    const char *prefix = node->ns ? (const char *)node->ns->prefix : name;
    const int line = (int)xmlGetLineNo(node);
    if (depth == 0 && !is(node, "robot"))
        return mukca_fail(s->error, MUKCA_INPUT,
                          "%s:%d: the root element is <%.40s>, not <robot>; this is no URDF",
                          s->path, line, name);
    if (depth >= DEEPEST)
        return mukca_fail(s->error, MUKCA_INPUT,
                          "%s:%d: elements nested more than %d deep; this is no URDF", s->path,
                          line, (int)DEEPEST);
    if (prefix && strncmp(prefix, "xacro", 5) == 0 && strchr(":", prefix[5]))
        return mukca_fail(s->error, MUKCA_INPUT,
                          "%s:%d: contains xacro macros; expand them first: xacro IN > OUT.urdf",
                          s->path, line);
    return MUKCA_OK;
}

/* Check the elements below a node, and remove all else. */
static mukca_status check_children(const scan *s, xmlNode *parent, int depth)
{
    for (xmlNode *child = parent->children, *next; child; child = next) {
        next = child->next;
        if (child->type != XML_ELEMENT_NODE) {
            xmlUnlinkNode(child);
            xmlFreeNode(child);
            continue;
        }
        MUKCA_TRY(check_element(s, child, depth));
        if (depth == 1 && is(child, "joint")) {
            MUKCA_TRY(read_joint(s, child));
        }
        MUKCA_TRY(check_children(s, child, depth + 1));
    }
    return MUKCA_OK;
}

/* Refuse document types: entities could hide elements and expand without limit. */
static void document_type(void *context, const xmlChar *name, const xmlChar *id, const xmlChar *uri)
{
    (void)name, (void)id, (void)uri;
    scan *s = ((xmlParserCtxtPtr)context)->_private;
    s->status =
        mukca_fail(s->error, MUKCA_INPUT,
                   "%s:%d: has a document type (<!DOCTYPE ...>), which no URDF needs; remove it",
                   s->path, xmlSAX2GetLineNumber(context));
    xmlStopParser(context);
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
    scan s = {.urdf = urdf, .path = path, .error = error};
    xmlChar *elements = NULL;
    int size;
    watch_memory();
    xmlParserCtxtPtr parser = xmlNewParserCtxt();
    if (!parser) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    parser->_private = &s;
    parser->sax->internalSubset = document_type;
    xmlDocPtr document =
        xmlCtxtReadMemory(parser, urdf->text, (int)strlen(urdf->text), NULL, NULL,
                          XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
    if (document && s.status == MUKCA_OK) s.status = check_children(&s, (xmlNode *)document, 0);
    if (document && s.status == MUKCA_OK) xmlDocDumpMemoryEnc(document, &elements, &size, "UTF-8");
    urdf->elements = (char *)elements;
    if (!document && s.status == MUKCA_OK) {
        const xmlError *e = xmlCtxtGetLastError(parser);
        char text[120] = "is broken";
        if (e && e->message) snprintf(text, sizeof text, "%s", e->message);
        text[strcspn(text, "\n")] = '\0';
        s.status =
            mukca_fail(error, MUKCA_INPUT, "%s:%d: broken XML: %s", path, e ? e->line : 0, text);
    }
    if (failed || (s.status == MUKCA_OK && !elements))
        s.status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    xmlFreeDoc(document);
    xmlFreeParserCtxt(parser);
    return s.status;
}

mukca_status mukca_urdf_text_read(mukca_urdf_text *urdf, const char *path, mukca_error *error)
{
    *urdf = (mukca_urdf_text){0};
    MUKCA_TRY(mukca_file_read(&urdf->text, path, error));
    path = mukca_file_shown(path);
    SHA256Data((const uint8_t *)urdf->text, strlen(urdf->text), urdf->sha256);
    const mukca_status status = *urdf->text ? scan_joints(urdf, path, error)
                                            : mukca_fail(error, MUKCA_INPUT, "%s: is empty", path);
    if (status != MUKCA_OK) mukca_urdf_text_free(urdf);
    return status;
}

void mukca_urdf_text_free(mukca_urdf_text *urdf)
{
    free(urdf->text);
    free(urdf->elements);
    for (int i = 0; i < urdf->n_joints; i++) free(urdf->joints[i].name);
    free(urdf->joints);
    memset(urdf, 0, sizeof *urdf);
}

const mukca_urdf_joint *mukca_urdf_text_joint(const mukca_urdf_text *urdf, const char *name)
{
    for (int i = 0; i < urdf->n_joints; i++)
        if (urdf->joints[i].name && strcmp(urdf->joints[i].name, name) == 0)
            return &urdf->joints[i];
    return NULL;
}
