/* Joint origins from the YAML files of robot makers, and their application to a chain. */
#include "io/kinematics.h"

#include <sha256.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "base/file.h"
#include "base/note.h"
#include "base/number.h"
#include "model/chain_hash.h"

/* A robot's file has some 60 lines; a larger one is of another kind. */
enum { LARGEST_FILE = 1 << 20, DEEPEST = 4 };

/* Differences from the URDF beyond the manufacturing tolerance of any arm: m, rad. */
static const double most_shift = 0.02, most_turn = 0.1;

const mukca_kinematics_layout mukca_kinematics_layouts[3] = {
    {.name = "Universal Robots", .root = "kinematics"},
    {.name = "Franka", .inner = "kinematic"},
    {.name = "UFACTORY", .root = "kinematics"}};

/* State of the reader: keys from the outermost mapping to the innermost. */
typedef struct {
    mukca_kinematics *to;
    const char *name; /* file name for messages */
    mukca_error *error;
    char key[DEEPEST][MUKCA_NAME_SIZE];
    int line[DEEPEST]; /* of each key */
    int depth;         /* open mappings */
    bool value_next;   /* the next scalar is the value of key[depth - 1] */
    unsigned found;    /* bit mask of the numbers read of the last entry */
} reader;

static mukca_status fail(const reader *r, int line, const char *what, const char *which)
{
    return mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s%.40s%s", r->name, line, what, which,
                      *which ? "'" : "");
}

/* Check that the last entry has all six numbers. */
static mukca_status close_entry(const reader *r)
{
    if (r->to->n == 0) return MUKCA_OK;
    const mukca_kinematics_entry *last = &r->to->entry[r->to->n - 1];
    for (int p = 0; p < MUKCA_PARAMETERS; p++)
        if (!(r->found & 1u << p))
            return mukca_fail(r->error, MUKCA_INPUT, "%s:%d: '%.40s' has no %s", r->name,
                              last->line, last->name, mukca_parameter_name[p]);
    return MUKCA_OK;
}

static mukca_status open_entry(reader *r, int level)
{
    mukca_kinematics *k = r->to;
    mukca_status status = close_entry(r);
    if (status != MUKCA_OK) return status;
    for (int i = 0; i < k->n; i++)
        if (strcmp(k->entry[i].name, r->key[level]) == 0)
            return fail(r, r->line[level], "a second entry '", r->key[level]);
    if (k->n == MUKCA_MAX_ELEMENTS) return fail(r, r->line[level], "too many entries", "");
    mukca_kinematics_entry *e = &k->entry[k->n++];
    memcpy(e->name, r->key[level], sizeof e->name);
    e->line = r->line[level];
    r->found = 0;
    return MUKCA_OK;
}

/* Process KEY: text, below r->key[0 .. depth - 1]. */
static mukca_status read_value(reader *r, const char *text, int line)
{
    mukca_kinematics *k = r->to;
    const bool rooted = strcmp(r->key[0], "kinematics") == 0;
    const int entry = rooted ? 1 : 0, field = r->depth - 1;
    if (rooted && field == 1 && strcmp(r->key[1], "hash") == 0) {
        if (strlen(text) >= sizeof k->hash) return fail(r, line, "the hash is too long", "");
        memcpy(k->hash, text, strlen(text) + 1);
        return MUKCA_OK;
    }
    const bool inner = field == entry + 2 && strcmp(r->key[field - 1], "kinematic") == 0;
    if (!inner && field != entry + 1)
        return fail(r, line, "expected x, y, z, roll, pitch, yaw of a joint, not '", r->key[field]);
    int p = 0;
    while (p < MUKCA_PARAMETERS && strcmp(mukca_parameter_name[p], r->key[field]) != 0) p++;
    if (p == MUKCA_PARAMETERS)
        return fail(r, line, "expected x, y, z, roll, pitch, yaw of a joint, not '", r->key[field]);
    if (k->n == 0 || k->entry[k->n - 1].line != r->line[entry]) {
        const mukca_status status = open_entry(r, entry);
        if (status != MUKCA_OK) return status;
    }
    if (r->found & 1u << p) return fail(r, line, "a second value of '", r->key[field]);
    double *value = &k->entry[k->n - 1].value[p];
    if (!mukca_number_parse(value, text)) return fail(r, line, "no number: '", text);
    if (fabs(*value) > (p < 3 ? MUKCA_NUMBER_LARGEST : 10))
        return fail(r, line, "out of range (lengths are in m, angles in rad): '", text);
    r->found |= 1u << p;
    return MUKCA_OK;
}

static mukca_status read_scalar(reader *r, const yaml_event_t *event)
{
    const int line = (int)event->start_mark.line + 1;
    const char *text = (const char *)event->data.scalar.value;
    const size_t length = event->data.scalar.length;
    const char *tag = (const char *)event->data.scalar.tag;
    if (r->depth == 0) return fail(r, line, "expected `kinematics:` or names of joints", "");
    if (strlen(text) != length) return fail(r, line, "contains a zero byte", "");
    if (tag) return fail(r, line, "tags are not read: '", tag);
    if (r->value_next) {
        r->value_next = false;
        return read_value(r, text, line);
    }
    if (length >= MUKCA_NAME_SIZE) return fail(r, line, "a name longer than 63 characters", "");
    memcpy(r->key[r->depth - 1], text, length + 1);
    r->line[r->depth - 1] = line;
    r->value_next = true;
    return MUKCA_OK;
}

static mukca_status read_event(reader *r, const yaml_event_t *event)
{
    const int line = (int)event->start_mark.line + 1;
    switch ((int)event->type) {
        case YAML_MAPPING_START_EVENT:
            if (r->depth > 0 && !r->value_next) return fail(r, line, "expected a name", "");
            if (r->depth == DEEPEST) return fail(r, line, "nested more than 4 deep", "");
            r->depth++;
            r->value_next = false;
            return MUKCA_OK;
        case YAML_MAPPING_END_EVENT:
            r->depth--;
            return MUKCA_OK;
        case YAML_SCALAR_EVENT:
            return read_scalar(r, event);
        case YAML_SEQUENCE_START_EVENT:
        case YAML_ALIAS_EVENT:
            return fail(r, line, "expected NAME: NUMBER, not a list or an alias", "");
        default:
            return MUKCA_OK;
    }
}

static mukca_status parse(reader *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    mukca_status status = MUKCA_OK;
    if (!yaml_parser_initialize(&parser))
        return mukca_fail(r->error, MUKCA_MEMORY, "out of memory");
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    for (bool more = true; more && status == MUKCA_OK;) {
        yaml_event_t event;
        if (!yaml_parser_parse(&parser, &event)) {
            const int line = (int)parser.problem_mark.line + 1;
            status = parser.error == YAML_MEMORY_ERROR
                         ? mukca_fail(r->error, MUKCA_MEMORY, "out of memory")
                         : mukca_fail(r->error, MUKCA_INPUT, "%s:%d: broken YAML: %.80s", r->name,
                                      line, parser.problem ? parser.problem : "no reason given");
            break;
        }
        more = event.type != YAML_STREAM_END_EVENT;
        status = read_event(r, &event);
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    return status;
}

/* Link names indicate Universal Robots' layout, an inner mapping Franka's. */
static const mukca_kinematics_layout *find_layout(const mukca_kinematics *k, bool inner)
{
    if (inner) return &mukca_kinematics_layouts[1];
    const bool links = k->hash[0] || (k->n > 0 && strncmp(k->entry[0].name, "joint", 5) != 0);
    return &mukca_kinematics_layouts[links ? 0 : 2];
}

mukca_status mukca_kinematics_read(mukca_kinematics *kinematics, const char *path,
                                   mukca_error *error)
{
    char *text;
    reader r = {.to = kinematics, .name = mukca_file_shown(path), .error = error};
    *kinematics = (mukca_kinematics){0};
    mukca_status status = mukca_file_read(&text, path, error);
    if (status != MUKCA_OK) return status;
    const size_t size = strlen(text);
    if (size > LARGEST_FILE)
        status = mukca_fail(error, MUKCA_INPUT, "%s: is larger than a file of origins", r.name);
    if (status == MUKCA_OK) status = parse(&r, text, size);
    if (status == MUKCA_OK) status = close_entry(&r);
    if (status == MUKCA_OK && kinematics->n == 0)
        status = mukca_fail(error, MUKCA_INPUT, "%s: no joint; expected x, y, z, roll, pitch, yaw",
                            r.name);
    SHA256Data((const uint8_t *)text, size, kinematics->sha256);
    kinematics->layout = find_layout(kinematics, strstr(text, "kinematic:") != NULL);
    free(text);
    return status;
}

/* Whether `text` equals NAME + `behind`, or ends in _NAME + `behind`. */
static bool is_named(const char *text, const char *name, const char *behind)
{
    const size_t length = strlen(text), tail = strlen(name) + strlen(behind);
    if (length < tail || (length > tail && text[length - tail - 1] != '_')) return false;
    const char *at = text + (length - tail);
    return strncmp(at, name, strlen(name)) == 0 && strcmp(at + strlen(name), behind) == 0;
}

int mukca_kinematics_find(const mukca_chain *chain, const char *name)
{
    for (int k = 0; k < chain->n_elements; k++)
        if (is_named(chain->element[k].name, name, "")) return k;
    for (int k = 0; k < chain->n_elements; k++)
        if (is_named(chain->element[k].child, name, "_link")) return k;
    return -1;
}

/* Note an origin that differs too much to be of the same arm. */
static void compare(const mukca_element *e, const double *value, const char *path,
                    mukca_note_fn *note, void *context)
{
    double A[9], B[9];
    mukca_rotation_from_rpy(A, e->rpy);
    mukca_rotation_from_rpy(B, value + 3);
    const double shift = mukca_distance3(e->xyz, value), turn = mukca_rotation_between(A, B);
    if (shift > most_shift || turn > most_turn)
        mukca_note_format(note, context,
                          "%s: joint '%s' is %.0f mm and %.2f rad from the URDF; is it of this "
                          "arm?",
                          mukca_file_shown(path), e->name, 1e3 * shift, turn);
}

mukca_status mukca_kinematics_apply(mukca_chain *chain, const mukca_kinematics *kinematics,
                                    const char *path, mukca_note_fn *note, void *context,
                                    mukca_error *error)
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
        compare(e, entry->value, path, note, context);
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
        mukca_note_format(note, context, "%s: %d entries are not between '%s' and '%s'; ignored",
                          mukca_file_shown(path), ignored, chain->base, chain->tip);
    memcpy(chain->kinematics_sha256, kinematics->sha256, sizeof chain->kinematics_sha256);
    memcpy(chain->kinematics_hash, kinematics->hash, sizeof chain->kinematics_hash);
    chain->urdf_geometry = urdf_geometry;
    return MUKCA_OK;
}
