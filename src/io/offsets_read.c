/* The offsets table: reading it back. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "io/offsets.h"
#include "io/table.h"

enum { JOINT, PARAMETER, NOMINAL, CALIBRATED, OFFSET, SIGMA, IDENTIFIABLE, TERM, COLUMNS };

typedef struct {
    mukca_offsets *offsets;
    const mukca_chain *chain;
    mukca_table table;
    int column[COLUMNS];
    mukca_note_fn *note;
    void *context;
    mukca_error *error;
    bool other; /* the table is another URDF's */
    int left_out;
} reader;

static mukca_status out_of_range(const reader *r, int column, const char *what)
{
    return mukca_table_fail(r->error, &r->table, r->column[column], "%s", what);
}

/* Value of the comment line "# key: value" into value[size]; false where there is none.  `from`
 * (may be NULL) is where to start and moves behind the line. */
static bool find_comment(char *value, size_t size, const char *comments, const char *key,
                         const char **from)
{
    size_t length = strlen(key);
    for (const char *line = from && *from ? *from : comments; *line;) {
        const char *end = line + strcspn(line, "\n");
        const char *next = end + (*end == '\n');
        if (strncmp(line, key, length) == 0) {
            size_t n = (size_t)(end - line) - length;
            if (n >= size) n = size - 1;
            memcpy(value, line + length, n);
            value[n] = '\0';
            if (from) *from = next;
            return true;
        }
        line = next;
    }
    return false;
}

static mukca_status check_origin(reader *r, bool force)
{
    char sha[72] = "", robot[MUKCA_NAME_SIZE] = "?";
    find_comment(robot, sizeof robot, r->table.comments, "# robot: ", NULL);
    if (!find_comment(sha, sizeof sha, r->table.comments, "# urdf_sha256: ", NULL))
        return mukca_fail(r->error, MUKCA_INPUT,
                          "%s: no offsets table: the line `# urdf_sha256:` is missing",
                          mukca_table_short_path(r->table.path));
    r->other = strcmp(sha, r->chain->urdf_sha256) != 0;
    if (r->other && !force)
        return mukca_fail(r->error, MUKCA_INPUT,
                          "%s: was made for another URDF (robot '%.40s', SHA-256 %.12s..., not "
                          "%.12s...); --force takes its offsets nevertheless",
                          mukca_table_short_path(r->table.path), robot, sha, r->chain->urdf_sha256);
    return MUKCA_OK;
}

static mukca_status read_placements(reader *r)
{
    const char *from = r->table.comments;
    mukca_offsets *o = r->offsets;
    while (
        o->n_placements < MUKCA_MAX_PLACEMENTS &&
        find_comment(o->placements[o->n_placements], MUKCA_NAME_SIZE, from, "# placement: ", &from))
        o->n_placements++;
    return MUKCA_OK;
}

static mukca_status read_sigma(double *sigma, const reader *r)
{
    const char *text = r->table.cell[r->column[SIGMA]];
    *sigma = HUGE_VAL;
    if (strcmp(text, "inf") == 0) return MUKCA_OK;
    *sigma = (double)NAN;
    if (strcmp(text, "nan") == 0 || strcmp(text, "-nan") == 0) return MUKCA_OK;
    return mukca_table_number(sigma, &r->table, r->column[SIGMA], r->error);
}

/* Nominal, calibrated and offset, which must agree. */
static mukca_status read_values(double value[OFFSET + 1], const reader *r)
{
    for (int c = NOMINAL; c <= OFFSET; c++) {
        mukca_status status = mukca_table_number(&value[c], &r->table, r->column[c], r->error);
        if (status) return status;
    }
    if (!(fabs(value[NOMINAL] + value[OFFSET] - value[CALIBRATED]) <= 1e-9))
        return out_of_range(r, CALIBRATED, "is not nominal + offset");
    for (int c = CALIBRATED; c <= OFFSET; c++) /* either may be used */
        if (fabs(value[c]) > MUKCA_NUMBER_LARGEST)
            return out_of_range(r, c, "is larger than any arm's");
    return MUKCA_OK;
}

static mukca_status read_parameter(reader *r, int parameter)
{
    mukca_offsets *o = r->offsets;
    const int element = mukca_chain_find_element(r->chain, r->table.cell[r->column[JOINT]]);
    if (element < 0) {
        r->left_out++;
        return MUKCA_OK;
    }
    const int i = MUKCA_PARAMETERS * element + parameter;
    double value[OFFSET + 1];
    if (o->listed[i]) return out_of_range(r, PARAMETER, "this parameter comes twice");
    mukca_status status = read_values(value, r);
    if (status) return status;
    /* theta holds the chain's nominal value still */
    o->theta[i] = value[NOMINAL] == o->theta[i] ? value[CALIBRATED] : o->theta[i] + value[OFFSET];
    o->listed[i] = 1;
    o->identifiable[i] = strcmp(r->table.cell[r->column[IDENTIFIABLE]], "0") != 0;
    return read_sigma(&o->sigma[i], r);
}

/* The effect that a row belongs to: the last one where it goes on with that, else a new one. */
static mukca_effect *find_effect(mukca_offsets *o, const mukca_effect *wanted)
{
    for (int e = 0; e < o->n_effects; e++) {
        mukca_effect *found = &o->effects[e];
        if (found->kind == wanted->kind && found->joint == wanted->joint &&
            found->placement == wanted->placement && found->variant == wanted->variant)
            return found;
    }
    if (o->n_effects == MUKCA_MAX_EFFECTS) return NULL;
    o->effects[o->n_effects] = *wanted;
    return &o->effects[o->n_effects++];
}

static mukca_status read_effect(reader *r, int kind)
{
    mukca_offsets *o = r->offsets;
    const char *joint = r->table.cell[r->column[JOINT]];
    mukca_effect wanted = {.kind = (mukca_effect_kind)kind, .joint = -1, .placement = -1};
    const mukca_effect_site site = mukca_effect_table[kind].site;
    if (site == MUKCA_SITE_SOCKET)
        return out_of_range(r, PARAMETER, "is a fault of recording, nothing to apply to an arm");
    if (site == MUKCA_SITE_ANGLE || site == MUKCA_SITE_ROTATION) {
        wanted.joint = mukca_chain_find_joint(r->chain, joint);
        if (wanted.joint < 0) return out_of_range(r, JOINT, "no such joint in the chain");
    }
    double value[OFFSET + 1];
    int term = mukca_effect_term_parse(&wanted,
                                       r->column[TERM] < 0 ? "-" : r->table.cell[r->column[TERM]]);
    if (term < 0 || wanted.placement >= o->n_placements || wanted.placement < -1)
        return out_of_range(r, TERM, "does not fit the effect");
    if (kind == MUKCA_EFFECT_JOINT_COUPLING &&
        (wanted.joint + wanted.variant < 0 || wanted.joint + wanted.variant >= r->chain->n_joints))
        return out_of_range(r, TERM, "the joint has no such neighbour");
    mukca_effect *effect = find_effect(o, &wanted);
    if (!effect) return out_of_range(r, PARAMETER, "too many effects");
    if (effect->coefficient[term] != 0) return out_of_range(r, PARAMETER, "comes twice");
    mukca_status status = read_values(value, r);
    if (status) return status;
    effect->coefficient[term] = value[CALIBRATED];
    return read_sigma(&o->effect_sigma[effect - o->effects][term], r);
}

static mukca_status read_row(reader *r)
{
    const char *name = r->table.cell[r->column[PARAMETER]];
    for (int p = 0; p < MUKCA_PARAMETERS; p++)
        if (strcmp(name, mukca_parameter_name[p]) == 0) return read_parameter(r, p);
    int kind = mukca_effect_find(name);
    if (kind < 0) return out_of_range(r, PARAMETER, "neither a parameter nor an effect");
    return read_effect(r, kind);
}

static mukca_status read_columns(reader *r)
{
    static const char *const names[COLUMNS] = {"joint",  "parameter", "nominal",      "calibrated",
                                               "offset", "sigma",     "identifiable", "term"};
    for (int i = 0; i < COLUMNS; i++) {
        r->column[i] = mukca_table_find(&r->table, names[i]);
        if (r->column[i] < 0 && i != TERM)
            return mukca_table_require(&r->column[i], &r->table, names[i], r->error);
    }
    return MUKCA_OK;
}

mukca_status mukca_offsets_read(mukca_offsets *offsets, const mukca_chain *chain, const char *path,
                                bool force, mukca_note_fn *note, void *context, mukca_error *error)
{
    reader r = {
        .offsets = offsets, .chain = chain, .note = note, .context = context, .error = error};
    char text[256];
    mukca_offsets_init(offsets, chain);
    mukca_status status = mukca_table_open(&r.table, path, MUKCA_HEADER, error);
    if (status) return status;
    status = check_origin(&r, force);
    if (status == MUKCA_OK) status = read_placements(&r);
    if (status == MUKCA_OK) status = read_columns(&r);
    while (status == MUKCA_OK) {
        bool more;
        status = mukca_table_next(&r.table, &more, error);
        if (status || !more) break;
        status = read_row(&r);
    }
    if (status == MUKCA_OK && r.other && note) {
        snprintf(text, sizeof text, "%s: made for another URDF; its offsets are added to this one",
                 mukca_table_short_path(path));
        note(context, text);
    }
    if (status == MUKCA_OK && r.left_out && note) {
        snprintf(text, sizeof text,
                 "%s: %d rows of joints that are not between '%s' and '%s' left out",
                 mukca_table_short_path(path), r.left_out, chain->base, chain->tip);
        note(context, text);
    }
    mukca_table_close(&r.table);
    return status;
}
