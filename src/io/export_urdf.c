/* The user's URDF with the origins of the chain replaced in place; the rest stays.  And a chain as
 * a URDF of its own. */
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "io/export.h"
#include "io/urdf.h"

/* 0 and -0 differ, as their texts do. */
static bool are_same(const double a[3], const double b[3])
{
    int same = 0;
    for (int i = 0; i < 3; i++) same += a[i] == b[i] && signbit(a[i]) == signbit(b[i]);
    return same == 3;
}

/* The element of a joint of the file; in a user's own, with another prefix.  -1: none. */
static int find_element(const mukca_export_input *input, const mukca_urdf_text *urdf,
                        const char *joint)
{
    const mukca_chain *chain = input->chain;
    if (!joint) return -1;
    const int found = mukca_chain_find_element(chain, joint);
    for (int k = 0; k < chain->n_elements && found < 0 && input->into; k++)
        if (!mukca_urdf_text_joint(urdf, chain->element[k].name) &&
            mukca_export_same_name(chain->element[k].name, joint, strlen(joint)))
            return k;
    return found;
}

/* Whether a user's own URDF has each joint once, where the chain has it; the tool may be missing.
 */
static mukca_status check_into(const mukca_urdf_text *urdf, const mukca_export_input *input)
{
    for (int k = 0; k < input->chain->n_elements; k++) {
        const mukca_element *e = &input->chain->element[k];
        const mukca_frame nominal = mukca_export_frame(e->xyz, e->rpy);
        mukca_export_origin origin;
        bool near = true;
        int n = 0;
        for (int i = 0; i < urdf->n_joints; i++) {
            if (find_element(input, urdf, urdf->joints[i].name) != k) continue;
            const mukca_frame joint = mukca_export_frame(urdf->joints[i].xyz, urdf->joints[i].rpy);
            near = mukca_export_near(&joint, &nominal);
            n++;
        }
        mukca_export_get_origin(&origin, input, k);
        const bool tool = e->joint < 0 && k + 1 == input->chain->n_elements;
        if (n == 0 && tool)
            mukca_note_format(input->notes, "no joint '%.60s': its offsets are left out", e->name);
        else if (n > 1 || !near || (n == 0 && (e->joint >= 0 || origin.moved)))
            return mukca_fail(input->error, MUKCA_INPUT, "%s: joint '%s' is %s",
                              mukca_file_shown(input->into), e->name,
                              n > 1   ? "there more than once, with other prefixes"
                              : n > 0 ? "not where the URDF of --urdf has it"
                                      : "missing");
    }
    return MUKCA_OK;
}

/* Write the text up to the joint's origin, and this; returns what follows. */
static const char *write_joint(FILE *stream, const char *at, const mukca_export_tag *joint,
                               const mukca_export_origin *origin, const double xyz[3],
                               const double rpy[3])
{
    mukca_export_tag tag;
    const char *start = joint->at + joint->length;
    if (mukca_export_find_below(&tag, joint, "origin")) {
        fwrite(at, 1, (size_t)(tag.at - at), stream);
        const mukca_export_attribute changed[] = {
            {"xyz", are_same(origin->xyz, xyz) ? NULL : origin->xyz, 3},
            {"rpy", are_same(origin->rpy, rpy) ? NULL : origin->rpy, 3}};
        mukca_export_put_tag(stream, &tag, changed, 2);
        return tag.at + tag.length;
    }
    start += strspn(start, " \t\r\n"); /* after the white space that follows the joint's tag */
    fwrite(at, 1, (size_t)(start - at), stream);
    mukca_export_print(stream, "<origin xyz=\"$b\" rpy=\"$b\"/>", origin->xyz, 3, origin->rpy, 3);
    return joint->at + joint->length;
}

/* Write the text with the changed origins; false: its joints were not found. */
static bool write_joints(FILE *stream, const mukca_urdf_text *urdf, const mukca_export_input *input)
{
    mukca_export_tag tag = {.at = urdf->text};
    const char *at = urdf->text;
    int n = 0;
    while (mukca_export_next_tag(&tag, "joint")) {
        mukca_export_origin origin;
        if (tag.depth != 1) continue;
        if (n == urdf->n_joints) return false;
        const mukca_urdf_joint *joint = &urdf->joints[n++];
        const int k = find_element(input, urdf, joint->name);
        if (k < 0) continue;
        mukca_export_get_origin(&origin, input, k);
        if (!origin.moved) continue;
        at = write_joint(stream, at, &tag, &origin, joint->xyz, joint->rpy);
    }
    fputs(at, stream);
    return n == urdf->n_joints;
}

static mukca_status write_urdf(FILE *stream, const mukca_export_input *input)
{
    mukca_urdf_text urdf;
    const char *path = input->into ? input->into : input->urdf_path;
    mukca_status status = MUKCA_OK;
    MUKCA_TRY(mukca_urdf_text_read(&urdf, path, input->error));
    if (input->into)
        status = check_into(&urdf, input);
    else if (strcmp(urdf.sha256, input->chain->urdf_sha256) != 0)
        status = mukca_fail(input->error, MUKCA_INPUT,
                            "%s: changed during the export; run it again", mukca_file_shown(path));
    if (status == MUKCA_OK && !write_joints(stream, &urdf, input))
        status = mukca_fail(input->error, MUKCA_INPUT,
                            "%s: its joints cannot be located in this encoding; save the file as "
                            "UTF-8",
                            mukca_file_shown(path));
    mukca_urdf_text_free(&urdf);
    return status;
}

const mukca_export_format mukca_export_urdf = {.write = write_urdf};
