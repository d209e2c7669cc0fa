/* Comparing an exported file with what would be exported now. */
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "io/export.h"
#include "io/table.h"

/* of m, rad and quaternions, relative for numbers above 1 (stiffness); the same bound below which
 * an offset is not exported */
static const double tolerance = 1e-9;

static void add_missing(mukca_export_difference *d, const char *what, const char *name)
{
    if (d->agrees) snprintf(d->where, sizeof d->where, "%s '%.80s' is missing", what, name);
    d->agrees = false;
}

/* Behind the comment or string (names contain digits) that starts at `c`; `c` where none does. */
static const char *skip_words(const char *c, const char *const comment[2])
{
    if (!comment) return c;
    const bool string = *c == '"';
    if (!string && strncmp(c, comment[0], strlen(comment[0])) != 0) return c;
    const char *mark = string ? "\"" : comment[1];
    const char *end = strstr(c + 1, mark);
    return end ? end + strlen(mark) : c + strlen(c);
}

/* The next number, moving *text behind it; false at the end.  Where `comment` is given, comments
 * and strings are skipped. */
static bool next_number(double *value, const char **text, const char *const comment[2])
{
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789.+-";
    const char *c = *text;
    while (*c) {
        const char *behind = skip_words(c, comment);
        const size_t word = behind == c ? strspn(c, letters) : 0;
        char number[64];
        if (behind != c) {
            c = behind;
            continue;
        }
        if (word > 0 && word < sizeof number) {
            memcpy(number, c, word);
            number[word] = '\0';
            if (mukca_number_parse(value, number)) {
                *text = c + word;
                return true;
            }
        }
        c += word > 0 ? word : 1;
    }
    *text = c;
    return false;
}

/* Number by number; `where` names the place, NULL: the number's place in the file. */
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

/* Does `node` have the tag and the name of `wanted`? */
static bool is_twin(const xmlNode *node, const xmlNode *wanted)
{
    xmlChar *a = xmlGetProp(node, BAD_CAST "name"), *b = xmlGetProp(wanted, BAD_CAST "name");
    const bool same = xmlStrEqual(node->name, wanted->name) && xmlStrEqual(a, b);
    xmlFree(a);
    xmlFree(b);
    return same;
}

/* Tags that hold a chain: of a URDF, and of a MuJoCo model. */
static bool is_of_chain(const xmlNode *node)
{
    static const char *const tags[] = {"robot", "origin", "mujoco", "worldbody", "body", "joint"};
    for (size_t i = 0; i < sizeof tags / sizeof *tags && node->type == XML_ELEMENT_NODE; i++)
        if (strcmp((const char *)node->name, tags[i]) == 0) return true;
    return false;
}

/* The twin of `wanted` in a list of nodes and, where `deep`, below them. */
static xmlNode *find_twin(xmlNode *node, const xmlNode *wanted, bool deep)
{
    for (; node; node = node->next) {
        if (!is_of_chain(node)) continue;
        if (is_twin(node, wanted)) return node;
        xmlNode *below = deep ? find_twin(node->children, wanted, true) : NULL;
        if (below) return below;
    }
    return NULL;
}

/* Every element and number of the chain `wanted` in the list `found`, or anywhere in `root`. */
static void compare_nodes(mukca_export_difference *d, xmlNode *root, xmlNode *found,
                          xmlNode *wanted, const char *parent)
{
    static const char *const keys[] = {"xyz", "rpy", "pos", "quat", "axis", "stiffness"};
    for (; wanted; wanted = wanted->next) {
        if (!is_of_chain(wanted)) continue;
        xmlChar *name = xmlGetProp(wanted, BAD_CAST "name");
        const char *where = name ? (const char *)name : parent;
        xmlNode *twin = find_twin(found, wanted, false);
        if (!twin && name) twin = find_twin(root, wanted, true);
        if (!twin) add_missing(d, (const char *)wanted->name, where);
        for (size_t i = 0; i < sizeof keys / sizeof *keys && twin; i++) {
            xmlChar *a = xmlGetProp(twin, BAD_CAST keys[i]);
            xmlChar *b = xmlGetProp(wanted, BAD_CAST keys[i]);
            if (a || b)
                compare_numbers(d, a ? (const char *)a : "", b ? (const char *)b : "", NULL, where);
            xmlFree(a);
            xmlFree(b);
        }
        if (twin) compare_nodes(d, root, twin->children, wanted->children, where);
        xmlFree(name);
    }
}

/* XML: the file may have more elements, and in another order, than the model. */
static mukca_status compare_xml(mukca_export_difference *d, const mukca_export_texts *texts,
                                mukca_error *error)
{
    const int quiet = XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING;
    xmlDoc *found = xmlReadMemory(texts->found, (int)strlen(texts->found), "found", NULL, quiet);
    xmlDoc *wanted =
        xmlReadMemory(texts->wanted, (int)strlen(texts->wanted), "wanted", NULL, quiet);
    mukca_status status = MUKCA_OK;
    if (found && wanted) {
        xmlNode *root = xmlDocGetRootElement(found);
        compare_nodes(d, root->children, root->children, xmlDocGetRootElement(wanted)->children,
                      "");
    } else {
        status = mukca_fail(error, MUKCA_INPUT, "%s: not well-formed XML; export it again",
                            mukca_table_short_path(texts->path));
    }
    xmlFreeDoc(found);
    xmlFreeDoc(wanted);
    return status;
}

mukca_status mukca_export_compare(mukca_export_difference *difference,
                                  const mukca_export_texts *texts, const char *const comment[2],
                                  mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    *difference = (mukca_export_difference){.agrees = true};
    if (comment[0])
        compare_numbers(difference, texts->found, texts->wanted, comment, NULL);
    else
        status = compare_xml(difference, texts, error);
    if (difference->compared == 0) difference->agrees = false;
    return status;
}
