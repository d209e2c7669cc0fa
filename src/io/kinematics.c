/* Joint origins from the YAML files of robot makers, and their application to a chain. */
#include "io/kinematics.h"

#include <sha256.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "base/file.h"
#include "base/number.h"
#include "base/suggest.h"
#include "base/text.h"
#include "model/chain_hash.h"

/* A robot's file has some 60 lines; a larger one is of another kind. */
enum { LARGEST_FILE = 1 << 20 };

/* Differences from the URDF beyond the manufacturing tolerance of any arm: m, rad. */
static const double most_shift = 0.02, most_turn = 0.1;

typedef struct {
    mukca_kinematics *to;
    const char *name; /* file name for messages */
    yaml_document_t document;
    mukca_status status; /* of the first failure */
    mukca_error *error;
} reader;

static void fail(reader *r, const yaml_node_t *at, const char *what, const char *which)
{
    if (r->status != MUKCA_OK) return;
    r->status = mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s%.40s%s", r->name,
                           (int)at->start_mark.line + 1, what, which, *which ? "'" : "");
}

static yaml_node_t *node(reader *r, int index)
{
    return yaml_document_get_node(&r->document, index);
}

/* The text of a name or a number, else "" after a failure. */
static const char *text_of(reader *r, const yaml_node_t *n)
{
    const char *text = (const char *)n->data.scalar.value;
    if (n->type != YAML_SCALAR_NODE)
        fail(r, n, "expected NAME: NUMBER, not a list or an alias", "");
    else if (strcmp((const char *)n->tag, YAML_DEFAULT_SCALAR_TAG) != 0)
        fail(r, n, "tags are not read: '", (const char *)n->tag);
    else if (strlen(text) != n->data.scalar.length)
        fail(r, n, "contains a zero byte", "");
    else if (strlen(text) >= MUKCA_NAME_SIZE)
        fail(r, n, "a text longer than 63 characters", "");
    else
        return text;
    return "";
}

/* Read the numbers of an entry; `found`: bit mask of those read. */
static void read_numbers(reader *r, unsigned *found, double *value, const yaml_node_t *key,
                         const yaml_node_t *map, bool inner)
{
    static const char expected[] = "expected x, y, z, roll, pitch, yaw of a joint, not '";
    if (map->type != YAML_MAPPING_NODE) {
        fail(r, map, expected, text_of(r, key));
        return;
    }
    for (yaml_node_pair_t *i = map->data.mapping.pairs.start; i < map->data.mapping.pairs.top;
         i++) {
        const yaml_node_t *name = node(r, i->key), *number = node(r, i->value);
        const char *field = text_of(r, name);
        if (!inner && strcmp(field, "kinematic") == 0) {
            r->to->inner = true;
            read_numbers(r, found, value, name, number, true);
            continue;
        }
        int p = 0;
        while (p < MUKCA_PARAMETERS && strcmp(mukca_parameter_name[p], field) != 0) p++;
        if (p == MUKCA_PARAMETERS) fail(r, name, expected, field);
        const char *text = text_of(r, number);
        if (r->status != MUKCA_OK) return;
        if (*found & 1u << p) fail(r, name, "a second value of '", field);
        *found |= 1u << p;
        if (!mukca_number_parse(&value[p], text))
            fail(r, number, "no number: '", text);
        else if (fabs(value[p]) > (p < 3 ? MUKCA_NUMBER_LARGEST : 10))
            fail(r, number, "out of range (lengths are in m, angles in rad): '", text);
    }
}

static void read_entry(reader *r, const yaml_node_t *key, const yaml_node_t *map)
{
    mukca_kinematics *k = r->to;
    const char *name = text_of(r, key);
    unsigned found = 0;
    for (int i = 0; i < k->n; i++)
        if (strcmp(k->entry[i].name, name) == 0) fail(r, key, "a second entry '", name);
    if (k->n == MUKCA_MAX_ELEMENTS) fail(r, key, "too many entries", "");
    if (r->status != MUKCA_OK) return;
    mukca_kinematics_entry *e = &k->entry[k->n++];
    memcpy(e->name, name, strlen(name) + 1);
    e->line = (int)key->start_mark.line + 1;
    read_numbers(r, &found, e->value, key, map, false);
    for (int p = 0; p < MUKCA_PARAMETERS && r->status == MUKCA_OK; p++)
        if (!(found & 1u << p))
            r->status = mukca_fail(r->error, MUKCA_INPUT, "%s:%d: '%.40s' has no %s", r->name,
                                   e->line, e->name, mukca_parameter_name[p]);
}

/* Read the entries below the root, or below its only key `kinematics`. */
static void read_entries(reader *r, const yaml_node_t *map, bool root)
{
    if (map->type != YAML_MAPPING_NODE) {
        fail(r, map, "expected `kinematics:` or names of joints", "");
        return;
    }
    for (yaml_node_pair_t *i = map->data.mapping.pairs.start;
         i < map->data.mapping.pairs.top && r->status == MUKCA_OK; i++) {
        const yaml_node_t *key = node(r, i->key), *value = node(r, i->value);
        const char *name = text_of(r, key);
        if (root && strcmp(name, "kinematics") == 0 && value->type == YAML_MAPPING_NODE) {
            r->to->root = true;
            read_entries(r, value, false);
        } else if (!root && strcmp(name, "hash") == 0)
            snprintf(r->to->hash, sizeof r->to->hash, "%s", text_of(r, value));
        else
            read_entry(r, key, value);
    }
}

static void parse(reader *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser)) {
        r->status = mukca_fail(r->error, MUKCA_MEMORY, "out of memory");
        return;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    if (yaml_parser_load(&parser, &r->document)) {
        const yaml_node_t *root = yaml_document_get_root_node(&r->document);
        if (root) read_entries(r, root, true);
        yaml_document_delete(&r->document);
    } else if (parser.error == YAML_MEMORY_ERROR) {
        r->status = mukca_fail(r->error, MUKCA_MEMORY, "out of memory");
    } else {
        r->status = mukca_fail(r->error, MUKCA_INPUT, "%s:%d: broken YAML: %.80s", r->name,
                               (int)parser.problem_mark.line + 1,
                               parser.problem ? parser.problem : "no reason given");
    }
    yaml_parser_delete(&parser);
}

mukca_status mukca_kinematics_read(mukca_kinematics *kinematics, const char *path,
                                   mukca_error *error)
{
    char *text;
    reader r = {.to = kinematics, .name = mukca_file_shown(path), .error = error};
    *kinematics = (mukca_kinematics){0};
    MUKCA_TRY(mukca_file_read(&text, path, error));
    const size_t size = strlen(text);
    if (size > LARGEST_FILE)
        r.status = mukca_fail(error, MUKCA_INPUT, "%s: is larger than a file of origins", r.name);
    else
        parse(&r, text, size);
    if (r.status == MUKCA_OK && kinematics->n == 0)
        r.status = mukca_fail(error, MUKCA_INPUT,
                              "%s: no joint; expected x, y, z, roll, pitch, yaw", r.name);
    SHA256Data((const uint8_t *)text, size, kinematics->sha256);
    free(text);
    return r.status;
}

int mukca_kinematics_find(const mukca_chain *chain, const char *name)
{
    char link[MUKCA_NAME_SIZE + 8];
    snprintf(link, sizeof link, "%s_link", name);
    for (int k = 0; k < chain->n_elements; k++)
        if (mukca_prefix_ends(chain->element[k].name, name)) return k;
    for (int k = 0; k < chain->n_elements; k++)
        if (mukca_prefix_ends(chain->element[k].child, link)) return k;
    return -1;
}

/* Note an origin that differs too much to be of the same arm. */
static void compare(const mukca_element *e, const double *value, const char *path,
                    mukca_notes notes)
{
    double A[9], B[9];
    mukca_rotation_from_rpy(A, e->rpy);
    mukca_rotation_from_rpy(B, value + 3);
    const double shift = mukca_distance3(e->xyz, value), turn = mukca_rotation_between(A, B);
    if (shift > most_shift || turn > most_turn)
        mukca_note_format(notes,
                          "%s: joint '%s' is %.0f mm and %.2f rad from the URDF; is it of this "
                          "arm?",
                          mukca_file_shown(path), e->name, 1e3 * shift, turn);
}

mukca_status mukca_kinematics_apply(mukca_chain *chain, const mukca_kinematics *kinematics,
                                    const char *path, mukca_notes notes, mukca_error *error)
{
    bool set[MUKCA_MAX_ELEMENTS] = {false};
    int ignored = 0;
    const uint64_t urdf_geometry = mukca_chain_hash(chain);
    for (int i = 0; i < kinematics->n; i++) {
        const mukca_kinematics_entry *entry = &kinematics->entry[i];
        const int k = mukca_kinematics_find(chain, entry->name);
        if (k < 0) {
            ignored++;
            continue;
        }
        mukca_element *e = &chain->element[k];
        if (set[k])
            return mukca_fail(error, MUKCA_INPUT, "%s:%d: a second entry for joint '%s'",
                              mukca_file_shown(path), entry->line, e->name);
        compare(e, entry->value, path, notes);
        memcpy(e->xyz, entry->value, sizeof e->xyz);
        memcpy(e->rpy, entry->value + 3, sizeof e->rpy);
        set[k] = true;
    }
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        if (!set[chain->joint_element[j]])
            return mukca_fail(
                error, MUKCA_INPUT,
                "%s: no entry for joint '%s' (child link '%s'); entries bear the name of "
                "the joint or of its child link: is it of this arm?",
                mukca_file_shown(path), e->name, e->child);
    }
    if (ignored)
        mukca_note_format(notes, "%s: %d entries are not between '%s' and '%s'; ignored",
                          mukca_file_shown(path), ignored, chain->base, chain->tip);
    memcpy(chain->kinematics_sha256, kinematics->sha256, sizeof chain->kinematics_sha256);
    memcpy(chain->kinematics_hash, kinematics->hash, sizeof chain->kinematics_hash);
    chain->urdf_geometry = urdf_geometry;
    return MUKCA_OK;
}
