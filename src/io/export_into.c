/* A user's URDF or MuJoCo model with the poses of the arm replaced in place; all other bytes are
 * unchanged. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/text.h"
#include "io/export.h"

typedef struct {
    FILE *stream;
    const mukca_export_input *input;
    const char *at;                  /* written up to here */
    mukca_frame nominal, calibrated; /* from the link of the last body to the present element */
    mukca_frame body;                /* the last body in the frame of its link */
} patch;

static const mukca_frame identity = {.R = MUKCA_IDENTITY};

static mukca_status fail(const patch *p, const char *body, const char *what)
{
    return mukca_fail(p->input->error, MUKCA_INPUT, "%s: body '%.60s' %s",
                      mukca_file_shown(p->input->into), body, what);
}

/* C = A^-1 B; C is neither. */
static void relate(mukca_frame *C, const mukca_frame *A, const mukca_frame *B)
{
    const double d[3] = {B->p[0] - A->p[0], B->p[1] - A->p[1], B->p[2] - A->p[2]};
    mukca_mat3_tvec(C->p, A->R, d);
    mukca_mat3_tmul(C->R, A->R, B->R);
}

/* Read where a body is in the frame of its link: turned, and anywhere on the axis of its joint. */
static mukca_status place(mukca_frame *body, const patch *p, const mukca_export_tag *tag,
                          const mukca_element *e)
{
    double pos[3] = {0, 0, 0}, off[3];
    mukca_frame step, link;
    mukca_export_tag inner = *tag;
    if (mukca_export_lacks_quat(tag))
        return fail(p, e->child, "has no quat; save the model from MuJoCo, which writes it");
    const bool joint = e->joint >= 0 && mukca_export_next_tag(&inner, "joint");
    if (!mukca_export_read_pose(&step, tag) ||
        (joint && !mukca_export_read_numbers(pos, 3, &inner, "pos")))
        return fail(p, e->child, "has a pos or quat that is not numbers");
    relate(&link, &p->nominal, &p->body);
    mukca_frame_multiply(body, &link, &step);
    if (mukca_export_near(body, &identity)) {
        *body = identity;
        return MUKCA_OK;
    }
    mukca_mat3_vec(off, body->R, pos);
    for (int i = 0; i < 3; i++) off[i] += body->p[i];
    const double along = joint ? mukca_dot3(off, e->axis) : 0;
    for (int i = 0; i < 3; i++) off[i] -= along * e->axis[i];
    for (int i = 0; i < 3; i++) body->p[i] -= off[i];
    if ((joint || e->joint < 0) && mukca_norm3(off) < MUKCA_EXPORT_METRES) return MUKCA_OK;
    return fail(p, e->child, "is not where the URDF has it; the model needs its zero posture");
}

/* Write the text up to the body's tag, and the tag with the calibrated pose. */
static mukca_status write_body(patch *p, const mukca_export_tag *tag, const mukca_element *e)
{
    double quat[4];
    mukca_frame body, pose;
    MUKCA_TRY(place(&body, p, tag, e));
    relate(&pose, &p->body, &p->calibrated);
    mukca_frame_multiply(&pose, &pose, &body);
    mukca_rotation_to_quaternion(quat, pose.R);
    fwrite(p->at, 1, (size_t)(tag->at - p->at), p->stream);
    const mukca_export_attribute changed[] = {{"pos", pose.p, 3}, {"quat", quat, 4}};
    mukca_export_put_tag(p->stream, tag, changed, 2);
    p->at = tag->at + tag->length;
    mukca_note_format(p->input->notes, "body '%.60s': moved by %.3f mm, %.3f mrad", e->child,
                      1e3 * mukca_distance3(p->calibrated.p, p->nominal.p),
                      1e3 * mukca_rotation_between(p->calibrated.R, p->nominal.R));
    p->nominal = p->calibrated = identity;
    p->body = body;
    return MUKCA_OK;
}

/* Advance to an element, whose body's tag is found; returns the number of such bodies. */
static int find_body(mukca_export_tag *tag, patch *p, int element)
{
    const mukca_element *e = &p->input->chain->element[element];
    mukca_export_origin origin;
    mukca_export_get_origin(&origin, p->input, element);
    const mukca_frame nominal = mukca_export_frame(e->xyz, e->rpy),
                      calibrated = mukca_export_frame(origin.xyz, origin.rpy);
    mukca_frame_multiply(&p->nominal, &p->nominal, &nominal);
    mukca_frame_multiply(&p->calibrated, &p->calibrated, &calibrated);
    return mukca_export_find_named(tag, p->at, "body", e->child, -1);
}

mukca_status mukca_export_body_frame(mukca_frame *body, const char *text, int element,
                                     const mukca_export_input *input)
{
    patch p = {NULL, input, text, identity, identity, identity};
    for (int k = 0; k <= element; k++) {
        mukca_export_tag tag;
        const mukca_element *e = &input->chain->element[k];
        if (find_body(&tag, &p, k) != 1) {
            if (k < element) continue;
            return fail(&p, e->child, "is missing, or there more than once");
        }
        MUKCA_TRY(place(body, &p, &tag, e));
        p.nominal = identity;
        p.body = *body;
        p.at = tag.at + tag.length;
    }
    return MUKCA_OK;
}

static mukca_status write_into(FILE *stream, const mukca_export_input *input)
{
    const mukca_chain *chain = input->chain;
    char *text;
    mukca_status status = MUKCA_OK;
    MUKCA_TRY(mukca_file_read(&text, input->into, input->error));
    patch p = {stream, input, text, identity, identity, identity};
    if (!strstr(text, "<mujoco")) {
        free(text);
        return mukca_export_urdf.write(stream, input);
    }
    for (int k = 0; k < chain->n_elements && status == MUKCA_OK; k++) {
        const mukca_element *e = &chain->element[k];
        mukca_export_tag tag;
        const int n = find_body(&tag, &p, k);
        if (n > 1)
            status = fail(&p, e->child, "is there more than once, with other prefixes");
        else if (n)
            status = write_body(&p, &tag, e);
        else if (e->joint >= 0)
            status = fail(&p, e->child, "is missing, or not in the order of the chain");
        else if (k + 1 == chain->n_elements)
            mukca_note_format(input->notes, "no body '%.60s': the offsets of %.60s are left out",
                              e->child, e->name);
    }
    if (status == MUKCA_OK) fputs(p.at, stream);
    free(text);
    return status;
}

const mukca_export_format mukca_export_into = {.write = write_into};
