/* How well a diagnosis knows each parameter of the geometry. */
#include "study/offset_sigma.h"

#include <math.h>
#include <string.h>

/* Derivative of the six parameters of a slot by its local offsets: J[6][6], differences of 1e-6. */
static void slot_jacobian(double J[6][6], gap_model *m, int slot, int width)
{
    const double step = 1e-6;
    double side[2][MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    const int at = MUKCA_PARAMETERS * m->slot_element[slot];
    memset(J, 0, sizeof(double[6][6]));
    for (int c = 0; c < width; c++) {
        double *unknown = m->theta + 6 * slot + c;
        const double kept = *unknown;
        for (int s = 0; s < 2; s++) {
            *unknown = kept + (s ? step : -step);
            gap_model_set_geometry(m);
            mukca_geometry_theta(side[s], m->chain, &m->geometry);
        }
        *unknown = kept;
        for (int p = 0; p < 6; p++) J[p][c] = (side[1][at + p] - side[0][at + p]) / (2 * step);
    }
    gap_model_set_geometry(m);
}

void gap_offset_sigmas(mukca_diagnosis *d, gap_model *m)
{
    const int n = MUKCA_PARAMETERS * m->chain->n_elements;
    d->theta_sigma = MUKCA_TAKE(&d->pool, double, n);
    d->theta_prior = MUKCA_TAKE(&d->pool, double, n);
    if (d->pool.failed) return;
    for (int i = 0; i < n; i++) d->theta_sigma[i] = d->theta_prior[i] = NAN;
    for (int k = 0; k < m->n_slots; k++) {
        const int width = k + 1 < m->n_slots ? 6 : m->slot_width;
        double J[6][6];
        slot_jacobian(J, m, k, width);
        for (int p = 0; p < width; p++) {
            const int i = MUKCA_PARAMETERS * m->slot_element[k] + p;
            double square = 0;
            for (int c = 0; c < width; c++)
                square += J[p][c] * J[p][c] * m->prior[6 * k + c] * m->prior[6 * k + c];
            d->theta_sigma[i] = gap_model_standard_error(m, 6 * k, J[p], width);
            d->theta_prior[i] = sqrt(square);
        }
    }
}
