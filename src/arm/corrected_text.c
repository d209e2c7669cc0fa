/* The corrected arm from the text of an offsets table: comment lines tell the chain, rows its
 * calibrated values and effects. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "mukca/corrected.h"

static const char *const type_name[] = {"fixed", "revolute", "continuous", "prismatic"};

enum { LONGEST_LINE = 1024, MOST_CELLS = 16 };

static void write_text(FILE *stream, const char *text)
{
    for (; *text; text++) fputc((unsigned char)*text < ' ' ? ' ' : *text, stream);
}

static void write_numbers(FILE *stream, const double *x, int n)
{
    for (int i = 0; i < n; i++) fprintf(stream, "%s%.17g", i ? " " : "\t", x[i]);
}

void mukca_chain_write_comments(FILE *stream, const mukca_chain *chain)
{
    fputs("# gravity:", stream);
    write_numbers(stream, chain->gravity, 3);
    fputc('\n', stream);
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *e = &chain->element[k];
        const double limits[2] = {e->lower, e->upper};
        fputs("# element:\t", stream);
        write_text(stream, e->name);
        fputc('\t', stream);
        write_text(stream, e->child);
        fprintf(stream, "\t%s", type_name[e->type]);
        write_numbers(stream, e->axis, 3);
        write_numbers(stream, e->xyz, 3);
        write_numbers(stream, e->rpy, 3);
        write_numbers(stream, limits, 2);
        fputc('\n', stream);
    }
    for (int m = 0; m < chain->n_masses; m++) {
        fprintf(stream, "# mass:\t%d", chain->mass[m].element);
        write_numbers(stream, &chain->mass[m].kg, 1);
        write_numbers(stream, chain->mass[m].com, 3);
        fputc('\n', stream);
    }
}

typedef struct {
    mukca_corrected *model;
    double theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    int line;
    char buffer[LONGEST_LINE];
    char *cell[MOST_CELLS];
    int n_cells;
    bool in_rows; /* the header is behind us */
    mukca_error *error;
} reader;

static mukca_status fail(const reader *r, const char *what)
{
    return mukca_fail(r->error, MUKCA_INPUT, "offsets table, line %d: %s", r->line, what);
}

/* Copy the line that begins at `text` and split it at tabs; returns what follows it. */
static const char *take_line(reader *r, const char *text)
{
    size_t length = strcspn(text, "\n");
    const char *next = text + length + (text[length] == '\n');
    r->line++;
    if (length >= LONGEST_LINE) length = LONGEST_LINE - 1;
    memcpy(r->buffer, text, length);
    r->buffer[length] = '\0';
    if (length > 0 && r->buffer[length - 1] == '\r') r->buffer[length - 1] = '\0';
    r->n_cells = 0;
    for (char *cell = r->buffer; cell && r->n_cells < MOST_CELLS;) {
        char *tab = strchr(cell, '\t');
        if (tab) *tab++ = '\0';
        r->cell[r->n_cells++] = cell;
        cell = tab;
    }
    return next;
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

static void copy_name(char name[MUKCA_NAME_SIZE], const char *text)
{
    snprintf(name, MUKCA_NAME_SIZE, "%s", text);
}

static mukca_status read_element(reader *r)
{
    mukca_chain *c = &r->model->chain;
    double limits[2];
    if (c->n_elements == MUKCA_MAX_ELEMENTS) return fail(r, "too many elements");
    mukca_element *e = &c->element[c->n_elements];
    int type = 0;
    if (r->n_cells != 8) return fail(r, "an element needs 7 fields");
    while (type < 4 && strcmp(type_name[type], r->cell[3]) != 0) type++;
    if (type == 4 || !numbers(e->axis, 3, r->cell[4], false) ||
        !numbers(e->xyz, 3, r->cell[5], false) || !numbers(e->rpy, 3, r->cell[6], false) ||
        !numbers(limits, 2, r->cell[7], true))
        return fail(r, "the element's numbers or its type cannot be read");
    copy_name(e->name, r->cell[1]);
    copy_name(e->child, r->cell[2]);
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
    mukca_chain *c = &r->model->chain;
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

static mukca_status read_comment(reader *r)
{
    mukca_chain *c = &r->model->chain;
    static const char *const key[] = {"# robot: ", "# base: ", "# tip: "};
    char *const name[] = {c->robot, c->base, c->tip};
    for (int i = 0; i < 3; i++)
        if (strncmp(r->cell[0], key[i], strlen(key[i])) == 0)
            copy_name(name[i], r->cell[0] + strlen(key[i]));
    if (strncmp(r->cell[0], "# urdf_sha256: ", 15) == 0)
        snprintf(c->urdf_sha256, sizeof c->urdf_sha256, "%s", r->cell[0] + 15);
    if (strcmp(r->cell[0], "# element:") == 0) return read_element(r);
    if (strcmp(r->cell[0], "# mass:") == 0) return read_mass(r);
    if (strcmp(r->cell[0], "# gravity:") == 0 &&
        (r->n_cells != 2 || !numbers(c->gravity, 3, r->cell[1], false)))
        return fail(r, "gravity cannot be read");
    return MUKCA_OK;
}

static mukca_status read_effect(reader *r, int kind, double value)
{
    mukca_corrected *m = r->model;
    mukca_effect wanted = {.kind = (mukca_effect_kind)kind, .joint = -1, .placement = -1};
    const mukca_effect_site site = mukca_effect_table[kind].site;
    if (site == MUKCA_SITE_SOCKET) return fail(r, "a fault of recording is nothing to apply");
    if (site == MUKCA_SITE_ANGLE || site == MUKCA_SITE_ROTATION) {
        wanted.joint = mukca_chain_find_joint(&m->chain, r->cell[0]);
        if (wanted.joint < 0) return fail(r, "no such joint");
    }
    const int term = mukca_effect_term_parse(&wanted, r->n_cells > 8 ? r->cell[8] : "-");
    if (term < 0) return fail(r, "the term does not fit the effect");
    if (wanted.kind == MUKCA_EFFECT_JOINT_COUPLING &&
        (wanted.joint + wanted.variant < 0 || wanted.joint + wanted.variant >= m->chain.n_joints))
        return fail(r, "the joint has no such neighbour");
    int e = 0;
    while (e < m->n_effects &&
           !(m->effects[e].kind == wanted.kind && m->effects[e].joint == wanted.joint &&
             m->effects[e].placement == wanted.placement &&
             m->effects[e].variant == wanted.variant))
        e++;
    if (e == MUKCA_MAX_EFFECTS) return fail(r, "too many effects");
    if (e == m->n_effects) m->effects[m->n_effects++] = wanted;
    m->effects[e].coefficient[term] = value;
    return MUKCA_OK;
}

static mukca_status read_row(reader *r)
{
    double value;
    if (r->n_cells < 8 || !mukca_number_parse(&value, r->cell[4]))
        return fail(r, "a row needs joint, parameter, unit, nominal and a calibrated number");
    for (int p = 0; p < MUKCA_PARAMETERS; p++) {
        if (strcmp(r->cell[1], mukca_parameter_name[p]) != 0) continue;
        const int k = mukca_chain_find_element(&r->model->chain, r->cell[0]);
        if (k < 0) return fail(r, "no such joint in the chain");
        r->theta[MUKCA_PARAMETERS * k + p] = value;
        return MUKCA_OK;
    }
    const int kind = mukca_effect_find(r->cell[1]);
    return kind < 0 ? fail(r, "neither a parameter nor an effect") : read_effect(r, kind, value);
}

static mukca_status read_header(reader *r)
{
    static const char *const name[] = {"joint",      "parameter", "unit",  "nominal",
                                       "calibrated", "offset",    "sigma", "identifiable"};
    for (int i = 0; i < 8; i++)
        if (i >= r->n_cells || strcmp(r->cell[i], name[i]) != 0)
            return fail(r, "this is not the header of an offsets table");
    if (r->model->chain.n_elements == 0)
        return fail(r, "no `# element:` lines: write the table anew with this version of mukca");
    mukca_chain_theta(r->theta, &r->model->chain);
    r->in_rows = true;
    return MUKCA_OK;
}

mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, mukca_error *error)
{
    reader r = {.model = model, .error = error};
    mukca_status status = MUKCA_OK;
    memset(model, 0, sizeof *model);
    while (*text && status == MUKCA_OK) {
        text = take_line(&r, text);
        if (!r.buffer[0])
            continue;
        else if (r.buffer[0] == '#')
            status = read_comment(&r);
        else
            status = r.in_rows ? read_row(&r) : read_header(&r);
    }
    if (status == MUKCA_OK && !r.in_rows) status = fail(&r, "ends before its header");
    if (status == MUKCA_OK) mukca_geometry_set(&model->geometry, &model->chain, r.theta);
    return status;
}

mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error)
{
    enum { LARGEST = 1 << 22 };
    FILE *file = fopen(path, "rb");
    if (!file) return mukca_fail(error, MUKCA_INPUT, "%.100s: %s", path, strerror(errno));
    char *text = calloc(1, LARGEST);
    size_t length = text ? fread(text, 1, LARGEST - 1, file) : 0;
    mukca_status status = MUKCA_OK;
    if (!text)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    else if (ferror(file) || length == LARGEST - 1)
        status = mukca_fail(error, MUKCA_INPUT, "%.100s: cannot be read, or is no table", path);
    else
        status = mukca_corrected_parse(model, text, error);
    free(text);
    fclose(file);
    return status;
}
