/* A user's URDF or MuJoCo model with the friction, armature and masses that mukca motion found; all
 * other bytes are unchanged. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "io/drives.h"
#include "io/export.h"
#include "io/table.h"
#include "io/urdf.h"

const char *const mukca_export_inertial[10] = {"mass", "moment_x", "moment_y", "moment_z", "ixx",
                                               "iyy",  "izz",      "ixy",      "ixz",      "iyz"};

enum { DRIVES = MUKCA_DRIVE_VALUES };

typedef struct {
    const mukca_export_input *input;
    char *text; /* the model, as patched so far */
    bool urdf;
    double drive[MUKCA_MAX_JOINTS][DRIVES]; /* new values, NaN: as it is */
    double inertial[MUKCA_MAX_JOINTS][10];  /* change of a link's parameters */
    bool rigid[MUKCA_MAX_JOINTS];           /* whether it changes, */
    bool tensor[MUKCA_MAX_JOINTS];          /* with its inertia */
} patch;

static mukca_status fail(const patch *p, const char *kind, const char *name, const char *what)
{
    return mukca_fail(p->input->error, MUKCA_INPUT, "%s: %s '%.60s' %s",
                      mukca_file_shown(p->input->into), kind, name, what);
}

/* ---- the table ---- */

enum { EFFECT, JOINT, PARAMETER, VALUE, PROBABILITY, FINDING, NOMINAL, FITTED, COLUMNS };
static const char *const columns[COLUMNS] = {"effect",      "joint",   "parameter", "value",
                                             "probability", "finding", "nominal",   "fitted"};

typedef struct {
    patch *p;
    int finding;                             /* of the last row */
    char effect[64], joint[MUKCA_NAME_SIZE]; /* of its most probable effect */
} reader;

static void note_left_out(const reader *r, double probability)
{
    if (probability < 0.5)
        mukca_note_format(r->p->input->notes,
                          "finding %d, %s at '%.60s': left out, as its probability is %.0f %%",
                          r->finding, r->effect, r->joint, 100 * probability);
    else
        mukca_note_format(r->p->input->notes,
                          "finding %d, %s: left out, as %s has no such parameter", r->finding,
                          r->effect, r->p->urdf ? "a URDF" : "a joint or body of MuJoCo");
}

/* Keep a row of an effect that is more probable than not: of each finding the first one. */
static void read_row(reader *r, mukca_table *table, const int *column)
{
    patch *p = r->p;
    char *const *cell = table->cell;
    const char *effect = cell[column[EFFECT]], *name = cell[column[JOINT]];
    const int joint = mukca_chain_find_joint(p->input->chain, name),
              finding = (int)mukca_table_number(table, column[FINDING]);
    const double value = mukca_table_number(table, column[VALUE]),
                 nominal = mukca_table_number(table, column[NOMINAL]),
                 fitted = mukca_table_number(table, column[FITTED]),
                 probability = mukca_table_number(table, column[PROBABILITY]);
    const bool first = finding != r->finding;
    if (joint < 0) mukca_table_fail(table, column[JOINT], "'%s' is no joint of the arm", name);
    if (table->status != MUKCA_OK) return;
    if (first) {
        r->finding = finding;
        snprintf(r->effect, sizeof r->effect, "%s", effect);
        snprintf(r->joint, sizeof r->joint, "%s", name);
    }
    if (strcmp(effect, r->effect) != 0 || strcmp(name, r->joint) != 0) return;
    bool held = false;
    for (int d = 0; d < DRIVES && probability >= 0.5; d++)
        if (strcmp(effect, mukca_drive_values[d].effect) == 0 &&
            (!p->urdf || mukca_drive_values[d].urdf)) {
            p->drive[joint][d] = fmax(fitted + value, 0);
            held = true;
        }
    for (int i = 0; i < 10 && probability >= 0.5; i++)
        if (strcmp(cell[column[PARAMETER]], mukca_export_inertial[i]) == 0 &&
            (strcmp(effect, "payload") == 0 || strncmp(effect, "link_", 5) == 0)) {
            p->inertial[joint][i] += fitted - nominal + value;
            p->rigid[joint] = held = true;
            p->tensor[joint] |= i >= 4;
        }
    if (!held && first) note_left_out(r, probability);
}

/* Read the table, which has the hash of the URDF that it was made with in a comment. */
static mukca_status read_changes(patch *p)
{
    const mukca_export_input *input = p->input;
    reader r = {.p = p};
    mukca_table table;
    int column[COLUMNS];
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++)
        for (int d = 0; d < DRIVES; d++) p->drive[j][d] = (double)NAN;
    mukca_table_open(&table, input->motion, MUKCA_HEADER, input->error);
    if (table.status == MUKCA_OK && !strstr(table.comments, input->chain->urdf_sha256) &&
        !input->other_arm)
        mukca_table_fail(&table, MUKCA_WHOLE_TABLE,
                         "made with another URDF than --urdf; --accept-other-arm uses it "
                         "nevertheless");
    for (int i = 0; i < COLUMNS; i++) column[i] = mukca_table_require(&table, columns[i]);
    while (mukca_table_next(&table)) read_row(&r, &table, column);
    return mukca_table_close(&table);
}

/* ---- links and joints ---- */

/* A link's own body by the URDF of --urdf, in the frame of the link. */
static mukca_mass nominal_body(const patch *p, int joint)
{
    const mukca_chain *chain = p->input->chain;
    for (int m = 0; m < chain->n_masses; m++)
        if (chain->mass[m].element == chain->joint_element[joint]) return chain->mass[m];
    return (mukca_mass){0};
}

/* ---- editing: the text up to a place, what is written instead, the text from another on ---- */

typedef struct {
    FILE *stream;
    char *text;
    size_t size;
} edit;

static mukca_status begin(edit *e, const patch *p, const char *until)
{
    *e = (edit){0};
    e->stream = open_memstream(&e->text, &e->size);
    if (!e->stream) return mukca_fail(p->input->error, MUKCA_MEMORY, "out of memory");
    fwrite(p->text, 1, (size_t)(until - p->text), e->stream);
    return MUKCA_OK;
}

static mukca_status finish(edit *e, patch *p, const char *from)
{
    fputs(from, e->stream);
    if (!mukca_file_close(e->stream, &e->text)) {
        free(e->text);
        return mukca_fail(p->input->error, MUKCA_MEMORY, "out of memory");
    }
    free(p->text);
    p->text = e->text;
    return MUKCA_OK;
}

/* Find the element `kind` by its name; in a URDF those of the robot alone. */
static mukca_status find(mukca_export_tag *tag, const patch *p, const char *kind, const char *name)
{
    const int n = mukca_export_find_named(tag, p->text, kind, name, p->urdf ? 1 : -1);
    return n == 1 ? MUKCA_OK : fail(p, kind, name, n ? "is there more than once" : "is missing");
}

/* Write a tag without its `/`: its element is open.  Returns what follows the tag. */
static const char *open_tag(FILE *stream, const mukca_export_tag *tag)
{
    const bool closed = tag->at[tag->length - 2] == '/';
    fwrite(tag->at, 1, tag->length - (closed ? 2 : 1), stream);
    fputc('>', stream);
    return tag->at + tag->length;
}

/* ---- joints ---- */

static mukca_status patch_joint(patch *p, int joint)
{
    static const mukca_export_tag fresh = {.at = "<dynamics/>", .length = 11};
    const char *name = mukca_chain_joint_name(p->input->chain, joint);
    mukca_export_attribute set[DRIVES];
    mukca_export_tag tag, inner;
    edit e;
    int n = 0;
    MUKCA_TRY(find(&tag, p, "joint", name));
    const bool below = p->urdf && mukca_export_find_below(&inner, &tag, "dynamics");
    const mukca_export_tag *changed = below ? &inner : p->urdf ? &fresh : &tag;
    for (int d = 0; d < DRIVES; d++) {
        const double *value = &p->drive[joint][d];
        double own = 0;
        if (!isfinite(*value)) continue;
        set[n] = (mukca_export_attribute){
            p->urdf ? mukca_drive_values[d].urdf : mukca_drive_values[d].mjcf, value, 1};
        mukca_export_read_numbers(&own, 1, changed, set[n].name);
        mukca_note_format(p->input->notes, "joint '%.60s': %s %.4g to %.4g", name, set[n].name, own,
                          *value);
        n++;
    }
    if (n == 0) return MUKCA_OK;
    MUKCA_TRY(begin(&e, p, below ? inner.at : tag.at));
    const char *rest = changed == &fresh ? open_tag(e.stream, &tag) : changed->at + changed->length;
    mukca_export_put_tag(e.stream, changed, set, n);
    return finish(&e, p, rest);
}

/* ---- links ---- */

/* Read the body of an <inertial> in the axes of its link or body; false: unreadable. */
static bool read_inertial(mukca_mass *b, const patch *p, const mukca_export_tag *tag)
{
    static const char *const tensor[6] = {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"};
    double rpy[3] = {0, 0, 0};
    mukca_frame T = {.p = {0}};
    mukca_mass own = {0};
    mukca_export_tag inner;
    bool ok = true;
    if (p->urdf) {
        if (mukca_export_find_below(&inner, tag, "origin"))
            ok = mukca_export_read_numbers(T.p, 3, &inner, "xyz") &&
                 mukca_export_read_numbers(rpy, 3, &inner, "rpy");
        if (mukca_export_find_below(&inner, tag, "mass"))
            ok &= mukca_export_read_numbers(&own.kg, 1, &inner, "value");
        for (int i = 0; i < 6 && mukca_export_find_below(&inner, tag, "inertia"); i++)
            ok &= mukca_export_read_numbers(&own.inertia[i], 1, &inner, tensor[i]);
        mukca_rotation_from_rpy(T.R, rpy);
    } else {
        ok = !mukca_export_lacks_quat(tag) && mukca_export_read_pose(&T, tag) &&
             mukca_export_read_numbers(&own.kg, 1, tag, "mass") &&
             mukca_export_read_numbers(own.inertia, 3, tag, "diaginertia") &&
             mukca_export_read_numbers(own.inertia, 6, tag, "fullinertia");
    }
    *b = (mukca_mass){0};
    mukca_body_add(b, &T, &own);
    return ok;
}

static void write_inertial(FILE *stream, const patch *p, const mukca_mass *b)
{
    static const double none[3] = {0, 0, 0};
    const double *I = b->inertia;
    if (p->urdf)
        mukca_export_print(stream,
                           "<inertial><origin xyz=\"$b\" rpy=\"$b\"/><mass value=\"$n\"/>"
                           "<inertia ixx=\"$n\" iyy=\"$n\" izz=\"$n\" ixy=\"$n\" ixz=\"$n\" "
                           "iyz=\"$n\"/></inertial>",
                           b->com, 3, none, 3, b->kg, I[0], I[1], I[2], I[3], I[4], I[5]);
    else
        mukca_export_print(stream, "<inertial pos=\"$b\" mass=\"$n\" fullinertia=\"$b\"/>", b->com,
                           3, b->kg, I, 6);
}

/* Behind the end of an element. */
static const char *end_of(const mukca_export_tag *tag, const char *end)
{
    const char *at = tag->at[tag->length - 2] == '/' ? NULL : strstr(tag->at, end);
    return at ? at + strlen(end) : tag->at + tag->length;
}

static mukca_status patch_link(patch *p, int joint)
{
    const mukca_chain *chain = p->input->chain;
    const char *name = chain->element[chain->joint_element[joint]].child;
    const char *kind = p->urdf ? "link" : "body";
    mukca_frame frame = {.R = MUKCA_IDENTITY};
    mukca_export_tag tag, inner;
    mukca_mass b = {0}, turned;
    edit e;
    MUKCA_TRY(find(&tag, p, kind, name));
    if (!p->urdf)
        MUKCA_TRY(mukca_export_body_frame(&frame, p->text, chain->joint_element[joint], p->input));
    const bool own = mukca_export_find_below(&inner, &tag, "inertial");
    if (own) { /* to the frame of the link, on which the change acts */
        if (!read_inertial(&turned, p, &inner))
            return fail(p, kind, name, "has an <inertial> that is not numbers with a quat");
        mukca_body_add(&b, &frame, &turned);
    } else {
        b = nominal_body(p, joint);
        mukca_note_format(p->input->notes,
                          "%s '%.60s' has no <inertial>; that of --urdf is the start", kind, name);
    }
    const double before = b.kg;
    if (!mukca_body_change(&b, p->inertial[joint], p->tensor[joint]))
        return fail(p, kind, name, "would have no mass; the table is of another arm");
    mukca_note_format(p->input->notes,
                      "%s '%.60s': mass %.4g kg to %.4g kg, centre of mass at %.4g %.4g %.4g m",
                      kind, name, before, b.kg, b.com[0], b.com[1], b.com[2]);
    for (int i = 0; i < 3; i++) b.com[i] -= frame.p[i];
    mukca_body_turn(&turned, &b, frame.R);
    MUKCA_TRY(begin(&e, p, own ? inner.at : tag.at));
    const char *rest = own ? end_of(&inner, "</inertial>") : open_tag(e.stream, &tag);
    write_inertial(e.stream, p, &turned);
    if (!own && tag.at[tag.length - 2] == '/') fprintf(e.stream, "</%s>", kind);
    return finish(&e, p, rest);
}

static mukca_status write_motion(FILE *stream, const mukca_export_input *input)
{
    mukca_export_input with = *input;
    if (!with.into) with.into = with.urdf_path;
    patch p = {.input = &with};
    MUKCA_TRY(mukca_file_read(&p.text, with.into, input->error));
    p.urdf = !strstr(p.text, "<mujoco");
    mukca_status status = read_changes(&p);
    for (int j = 0; j < input->chain->n_joints && status == MUKCA_OK; j++) {
        status = patch_joint(&p, j);
        if (status == MUKCA_OK && p.rigid[j]) status = patch_link(&p, j);
    }
    if (status == MUKCA_OK) fputs(p.text, stream);
    free(p.text);
    return status;
}

const mukca_export_format mukca_export_motion = {.write = write_motion, .holds_all = true};
