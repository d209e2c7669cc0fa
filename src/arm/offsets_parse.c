/* Parser of offsets tables and of the chain in their comments. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/cells.h"
#include "base/number.h"
#include "base/print.h"

enum { JOINT, PARAMETER, NOMINAL, CALIBRATED, OFFSET, SIGMA, IDENTIFIABLE, TERM, COLUMNS };
enum { MOST_CELLS = 32 };

static const char *const column_name[COLUMNS] = {
    "joint", "parameter", "nominal", "calibrated", "offset", "sigma", "identifiable", "term"};

typedef struct {
    const mukca_offsets_target *into;
    mukca_offsets_origin *origin;
    const mukca_chain *chain;
    mukca_chain *new_chain; /* under construction in mukca_chain_parse */
    const char *name;       /* name of the table in messages */
    mukca_error *error;
    mukca_lines lines;
    char delimiter;
    int n_cells; /* cells of the header and each row; 0 before the header */
    char *cell[MOST_CELLS];
    int n_placements;
    int column[COLUMNS]; /* index of each column, -1: absent */
    char robot[MUKCA_NAME_SIZE], sha[72], kinematics[72];
} reader;

static mukca_status fail(const reader *r, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static mukca_status fail(const reader *r, const char *format, ...)
{
    mukca_error *error = r->error;
    va_list args;
    if (!error) return MUKCA_INPUT;
    error->status = MUKCA_INPUT;
    if (r->lines.number > 0) /* else the error concerns the whole table */
        mukca_print(error->text, sizeof error->text, "%s:%d: ", r->name, r->lines.number);
    else
        mukca_print(error->text, sizeof error->text, "%s: ", r->name);
    const size_t used = strlen(error->text);
    va_start(args, format);
    mukca_print_list(error->text + used, sizeof error->text - used, format, args);
    va_end(args);
    return MUKCA_INPUT;
}

/* Fail in one of the COLUMNS. */
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

/* Match the comment "# key: value" and copy the value, truncated to value[size]; else false. */
static bool comment(char *value, size_t size, const char *line, const char *key)
{
    const size_t length = strlen(key);
    if (strncmp(line, key, length) != 0) return false;
    mukca_print(value, size, "%s", line + length);
    return true;
}

static void read_comment(reader *r)
{
    const mukca_offsets_target *into = r->into;
    char placement[MUKCA_NAME_SIZE];
    comment(r->robot, sizeof r->robot, r->lines.line, "# robot: ");
    comment(r->sha, sizeof r->sha, r->lines.line, "# urdf_sha256: ");
    comment(r->kinematics, sizeof r->kinematics, r->lines.line, "# kinematics_sha256: ");
    mukca_acceptance_read(into->acceptance, r->lines.line);
    if (r->n_placements == MUKCA_MAX_PLACEMENTS ||
        !comment(placement, sizeof placement, r->lines.line, "# placement: "))
        return;
    if (into->rest) memcpy(into->rest->placements[r->n_placements], placement, sizeof placement);
    r->n_placements++;
}

/* Check the origin.  The error concerns the whole table and has no line number. */
static mukca_status check_origin(reader *r)
{
    const int number = r->lines.number;
    const mukca_acceptance *a = r->into->acceptance;
    r->lines.number = 0;
    if (strcmp(r->sha, "?") == 0)
        return fail(r, "no offsets table: the line `# urdf_sha256:` is missing");
    r->origin->other = strcmp(r->sha, r->chain->urdf_sha256) != 0;
    if (r->origin->other && !r->origin->force)
        return fail(r,
                    "was made for another URDF (robot '%.40s', SHA-256 %.12s..., not %.12s...); "
                    "--force applies its offsets nevertheless",
                    r->robot, r->sha, r->chain->urdf_sha256);
    if (strcmp(r->kinematics, r->chain->kinematics_sha256) != 0 && !r->origin->force)
        return fail(
            r, "was made %s: its offsets are added to other origins; give %s",
            r->kinematics[0] ? "with a factory file (--kinematics)" : "without --kinematics",
            r->kinematics[0] ? "the same --kinematics FILE" : "no --kinematics");
    if (a->given && !a->accepted && !r->origin->accept_failed)
        return fail(r,
                    "this calibration did not pass: %.150s (--accept-failed uses it nevertheless)",
                    a->reason);
    r->lines.number = number;
    return MUKCA_OK;
}

/* Read the header; columns may be in any order. */
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

/* Read nominal, calibrated and offset, which must agree. */
static mukca_status read_values(double value[OFFSET + 1], const reader *r)
{
    for (int c = NOMINAL; c <= OFFSET; c++) {
        mukca_status status = read_number(&value[c], r, c);
        if (status != MUKCA_OK) return status;
    }
    if (!(fabs(value[NOMINAL] + value[OFFSET] - value[CALIBRATED]) <= 1e-9))
        return fail_cell(r, CALIBRATED, "is not nominal + offset");
    for (int c = CALIBRATED; c <= OFFSET; c++) /* either may be applied */
        if (fabs(value[c]) > MUKCA_NUMBER_LARGEST)
            return fail_cell(r, c, "is larger than any arm's");
    return MUKCA_OK;
}

static mukca_status read_parameter(reader *r, int parameter)
{
    const mukca_offsets_target *into = r->into;
    const int element = mukca_chain_find_element(r->chain, r->cell[r->column[JOINT]]);
    if (element < 0) {
        r->origin->ignored++;
        return MUKCA_OK;
    }
    const int i = MUKCA_PARAMETERS * element + parameter;
    double value[OFFSET + 1];
    if (into->listed[i]) return fail_cell(r, PARAMETER, "this parameter comes twice");
    mukca_status status = read_values(value, r);
    if (status != MUKCA_OK) return status;
    /* here theta still has the chain's nominal value */
    into->theta[i] =
        value[NOMINAL] == into->theta[i] ? value[CALIBRATED] : into->theta[i] + value[OFFSET];
    into->listed[i] = 1;
    if (!into->rest) return MUKCA_OK;
    into->rest->identifiable[i] = strcmp(r->cell[r->column[IDENTIFIABLE]], "0") != 0;
    return read_sigma(&into->rest->sigma[i], r);
}

/* Find the effect of a row, or append it; NULL: too many. */
static mukca_effect *find_effect(const mukca_offsets_target *into, const mukca_effect *wanted)
{
    for (int e = 0; e < *into->n_effects; e++)
        if (mukca_effect_same(&into->effects[e], wanted)) return &into->effects[e];
    if (*into->n_effects == MUKCA_MAX_EFFECTS) return NULL;
    into->effects[*into->n_effects] = *wanted;
    return &into->effects[(*into->n_effects)++];
}

static mukca_status read_effect(reader *r, int kind)
{
    const mukca_offsets_target *into = r->into;
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
    if (term < 0 || wanted.placement >= r->n_placements || wanted.placement < -1)
        return fail_cell(r, TERM, "does not fit the effect at this joint");
    mukca_effect *effect = find_effect(into, &wanted);
    if (!effect) return fail_cell(r, PARAMETER, "too many effects");
    if (effect->coefficient[term] != 0) return fail_cell(r, PARAMETER, "comes twice");
    mukca_status status = read_values(value, r);
    if (status != MUKCA_OK) return status;
    effect->coefficient[term] = value[CALIBRATED];
    if (!into->rest) return MUKCA_OK;
    return read_sigma(&into->rest->effect_sigma[effect - into->effects][term], r);
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
                    r->lines.left ? "" : "; the last line is cut off");
    return read_row(r);
}

mukca_status mukca_offsets_parse_into(const mukca_offsets_target *into,
                                      mukca_offsets_origin *origin, const mukca_chain *chain,
                                      mukca_bytes table, mukca_error *error)
{
    reader r = {.into = into,
                .origin = origin,
                .chain = chain,
                .name = origin->name,
                .lines = {.text = table.text, .left = table.size},
                .robot = "?",
                .sha = "?",
                .error = error};
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
    if (into->rest) into->rest->n_placements = r.n_placements;
    if (r.n_cells > 0) return MUKCA_OK;
    r.lines.number = 0;
    return fail(&r, "is empty; expected a header and rows");
}

static mukca_status read_element(reader *r)
{
    mukca_chain *c = r->new_chain;
    double limits[2] = {-HUGE_VAL, HUGE_VAL};
    if (c->n_elements == MUKCA_MAX_ELEMENTS) return fail(r, "too many elements");
    mukca_element *e = &c->element[c->n_elements];
    int type = 0;
    if (r->n_cells != 8) return fail(r, "an element needs 7 fields");
    while (type < 4 && strcmp(mukca_joint_type_name[type], r->cell[3]) != 0) type++;
    const bool limited = strcmp(r->cell[7], "-inf inf") != 0;
    if (type == 4 || !mukca_number_parse_list(e->axis, 3, r->cell[4]) ||
        !mukca_number_parse_list(e->xyz, 3, r->cell[5]) ||
        !mukca_number_parse_list(e->rpy, 3, r->cell[6]) ||
        (limited && !mukca_number_parse_list(limits, 2, r->cell[7])))
        return fail(r, "the element's numbers or its type cannot be read");
    mukca_print(e->name, sizeof e->name, "%s", r->cell[1]);
    mukca_print(e->child, sizeof e->child, "%s", r->cell[2]);
    e->type = (mukca_joint_type)type;
    e->lower = limits[0];
    e->upper = limits[1];
    e->joint = -1;
    if (e->type != MUKCA_FIXED) {
        if (c->n_joints == MUKCA_MAX_JOINTS) return fail(r, "too many joints");
        if (!(fabs(mukca_dot3(e->axis, e->axis) - 1) < 1e-6))
            return fail(r, "the joint's axis is no unit vector");
        e->joint = c->n_joints;
        c->joint_element[c->n_joints++] = c->n_elements;
    }
    c->n_elements++;
    return MUKCA_OK;
}

static mukca_status read_mass(reader *r)
{
    mukca_chain *c = r->new_chain;
    double element;
    if (c->n_masses == MUKCA_MAX_MASSES) return fail(r, "too many masses");
    mukca_mass *m = &c->mass[c->n_masses++];
    if (r->n_cells != 4 || !mukca_number_parse(&element, r->cell[1]) ||
        !mukca_number_parse(&m->kg, r->cell[2]) ||
        !mukca_number_parse_list(m->com, 3, r->cell[3]) ||
        !(element >= -1 && element < MUKCA_MAX_ELEMENTS))
        return fail(r, "the mass cannot be read");
    m->element = (int)element;
    return MUKCA_OK;
}

/* Parse a comment line of the chain: "# key: value", or "# key:" and cells. */
static mukca_status read_chain_line(reader *r)
{
    mukca_chain *c = r->new_chain;
    char *line = r->lines.line;
    comment(c->robot, sizeof c->robot, line, "# robot: ");
    comment(c->base, sizeof c->base, line, "# base: ");
    comment(c->tip, sizeof c->tip, line, "# tip: ");
    comment(c->urdf_sha256, sizeof c->urdf_sha256, line, "# urdf_sha256: ");
    comment(c->kinematics_sha256, sizeof c->kinematics_sha256, line, "# kinematics_sha256: ");
    comment(c->kinematics_hash, sizeof c->kinematics_hash, line, "# kinematics_hash: ");
    r->n_cells = mukca_cells_count(line, '\t');
    if (r->n_cells > MOST_CELLS || !mukca_cells_split(r->cell, r->n_cells, line, '\t'))
        return MUKCA_OK;
    if (strcmp(r->cell[0], "# element:") == 0) return read_element(r);
    if (strcmp(r->cell[0], "# mass:") == 0) return read_mass(r);
    if (strcmp(r->cell[0], "# gravity:") == 0 &&
        (r->n_cells != 2 || !mukca_number_parse_list(c->gravity, 3, r->cell[1])))
        return fail(r, "gravity cannot be read");
    return MUKCA_OK;
}

mukca_status mukca_chain_parse(mukca_chain *chain, mukca_bytes table, const char *name,
                               mukca_error *error)
{
    reader r = {.new_chain = chain,
                .name = name,
                .lines = {.text = table.text, .left = table.size},
                .error = error};
    *chain = (mukca_chain){0};
    while (mukca_lines_next(&r.lines)) {
        if (r.lines.line[0] != '#') continue;
        const mukca_status status = read_chain_line(&r);
        if (status != MUKCA_OK) return status;
    }
    if (chain->n_elements > 0) return MUKCA_OK;
    return fail(&r,
                "no offsets table, or one of an older version: it lacks the `# element:` lines");
}
