/* Comparing exported models with the table. */
#include "io/export_check.h"

#include <errno.h>
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "io/table.h"
#include "io/urdf.h"

static const double tolerance = 1e-9; /* m, rad; stiffness: relative */

/* Remember the worst place. */
static void note_difference(mukca_export_difference *d, double position, double angle,
                            const char *where, const char *what)
{
    d->compared++;
    if (!(position <= d->position && angle <= d->angle) || d->where[0] == '\0')
        snprintf(d->where, sizeof d->where, "%.80s%s%s", where, *what ? " " : "", what);
    if (!(position <= d->position)) d->position = position;
    if (!(angle <= d->angle)) d->angle = angle;
    d->agrees = d->agrees && position <= tolerance && angle <= tolerance;
}

static void note_missing(mukca_export_difference *d, const char *what, const char *name)
{
    if (d->agrees) snprintf(d->where, sizeof d->where, "%s '%.80s' is missing", what, name);
    d->agrees = false;
}

static double distance(const double *a, const double *b)
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

static mukca_status check_urdf(mukca_export_difference *d, const char *path,
                               const mukca_export_input *input, mukca_error *error)
{
    mukca_chain *chain = calloc(1, sizeof *chain);
    if (!chain) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_urdf_options options = {.base = input->chain->base, .tip = input->chain->tip};
    mukca_status status = mukca_urdf_load(chain, path, &options, NULL, NULL, error);
    for (int k = 0; status == MUKCA_OK && k < input->chain->n_elements; k++) {
        const mukca_element *wanted = &input->chain->element[k];
        const int at = mukca_chain_find_element(chain, wanted->name);
        double xyz[3], rpy[3], quaternion[4], R[9], S[9];
        if (at < 0) {
            note_missing(d, "joint", wanted->name);
            continue;
        }
        mukca_export_origin(xyz, rpy, quaternion, input, k);
        mukca_rotation_from_rpy(R, rpy);
        mukca_rotation_from_rpy(S, chain->element[at].rpy);
        note_difference(d, distance(xyz, chain->element[at].xyz), mukca_rotation_between(R, S),
                        wanted->name, "");
    }
    free(chain);
    return status;
}

/* ---- MuJoCo ---- */

static xmlNode *find_named(xmlNode *node, const char *tag, const char *name)
{
    for (; node; node = node->next) {
        if (node->type != XML_ELEMENT_NODE) continue;
        if (strcmp((const char *)node->name, tag) == 0) {
            xmlChar *found = xmlGetProp(node, (const xmlChar *)"name");
            const bool match = found && strcmp((const char *)found, name) == 0;
            xmlFree(found);
            if (match) return node;
        }
        xmlNode *below = find_named(node->children, tag, name);
        if (below) return below;
    }
    return NULL;
}

/* Numbers of an attribute; `values` keeps its defaults where there is none. */
static bool attribute(double *values, int n, xmlNode *node, const char *key)
{
    xmlChar *text = xmlGetProp(node, (const xmlChar *)key);
    const bool good = !text || mukca_number_parse_list(values, n, (const char *)text);
    xmlFree(text);
    return good;
}

static void check_body(mukca_export_difference *d, xmlNode *found, xmlNode *wanted,
                       const char *name)
{
    double p[2][3] = {{0}}, q[2][4] = {{1, 0, 0, 0}, {1, 0, 0, 0}}, R[2][9];
    xmlNode *const node[2] = {found, wanted};
    for (int i = 0; i < 2; i++) {
        if (!attribute(p[i], 3, node[i], "pos") || !attribute(q[i], 4, node[i], "quat"))
            p[i][0] = (double)NAN;
        mukca_rotation_from_quaternion(R[i], q[i]);
    }
    note_difference(d, distance(p[0], p[1]), mukca_rotation_between(R[0], R[1]), name, "pos, quat");
}

static void check_joint(mukca_export_difference *d, xmlNode *found, xmlNode *wanted,
                        const char *name)
{
    double k[2] = {0, 0}, axis[2][3] = {{0, 0, 1}, {0, 0, 1}};
    xmlNode *const node[2] = {found, wanted};
    bool good = true;
    for (int i = 0; i < 2; i++)
        good = attribute(&k[i], 1, node[i], "stiffness") &&
               attribute(axis[i], 3, node[i], "axis") && good;
    const double off = k[1] > 0 ? fabs(k[0] / k[1] - 1) : fabs(k[0]);
    note_difference(d, good ? off : (double)NAN, distance(axis[0], axis[1]), name,
                    "stiffness, axis");
}

/* Every body and joint of `wanted` in `found`. */
static void check_nodes(mukca_export_difference *d, xmlNode *found, xmlNode *wanted)
{
    for (; wanted; wanted = wanted->next) {
        if (wanted->type != XML_ELEMENT_NODE) continue;
        const char *tag = (const char *)wanted->name;
        const bool body = strcmp(tag, "body") == 0, joint = strcmp(tag, "joint") == 0;
        xmlChar *name = xmlGetProp(wanted, (const xmlChar *)"name");
        if ((body || joint) && name) {
            xmlNode *twin = find_named(found, tag, (const char *)name);
            if (!twin)
                note_missing(d, tag, (const char *)name);
            else if (body)
                check_body(d, twin, wanted, (const char *)name);
            else
                check_joint(d, twin, wanted, (const char *)name);
        }
        xmlFree(name);
        check_nodes(d, found, wanted->children);
    }
}

static mukca_status check_mjcf(mukca_export_difference *d, const char *path, const char *text,
                               size_t length, const char *wanted, mukca_error *error)
{
    const int quiet = XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING;
    xmlDoc *found = xmlReadMemory(text, (int)length, path, NULL, quiet);
    xmlDoc *now = xmlReadMemory(wanted, (int)strlen(wanted), "now", NULL, quiet);
    mukca_status status = MUKCA_OK;
    if (found && now)
        check_nodes(d, xmlDocGetRootElement(found), xmlDocGetRootElement(now));
    else
        status = mukca_fail(error, MUKCA_INPUT, "%s: is no well-formed XML",
                            mukca_table_short_path(path));
    xmlFreeDoc(found);
    xmlFreeDoc(now);
    return status;
}

/* ---- YAML and C: number by number ---- */

/* The next number outside of comments (`#` to the end of the line in YAML, slash-star in C), moving
 * *text behind it; false at the end. */
static bool next_number(double *value, const char **text, bool yaml)
{
    const char *c = *text;
    while (*c) {
        if (yaml && *c == '#') c += strcspn(c, "\n");
        if (!yaml && c[0] == '/' && c[1] == '*') {
            const char *end = strstr(c, "*/");
            c = end ? end + 2 : c + strlen(c);
        } else if (*c == '"') { /* names may hold digits */
            const char *end = strchr(c + 1, '"');
            c = end ? end + 1 : c + strlen(c);
        }
        const size_t word = strspn(c,
                                   "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
                                   "0123456789.+-");
        char number[64];
        if (word == 0) {
            c += *c != '\0' && *c != '"' && !(yaml && *c == '#');
            continue;
        }
        if (word < sizeof number) {
            memcpy(number, c, word);
            number[word] = '\0';
            if (mukca_number_parse(value, number)) {
                *text = c + word;
                return true;
            }
        }
        c += word;
    }
    *text = c;
    return false;
}

static void check_numbers(mukca_export_difference *d, const char *found, const char *wanted,
                          bool yaml)
{
    for (int i = 1;; i++) {
        double a, b;
        char where[40];
        const bool more = next_number(&a, &found, yaml), due = next_number(&b, &wanted, yaml);
        if (!more && !due) return;
        snprintf(where, sizeof where, "number %d", i);
        if (more != due) {
            note_missing(d, more ? "the table for" : "in the file,", where);
            return;
        }
        note_difference(d, fabs(a - b), 0, where, "");
    }
}

static mukca_status read_file(char **text, size_t *length, const char *path, mukca_error *error)
{
    enum { LARGEST = 1 << 26 };
    FILE *file = fopen(path, "rb");
    *text = NULL;
    *length = 0;
    if (!file)
        return mukca_fail(error, MUKCA_INPUT, "%s: %s", mukca_table_short_path(path),
                          strerror(errno));
    mukca_status status = MUKCA_OK;
    for (size_t room = 0; status == MUKCA_OK;) {
        if (*length + 1 >= room) {
            room = room ? 2 * room : 1 << 16;
            char *grown = room <= LARGEST ? realloc(*text, room) : NULL;
            if (!grown)
                status =
                    mukca_fail(error, MUKCA_MEMORY, "%s: too large", mukca_table_short_path(path));
            if (!grown) break;
            *text = grown;
        }
        const size_t got = fread(*text + *length, 1, room - *length - 1, file);
        *length += got;
        (*text)[*length] = '\0';
        if (got == 0) break;
    }
    if (status == MUKCA_OK && ferror(file))
        status = mukca_fail(error, MUKCA_INPUT, "%s: cannot be read", mukca_table_short_path(path));
    fclose(file);
    return status;
}

mukca_status mukca_export_check(mukca_export_difference *difference, const char *path,
                                const mukca_exporter *exporter, const mukca_export_input *input,
                                mukca_error *error)
{
    *difference = (mukca_export_difference){.agrees = true};
    if (exporter->write == mukca_export_urdf) return check_urdf(difference, path, input, error);
    char *text, *wanted = NULL;
    size_t length, size;
    mukca_status status = read_file(&text, &length, path, error);
    FILE *stream = status == MUKCA_OK ? open_memstream(&wanted, &size) : NULL;
    if (status == MUKCA_OK && !stream) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK) status = exporter->write(stream, input, error);
    if (stream && fclose(stream) != 0 && status == MUKCA_OK)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK && exporter->write == mukca_export_mjcf)
        status = check_mjcf(difference, path, text, length, wanted, error);
    else if (status == MUKCA_OK)
        check_numbers(difference, text, wanted, exporter->write == mukca_export_yaml);
    if (status == MUKCA_OK && difference->compared == 0) difference->agrees = false;
    free(text);
    free(wanted);
    return status;
}
