/* The calibrated origins in the YAML formats of robot makers' descriptions. */
#include <ctype.h>
#include <string.h>

#include "base/text.h"
#include "io/export.h"
#include "io/kinematics.h"

/* Universal Robots' entries, as in ur_description. */
static const char *const ur_names[] = {"shoulder", "upper_arm", "forearm",
                                       "wrist_1",  "wrist_2",   "wrist_3"};

/* "joint4" of "fr3_joint4"; NULL for other names. */
static const char *short_name(const char *name)
{
    const char *last = strrchr(name, '_');
    if (!last || strncmp(last, "_joint", 6) != 0 || !isdigit((unsigned char)last[6])) return NULL;
    return last + 1;
}

static void add_entry(mukca_kinematics *k, const char *name)
{
    snprintf(k->entry[k->n++].name, MUKCA_NAME_SIZE, "%s", name);
}

/* Name the entries of an arm without a kinematics file as the maker's description does, recognised
 * by names of joints and links; other arms in the style of UFACTORY. */
static void name_entries(mukca_kinematics *k, const mukca_chain *chain)
{
    bool ur = chain->n_joints == 6, franka = true;
    for (int j = 0; j < chain->n_joints; j++) {
        const int element = chain->joint_element[j];
        ur = ur && mukca_kinematics_find(chain, ur_names[j]) == element;
        franka = franka && short_name(chain->element[element].name);
    }
    *k = (mukca_kinematics){.layout = ur       ? &mukca_kinematics_ur
                                      : franka ? &mukca_kinematics_franka
                                               : &mukca_kinematics_ufactory};
    for (int e = 0, j = 0; e < chain->n_elements; e++) {
        const mukca_element *element = &chain->element[e];
        const char *part = franka ? short_name(element->name) : NULL;
        if (element->type != MUKCA_FIXED)
            add_entry(k, ur ? ur_names[j++] : part ? part : element->name);
        else if (part) /* joint8 of a Franka is fixed */
            add_entry(k, part);
    }
}

static void print_entry(FILE *stream, const mukca_kinematics *k, const char *name,
                        const double *value)
{
    const char *inner = k->layout->inner;
    const int indent = k->layout->root ? 2 : 0;
    fprintf(stream, "%*s%s:\n", indent, "", name);
    if (inner) fprintf(stream, "%*s%s:\n", indent + 2, "", inner);
    for (int p = 0; p < MUKCA_PARAMETERS; p++) {
        fprintf(stream, "%*s%s: ", indent + (inner ? 4 : 2), "", mukca_parameter_name[p]);
        mukca_export_print(stream, "$n\n", value[p]);
    }
}

/* Note calibrated origins without an entry in the file. */
static void note_others(const mukca_export_input *input, const bool *written)
{
    for (int e = 0; e < input->chain->n_elements; e++) {
        const mukca_element *nominal = &input->chain->element[e];
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, e);
        bool moved = false;
        for (int i = 0; i < 3; i++)
            moved |= origin.xyz[i] != nominal->xyz[i] || origin.rpy[i] != nominal->rpy[i];
        if (written[e] || !moved) continue;
        mukca_note_format(input->notes,
                          "the calibrated origin of '%s' is not exported: the file has no entry "
                          "for it; put it into the URDF",
                          nominal->name);
    }
}

/* Write the hash.  UR's driver compares it with that of the robot's own calibration, which no file
 * changes, and reports a difference at each start; ur_description does not load without one. */
static void write_hash(FILE *stream, const mukca_export_input *input, const mukca_kinematics *k,
                       bool fitted)
{
    if (!k->hash[0]) return;
    if (fitted) {
        fputs("  # marks the robot, for its driver; the origins are fitted, not the factory's\n",
              stream);
        mukca_note_format(input->notes,
                          "hash %s marks the robot, for its driver; the origins are fitted, not "
                          "the factory's",
                          k->hash);
    }
    fprintf(stream, "  hash: %s\n", k->hash);
}

static mukca_status write_kinematics(FILE *stream, const mukca_export_input *input)
{
    mukca_kinematics entries;
    const mukca_kinematics *k = input->kinematics;
    bool written[MUKCA_MAX_ELEMENTS] = {false}, fitted = false;
    if (!k) name_entries(&entries, input->chain);
    if (!k) k = &entries;
    mukca_export_provenance(stream, "# ", input);
    if (k->layout->root) fprintf(stream, "%s:\n", k->layout->root);
    for (int i = 0; i < k->n; i++) {
        const mukca_kinematics_entry *entry = &k->entry[i];
        const int element = mukca_kinematics_find(input->chain, entry->name);
        double value[MUKCA_PARAMETERS];
        memcpy(value, entry->value, sizeof value);
        if (element >= 0) {
            mukca_export_origin origin;
            mukca_export_get_origin(&origin, input, element);
            memcpy(value, origin.xyz, sizeof origin.xyz);
            memcpy(value + 3, origin.rpy, sizeof origin.rpy);
            for (int p = 0; p < MUKCA_PARAMETERS; p++) fitted |= value[p] != entry->value[p];
            written[element] = true;
        }
        print_entry(stream, k, entry->name, value);
    }
    write_hash(stream, input, k, fitted);
    if (k->layout == &mukca_kinematics_ur && !k->hash[0])
        mukca_note_format(input->notes,
                          "%s the hash is missing that UR's driver compares with the robot's",
                          input->kinematics ? "the factory file has no `hash:`;"
                                            : "without the factory file (--kinematics)");
    note_others(input, written);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_kinematics = {
    .write = write_kinematics, .holds = mukca_export_holds_none, .comment = {"#", "\n"}};
