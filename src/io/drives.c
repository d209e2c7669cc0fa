/* Friction and armature of an arm's joints from its URDF or MuJoCo model. */
#include "io/drives.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "io/export.h"

enum {
    CLASSES = 128, /* default classes of a MuJoCo model that are known, */
    DEPTHS = 256   /* and nested elements; deeper joints have none */
};

const mukca_drive_value mukca_drive_values[MUKCA_DRIVE_VALUES] = {
    {"coulomb", "frictionloss", "friction"},
    {"viscous", "damping", "damping"},
    {"armature", "armature", NULL}};

/* A default class of joints. */
typedef struct {
    const char *name; /* in the text; NULL: none */
    size_t length;
    double value[MUKCA_DRIVE_VALUES];
} joint_class;

typedef struct {
    double *value[MUKCA_DRIVE_VALUES]; /* of the joints: out */
    const mukca_chain *chain;
    joint_class list[CLASSES]; /* the first one: of joints that have no other */
    int n;
    int at[DEPTHS];       /* class that holds in the open element of this depth */
    bool defines[DEPTHS]; /* which is a <default> */
} reader;

static void read_value(double *value, const mukca_export_tag *tag, const char *name)
{
    double number = *value;
    if (mukca_export_read_numbers(&number, 1, tag, name) && number >= 0) *value = number;
}

/* Joint of a tag by its name; -1: none of the chain. */
static int find_joint(const mukca_export_tag *tag, const mukca_chain *chain)
{
    size_t length;
    const char *name = mukca_export_find_attribute(&length, tag, "name");
    for (int j = 0; name && j < chain->n_joints; j++)
        if (mukca_export_same_name(mukca_chain_joint_name(chain, j), name, length)) return j;
    return -1;
}

static void read_dynamics(reader *r, const mukca_export_tag *joint)
{
    const int j = find_joint(joint, r->chain);
    mukca_export_tag tag;
    if (j < 0 || !mukca_export_find_below(&tag, joint, "dynamics")) return;
    for (int k = 0; k < MUKCA_DRIVE_VALUES && mukca_drive_values[k].urdf; k++)
        read_value(&r->value[k][j], &tag, mukca_drive_values[k].urdf);
}

/* The class that an attribute names; `otherwise`: it names none. */
static int class_of(const reader *r, const mukca_export_tag *tag, const char *attribute,
                    int otherwise)
{
    size_t length;
    const char *name = mukca_export_find_attribute(&length, tag, attribute);
    for (int k = 0; name && k < r->n; k++)
        if (r->list[k].name && r->list[k].length == length &&
            memcmp(r->list[k].name, name, length) == 0)
            return k;
    return otherwise;
}

/* A class of its own for a <default>, with the values of the one around it; the outermost one is of
 * all joints. */
static int open_class(reader *r, const mukca_export_tag *tag, int around)
{
    size_t length;
    const bool outermost = tag->depth == 0 || !r->defines[tag->depth - 1];
    const char *name = mukca_export_find_attribute(&length, tag, "class");
    if (!outermost && r->n == CLASSES) return around;
    const int k = outermost ? 0 : r->n++;
    if (!outermost) r->list[k] = r->list[around];
    if (name) r->list[k].name = name, r->list[k].length = length;
    return k;
}

/* An element of a MuJoCo model (defaults come before the bodies, else they are not met). */
static void read_element(reader *r, const mukca_export_tag *tag)
{
    const int around = tag->depth ? r->at[tag->depth - 1] : 0;
    r->at[tag->depth] = class_of(r, tag, "childclass", around);
    r->defines[tag->depth] = mukca_export_is_tag(tag, "default");
    if (r->defines[tag->depth]) r->at[tag->depth] = open_class(r, tag, around);
    if (!mukca_export_is_tag(tag, "joint")) return;
    const bool defines = tag->depth && r->defines[tag->depth - 1];
    const int j = defines ? -1 : find_joint(tag, r->chain);
    joint_class *of = &r->list[defines ? around : class_of(r, tag, "class", around)], own = *of;
    if (!defines) of = &own;
    for (int k = 0; k < MUKCA_DRIVE_VALUES; k++)
        read_value(&of->value[k], tag, mukca_drive_values[k].mjcf);
    for (int k = 0; k < MUKCA_DRIVE_VALUES && j >= 0; k++) r->value[k][j] = own.value[k];
}

mukca_status mukca_drives_read(mukca_drives *drives, const char *path, const mukca_chain *chain,
                               mukca_error *error)
{
    char *text;
    bool urdf = false;
    MUKCA_TRY(mukca_file_read(&text, path, error));
    *drives = (mukca_drives){0};
    reader r = {
        .value = {drives->coulomb, drives->viscous, drives->armature}, .chain = chain, .n = 1};
    for (mukca_export_tag tag = {.at = text}; mukca_export_next_tag(&tag, NULL);) {
        if (tag.depth == 0) urdf = mukca_export_is_tag(&tag, "robot");
        if (tag.depth < 0 || tag.depth >= DEPTHS) continue;
        if (!urdf)
            read_element(&r, &tag);
        else if (tag.depth == 1 && mukca_export_is_tag(&tag, "joint"))
            read_dynamics(&r, &tag);
    }
    free(text);
    return MUKCA_OK;
}
