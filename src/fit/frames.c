/* Frames of measured poses as elements of the chain. */
#include "fit/frames.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/align.h"

static void fixed_element(mukca_element *element, const char *name, const char *child)
{
    memset(element, 0, sizeof *element);
    snprintf(element->name, sizeof element->name, "%s", name);
    snprintf(element->child, sizeof element->child, "%s", child);
    element->type = MUKCA_FIXED;
    element->joint = -1;
    element->axis[2] = 1;
}

mukca_status mukca_chain_with_frames(mukca_chain *out, const mukca_chain *chain, bool base,
                                     bool tool, mukca_error *error)
{
    tool = tool && mukca_chain_tip_element(chain) < 0;
    const int n = chain->n_elements + base + tool;
    if (n > MUKCA_MAX_ELEMENTS)
        return mukca_fail(error, MUKCA_INPUT, "the chain has %d elements, at most %d are supported",
                          n, (int)MUKCA_MAX_ELEMENTS);
    if (out != chain) *out = *chain;
    if (base) {
        memmove(out->element + 1, out->element, (size_t)out->n_elements * sizeof *out->element);
        fixed_element(&out->element[0], MUKCA_BASE_FRAME, chain->base);
        for (int m = 0; m < out->n_masses; m++) out->mass[m].element++;
        for (int j = 0; j < out->n_joints; j++) out->joint_element[j]++;
    }
    if (tool) fixed_element(&out->element[n - 1], MUKCA_TOOL_FRAME, chain->tip);
    out->n_elements = n;
    return MUKCA_OK;
}

mukca_status mukca_frames_start(double *theta, const mukca_chain *chain, const mukca_dataset *data,
                                bool base, bool tool, mukca_error *error)
{
    unsigned char *keep = NULL;
    const int tip = mukca_chain_tip_element(chain);
    mukca_geometry geometry;
    mukca_alignment found;
    mukca_chain_theta(theta, chain);
    if (!base && !tool) return MUKCA_OK;
    mukca_geometry_set(&geometry, chain, NULL);
    if (data->n_targets > 1) { /* align with the samples of the first target */
        keep = malloc((size_t)data->n_rows);
        for (int i = 0; i < data->n_rows && keep; i++) keep[i] = data->target[i] == data->target[0];
    }
    const mukca_align_options options = {.tracker = base, .target = tool, .keep = keep};
    const bool aligned =
        (keep || data->n_targets < 2) && mukca_align(&found, &geometry, data, &options);
    free(keep);
    if (!aligned) return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    if (base) geometry.origin[0] = found.tracker;
    if (tool) mukca_frame_multiply(&geometry.origin[tip], &geometry.origin[tip], &found.target);
    mukca_geometry_theta(theta, chain, &geometry);
    return MUKCA_OK;
}
