/* The chain from the comment lines of an offsets table. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arm/offsets.h"
#include "base/cells.h"
#include "base/number.h"

enum { LONGEST_LINE = 1024, MOST_CELLS = 8 };

typedef struct {
    mukca_chain *chain;
    const char *name;
    int line, n_cells;
    char *cell[MOST_CELLS];
    mukca_error *error;
} reader;

static mukca_status fail(const reader *r, const char *what)
{
    return mukca_fail(r->error, MUKCA_INPUT, "%s:%d: %s", r->name, r->line, what);
}

/* n numbers of a cell; infinite ones are allowed where asked. */
static bool numbers(double *x, int n, const char *cell, bool infinite)
{
    char word[64];
    for (int i = 0; i < n; i++) {
        cell += strspn(cell, " ");
        const size_t length = strcspn(cell, " ");
        if (length == 0 || length >= sizeof word) return false;
        memcpy(word, cell, length);
        word[length] = '\0';
        cell += length;
        if (infinite && strcmp(word, "inf") == 0)
            x[i] = HUGE_VAL;
        else if (infinite && strcmp(word, "-inf") == 0)
            x[i] = -HUGE_VAL;
        else if (!mukca_number_parse(&x[i], word))
            return false;
    }
    return cell[strspn(cell, " ")] == '\0';
}

static mukca_status read_element(reader *r)
{
    mukca_chain *c = r->chain;
    double limits[2];
    if (c->n_elements == MUKCA_MAX_ELEMENTS) return fail(r, "too many elements");
    mukca_element *e = &c->element[c->n_elements];
    int type = 0;
    if (r->n_cells != 8) return fail(r, "an element needs 7 fields");
    while (type < 4 && strcmp(mukca_joint_type_name[type], r->cell[3]) != 0) type++;
    if (type == 4 || !numbers(e->axis, 3, r->cell[4], false) ||
        !numbers(e->xyz, 3, r->cell[5], false) || !numbers(e->rpy, 3, r->cell[6], false) ||
        !numbers(limits, 2, r->cell[7], true))
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
    double element, kg, com[3];
    if (c->n_masses == MUKCA_MAX_MASSES) return fail(r, "too many masses");
    if (r->n_cells != 4 || !numbers(&element, 1, r->cell[1], false) ||
        !numbers(&kg, 1, r->cell[2], false) || !numbers(com, 3, r->cell[3], false) ||
        !(element >= -1 && element < MUKCA_MAX_ELEMENTS))
        return fail(r, "the mass cannot be read");
    mukca_mass *m = &c->mass[c->n_masses++];
    *m = (mukca_mass){.element = (int)element, .kg = kg};
    memcpy(m->com, com, sizeof com);
    return MUKCA_OK;
}

static mukca_status read_comment(reader *r, char *line)
{
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
        (r->n_cells != 2 || !numbers(c->gravity, 3, r->cell[1], false)))
        return fail(r, "gravity cannot be read");
    return MUKCA_OK;
}

mukca_status mukca_chain_parse(mukca_chain *chain, const char *text, const char *name,
                               mukca_error *error)
{
    reader r = {.chain = chain, .name = name, .error = error};
    memset(chain, 0, sizeof *chain);
    while (*text) {
        char line[LONGEST_LINE];
        size_t length = strcspn(text, "\n"), kept = length;
        r.line++;
        if (kept >= sizeof line) kept = sizeof line - 1;
        memcpy(line, text, kept);
        while (kept > 0 && line[kept - 1] == '\r') kept--;
        line[kept] = '\0';
        if (line[0] == '#') {
            const mukca_status status = read_comment(&r, line);
            if (status != MUKCA_OK) return status;
        }
        text += length + (text[length] == '\n');
    }
    if (chain->n_elements == 0)
        return fail(&r, "no `# element:` lines: write the table anew with this version of mukca");
    return MUKCA_OK;
}
