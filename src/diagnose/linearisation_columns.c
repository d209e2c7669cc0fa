/* Columns of a candidate at a linearisation: levers times basis functions. */
#include <string.h>

#include "base/clones.h"
#include "diagnose/linearisation.h"
#include "diagnose/unlisted.h"
#include "math/four.h"

/* Levers [d][width] of a candidate's terms, width 1 or 3: those of sample 0, and the step to the
 * next sample. */
typedef struct {
    const double *first;
    size_t step;
} lever_rows;

/* False: the candidate's columns are not levers times basis functions. */
static bool levers_of(lever_rows *out, const mukca_linearisation *linear,
                      const mukca_recording *recording, const mukca_candidate *h)
{
    const size_t d = (size_t)recording->dim, n = (size_t)recording->chain->n_joints,
                 joint = (size_t)h->joint;
    if (!h->basis || h->kind == MUKCA_CANDIDATE_STRETCH ||
        h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME)
        return false;
    switch (mukca_candidate_site(h)) {
        case MUKCA_SITE_ANGLE:
            *out = (lever_rows){linear->lever + joint * d, n * d};
            return true;
        case MUKCA_SITE_ROTATION:
            *out = (lever_rows){linear->rotation_lever + joint * 3 * d, n * 3 * d};
            return true;
        case MUKCA_SITE_BASE:
            *out = (lever_rows){linear->base_lever, 3 * d};
            return true;
        default:
            return false;
    }
}

/* E := levers times the basis functions. */
MUKCA_CLONES static void turn_levers(double *E, int ld, const lever_rows *by,
                                     const mukca_recording *recording, const mukca_candidate *h)
{
    const int d = recording->dim, terms = h->terms, width = h->width_of_term;
    for (int i = 0; i < recording->n_samples; i++, E += d * ld) {
        const float *b = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        const double *levers = by->first + (size_t)i * by->step;
        int t = 0;
        for (; t + 4 <= terms && width == 3; t += 4, b += 12) {
            const four x = {(double)b[0], (double)b[3], (double)b[6], (double)b[9]},
                       y = {(double)b[1], (double)b[4], (double)b[7], (double)b[10]},
                       z = {(double)b[2], (double)b[5], (double)b[8], (double)b[11]};
            const double *l = levers;
            for (int c = 0; c < d; c++, l += 3)
                STORE4(E + c * ld + t, l[0] * x + l[1] * y + l[2] * z);
        }
        for (; t < terms; t++, b += width) {
            const double *l = levers;
            for (int c = 0; c < d; c++, l += width) {
                double sum = l[0] * (double)b[0];
                for (int k = 1; k < width; k++) sum += l[k] * (double)b[k];
                E[c * ld + t] = sum;
            }
        }
    }
}

void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_recording *recording, const mukca_candidate *h)
{
    const int d = recording->dim, n_joints = recording->chain->n_joints, terms = h->terms;
    const int width = h->width_of_term, ldx = linear->stride;
    lever_rows by;
    if (levers_of(&by, linear, recording, h)) {
        turn_levers(E, ld, &by, recording, h);
        return;
    }
    for (int i = 0; i < recording->n_samples; i++) {
        double *out = E + (size_t)i * (size_t)d * (size_t)ld;
        const int row = recording->order[i];
        const double *levers = linear->lever + (size_t)(i * n_joints) * (size_t)d;
        for (int c = 0; c < d; c++) memset(out + c * ld, 0, sizeof *out * (size_t)terms);
        if (mukca_candidate_is_fault(h)) {
            const double share = mukca_candidate_fault_share(h, recording, row);
            for (int c = 0; c < 3; c++) out[c * ld + c] = -share;
            continue;
        }
        if (h->kind == MUKCA_CANDIDATE_UNLISTED_TILT)
            mukca_unlisted_tilt(out, ld, h, linear->seated_frame + 9 * i,
                                recording->chain->gravity);
        if (!h->basis) continue; /* a change of distance moves no sample */
        const float *basis = h->basis + (size_t)row * (size_t)(terms * width);
        if (h->kind == MUKCA_CANDIDATE_STRETCH) { /* along x, y and z of the slot's frame */
            const double *slot =
                linear->columns + (size_t)(i * d) * (size_t)ldx + 6 * h->stretch.slot;
            for (int c = 0; c < d; c++)
                for (int t = 0; t < 3; t++) out[c * ld + t] = slot[c * ldx + t] * (double)basis[t];
        } else if (h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME) {
            const double *slot = linear->columns + (size_t)(i * d) * (size_t)ldx +
                                 6 * h->simple.slot + (h->simple.turns ? 3 : 0);
            for (int c = 0; c < d; c++)
                for (int t = 0; t < terms; t++)
                    out[c * ld + t] = slot[c * ldx + t % 3] * (double)basis[t];
        } else if (mukca_candidate_site(h) == MUKCA_SITE_TIP) {
            const double *frame = linear->seated_frame + 9 * i;
            for (int c = 0; c < 3; c++)
                for (int t = 0; t < 3; t++)
                    out[c * ld + t] = frame[3 * c + t] * (double)basis[t * width + t];
        } else if (mukca_candidate_site(h) == MUKCA_SITE_ANGLES) {
            for (int k = 0; k < n_joints; k++)
                for (int c = 0; c < d; c++) out[c * ld] += levers[k * d + c] * (double)basis[k];
        }
    }
}
