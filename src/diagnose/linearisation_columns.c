/* Columns of a candidate at a linearisation: levers times its basis functions. */
#include <string.h>

#include "base/clones.h"
#include "diagnose/linearisation.h"
#include "diagnose/unlisted.h"

/* Levers [d][width] of a candidate's terms, width 1 or 3: of sample 0, and how far the next
 * sample's are behind. */
typedef struct {
    const double *first;
    size_t step;
} lever_rows;

/* Returns false where it has no such columns. */
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
                                     const mukca_recording *recording, const mukca_candidate *h,
                                     mukca_span of)
{
    const int d = recording->dim, terms = h->terms, width = h->width_of_term;
    double b[3][MUKCA_MAX_COLUMNS];
    for (int i = of.start; i < of.end; i++) {
        const float *basis = h->basis + (size_t)recording->order[i] * (size_t)(terms * width);
        for (int t = 0; t < terms; t++)
            for (int k = 0; k < 3; k++) b[k][t] = k < width ? (double)basis[width * t + k] : 0;
        const double *l = by->first + (size_t)i * by->step;
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
    mukca_linearisation_columns_of(E, ld, linear, recording, h,
                                   (mukca_span){0, recording->n_samples});
}

void mukca_linearisation_columns_of(double *E, int ld, const mukca_linearisation *linear,
                                    const mukca_recording *recording, const mukca_candidate *h,
                                    mukca_span of)
{
    const int d = recording->dim, n_joints = recording->chain->n_joints, terms = h->terms;
    const int width = h->width_of_term, ldx = linear->stride;
    lever_rows by;
    if (levers_of(&by, linear, recording, h)) {
        turn_levers(E, ld, &by, recording, h, of);
        return;
    }
    for (int i = of.start; i < of.end; i++) {
        double *out = E + (size_t)(i - of.start) * (size_t)d * (size_t)ld;
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
