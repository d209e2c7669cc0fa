/* Part of a diagnosis that applies to other configurations of the arm. */
#include "diagnose/diagnose.h"

#include <math.h>
#include <string.h>

#include "diagnose/regression.h"

/* One coefficient instead of one per mass: the sum of the masses' parts without the factors
 * estimated from measured efforts, which are unknown elsewhere. */
static bool tie_masses(mukca_candidate *h, mukca_regression *m)
{
    const int rows = m->recording.data->n_rows, terms = h->terms, width = h->width_of_term;
    float *basis = MUKCA_TAKE(&m->pool, float, rows *width);
    if (!basis) return false;
    for (int row = 0; row < rows; row++)
        for (int k = 0; k < width; k++) {
            double sum = 0;
            for (int t = 1; t < terms; t++)
                sum += (double)h->basis[(row * terms + t) * width + k] /
                       m->recording.mass_factor[t - 1];
            basis[row * width + k] = (float)sum;
        }
    h->basis = basis;
    h->terms = 1;
    return true;
}

/* Derivative of the six parameters of a slot by its local offsets, J[6][6]: central differences of
 * 1e-6. */
static void slot_jacobian(double J[6][6], mukca_regression *m, int slot, int width)
{
    const double step = 1e-6;
    double side[2][MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS];
    const int at = MUKCA_PARAMETERS * m->unknowns.slot_element[slot];
    memset(J, 0, sizeof(double[6][6]));
    for (int c = 0; c < width; c++) {
        double *unknown = m->unknowns.theta + 6 * slot + c;
        const double kept = *unknown;
        for (int s = 0; s < 2; s++) {
            *unknown = kept + (s ? step : -step);
            mukca_unknowns_set_geometry(&m->unknowns, m->recording.chain);
            mukca_geometry_theta(side[s], m->recording.chain, &m->unknowns.arm.geometry);
        }
        *unknown = kept;
        for (int p = 0; p < 6; p++) J[p][c] = (side[1][at + p] - side[0][at + p]) / (2 * step);
    }
    mukca_unknowns_set_geometry(&m->unknowns, m->recording.chain);
}

/* Moments of a sum of direction[t] times the unknown column + t: first and second of the mixture of
 * the models. */
typedef struct {
    double mean, square;
} moments;

static void add(moments *to, mukca_regression *m, int column, const double *direction, int terms,
                double weight)
{
    double mean = 0;
    for (int t = 0; t < terms; t++) mean += direction[t] * m->evidence.mean[column + t];
    const double sigma = mukca_regression_standard_error(m, column, direction, terms);
    to->mean += weight * mean;
    to->square += weight * (mean * mean + sigma * sigma);
}

static double sigma_of(const moments *m)
{
    return sqrt(fmax(m->square - m->mean * m->mean, 0));
}

/* Elements without unknowns of their own scale with the factor of all lengths.  Samples of sockets
 * do not identify those before the second joint. */
static void add_lengths(mukca_applied *a, moments *theta, mukca_regression *m, double weight)
{
    const mukca_unknowns *u = &m->unknowns;
    const mukca_chain *chain = m->recording.chain;
    const int factor = u->first_tracker - 1;
    const bool poses = m->recording.groups[0].socket < 0;
    for (int k = poses ? 0 : chain->joint_element[0] + 1; k < chain->n_elements; k++) {
        bool is_free = false;
        for (int s = 0; s < u->n_slots; s++) is_free |= u->slot_element[s] == k;
        for (int c = 0; c < 3 && !is_free; c++) {
            const double length = chain->element[k].xyz[c];
            const int i = MUKCA_PARAMETERS * k + c;
            if (!(fabs(length) > 0)) continue;
            add(&theta[i], m, factor, &length, 1, weight);
            a->theta_prior[i] = fabs(length) * u->theta_prior[factor];
        }
    }
}

static void add_slots(mukca_applied *a, moments *theta, mukca_regression *m, double weight)
{
    for (int k = 0; k < m->unknowns.n_slots; k++) {
        const int width = k + 1 < m->unknowns.n_slots ? 6 : m->unknowns.slot_width;
        double J[6][6];
        slot_jacobian(J, m, k, width);
        for (int p = 0; p < width; p++) {
            const int i = MUKCA_PARAMETERS * m->unknowns.slot_element[k] + p;
            double square = 0;
            for (int c = 0; c < width; c++)
                square += pow(J[p][c] * m->unknowns.theta_prior[6 * k + c], 2);
            add(&theta[i], m, 6 * k, J[p], width, weight);
            a->theta_prior[i] = sqrt(square);
        }
    }
}

void mukca_applied_fit(mukca_applied *a, mukca_regression *m)
{
    mukca_unknowns *u = &m->unknowns;
    for (int c = 0; c < u->n_causes; c++) {
        mukca_candidate *h = &u->cause[c].candidate;
        if (mukca_candidate_class(h) == MUKCA_CLASS_UNKNOWN)
            mukca_unknowns_drop(u, c--);
        else if (mukca_candidate_by_mass(h) && !tie_masses(h, m))
            return;
    }
    mukca_regression_fit(m, 6, MUKCA_FIT_INDEPENDENT);
    const int n = MUKCA_PARAMETERS * m->recording.chain->n_elements,
              models = u->n_models ? u->n_models : 1;
    moments theta[MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS] = {0},
                                     effect[MUKCA_MAX_APPLIED][MUKCA_MAX_TERMS] = {0};
    const double one = 1;
    for (int i = 0; i < n; i++) a->theta_prior[i] = NAN;
    for (int k = 0; k < models; k++) {
        const double weight = u->n_models ? u->model_weight[k] : 1;
        if (!mukca_regression_solve(m, mukca_regression_collect(m, u->family),
                                    u->n_models ? k : -1))
            return;
        add_slots(a, theta, m, weight);
        add_lengths(a, theta, m, weight);
        for (int c = 0, i = 0; c < u->n_causes && i < MUKCA_MAX_APPLIED; c++) {
            const mukca_candidate *h = &u->cause[c].candidate;
            if (!mukca_candidate_moves_arm(h)) continue;
            for (int t = 0; t < h->terms; t++)
                add(&effect[i][t], m, mukca_unknowns_column(u, c) + t, &one, 1, weight);
            i++;
        }
    }
    for (int i = 0; i < n; i++)
        a->theta_sigma[i] = isnan(a->theta_prior[i]) ? (double)NAN : sigma_of(&theta[i]);
    for (int c = 0; c < u->n_causes && a->n_effects < MUKCA_MAX_APPLIED; c++) {
        const mukca_candidate *h = &u->cause[c].candidate;
        if (!mukca_candidate_moves_arm(h)) continue;
        const int i = a->n_effects++;
        a->effects[i] = h->effect;
        a->effects[i].terms = h->terms;
        for (int t = 0; t < h->terms; t++) {
            a->effects[i].coefficient[t] = u->cause[c].coefficient[t];
            a->effect_sigma[i][t] = sigma_of(&effect[i][t]);
        }
    }
    a->geometry = u->arm.geometry;
    a->tracker = u->arm.log.tracker[0];
    a->fitted = true;
}
