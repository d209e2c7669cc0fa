/* The calibrated origins in the YAML formats of robot makers' descriptions. */
#include <string.h>

#include "base/text.h"
#include "io/export.h"
#include "io/kinematics.h"

static void print_entry(FILE *stream, const mukca_kinematics *k, const char *name,
                        const double *value)
{
    const int indent = k->root ? 2 : 0;
    fprintf(stream, "%*s%s:\n", indent, "", name);
    if (k->inner) fprintf(stream, "%*skinematic:\n", indent + 2, "");
    for (int p = 0; p < MUKCA_PARAMETERS; p++) {
        fprintf(stream, "%*s%s: ", indent + (k->inner ? 4 : 2), "", mukca_parameter_name[p]);
        mukca_export_print(stream, "$n\n", value[p]);
    }
}

/* Note calibrated origins without an entry in the file. */
static void note_others(const mukca_export_input *input, const bool *written)
{
    for (int e = 0; e < input->chain->n_elements; e++) {
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, e);
        if (written[e] || !origin.moved) continue;
        mukca_note_format(input->notes,
                          "the calibrated origin of '%s' is not exported: the file has no entry "
                          "for it; put it into the URDF",
                          input->chain->element[e].name);
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
    const mukca_kinematics *k = input->kinematics;
    bool written[MUKCA_MAX_ELEMENTS] = {false}, fitted = false;
    if (!k)
        return mukca_fail(input->error, MUKCA_USAGE,
                          "this format needs --kinematics FILE: the robot's own file, or that of "
                          "its description");
    mukca_export_provenance(stream, "# ", input);
    if (k->root) fputs("kinematics:\n", stream);
    for (int i = 0; i < k->n; i++) {
        const mukca_kinematics_entry *entry = &k->entry[i];
        const int element = mukca_kinematics_find(input->chain, entry->name);
        mukca_export_origin origin;
        memcpy(origin.theta, entry->value, sizeof origin.theta);
        if (element >= 0) {
            mukca_export_get_origin(&origin, input, element);
            for (int p = 0; p < MUKCA_PARAMETERS; p++) fitted |= origin.theta[p] != entry->value[p];
            written[element] = true;
        }
        print_entry(stream, k, entry->name, origin.theta);
    }
    write_hash(stream, input, k, fitted);
    note_others(input, written);
    return MUKCA_OK;
}

const mukca_export_format mukca_export_kinematics = {.write = write_kinematics,
                                                     .comment = {"#", "\n"}};
