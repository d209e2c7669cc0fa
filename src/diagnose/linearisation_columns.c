/* Columns of a candidate at a linearisation: levers times basis functions. */
#include <math.h>
#include <string.h>

#include "base/clones.h"
#include "diagnose/linearisation.h"
#include "math/four.h"

/* Levers of a candidate's terms at sample 0, and steps to those of the next sample, coordinate,
 * component of a term, and term (of three axes); the other coordinates do not move. */
typedef struct {
    const double *first;
    size_t sample;
    int coordinates, coordinate, component, term;
} lever_rows;

/* first NULL: the candidate's columns are not levers times basis functions. */
static lever_rows levers_of(const mukca_linearisation *linear, const mukca_candidate *h)
{
    const int d = linear->recording->dim, n = linear->recording->chain->n_joints, joint = h->joint,
              ld = linear->stride;
    const double *frame = linear->columns;
    switch (mukca_candidate_site(h)) {
        case MUKCA_SITE_ANGLE:
            return (lever_rows){linear->lever + joint * d, (size_t)(n * d), d, 1, 0, 0};
        case MUKCA_SITE_ANGLES:
            return (lever_rows){linear->lever, (size_t)(n * d), d, 1, d, 0};
        case MUKCA_SITE_ROTATION:
            return (lever_rows){
                linear->rotation_lever + joint * 3 * d, (size_t)(n * 3 * d), d, 3, 1, 0};
        case MUKCA_SITE_BASE:
            return (lever_rows){linear->base_lever, (size_t)(3 * d), d, 3, 1, 0};
        case MUKCA_SITE_TIP:
            return (lever_rows){linear->seated_frame, 9, 3, 3, 1, 0};
        case MUKCA_SITE_FRAME: /* along or about x, y and z */
            frame += 6 * h->unlisted.slot + (h->unlisted.place == MUKCA_PLACE_TURN ? 3 : 0);
            return (lever_rows){frame, (size_t)d * (size_t)ld, d, ld, 0, 1};
        default:
            return (lever_rows){0};
    }
}

/* E := levers times the basis functions. */
MUKCA_CLONES static void turn_levers(double *E, int ld, const lever_rows *by,
                                     const mukca_recording *recording, const mukca_candidate *h)
{
    const int d = recording->dim, terms = h->terms, width = h->width_of_term;
    for (int i = 0; i < recording->n_samples; i++, E += d * ld) {
        const float *b = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        const double *levers = by->first + (size_t)i * by->sample;
        int t = 0;
        for (; t + 4 <= terms && width == 3; t += 4, b += 12) {
            const four x = {(double)b[0], (double)b[3], (double)b[6], (double)b[9]},
                       y = {(double)b[1], (double)b[4], (double)b[7], (double)b[10]},
                       z = {(double)b[2], (double)b[5], (double)b[8], (double)b[11]};
            const double *l = levers;
            for (int c = 0; c < by->coordinates; c++, l += 3)
                STORE4(E + c * ld + t, l[0] * x + l[1] * y + l[2] * z);
        }
        for (; t + 4 <= terms && width == 1 && !by->term; t += 4, b += 4) {
            const four x = {(double)b[0], (double)b[1], (double)b[2], (double)b[3]};
            const double *l = levers;
            for (int c = 0; c < by->coordinates; c++, l += by->coordinate)
                STORE4(E + c * ld + t, l[0] * x);
        }
        for (; t < terms; t++, b += width) {
            const double *l = levers + t % 3 * by->term;
            for (int c = 0; c < by->coordinates; c++, l += by->coordinate) {
                double sum = l[0] * (double)b[0];
                for (int k = 1; k < width; k++) sum += l[k * by->component] * (double)b[k];
                E[c * ld + t] = sum;
            }
        }
        for (int c = by->coordinates; c < d; c++) memset(E + c * ld, 0, sizeof *E * (size_t)terms);
    }
}

/* Columns out[3][ld], 3 wide, of a function of the tilt for the frame R[9] of the tip, with v, the
 * vertical component of an axis of it.  On the tool: a shift to either side, by the sign of
 * v.  In the socket: upwards by v and v^2, as by an oval ball or its neck on the rim, and along the
 * axis by v. */
static void tilt(double *out, int ld, const mukca_candidate *h, const double *R,
                 const double gravity[3])
{
    const double g = fmax(sqrt(mukca_dot3(gravity, gravity)), 1e-9);
    const int k = h->unlisted.argument;
    double v = 0;
    for (int c = 0; c < 3; c++) v -= R[3 * c + k] * gravity[c] / g;
    for (int c = 0; c < 3; c++, out += ld) {
        if (h->unlisted.place == MUKCA_PLACE_TOOL) {
            for (int t = 0; t < 3; t++) out[t] = v > 0 ? R[3 * c + t] : -R[3 * c + t];
            continue;
        }
        out[0] = -gravity[c] / g * v;
        out[1] = out[0] * v;
        out[2] = R[3 * c + k] * v;
    }
}

void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_candidate *h)
{
    const mukca_recording *recording = linear->recording;
    const int d = recording->dim;
    const lever_rows by = levers_of(linear, h);
    if (by.first) {
        turn_levers(E, ld, &by, recording, h);
        return;
    }
    for (int i = 0; i < recording->n_samples; i++) {
        double *out = E + (size_t)i * (size_t)d * (size_t)ld;
        for (int c = 0; c < d; c++) memset(out + c * ld, 0, sizeof *out * (size_t)h->terms);
        if (mukca_candidate_site(h) == MUKCA_SITE_SOCKET) {
            const double displacement =
                mukca_candidate_fault_share(h, recording, recording->order[i]);
            for (int c = 0; c < 3; c++) out[c * ld + c] = -displacement;
        } else if (mukca_candidate_site(h) == MUKCA_SITE_SEAT) {
            tilt(out, ld, h, linear->seated_frame + 9 * i, recording->chain->gravity);
        }
    }
}
