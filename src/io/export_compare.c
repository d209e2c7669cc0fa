/* Comparison of an exported file with a new export. */
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "io/export.h"
#include "io/xml_memory.h"

/* tolerance for m, rad and quaternions, relative for numbers above 1 (stiffness); equal to the
 * smallest offset that is exported */
static const double tolerance = 1e-9;

static void add_missing(mukca_export_difference *d, const char *what, const char *name)
{
    if (d->agrees) snprintf(d->where, sizeof d->where, "%s '%.80s' is missing", what, name);
    d->agrees = false;
}

/* Length of the comment or string (names contain digits) at `c`; 0: neither starts there. */
static size_t words(const char *c, const char *const comment[2])
{
    const bool string = *c == '"';
    if (!string && strncmp(c, comment[0], strlen(comment[0])) != 0) return 0;
    const char *mark = string ? "\"" : comment[1];
    const char *end = strstr(c + 1, mark);
    return end ? (size_t)(end - c) + strlen(mark) : strlen(c);
}

/* Read the next number and advance *text past it; false at the end.  If `comment` is given,
 * comments and strings are skipped. */
static bool next_number(double *value, const char **text, const char *const comment[2])
{
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789.+-";
    char number[64];
    while (**text) {
        const char *start = *text;
        const size_t skipped = comment ? words(start, comment) : 0;
        const size_t length = skipped ? 0 : strspn(start, letters);
        *text += skipped ? skipped : length ? length : 1;
        snprintf(number, sizeof number, "%.*s", (int)length, start);
        if (length < sizeof number && mukca_number_parse(value, number)) return true;
    }
    return false;
}

/* Compare number by number; `where` is the location, NULL: the number's index in the file. */
static void compare_numbers(mukca_export_difference *d, const char *found, const char *wanted,
                            const char *const comment[2], const char *where)
{
    for (int i = 1;; i++) {
        double a, b;
        char place[40];
        const bool more = next_number(&a, &found, comment), due = next_number(&b, &wanted, comment);
        if (!more && !due) return;
        snprintf(place, sizeof place, "number %d", i);
        if (more != due) {
            add_missing(d, more ? "the table for" : "in the file,", where ? where : place);
            return;
        }
        const double difference = fabs(a - b) / fmax(1, fabs(b));
        d->compared++;
        if (!(difference <= d->largest) || !d->where[0])
            snprintf(d->where, sizeof d->where, "%.80s", where ? where : place);
        if (!(difference <= d->largest)) d->largest = difference;
        d->agrees = d->agrees && difference <= tolerance;
    }
}

void mukca_export_compare_text(mukca_export_difference *difference, const char *found,
                               const char *wanted, const char *const comment[2])
{
    compare_numbers(difference, found, wanted, comment, NULL);
}

/* Whether an element is part of the chain, in a URDF or a MuJoCo model. */
static bool is_of_chain(const xmlNode *node)
{
    static const char *const tags[] = {"robot", "origin", "mujoco", "worldbody", "body", "joint"};
    for (size_t i = 0; i < sizeof tags / sizeof *tags && node->type == XML_ELEMENT_NODE; i++)
        if (strcmp((const char *)node->name, tags[i]) == 0) return true;
    return false;
}

/* Value of an attribute; "" if absent. */
static const char *attribute(const xmlNode *node, const char *key)
{
    const xmlAttr *a = xmlHasProp(node, BAD_CAST key);
    const bool text = a && a->type == XML_ATTRIBUTE_NODE && a->children && a->children->content;
    return text ? (const char *)a->children->content : "";
}

/* Find the element `tag` among the siblings of `node` and their descendants: with that name, or, if
 * such elements have no name, inside the element of that name. */
static xmlNode *find(xmlNode *node, const xmlChar *tag, const char *name, bool inside)
{
    for (; node; node = node->next) {
        if (!is_of_chain(node)) continue;
        const char *own = attribute(node, "name");
        const bool named = *own ? strcmp(own, name) == 0 : inside;
        if (named && xmlStrEqual(node->name, tag)) return node;
        xmlNode *below = find(node->children, tag, name, named);
        if (below) return below;
    }
    return NULL;
}

/* Compare every element and number of the chain `wanted`, whose parent has the name `parent`. */
static void compare_nodes(mukca_export_difference *d, xmlNode *root, xmlNode *wanted,
                          const char *parent)
{
    static const char *const keys[] = {"xyz", "rpy", "pos", "quat", "axis", "stiffness"};
    for (; wanted; wanted = wanted->next) {
        if (!is_of_chain(wanted)) continue;
        const char *own = attribute(wanted, "name");
        const char *name = *own ? own : parent;
        xmlNode *twin = find(root, wanted->name, name, !*name);
        if (!twin) add_missing(d, (const char *)wanted->name, name);
        for (size_t i = 0; i < sizeof keys / sizeof *keys && twin; i++) {
            const char *a = attribute(twin, keys[i]), *b = attribute(wanted, keys[i]);
            compare_numbers(d, a, b, NULL, name);
        }
        compare_nodes(d, root, wanted->children, name);
    }
}

mukca_status mukca_export_compare_xml(mukca_export_difference *difference, const char *found,
                                      const char *wanted)
{
    mukca_xml_memory_watch();
    const int quiet = XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING;
    xmlDoc *a = xmlReadMemory(found, (int)strlen(found), "found", NULL, quiet);
    xmlDoc *b = xmlReadMemory(wanted, (int)strlen(wanted), "wanted", NULL, quiet);
    const bool whole = !mukca_xml_memory_failed(), readable = a && b;
    if (readable && whole)
        compare_nodes(difference, xmlDocGetRootElement(a)->children,
                      xmlDocGetRootElement(b)->children, "");
    xmlFreeDoc(a);
    xmlFreeDoc(b);
    return !whole ? MUKCA_MEMORY : readable ? MUKCA_OK : MUKCA_INPUT;
}
