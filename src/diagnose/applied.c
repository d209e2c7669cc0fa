/* What of a diagnosis can be applied to other configurations of the arm. */
#include "diagnose/applied.h"

#include <math.h>
#include <string.h>

#include "diagnose/candidates.h"

/* One coefficient instead of one per mass: the sum of the masses' parts without the factors that
 * measured efforts gave them, which nobody else knows. */
static bool tie_masses(gap_hypothesis *h, gap_model *m)
{
    const int rows = m->data->n_rows, terms = h->terms, width = h->width;
    float *basis = MUKCA_TAKE(&m->pool, float, rows *width);
    if (!basis) return false;
    for (int row = 0; row < rows; row++)
        for (int k = 0; k < width; k++) {
            double sum = 0;
            for (int t = 1; t < terms; t++)
                sum += (double)h->basis[(row * terms + t) * width + k] / m->lump_scale[t - 1];
            basis[row * width + k] = (float)sum;
        }
    h->basis = basis;
    h->terms = 1;
    return true;
}

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

static void parameter_sigmas(mukca_applied *a, gap_model *m)
{
    for (int i = 0; i < MUKCA_PARAMETERS * m->chain->n_elements; i++)
        a->theta_sigma[i] = a->theta_prior[i] = NAN;
    for (int k = 0; k < m->n_slots; k++) {
        const int width = k + 1 < m->n_slots ? 6 : m->slot_width;
        double J[6][6];
        slot_jacobian(J, m, k, width);
        for (int p = 0; p < width; p++) {
            const int i = MUKCA_PARAMETERS * m->slot_element[k] + p;
            double square = 0;
            for (int c = 0; c < width; c++)
                square += J[p][c] * J[p][c] * m->prior[6 * k + c] * m->prior[6 * k + c];
            a->theta_sigma[i] = gap_model_standard_error(m, 6 * k, J[p], width);
            a->theta_prior[i] = sqrt(square);
        }
    }
}

void gap_applied(mukca_diagnosis *d, gap_model *m)
{
    mukca_applied *a = &d->applied;
    for (int c = 0; c < m->n_causes; c++) {
        gap_hypothesis *h = &m->cause[c].hypothesis;
        if (h->kind == GAP_BUMPS)
            gap_model_drop(m, c--);
        else if (gap_hypothesis_by_mass(h) && !tie_masses(h, m))
            return;
    }
    gap_model_fit(m, 6, GAP_FREE);
    gap_model_prior(m->prior, m, -1);
    for (int i = 0; i < GAP_RHOS; i++)
        if (gap_rho[i] == m->rho) {
            gap_model_pack(&m->pack[i], m, m->rho);
            if (!(gap_model_evidence(m, &m->pack[i], m->prior, m->sigma, NULL) > -HUGE_VAL)) return;
        }
    parameter_sigmas(a, m);
    int column = m->n_geometry;
    for (int c = 0; c < m->n_causes; c++) {
        const gap_hypothesis *h = &m->cause[c].hypothesis;
        if (h->kind == GAP_EFFECT && a->n_effects < MUKCA_MAX_CAUSES) {
            mukca_effect *effect = &a->effects[a->n_effects];
            *effect = h->effect;
            effect->terms = h->terms;
            for (int t = 0; t < h->terms; t++) {
                const double one = 1;
                effect->coefficient[t] = m->cause[c].coefficient[t];
                a->effect_sigma[a->n_effects][t] = gap_model_standard_error(m, column + t, &one, 1);
            }
            a->n_effects++;
        }
        column += h->terms;
    }
    a->geometry = m->geometry;
    a->tracker = m->tracker;
    a->fitted = true;
}
