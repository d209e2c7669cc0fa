/* Parser of offsets tables, with the chain and the verdict in their comments. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/cells.h"
#include "base/hash.h"
#include "base/number.h"

enum { JOINT, PARAMETER, NOMINAL, CALIBRATED, OFFSET, SIGMA, IDENTIFIABLE, UNIT, TERM, COLUMNS };
enum { MOST_CELLS = 32 };

static const char *const column_name[COLUMNS] = {"joint",        "parameter", "nominal",
                                                 "calibrated",   "offset",    "sigma",
                                                 "identifiable", "unit",      "term"};

typedef struct {
    const mukca_offsets_target *into;
    mukca_offsets_origin *origin;
    const mukca_chain *chain;
    mukca_error *error;
    mukca_lines lines;
    char delimiter;
    int n_cells; /* cells of the header and each row; 0 before the header */
    char *cell[MOST_CELLS];
    int n_placements;
    int column[COLUMNS]; /* index of each column, -1: absent */
    uint64_t digest;     /* of the lines so far */
    char stated[24];     /* digest in the comments; empty: none */
} reader;

__attribute__((format(printf, 2, 3))) static mukca_status fail(const reader *r, const char *format,
                                                               ...)
{
    mukca_error *error = r->error;
    va_list args;
    if (!error) return MUKCA_INPUT;
    error->status = MUKCA_INPUT;
    if (r->lines.number > 0) /* else the error concerns the whole table */
        mukca_print(error->text, sizeof error->text, "%s:%d: ", r->origin->name, r->lines.number);
    else
        mukca_print(error->text, sizeof error->text, "%s: ", r->origin->name);
    const size_t used = strlen(error->text);
    va_start(args, format);
    mukca_print_list(error->text + used, sizeof error->text - used, format, args);
    va_end(args);
    return MUKCA_INPUT;
}

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

static mukca_status read_element(const reader *r, mukca_chain *c, int n)
{
    double limits[2] = {-HUGE_VAL, HUGE_VAL};
    if (c->n_elements == MUKCA_MAX_ELEMENTS) return fail(r, "too many elements");
    mukca_element *e = &c->element[c->n_elements];
    int type = 0;
    if (n != 8) return fail(r, "an element needs 7 fields");
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

static mukca_status read_mass(const reader *r, mukca_chain *c, int n)
{
    double element;
    if (c->n_masses == MUKCA_MAX_MASSES) return fail(r, "too many masses");
    mukca_mass *m = &c->mass[c->n_masses++];
    if (n != 4 || !mukca_number_parse(&element, r->cell[1]) ||
        !mukca_number_parse(&m->kg, r->cell[2]) ||
        !mukca_number_parse_list(m->com, 3, r->cell[3]) ||
        !(element >= -1 && element < MUKCA_MAX_ELEMENTS))
        return fail(r, "the mass cannot be read");
    m->element = (int)element;
    return MUKCA_OK;
}

/* Parse "# key: value", or "# key:" and cells. */
static mukca_status read_comment(reader *r)
{
    const mukca_offsets_target *into = r->into;
    mukca_chain *c = r->origin->embedded;
    char *line = r->lines.line, placement[MUKCA_NAME_SIZE];
    comment(c->robot, sizeof c->robot, line, "# robot: ");
    comment(c->base, sizeof c->base, line, "# base: ");
    comment(c->tip, sizeof c->tip, line, "# tip: ");
    comment(c->urdf_sha256, sizeof c->urdf_sha256, line, "# urdf_sha256: ");
    comment(c->kinematics_sha256, sizeof c->kinematics_sha256, line, "# kinematics_sha256: ");
    comment(c->kinematics_hash, sizeof c->kinematics_hash, line, "# kinematics_hash: ");
    mukca_acceptance_read(into->acceptance, line);
    if (r->n_placements < MUKCA_MAX_PLACEMENTS &&
        comment(placement, sizeof placement, line, "# placement: ")) {
        if (into->rest)
            memcpy(into->rest->placements[r->n_placements], placement, sizeof placement);
        r->n_placements++;
    }
    const int n = mukca_cells_count(line, '\t');
    if (n > MOST_CELLS || !mukca_cells_split(r->cell, n, line, '\t')) return MUKCA_OK;
    if (strcmp(r->cell[0], "# element:") == 0) return read_element(r, c, n);
    if (strcmp(r->cell[0], "# mass:") == 0) return read_mass(r, c, n);
    if (strcmp(r->cell[0], "# gravity:") == 0 &&
        (n != 2 || !mukca_number_parse_list(c->gravity, 3, r->cell[1])))
        return fail(r, "gravity cannot be read");
    return MUKCA_OK;
}

/* Check the comments.  The errors concern the whole table and have no line number. */
static mukca_status check_comments(reader *r)
{
    const mukca_offsets_target *into = r->into;
    const mukca_acceptance *a = into->acceptance;
    if (r->chain->n_elements == 0)
        return fail(
            r, "no offsets table, or one of an older version: it lacks the `# element:` lines");
    if (into->check) MUKCA_TRY(into->check(r->origin, r->chain, r->error));
    if (a->given && !a->accepted && !(r->origin->accept & MUKCA_ACCEPT_FAILED))
        return fail(r,
                    "this calibration did not pass: %.150s (--accept-failed uses it nevertheless)",
                    a->reason);
    return MUKCA_OK;
}

/* Compare all lines with the digest among them; a table of an older version has none. */
static mukca_status check_digest(const reader *r)
{
    mukca_acceptance *a = r->into->acceptance;
    char digest[17] = "";
    for (int i = 0; i < 16; i++) digest[i] = "0123456789abcdef"[r->digest >> (60 - 4 * i) & 15];
    a->intact = strcmp(r->stated, digest) == 0;
    if (a->intact || !r->stated[0]) return MUKCA_OK;
    if (!(r->origin->accept & MUKCA_ACCEPT_EDITED))
        return fail(r,
                    "was edited or cut after it was written: the digest differs; calibrate again "
                    "(--accept-edited uses it nevertheless)");
    mukca_acceptance_read(a, "# accepted: no; the table was edited or cut after it was written");
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
        if (i < UNIT && r->column[i] < 0)
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
    for (int c = NOMINAL; c <= OFFSET; c++) MUKCA_TRY(read_number(&value[c], r, c));
    if (!(fabs(value[NOMINAL] + value[OFFSET] - value[CALIBRATED]) <= 1e-9))
        return fail_cell(r, CALIBRATED, "is not nominal + offset");
    for (int c = CALIBRATED; c <= OFFSET; c++) /* either may be applied */
        if (fabs(value[c]) > MUKCA_NUMBER_LARGEST)
            return fail_cell(r, c, "is larger than any arm's");
    return MUKCA_OK;
}

static mukca_status check_unit(const reader *r, const char *unit)
{
    const char *found = r->column[UNIT] < 0 ? unit : r->cell[r->column[UNIT]];
    if (strcmp(found, unit) == 0) return MUKCA_OK;
    return fail(r, "column 'unit': is '%.20s'; convert the row to %s", found, unit);
}

/* Whether the row is of a measurement's frame at an end of the chain: no part of the arm. */
static bool is_frame(const reader *r, const char *joint)
{
    const mukca_chain *embedded = r->origin->embedded;
    const int k = mukca_chain_find_element(embedded, joint);
    const char *child = k < 0 ? "" : embedded->element[k].child;
    return strcmp(child, r->chain->base) == 0 || strcmp(child, r->chain->tip) == 0;
}

static mukca_status read_parameter(reader *r, int parameter)
{
    const mukca_offsets_target *into = r->into;
    const int element = mukca_chain_find_element(r->chain, r->cell[r->column[JOINT]]);
    if (element < 0 && r->chain == r->origin->embedded)
        return fail_cell(r, JOINT, "no such joint in its chain");
    if (element < 0) {
        r->origin->ignored += !is_frame(r, r->cell[r->column[JOINT]]);
        return MUKCA_OK;
    }
    const int i = MUKCA_PARAMETERS * element + parameter;
    double value[OFFSET + 1];
    if (into->listed[i]) return fail_cell(r, PARAMETER, "this parameter comes twice");
    MUKCA_TRY(check_unit(r, parameter < 3 ? "m" : "rad"));
    MUKCA_TRY(read_values(value, r));
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
    const char *unit = mukca_effect_table[kind]->unit; /* older tables: of a turning joint */
    if (r->column[UNIT] >= 0 && strcmp(r->cell[r->column[UNIT]], unit) != 0)
        unit = mukca_effect_unit(effect, r->chain);
    MUKCA_TRY(check_unit(r, unit));
    MUKCA_TRY(read_values(value, r));
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

/* Read the header or a row.  Errors of the whole table have no line number. */
static mukca_status read_content(reader *r)
{
    if (r->n_cells == 0) {
        const int number = r->lines.number;
        r->lines.number = 0;
        MUKCA_TRY(check_comments(r));
        r->lines.number = number;
        mukca_chain_theta(r->into->theta, r->chain);
        return read_header(r);
    }
    const int found = mukca_cells_count(r->lines.line, r->delimiter);
    if (!mukca_cells_split(r->cell, r->n_cells, r->lines.line, r->delimiter))
        return fail(r, "%d columns, but %d in the header%s", found, r->n_cells,
                    r->lines.left ? "" : "; the last line is cut off");
    return read_row(r);
}

/* Add the line to the digest, unless it is the digest. */
static void digest_line(reader *r)
{
    if (r->n_cells == 0 && comment(r->stated, sizeof r->stated, r->lines.line, "# digest: "))
        return;
    r->digest = mukca_hash(r->digest, r->lines.line, strlen(r->lines.line));
    if (r->lines.text[-1] == '\n') r->digest = mukca_hash(r->digest, "\n", 1);
}

mukca_status mukca_offsets_parse_into(const mukca_offsets_target *into,
                                      mukca_offsets_origin *origin, const mukca_chain *chain,
                                      const char *text, size_t size, mukca_error *error)
{
    reader r = {.into = into,
                .origin = origin,
                .chain = chain ? chain : origin->embedded,
                .lines = {.text = text, .left = size},
                .digest = MUKCA_HASH_START,
                .error = error};
    memset(origin->embedded, 0, sizeof *origin->embedded);
    *into->n_effects = 0;
    mukca_acceptance_init(into->acceptance);
    origin->ignored = 0;
    while (mukca_lines_next(&r.lines)) {
        const char *first = r.lines.line + strspn(r.lines.line, " \t");
        const bool is_comment = *first == '#';
        digest_line(&r);
        if (!*first || (is_comment && r.n_cells > 0)) continue;
        if (is_comment)
            MUKCA_TRY(read_comment(&r));
        else if (!r.lines.whole)
            return fail(&r, "the line is longer than a table's may be");
        else
            MUKCA_TRY(read_content(&r));
    }
    if (into->rest) into->rest->n_placements = r.n_placements;
    r.lines.number = 0;
    return r.n_cells > 0 ? check_digest(&r) : fail(&r, "is empty; expected a header and rows");
}
