/* Contribution of noise in the recorded angles to a candidate's score.
 *
 * The ball is in its socket: the noise of a sample is in its recorded angles, and a function of
 * these angles contains it.  Its product with the residual then has a mean other than zero even
 * without such a cause (errors in variables: W. A. Fuller, Measurement Error Models, 1987,
 * section 1.1).  With many postures per socket this bias is far below the noise.  With one or a
 * few, as of a gantry or a three-axis arm, it dominates once the geometry is fitted. */
#include "diagnose/angle_noise.h"

#include <math.h>
#include <string.h>

/* Alternating signs preserve the range of the angles, which scales some functions. */
static double sign_of(int sample)
{
    return sample % 2 ? -1 : 1;
}

/* Change the angles of each sample so that the tip moves by `shift` along axis c. */
static void move_tips(mukca_recording *moved, const mukca_regression *m, int c, double shift)
{
    const mukca_recording *r = &m->recording;
    const int n = r->chain->n_joints;
    for (int i = 0; i < r->n_samples; i++) {
        const size_t at = (size_t)r->order[i] * (size_t)n;
        double *q = moved->data->q + at, step[3] = {0, 0, 0};
        mukca_displacement displacement;
        mukca_unknowns_displacement(&displacement, &m->unknowns, n, r->order[i]);
        memcpy(q, r->data->q + at, sizeof *q * (size_t)n);
        step[c] = sign_of(i) * shift;
        mukca_linearisation_seat(q, step, n, &m->unknowns.geometry, &displacement);
        for (int j = 0; j < n; j++)
            moved->move[at + (size_t)j] =
                r->move[at + (size_t)j] + q[j] - r->data->q[at + (size_t)j];
    }
}

/* bias[terms]: expectation of the candidate's projected gradient E'u over the noise, with its
 * columns in p->scratch.E.  The noise of observation k enters u_k with the weight 1 - 1/n - (Z
 * Z')_kk, and the columns of its row with their derivative. */
static void self_gradient(double *bias, mukca_projector *p, const mukca_candidate *h,
                          mukca_recording *moved, const mukca_candidate *there)
{
    const mukca_regression *m = p->m;
    const mukca_recording *r = &m->recording;
    const int d = r->dim, n = p->n, terms = h->terms;
    const double sigma = 1 / sqrt(p->precision);
    memset(bias, 0, sizeof *bias * (size_t)terms);
    for (int c = 0; c < 3; c++) {
        move_tips(moved, m, c, sigma);
        mukca_candidate_fill(there, moved);
        mukca_linearisation_columns(p->scratch.W, terms, &m->linear, r, there);
        for (int g = 0; g < r->n_groups; g++)
            for (int i = r->groups[g].start;
                 r->groups[g].socket >= 0 && i < r->groups[g].start + r->groups[g].count; i++) {
                const double *z = p->Zt + (size_t)(i * d + c) * (size_t)n;
                const int at = (i * d + c) * terms;
                double weight = p->precision * (1 - 1.0 / r->groups[g].count);
                for (int k = 0; k < n; k++) weight -= z[k] * z[k];
                /* y is minus the predicted tip: the sign of its noise is opposite */
                for (int t = 0; t < terms; t++)
                    bias[t] -=
                        (p->scratch.W[at + t] - p->scratch.E[at + t]) * sign_of(i) * sigma * weight;
            }
    }
}

double mukca_angle_noise_gain(mukca_projector *p, const mukca_candidate *h)
{
    const mukca_regression *m = p->m;
    const int terms = h->terms, rows = m->recording.data->n_rows;
    const size_t values = (size_t)rows * (size_t)m->recording.chain->n_joints;
    double G[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], g[MUKCA_MAX_COLUMNS];
    double copy[MUKCA_MAX_COLUMNS * MUKCA_MAX_COLUMNS], gradient[MUKCA_MAX_COLUMNS];
    double bias[MUKCA_MAX_COLUMNS];
    mukca_pool pool = {0};
    mukca_dataset data = *m->recording.data;
    mukca_recording moved = m->recording;
    mukca_candidate there = *h;
    data.q = MUKCA_TAKE(&pool, double, values);
    moved.data = &data;
    moved.move = MUKCA_TAKE(&pool, double, values);
    there.basis = MUKCA_TAKE(&pool, float, (size_t)(rows * terms * h->width_of_term));
    double gain = 0;
    if (!pool.failed && h->basis) {
        memcpy(data.q, m->recording.data->q, sizeof *data.q * values);
        memcpy(moved.move, m->recording.move, sizeof *data.q * values);
        mukca_linearisation_columns(p->scratch.E, terms, &m->linear, &m->recording, h);
        mukca_projector_rows(p);
        self_gradient(bias, p, h, &moved, &there);
        mukca_projector_project(G, g, p, terms, h);
        memcpy(copy, G, sizeof *G * (size_t)(terms * terms));
        memcpy(gradient, g, sizeof *g * (size_t)terms);
        gain = mukca_bayes_factor_average(copy, gradient, h, p->residual, p->normal->dof, NULL);
        /* noise is what the candidate leaves unexplained: the gain in fit is at least that of the
         * score */
        const double left = exp(-2 * fmax(gain, 0) / p->normal->dof);
        for (int t = 0; t < terms; t++) g[t] -= left * bias[t];
        gain -= mukca_bayes_factor_average(G, g, h, p->residual, p->normal->dof, NULL);
    }
    mukca_pool_free(&pool);
    return gain;
}
