/* Columns of a candidate at a linearisation: levers times its basis functions. */
#include <string.h>

#include "base/clones.h"
#include "diagnose/linearisation.h"
#include "diagnose/unlisted.h"

/* Levers [d][width] of a candidate's terms, width 1 or 3: of sample 0, and how far the next
 * sample's are behind.  Returns false where it has no such columns. */
static bool levers_of(const double **lever, size_t *step, const mukca_linearisation *linear,
                      const mukca_recording *recording, const mukca_candidate *h)
{
    const size_t d = (size_t)recording->dim, n = (size_t)recording->chain->n_joints,
                 joint = (size_t)h->joint;
    if (!h->basis || h->kind == MUKCA_CANDIDATE_STRETCH ||
        h->kind == MUKCA_CANDIDATE_UNLISTED_FRAME)
        return false;
    switch (mukca_candidate_site(h)) {
        case MUKCA_SITE_ANGLE:
            *step = n * d;
            *lever = linear->lever + joint * d;
            return true;
        case MUKCA_SITE_ROTATION:
            *step = n * 3 * d;
            *lever = linear->rotation_lever + joint * 3 * d;
            return true;
        case MUKCA_SITE_BASE:
            *step = 3 * d;
            *lever = linear->base_lever;
            return true;
        default:
            return false;
    }
}

/* E := levers times the basis functions. */
MUKCA_CLONES static void turn_levers(double *E, int ld, const double *lever, size_t step,
                                     const mukca_recording *recording, const mukca_candidate *h)
{
    const int d = recording->dim, terms = h->terms, width = h->width_of_term;
    double b[3][MUKCA_MAX_COLUMNS];
    for (int i = 0; i < recording->n_samples; i++, lever += step) {
        const float *basis = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        for (int t = 0; t < terms; t++)
            for (int k = 0; k < 3; k++) b[k][t] = k < width ? (double)basis[width * t + k] : 0;
        const double *l = lever;
        for (int c = 0; c < d; c++, l += width, E += ld)
            if (width == 1)
                for (int t = 0; t < terms; t++) E[t] = l[0] * b[0][t];
            else
                for (int t = 0; t < terms; t++)
                    E[t] = l[0] * b[0][t] + l[1] * b[1][t] + l[2] * b[2][t];
    }
}

void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_recording *recording, const mukca_candidate *h)
{
    const int d = recording->dim, n_joints = recording->chain->n_joints, terms = h->terms;
    const int width = h->width_of_term, ldx = linear->stride;
    size_t step;
    const double *lever;
    if (levers_of(&lever, &step, linear, recording, h)) {
        turn_levers(E, ld, lever, step, recording, h);
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
            mukca_unlisted_tilt(out, ld, h, linear->tip_frame + 9 * i, recording->chain->gravity);
        if (!h->basis) continue; /* a distance moves no sample */
        const float *basis = h->basis + (size_t)row * (size_t)(terms * width);
        if (h->kind == MUKCA_CANDIDATE_STRETCH) { /* as x y z of the slot's frame do */
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
            const double *frame = linear->tip_frame + 9 * i;
            for (int c = 0; c < 3; c++)
                for (int t = 0; t < 3; t++)
                    out[c * ld + t] = frame[3 * c + t] * (double)basis[t * width + t];
        } else if (mukca_candidate_site(h) == MUKCA_SITE_ANGLES) {
            for (int k = 0; k < n_joints; k++)
                for (int c = 0; c < d; c++) out[c * ld] += levers[k * d + c] * (double)basis[k];
        }
    }
}
