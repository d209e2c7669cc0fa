/* The chain from the comment lines of an offsets table. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/cells.h"
#include "base/number.h"

enum { MOST_CELLS = 8 };

typedef struct {
    mukca_chain *chain;
    const char *name;
    mukca_lines lines;
    int n_cells;
    char *cell[MOST_CELLS];
    mukca_error *error;
} reader;

static mukca_status fail(const reader *r, const char *what)
{
    return mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s", r->name, r->lines.number, what);
}

static mukca_status read_element(reader *r)
{
    mukca_chain *c = r->chain;
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
    snprintf(e->name, sizeof e->name, "%s", r->cell[1]);
    snprintf(e->child, sizeof e->child, "%s", r->cell[2]);
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
    mukca_chain *c = r->chain;
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

static mukca_status read_comment(reader *r)
{
    char *line = r->lines.line;
    mukca_chain *c = r->chain;
    const struct {
        const char *key;
        char *to;
        size_t size;
    } names[] = {{"# robot: ", c->robot, sizeof c->robot},
                 {"# base: ", c->base, sizeof c->base},
                 {"# tip: ", c->tip, sizeof c->tip},
                 {"# urdf_sha256: ", c->urdf_sha256, sizeof c->urdf_sha256}};
    for (int i = 0; i < 4; i++)
        if (strncmp(line, names[i].key, strlen(names[i].key)) == 0)
            snprintf(names[i].to, names[i].size, "%.*s", (int)names[i].size - 1,
                     line + strlen(names[i].key));
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

mukca_status mukca_chain_parse(mukca_chain *chain, const char *text, const char *name,
                               mukca_error *error)
{
    reader r = {.chain = chain, .name = name, .lines = {.text = text}, .error = error};
    memset(chain, 0, sizeof *chain);
    while (mukca_lines_next(&r.lines)) {
        if (r.lines.line[0] != '#') continue;
        const mukca_status status = read_comment(&r);
        if (status != MUKCA_OK) return status;
    }
    if (chain->n_elements > 0) return MUKCA_OK;
    return fail(&r, "no `# element:` lines: write the table anew with this version of mukca");
}
