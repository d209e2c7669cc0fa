/* Convention of measured orientations: --rotation, and its check against the arm's kinematics. */
#include "io/rotations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "fit/align.h"
#include "fit/poses.h"
#include "math/angles.h"
#include "math/stats.h"
#include "mukca/rotation.h"

/* Largest deviation from length 1 of a quaternion written with three decimals. */
static const double length_tolerance = 0.01;
/* At least so many different orientations decide: 36 numbers against 12 of two frames. */
enum { LEAST_SAMPLES = 6 };
/* Rotations between samples start from here, rad; rows beyond these add none. */
static const double least_rotation = 0.05;
enum { MOST_SEEN = 20000 };
/* Errors below `least_turn`, rad, may be the nominal arm's own, those above `most_turn` are no
 * tracker's.  Positions fit a real arm within 1 cm per metre of its length (fit/mismatch.c). */
static const double least_turn = 0.02, most_turn = 0.1, positions_fit = 0.01;
/* Errors are compared where four samples of five are better: a conversion may agree in half of
 * them, outliers are fewer. */
static const double most_samples = 0.8;
/* Another form explains the contradiction if it reduces the errors so: with 24 degrees of freedom,
 * noise does not. */
static const double explained = 1 / 3.0;

/* The first SOURCES are those by which programs compute quaternions; reversed ones are equivalent.
 */
static const char *const conventions[] = {MUKCA_VECTOR, "xyz", "XYZ", "ZYZ", "ZXZ", "XZY", "YXZ",
                                          "YZX",        "ZXY", "XYX", "XZX", "YXY", "YZY", "ZYX",
                                          "zyx",        "zyz", "zxz", "xzy", "yxz", "yzx", "zxy",
                                          "xyx",        "xzx", "yxy", "yzy"};
enum { CONVENTIONS = sizeof conventions / sizeof *conventions, SOURCES = 5 };

static bool is(const mukca_rotation_form *form, const char *as)
{
    return strcmp(form->as, as) == 0;
}

static bool is_order(const mukca_rotation_form *form)
{
    return is(form, "wxyz") || is(form, "xyzw");
}

bool mukca_rotation_form_read(mukca_rotation_form *form, const char *text)
{
    const char *equals = strchr(text, '=');
    const size_t length = equals ? (size_t)(equals - text) : 0;
    *form = (mukca_rotation_form){0};
    if (length >= sizeof form->converted) return false;
    memcpy(form->converted, text, length);
    if (equals) text = equals + 1;
    if (strlen(text) >= sizeof form->as) return false;
    memcpy(form->as, text, strlen(text));
    if (equals) return mukca_angles_known(form->converted) && mukca_angles_known(text);
    return mukca_angles_known(text) || is_order(form) || is(form, "none") || is(form, "inverse");
}

void mukca_rotations_map(mukca_table *table, int turn[4], const char **convention,
                         const mukca_rotation_form *form)
{
    const int n = *convention ? 3 : 4;
    int sorted[4];
    if (is(form, "none")) memset(turn, -1, 4 * sizeof *turn);
    if (!form->as[0] || form->converted[0] || turn[0] < 0 || is(form, "inverse")) return;
    if (is_order(form) != (n == 4))
        mukca_table_fail(table, turn[0], "--rotation %s, but the orientations are %s", form->as,
                         n == 4 ? "quaternions (wxyz, xyzw)"
                                : "three numbers (vector, or angles as XYZ or xyz)");
    for (int i = 0; i < n; i++) {
        int rank = 0;
        for (int k = 0; k < n; k++) rank += turn[k] < turn[i];
        sorted[rank] = turn[i];
    }
    for (int i = 0; i < n; i++) turn[i] = sorted[is(form, "xyzw") ? (i + 3) % 4 : i];
    if (n == 3) *convention = form->as;
}

bool mukca_rotations_normalise(double quaternion[4])
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += quaternion[i] * quaternion[i];
    const double length = sqrt(square);
    if (!(fabs(length - 1) <= length_tolerance)) return false;
    for (int i = 0; i < 4; i++) quaternion[i] /= length;
    return true;
}

void mukca_rotations_invert(double position[3], double quaternion[4])
{
    double R[9], p[3];
    mukca_rotation_from_quaternion(R, quaternion);
    mukca_mat3_tvec(p, R, position);
    for (int i = 0; i < 3; i++) position[i] = -p[i], quaternion[1 + i] *= -1;
}

void mukca_rotations_convert(double quaternion[4], const mukca_rotation_form *form)
{
    double R[9], numbers[3];
    for (int i = 1; i < 4 && is(form, "inverse"); i++) quaternion[i] *= -1;
    if (!form->converted[0]) return;
    mukca_rotation_from_quaternion(R, quaternion);
    mukca_angles_from_rotation(numbers, R, form->converted);
    mukca_angles_to_rotation(R, numbers, form->as);
    mukca_rotation_to_quaternion(quaternion, R);
}

/* Rotation between two orientations, rad. */
static double between(const double a[4], const double b[4])
{
    return 2 * acos(fmin(1, fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3])));
}

/* Whether an orientation of the tip differs from all that are kept. */
static bool is_new(const mukca_rotation_samples *o, const double tip[4], int n)
{
    for (int i = 0; i < n; i++)
        if (between(o->sample[i].tip, tip) < o->least) return false;
    return true;
}

/* Full: keep those that differ twice as much. */
static void thin_out(mukca_rotation_samples *o)
{
    int n = 0;
    o->least *= 2;
    for (int i = 0; i < o->n; i++)
        if (is_new(o, o->sample[i].tip, n)) o->sample[n++] = o->sample[i];
    o->n = n;
}

void mukca_rotations_start(mukca_rotation_samples *o, const mukca_chain *chain)
{
    mukca_geometry_set(&o->geometry, chain, NULL);
    o->n_joints = chain->n_joints;
    o->least = least_rotation;
    for (int k = 0; k < chain->n_elements; k++) o->reach += mukca_norm3(chain->element[k].xyz);
}

void mukca_rotations_keep(mukca_rotation_samples *o, const double *q, const double pose[7],
                          const double raw[4], const char *target)
{
    const char *name = target ? target : "";
    mukca_frame tip;
    double turned[4];
    if (isnan(pose[0]) || o->seen++ >= MOST_SEEN) return;
    if (o->seen == 1) snprintf(o->target, sizeof o->target, "%s", name);
    if (strncmp(o->target, name, sizeof o->target - 1) != 0) return;
    mukca_fk_pose(&tip, &o->geometry, q, NULL);
    mukca_rotation_to_quaternion(turned, tip.R);
    while (is_new(o, turned, o->n)) {
        if (o->n == MUKCA_ROTATIONS) {
            thin_out(o);
            continue;
        }
        mukca_rotation_sample *s = &o->sample[o->n++];
        memcpy(s->tip, turned, sizeof s->tip);
        memcpy(s->raw, raw, sizeof s->raw);
        memcpy(s->measured, pose, sizeof s->measured);
        memcpy(s->q, q, sizeof *q * (size_t)o->n_joints);
    }
}

/* A form in which the orientations may be meant; zeroed but for the factor: as read. */
typedef struct {
    mukca_rotation_form form;
    double factor;      /* of the numbers */
    bool inverse_pose;  /* --inverse-poses is wrong */
    double error, turn; /* after the alignment: m, orientations at a tool's length; rad */
} hypothesis;

/* Set the k-th hypothesis; false: none. */
static bool set_hypothesis(hypothesis *h, int numbers, int k)
{
    static const char *const plain[] = {"", "inverse", "wxyz", "xyzw"};
    const int n_plain = numbers == 4 ? 4 : 2;
    *h = (hypothesis){.factor = 1, .inverse_pose = k == 0};
    if (k < n_plain) return mukca_rotation_form_read(&h->form, plain[k]) || k == 0;
    const int to = (k - n_plain) % CONVENTIONS, from = (k - n_plain) / CONVENTIONS;
    if (from >= (numbers == 3 ? 3 : SOURCES)) return false;
    snprintf(h->form.as, sizeof h->form.as, "%s", conventions[to]);
    if (numbers != 3)
        snprintf(h->form.converted, sizeof h->form.converted, "%s", conventions[from]);
    else if (from > 0)
        h->factor = from == 1 ? 180 / M_PI : M_PI / 180;
    return true;
}

/* Measured pose of a sample in the file's form or in another. */
static void pose_of(double position[3], double quaternion[4], const mukca_rotation_samples *o,
                    int i, const hypothesis *h)
{
    const double *raw = o->sample[i].raw, *measured = o->sample[i].measured;
    const double numbers[3] = {h->factor * raw[0], h->factor * raw[1], h->factor * raw[2]};
    double R[9];
    memcpy(position, measured, 3 * sizeof *position);
    memcpy(quaternion, measured + 3, 4 * sizeof *quaternion);
    if (is_order(&h->form)) {
        for (int c = 0; c < 4; c++) quaternion[c] = raw[is(&h->form, "xyzw") ? (c + 3) % 4 : c];
    } else if (o->numbers == 3 && h->form.as[0] && !is(&h->form, "inverse")) {
        mukca_angles_to_rotation(R, numbers, h->form.as);
        mukca_rotation_to_quaternion(quaternion, R);
    } else {
        mukca_rotations_convert(quaternion, h->form.as[0] ? &h->form : &o->form);
    }
    (void)mukca_rotations_normalise(quaternion);
    if (o->inverse != h->inverse_pose) mukca_rotations_invert(position, quaternion);
}

static void fill(mukca_dataset *d, const mukca_rotation_samples *o, const hypothesis *h)
{
    for (int i = 0; i < d->n_rows; i++)
        pose_of(d->position + 3 * i, d->quaternion + 4 * i, o, i, h);
}

/* Median difference between the arm's and the measured rotations between two samples, rad: frames
 * do not matter. */
static double difference(const mukca_dataset *d, const mukca_rotation_samples *o)
{
    double list[MUKCA_ROTATIONS * MUKCA_ROTATIONS / 2];
    int n = 0;
    for (int i = 0; i < d->n_rows; i++)
        for (int k = 0; k < i; k++)
            list[n++] = fabs(between(o->sample[i].tip, o->sample[k].tip) -
                             between(d->quaternion + 4 * i, d->quaternion + 4 * k));
    return mukca_stats_median(list, n);
}

/* Align the arm to the poses; false: out of memory. */
static bool align(hypothesis *h, const mukca_dataset *d, const mukca_rotation_samples *o)
{
    const mukca_align_options free_frames = {.tracker = true, .target = true};
    double error[MUKCA_ROTATIONS], turn[MUKCA_ROTATIONS];
    mukca_alignment a;
    if (!mukca_align(&a, &o->geometry, d, &free_frames)) return false;
    for (int i = 0; i < d->n_rows; i++) {
        mukca_frame T;
        double R[9];
        mukca_fk_pose(&T, &o->geometry, o->sample[i].q, NULL);
        mukca_frame_multiply(&T, &T, &a.target);
        mukca_frame_multiply(&T, &a.tracker, &T);
        mukca_rotation_from_quaternion(R, d->quaternion + 4 * i);
        turn[i] = mukca_rotation_between(R, T.R);
        error[i] =
            hypot(mukca_distance3(T.p, d->position + 3 * i), MUKCA_METRES_PER_RADIAN * turn[i]);
    }
    h->error = mukca_stats_quantile(error, d->n_rows, most_samples);
    h->turn = mukca_stats_quantile(turn, d->n_rows, most_samples);
    return true;
}

/* "intrinsic XYZ", "extrinsic xyz" */
static void describe(char text[24], const char *convention)
{
    const char *kind = convention[0] >= 'x' ? "extrinsic" : "intrinsic";
    if (strcmp(convention, MUKCA_VECTOR) == 0)
        snprintf(text, 24, "a rotation vector");
    else
        snprintf(text, 24, "%s %s", kind, convention);
}

/* Fail, and name the form in which the orientations agree with the arm. */
static void name_form(mukca_table *table, const mukca_rotation_samples *o, const hypothesis *h,
                      double turn)
{
    const bool inverse = o->inverse;
    const char *unit = h->factor < 1 ? "degrees" : "radians";
    char as[24], converted[24], text[160];
    describe(as, h->form.as);
    describe(converted, h->form.converted);
    if (h->inverse_pose)
        snprintf(text, sizeof text, "the poses fit as those of the %s: %s --inverse-poses",
                 inverse ? "target in the fixed frame" : "fixed frame in the target's",
                 inverse ? "omit" : "give");
    else if (is_order(&h->form))
        snprintf(text, sizeof text, "the quaternions fit as %s: --rotation %s", h->form.as,
                 h->form.as);
    else if (is(&h->form, "inverse"))
        snprintf(text, sizeof text, "they fit as their inverses: --rotation inverse");
    else if (h->form.converted[0])
        snprintf(text, sizeof text,
                 "they fit if angles that are %s were converted as %s: --rotation %s=%s", as,
                 converted, h->form.converted, h->form.as);
    else if (h->factor != 1)
        snprintf(text, sizeof text,
                 "the angles fit as %s in %s: --rotation %s, and the unit after the columns' "
                 "names, as in 'rx [%.3s]'",
                 as, unit, h->form.as, unit);
    else
        snprintf(text, sizeof text, "the angles fit as %s: --rotation %s", as, h->form.as);
    mukca_table_fail(table, o->column, "the orientations contradict the positions by %.0f mrad; %s",
                     1e3 * turn, text);
}

/* Do the positions fit the arm, whatever the orientations are?  False: out of memory. */
static bool fit_positions(bool *fit, const mukca_dataset *d, const mukca_rotation_samples *o)
{
    const mukca_align_options free_frames = {.tracker = true, .target = true};
    mukca_dataset positions = *d; /* shares the other arrays */
    mukca_alignment a;
    positions.quaternion = NULL;
    if (!mukca_align(&a, &o->geometry, &positions, &free_frames)) return false;
    *fit = a.median_m < positions_fit * o->reach;
    return true;
}

/* The samples in the form that was read do not fit: find another; its error remains that of `read`
 * if there is none.  False: out of memory. */
static bool find_form(hypothesis *best, mukca_dataset *d, const mukca_rotation_samples *o,
                      const hypothesis *read)
{
    hypothesis h;
    *best = *read;
    for (int k = 0; set_hypothesis(&h, o->numbers, k); k++) {
        fill(d, o, &h);
        if (!(difference(d, o) < read->turn / 2)) continue;
        if (!align(&h, d, o)) return false;
        if (h.error < 0.9 * best->error) *best = h;
    }
    return true;
}

void mukca_rotations_judge(mukca_table *table, const mukca_rotation_samples *o, mukca_notes notes)
{
    mukca_dataset d = {0};
    hypothesis read = {.factor = 1}, best = {0};
    bool positions = false;
    if (table->status != MUKCA_OK || o->n < LEAST_SAMPLES) return;
    bool done = mukca_dataset_create(&d, o->n, o->n_joints, 0, 0, table->error) == MUKCA_OK;
    d.position = calloc((size_t)o->n, 3 * sizeof(double));
    d.quaternion = calloc((size_t)o->n, 4 * sizeof(double));
    done = done && d.position && d.quaternion;
    for (int i = 0; i < o->n && done; i++)
        memcpy(d.q + (size_t)i * (size_t)d.n_joints, o->sample[i].q,
               (size_t)d.n_joints * sizeof *d.q);
    if (done) fill(&d, o, &read);
    done = done && align(&read, &d, o);
    if (done && read.turn > least_turn) {
        done = find_form(&best, &d, o, &read);
        if (best.error < explained * read.error &&
            best.turn < fmin(most_turn, explained * read.turn))
            name_form(table, o, &best, read.turn);
        else if (done && read.turn > most_turn)
            done = fit_positions(&positions, &d, o);
    }
    if (positions)
        mukca_note_format(notes,
                          "%s: the orientations contradict the positions by %.0f mrad in every "
                          "common convention; --rotation none reads the positions alone",
                          mukca_file_shown(table->path), 1e3 * read.turn);
    if (!done) mukca_table_stop(table, mukca_fail(table->error, MUKCA_MEMORY, "out of memory"));
    mukca_dataset_free(&d);
}
