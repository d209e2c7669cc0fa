/* Denavit-Hartenberg tables of a chain. */
#include "model/dh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Sine of the angle below which two axes are treated as parallel.  This causes an error of sine
 * times a metre; the alternative, a common normal, causes the rounding error of d = metre / sine,
 * 1e-16 / sine.  Both are equal at 1e-8. */
static const double parallel = 1e-8;

/* Smaller lengths and angles (m, rad) are rounding errors and set to 0; the following rows absorb
 * them. */
static const double smallest = 1e-12;

static double clean(double x)
{
    return fabs(x) < smallest ? 0 : x;
}

/* Rz(theta) Tz(d) Tx(a) Rx(alpha) */
static mukca_frame row_frame(const mukca_dh_row *r)
{
    const double c = cos(r->theta), s = sin(r->theta), ca = cos(r->alpha), sa = sin(r->alpha);
    return (mukca_frame){.R = {c, -s * ca, s * sa, s, c * ca, -c * sa, 0, sa, ca},
                         .p = {r->a * c, r->a * s, r->d}};
}

/* Find the row from frame F, whose z axis is one line, to the z axis of frame `line`, base frame.
 * For the last row, `tip` is the frame to be reached; else NULL. */
static void find_row(mukca_dh_row *r, const mukca_frame *F, const mukca_frame *line,
                     const mukca_frame *tip)
{
    const double shift[3] = {line->p[0] - F->p[0], line->p[1] - F->p[1], line->p[2] - F->p[2]};
    const double axis[3] = {line->R[2], line->R[5], line->R[8]};
    double w[3], z[3];
    mukca_mat3_tvec(w, F->R, shift);
    mukca_mat3_tvec(z, F->R, axis);
    const double sine = hypot(z[0], z[1]);
    r->d = tip ? clean(w[2]) : 0;
    if (sine >= parallel) {
        r->theta = atan2(z[0], -z[1]);
        r->d = clean(w[2] - z[2] * (w[0] * z[0] + w[1] * z[1]) / (sine * sine));
    } else if (hypot(w[0], w[1]) >= smallest) {
        r->theta = atan2(w[1], w[0]);
    } else if (tip) {
        double turn[9];
        mukca_mat3_tmul(turn, F->R, tip->R);
        r->theta = atan2(turn[3], turn[0]);
    } else {
        r->theta = 0;
    }
    /* of the two directions of x along the normal, the one with the smaller rotation */
    if (fabs(r->theta) > M_PI / 2 + parallel && (sine >= parallel || !tip))
        r->theta -= copysign(M_PI, r->theta);
    r->theta = clean(r->theta);
    const double c = cos(r->theta), s = sin(r->theta);
    r->a = clean(c * w[0] + s * w[1]);
    r->alpha = clean(atan2(s * z[0] - c * z[1], z[2]));
}

/* A frame whose z axis is that of joint j at q = 0; for j = n_joints the tip. */
static mukca_frame joint_line(const mukca_chain *chain, const mukca_geometry *g, int j,
                              const mukca_frame *before, const mukca_frame *tip)
{
    if (j == chain->n_joints) return *tip;
    const int k = chain->joint_element[j];
    mukca_frame line = before[k];
    double z[3];
    mukca_mat3_vec(z, before[k].R, g->axis[k]);
    for (int i = 0; i < 3; i++) line.R[3 * i + 2] = z[i];
    return line;
}

static bool is_zero(const mukca_dh_row *r)
{
    return r->a == 0 && r->alpha == 0 && r->d == 0 && r->theta == 0;
}

/* Make a name for a fixed row, different from those of the joints. */
static void name_row(char name[MUKCA_NAME_SIZE], const mukca_chain *chain, const char *wanted)
{
    snprintf(name, MUKCA_NAME_SIZE, "%s", wanted);
    while (mukca_chain_find_joint(chain, name) >= 0) {
        const size_t n = strlen(name);
        if (n + 1 < MUKCA_NAME_SIZE) memcpy(name + n, "_", 2);
    }
}

/* Convert standard rows to modified ones: the part of a row after its rotation moves to the
 * next. */
static void shift_rows(mukca_dh_row *row, int n)
{
    for (int k = n - 1; k >= 0; k--) {
        row[k].a = k ? row[k - 1].a : 0;
        row[k].alpha = k ? row[k - 1].alpha : 0;
    }
}

void mukca_dh_from_chain(mukca_dh *dh, const mukca_chain *chain, const double *theta,
                         mukca_dh_convention convention)
{
    const double q[MUKCA_MAX_JOINTS] = {0};
    const int n = chain->n_joints;
    mukca_geometry geometry;
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    mukca_frame F = {.R = MUKCA_IDENTITY};
    mukca_dh_row row[MUKCA_MAX_JOINTS + 2];
    mukca_geometry_set(&geometry, chain, theta);
    mukca_fk_frames(before, &tip, &geometry, q, NULL);
    for (int k = 0; k < n + 2; k++) {
        mukca_dh_row *r = &row[k];
        const int j = k - 1;
        const mukca_frame line = joint_line(chain, &geometry, k < n ? k : n, before, &tip);
        *r = (mukca_dh_row){.type = MUKCA_FIXED, .lower = -HUGE_VAL, .upper = HUGE_VAL};
        find_row(r, &F, &line, k >= n ? &tip : NULL);
        const mukca_frame step = row_frame(r);
        mukca_frame_multiply(&F, &F, &step);
        if (j < 0 || j == n) {
            name_row(r->name, chain, j < 0 ? "base" : "tip");
            continue;
        }
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        memcpy(r->name, e->name, sizeof r->name);
        r->type = e->type;
        r->lower = e->lower;
        r->upper = e->upper;
    }
    if (convention == MUKCA_DH_MODIFIED) shift_rows(row, n + 2);
    *dh = (mukca_dh){.convention = convention};
    for (int k = 0; k < n + 2; k++)
        if (row[k].type != MUKCA_FIXED || !is_zero(&row[k])) dh->row[dh->n_rows++] = row[k];
}
