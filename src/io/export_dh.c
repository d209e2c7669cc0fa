/* The calibrated arm as a Denavit-Hartenberg table, standard or modified. */
#include <math.h>
#include <string.h>

#include "io/export.h"

/* Row k maps the frame of row k to that of row k - 1:
 *   standard  T = Rz(theta + q) Tz(d) Tx(a) Rx(alpha)   (Denavit, Hartenberg 1955; Paul 1981)
 *   modified  T = Rx(alpha) Tx(a) Rz(theta + q) Tz(d)   (Khalil 1986; Craig 1989)
 * A prismatic joint adds q to d.  Fixed rows before the first and after the last joint contain what
 * the joints' rows cannot represent.  d of nearly parallel axes is large, as their common normal is
 * far away (Hayati 1983). */
typedef struct {
    const mukca_element *joint; /* NULL: fixed, of the base or the tool */
    double a, alpha, d, theta;  /* m, rad */
} row;

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
static mukca_frame row_frame(const row *r)
{
    const double c = cos(r->theta), s = sin(r->theta), ca = cos(r->alpha), sa = sin(r->alpha);
    return (mukca_frame){.R = {c, -s * ca, s * sa, s, c * ca, -c * sa, 0, sa, ca},
                         .p = {r->a * c, r->a * s, r->d}};
}

/* Find the row from frame F, whose z axis is one line, to the z axis of frame `line`, base frame.
 * For the last row, `tip` is the frame to be reached; else NULL. */
static void find_row(row *r, const mukca_frame *F, const mukca_frame *line, const mukca_frame *tip)
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

/* Print the name of a fixed row, different from those of the joints. */
static void print_name(FILE *stream, const mukca_chain *chain, const char *wanted)
{
    char name[MUKCA_NAME_SIZE];
    snprintf(name, sizeof name, "%s", wanted);
    while (mukca_chain_find_joint(chain, name) >= 0 && strlen(name) + 1 < sizeof name)
        memcpy(name + strlen(name), "_", 2);
    fputs(name, stream);
}

/* The rows of the calibrated arm in the standard convention: rows[n_joints + 2]. */
static void find_rows(row *rows, const mukca_export_input *input)
{
    const double q[MUKCA_MAX_JOINTS] = {0};
    const mukca_chain *chain = input->chain;
    const int n = chain->n_joints;
    double theta[MUKCA_MAX_THETA];
    mukca_geometry geometry;
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    mukca_frame F = {.R = MUKCA_IDENTITY};
    for (int k = 0; k < chain->n_elements; k++) {
        mukca_export_origin origin;
        mukca_export_get_origin(&origin, input, k);
        memcpy(theta + MUKCA_PARAMETERS * k, origin.theta, sizeof origin.theta);
    }
    mukca_geometry_set(&geometry, chain, theta);
    mukca_fk_frames(before, &tip, &geometry, q, NULL);
    for (int k = 0; k < n + 2; k++) {
        const mukca_frame line = joint_line(chain, &geometry, k < n ? k : n, before, &tip);
        rows[k] =
            (row){.joint = k < 1 || k > n ? NULL : &chain->element[chain->joint_element[k - 1]]};
        find_row(&rows[k], &F, &line, k >= n ? &tip : NULL);
        const mukca_frame step = row_frame(&rows[k]);
        mukca_frame_multiply(&F, &F, &step);
    }
}

static mukca_status write_table(FILE *stream, const mukca_export_input *input, bool modified)
{
    row rows[MUKCA_MAX_JOINTS + 2];
    const int n = input->chain->n_joints;
    find_rows(rows, input);
    for (int k = n + 1; k >= 0 && modified; k--) { /* what follows a rotation moves to the next */
        rows[k].a = k ? rows[k - 1].a : 0;
        rows[k].alpha = k ? rows[k - 1].alpha : 0;
    }
    mukca_export_provenance(stream, "# ", input);
    fprintf(
        stream,
        "# convention: %s\n# T_base_tip is the product of the rows' %s;\n"
        "# a prismatic joint adds q to d.\n"
        "joint\ttype\ta_m\talpha_rad\td_m\ttheta_rad\tlower\tupper\n",
        modified ? "modified" : "standard",
        modified ? "Rx(alpha) Tx(a) Rz(theta + q) Tz(d)" : "Rz(theta + q) Tz(d) Tx(a) Rx(alpha)");
    for (int k = 0; k < n + 2; k++) {
        const row *r = &rows[k];
        const mukca_element *e = r->joint;
        if (!e && r->a == 0 && r->alpha == 0 && r->d == 0 && r->theta == 0) continue;
        if (e)
            fputs(e->name, stream);
        else
            print_name(stream, input->chain, k ? "tip" : "base");
        mukca_export_print(stream, "\t$s\t$n\t$n\t$n\t$n",
                           mukca_joint_type_name[e ? e->type : MUKCA_FIXED], r->a, r->alpha, r->d,
                           r->theta);
        for (int side = 0; side < 2; side++) {
            const double limit = !e ? HUGE_VAL : side ? e->upper : e->lower;
            mukca_export_print(stream, isfinite(limit) ? "\t$n" : "\t", limit);
        }
        fputc('\n', stream);
    }
    return MUKCA_OK;
}

static mukca_status write_standard(FILE *stream, const mukca_export_input *input)
{
    return write_table(stream, input, false);
}

static mukca_status write_modified(FILE *stream, const mukca_export_input *input)
{
    return write_table(stream, input, true);
}

const mukca_export_format mukca_export_dh = {.write = write_standard, .comment = {"#", "\n"}};
const mukca_export_format mukca_export_mdh = {.write = write_modified, .comment = {"#", "\n"}};
