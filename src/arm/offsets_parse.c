/* The offsets table from its text. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/cells.h"
#include "base/number.h"

enum { JOINT, PARAMETER, NOMINAL, CALIBRATED, OFFSET, SIGMA, IDENTIFIABLE, TERM, COLUMNS };
enum { MOST_CELLS = 32 };

static const char *const column_name[COLUMNS] = {
    "joint", "parameter", "nominal", "calibrated", "offset", "sigma", "identifiable", "term"};

typedef struct {
    mukca_offsets *offsets;
    mukca_offsets_origin *origin;
    const mukca_chain *chain;
    mukca_error *error;
    mukca_lines lines;
    char delimiter;
    int n_cells; /* of the header, and so of each row; 0 before it */
    char *cell[MOST_CELLS];
    int column[COLUMNS]; /* index of each column, -1: absent */
    char robot[MUKCA_NAME_SIZE], sha[72];
} reader;

static mukca_status fail(const reader *r, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static mukca_status fail(const reader *r, const char *format, ...)
{
    char what[160];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    return mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s", r->origin->name, r->lines.number, what);
}

/* Failure in one of the COLUMNS. */
static mukca_status fail_cell(const reader *r, int column, const char *what)
{
    return fail(r, "column '%s': %s", column_name[column], what);
}

static mukca_status read_number(double *value, const reader *r, int column)
{
    char fault[MUKCA_CELL_FAULT];
    if (mukca_cell_number(value, r->cell[r->column[column]], fault)) return MUKCA_OK;
    return fail_cell(r, column, fault);
}

/* Where the line is the comment "# key: value": the value, cut to value[size]; else false. */
static bool comment(char *value, size_t size, const char *line, const char *key)
{
    const size_t length = strlen(key);
    if (strncmp(line, key, length) != 0) return false;
    snprintf(value, size, "%.*s", (int)size - 1, line + length);
    return true;
}

static void read_comment(reader *r)
{
    mukca_offsets *o = r->offsets;
    comment(r->robot, sizeof r->robot, r->lines.line, "# robot: ");
    comment(r->sha, sizeof r->sha, r->lines.line, "# urdf_sha256: ");
    if (o->n_placements < MUKCA_MAX_PLACEMENTS)
        o->n_placements += comment(o->placements[o->n_placements], MUKCA_NAME_SIZE, r->lines.line,
                                   "# placement: ");
}

static mukca_status check_origin(reader *r)
{
    const char *name = r->origin->name;
    if (strcmp(r->sha, "?") == 0)
        return mukca_fail(r->error, MUKCA_INPUT,
                          "%s: no offsets table: the line `# urdf_sha256:` is missing", name);
    r->origin->other = strcmp(r->sha, r->chain->urdf_sha256) != 0;
    if (r->origin->other && !r->origin->force)
        return mukca_fail(r->error, MUKCA_INPUT,
                          "%s: was made for another URDF (robot '%.40s', SHA-256 %.12s..., not "
                          "%.12s...); --force takes its offsets nevertheless",
                          name, r->robot, r->sha, r->chain->urdf_sha256);
    return MUKCA_OK;
}

/* The columns may stand in any order. */
static mukca_status read_header(reader *r)
{
    r->delimiter = mukca_cells_delimiter(r->lines.line);
    r->n_cells = mukca_cells_count(r->lines.line, r->delimiter);
    if (r->n_cells > MOST_CELLS) return fail(r, "has more columns than an offsets table");
    mukca_cells_split(r->cell, r->n_cells, r->lines.line, r->delimiter);
    for (int i = 0; i < COLUMNS; i++) {
        r->column[i] = -1;
        for (int c = 0; c < r->n_cells; c++) {
            if (strcmp(r->cell[c], column_name[i]) != 0) continue;
            if (r->column[i] >= 0) return fail_cell(r, i, "comes twice");
            r->column[i] = c;
        }
        if (r->column[i] < 0 && i != TERM)
            return fail(r, "the header has no column '%s'", column_name[i]);
    }
    return MUKCA_OK;
}

static mukca_status read_sigma(double *sigma, const reader *r)
{
    const char *text = r->cell[r->column[SIGMA]];
    *sigma = HUGE_VAL;
    if (strcmp(text, "inf") == 0) return MUKCA_OK;
    *sigma = (double)NAN;
    if (strcmp(text, "nan") == 0 || strcmp(text, "-nan") == 0) return MUKCA_OK;
    return read_number(sigma, r, SIGMA);
}

/* Nominal, calibrated and offset, which must agree. */
static mukca_status read_values(double value[OFFSET + 1], const reader *r)
{
    for (int c = NOMINAL; c <= OFFSET; c++) {
        mukca_status status = read_number(&value[c], r, c);
        if (status != MUKCA_OK) return status;
    }
    if (!(fabs(value[NOMINAL] + value[OFFSET] - value[CALIBRATED]) <= 1e-9))
        return fail_cell(r, CALIBRATED, "is not nominal + offset");
    for (int c = CALIBRATED; c <= OFFSET; c++) /* either may be used */
        if (fabs(value[c]) > MUKCA_NUMBER_LARGEST)
            return fail_cell(r, c, "is larger than any arm's");
    return MUKCA_OK;
}

static mukca_status read_parameter(reader *r, int parameter)
{
    mukca_offsets *o = r->offsets;
    const int element = mukca_chain_find_element(r->chain, r->cell[r->column[JOINT]]);
    if (element < 0) {
        r->origin->ignored++;
        return MUKCA_OK;
    }
    const int i = MUKCA_PARAMETERS * element + parameter;
    double value[OFFSET + 1];
    if (o->listed[i]) return fail_cell(r, PARAMETER, "this parameter comes twice");
    mukca_status status = read_values(value, r);
    if (status != MUKCA_OK) return status;
    /* theta holds the chain's nominal value still */
    o->theta[i] = value[NOMINAL] == o->theta[i] ? value[CALIBRATED] : o->theta[i] + value[OFFSET];
    o->listed[i] = 1;
    o->identifiable[i] = strcmp(r->cell[r->column[IDENTIFIABLE]], "0") != 0;
    return read_sigma(&o->sigma[i], r);
}

/* The effect that a row belongs to: the last one where it goes on with that, else a new one. */
static mukca_effect *find_effect(mukca_offsets *o, const mukca_effect *wanted)
{
    for (int e = 0; e < o->n_effects; e++)
        if (mukca_effect_same(&o->effects[e], wanted)) return &o->effects[e];
    if (o->n_effects == MUKCA_MAX_EFFECTS) return NULL;
    o->effects[o->n_effects] = *wanted;
    return &o->effects[o->n_effects++];
}

static mukca_status read_effect(reader *r, int kind)
{
    mukca_offsets *o = r->offsets;
    const char *joint = r->cell[r->column[JOINT]];
    mukca_effect wanted = {.kind = (mukca_effect_kind)kind, .joint = -1, .placement = -1};
    if (mukca_effect_has(kind, MUKCA_TRAIT_RECORDING_FAULT))
        return fail_cell(r, PARAMETER, "is a recording fault and cannot be applied to an arm");
    if (mukca_effect_has_joint(kind)) {
        wanted.joint = mukca_chain_find_joint(r->chain, joint);
        if (wanted.joint < 0) return fail_cell(r, JOINT, "no such joint in the chain");
    }
    double value[OFFSET + 1];
    const char *text = r->column[TERM] < 0 ? "-" : r->cell[r->column[TERM]];
    const int term = mukca_effect_term_parse(&wanted, text, r->chain->n_joints);
    if (term < 0 || wanted.placement >= o->n_placements || wanted.placement < -1)
        return fail_cell(r, TERM, "does not fit the effect at this joint");
    mukca_effect *effect = find_effect(o, &wanted);
    if (!effect) return fail_cell(r, PARAMETER, "too many effects");
    if (effect->coefficient[term] != 0) return fail_cell(r, PARAMETER, "comes twice");
    mukca_status status = read_values(value, r);
    if (status != MUKCA_OK) return status;
    effect->coefficient[term] = value[CALIBRATED];
    return read_sigma(&o->effect_sigma[effect - o->effects][term], r);
}

static mukca_status read_row(reader *r)
{
    const char *name = r->cell[r->column[PARAMETER]];
    for (int p = 0; p < MUKCA_PARAMETERS; p++)
        if (strcmp(name, mukca_parameter_name[p]) == 0) return read_parameter(r, p);
    int kind = mukca_effect_find(name);
    if (kind < 0) return fail_cell(r, PARAMETER, "neither a parameter nor an effect");
    return read_effect(r, kind);
}

static mukca_status read_content(reader *r)
{
    if (r->n_cells == 0) {
        const mukca_status status = check_origin(r);
        return status == MUKCA_OK ? read_header(r) : status;
    }
    const int found = mukca_cells_count(r->lines.line, r->delimiter);
    if (!mukca_cells_split(r->cell, r->n_cells, r->lines.line, r->delimiter))
        return fail(r, "%d columns, but %d in the header%s", found, r->n_cells,
                    *r->lines.text ? "" : "; the last line is cut off");
    return read_row(r);
}

mukca_status mukca_offsets_parse(mukca_offsets *offsets, mukca_offsets_origin *origin,
                                 const mukca_chain *chain, const char *text, mukca_error *error)
{
    reader r = {.offsets = offsets,
                .origin = origin,
                .chain = chain,
                .lines = {.text = text},
                .robot = "?",
                .sha = "?",
                .error = error};
    mukca_offsets_init(offsets, chain);
    origin->other = false;
    origin->ignored = 0;
    while (mukca_lines_next(&r.lines)) {
        const char *first = r.lines.line + strspn(r.lines.line, " \t");
        if (*first == '#' && r.n_cells == 0) read_comment(&r);
        if (*first == '#' || !*first) continue;
        if (!r.lines.whole) return fail(&r, "the line is longer than a table's may be");
        const mukca_status status = read_content(&r);
        if (status != MUKCA_OK) return status;
    }
    if (r.n_cells > 0) return MUKCA_OK;
    return mukca_fail(error, MUKCA_INPUT, "%s: is empty; expected a header and rows", origin->name);
}
