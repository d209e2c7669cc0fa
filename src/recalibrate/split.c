/* The arm with a parameter for each joint zero and each link offset. */
#include <stdio.h>
#include <string.h>

#include "recalibrate/recalibrate.h"

static mukca_element *append(mukca_split_arm *split, const mukca_element *like, int of, char kind)
{
    mukca_chain *chain = &split->chain;
    mukca_element *e = &chain->element[chain->n_elements];
    *e = *like;
    snprintf(e->name, sizeof e->name, "%c%d", kind, of);
    split->of[chain->n_elements++] = of;
    return e;
}

/* Which axis of its frame a joint turns about, and in which sense; -1: another one. */
static int along_axis(double *sign, const double axis[3])
{
    for (int a = 0; a < 3; a++)
        if (fabs(axis[a]) > 1 - 1e-15) {
            *sign = axis[a] > 0 ? 1 : -1;
            return a;
        }
    *sign = 1;
    return -1;
}

/* Origin, and motion of the joint about one axis of it; another axis becomes z, and a third element
 * turns back. */
static void append_joint(mukca_split_arm *split, const mukca_element *e, int k)
{
    mukca_element *origin = append(split, e, k, 'l'), *motion = append(split, e, k, 'a');
    const bool turns = mukca_joint_turns((int)e->type);
    int axis = along_axis(&split->sign[e->joint], e->axis);
    memset(motion->xyz, 0, sizeof motion->xyz);
    memset(motion->rpy, 0, sizeof motion->rpy);
    origin->type = MUKCA_FIXED;
    origin->joint = -1;
    split->chain.joint_element[e->joint] = split->chain.n_elements - 1;
    split->axis[e->joint] = turns ? axis < 0 ? 2 : axis : -1;
    if (axis >= 0 || !turns) return;
    double R[9], A[9], RA[9], e1[3], e2[3];
    mukca_element *back = append(split, origin, k, 'b');
    mukca_rotation_transverse(e1, e2, e->axis);
    for (int i = 0; i < 3; i++) A[3 * i] = e1[i], A[3 * i + 1] = e2[i], A[3 * i + 2] = e->axis[i];
    mukca_rotation_from_rpy(R, e->rpy);
    mukca_mat3_mul(RA, R, A);
    mukca_rotation_to_rpy(origin->rpy, RA, NULL);
    const double identity[9] = MUKCA_IDENTITY;
    mukca_mat3_tmul(R, A, identity);
    memset(back->xyz, 0, sizeof back->xyz);
    mukca_rotation_to_rpy(back->rpy, R, NULL);
    memcpy(motion->axis, identity + 6, sizeof motion->axis);
}

mukca_status mukca_split_arm_set(mukca_split_arm *split, const mukca_chain *arm, mukca_error *error)
{
    const int most = MUKCA_MAX_ELEMENTS - 2; /* two frames */
    split->chain = *arm;
    split->chain.n_elements = split->chain.n_masses = 0;
    for (int k = 0; k < arm->n_elements; k++) {
        const mukca_element *e = &arm->element[k];
        if (split->chain.n_elements + (e->joint < 0 ? 1 : 3) > most)
            return mukca_fail(error, MUKCA_INPUT,
                              "the chain has too many elements for recalibrate; use calibrate");
        if (e->joint < 0)
            append(split, e, k, 't');
        else
            append_joint(split, e, k);
    }
    return MUKCA_OK;
}

void mukca_split_arm_name(mukca_unknown *unknown, const mukca_split_arm *split,
                          const mukca_chain *arm, const mukca_fit *fit, int i)
{
    const int at = fit->parameters.index[i] / MUKCA_PARAMETERS,
              parameter = fit->parameters.index[i] % MUKCA_PARAMETERS;
    const mukca_element *e = &fit->chain.element[at];
    const bool base = !strcmp(e->name, MUKCA_BASE_FRAME), frame = mukca_element_is_frame(e);
    const int shift = !strcmp(fit->chain.element[0].name, MUKCA_BASE_FRAME);
    unknown->element = frame ? -1 : split->of[at - shift];
    unknown->sign = e->joint >= 0 ? split->sign[e->joint] : 1;
    unknown->angle = parameter >= 3;
    const char *name = frame ? base ? "base" : "tool" : arm->element[unknown->element].name;
    if (e->joint >= 0)
        snprintf(unknown->text, sizeof unknown->text, "%s zero", name);
    else
        snprintf(unknown->text, sizeof unknown->text, "%s%s %c", name, parameter < 3 ? "" : " turn",
                 "xyz"[parameter % 3]);
}
