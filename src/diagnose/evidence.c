/* Evidence of the linearised model and its fit: noise, AR(1) and prior scales by evidence. */
#include <math.h>
#include <string.h>

#include "diagnose/model.h"
#include "math/dense.h"
#include "math/stats.h"

const double gap_rho[GAP_RHOS] = {0.0, 0.25, 0.5};

/* Prior sigma of a joint's zero, rad: real arms are off by up to 15 mrad. */
#define ZERO_SIGMA 20e-3
/* Of a factor common to all lengths: without it a wrong distance of the sockets would be told from
 * the arm's size by the priors of single lengths, which know little of their sum. */
#define SCALE_SIGMA 2e-3
/* Of the ball's place on the tool, m, which nobody measures. */
#define TIP_SIGMA 20e-3

static const double angle_scales[] = {0.1e-3, 0.3e-3, 1e-3, 3e-3, 10e-3};
static const double socket_scales[] = {0.2e-3, 1e-3, 5e-3, 20e-3};
static const double ball_scales[] = {0.05e-3, 0.2e-3, 1e-3};

int gap_scales(const double **scales, const gap_hypothesis *h)
{
    switch (h->kind) {
        case GAP_STEP:
        case GAP_CREEP:
        case GAP_SPIKE:
        case GAP_DISTANCE:
            *scales = socket_scales;
            return (int)(sizeof socket_scales / sizeof *socket_scales);
        default:
            break;
    }
    if (h->kind == GAP_EFFECT && h->effect.kind == MUKCA_EFFECT_BALL_SHIFT) {
        *scales = ball_scales;
        return (int)(sizeof ball_scales / sizeof *ball_scales);
    }
    *scales = angle_scales;
    return (int)(sizeof angle_scales / sizeof *angle_scales);
}

void gap_model_pack(gap_pack *pack, const gap_model *m, double rho)
{
    const int d = m->dim, size = m->n_columns + 1;
    const double r1 = sqrt(1 - rho * rho);
    double *mean = m->work; /* [size] per component and group is enough: see below */
    pack->rho = rho;
    pack->log_det = 0;
    pack->dof = 0;
    memset(pack->distance, 0, sizeof *pack->distance * (size_t)(m->n_pairs * size));
    for (int p = 0; p < m->n_pairs; p++) {
        pack->variance[p] = 0;
        memcpy(pack->distance + p * size, m->direct + p * size, sizeof *mean * (size_t)size);
        pack->distance[p * size + size - 1] = m->pairs[p].distance;
    }
    for (int g = 0; g < m->n_groups; g++) {
        const gap_group *group = &m->groups[g];
        const int n = group->count;
        if (!n) continue;
        const double *X = m->columns + (size_t)(group->start * d) * (size_t)size;
        double *W = pack->white + (size_t)(group->start * d) * (size_t)size;
        double weights = 0; /* o'o of the whitened ones */
        for (int i = 0; i < n; i++) {
            const double w = m->weight ? m->weight[m->order[group->start + i]] : 1;
            const double own = i ? 1 / r1 : 1, before = i ? rho / r1 : 0;
            const double one = (own - before) * w;
            weights += one * one;
            for (int c = 0; c < d; c++) {
                const double *x = X + (size_t)(i * d + c) * (size_t)size;
                double *out = W + (size_t)(i * d + c) * (size_t)size;
                if (i && rho > 0) {
                    const double *last = x - (size_t)d * (size_t)size;
                    for (int k = 0; k < size; k++) out[k] = w * (own * x[k] - before * last[k]);
                } else {
                    for (int k = 0; k < size; k++) out[k] = w * x[k];
                }
            }
        }
        pack->log_det -= 0.5 * d * (n - 1) * log(1 - rho * rho);
        pack->dof += d * n;
        if (group->socket < 0) continue;
        pack->dof -= 3;
        pack->log_det -= 0.5 * 3 * log(weights);
        for (int c = 0; c < 3; c++) {
            memset(mean, 0, sizeof *mean * (size_t)size);
            for (int i = 0; i < n; i++) {
                const double w = m->weight ? m->weight[m->order[group->start + i]] : 1;
                const double one = w * (i ? (1 - rho) / r1 : 1) / weights;
                const double *out = W + (size_t)(i * d + c) * (size_t)size;
                for (int k = 0; k < size; k++) mean[k] += one * out[k];
            }
            for (int i = 0; i < n; i++) {
                const double w = m->weight ? m->weight[m->order[group->start + i]] : 1;
                const double one = w * (i ? (1 - rho) / r1 : 1);
                double *out = W + (size_t)(i * d + c) * (size_t)size;
                for (int k = 0; k < size; k++) out[k] -= one * mean[k];
            }
            for (int p = 0; p < m->n_pairs; p++) {
                const gap_pair *pair = &m->pairs[p];
                if (pair->a != g && pair->b != g) continue;
                const double sign = pair->a == g ? pair->direction[c] : -pair->direction[c];
                for (int k = 0; k < size; k++) pack->distance[p * size + k] += sign * mean[k];
                if (c == 0) pack->variance[p] += 1 / weights;
            }
        }
    }
    memset(pack->gram, 0, sizeof *pack->gram * (size_t)(size * size));
    mukca_dense_syrk(pack->gram, size, pack->white, m->n * d, size);
}

double gap_model_evidence(gap_model *m, const gap_pack *pack, const double *prior, double sigma,
                          double *mean)
{
    const int n = m->n_columns, size = n + 1;
    const double precision = 1 / (sigma * sigma);
    const double sd2 = m->options.distance_sigma * m->options.distance_sigma;
    double *L = m->posterior_chol, *z = m->work; /* L[n][n], z[n] */
    double quadratic = precision * pack->gram[size * size - 1], log_variance = 0, log_diagonal = 0;

    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] = precision * pack->gram[i * size + j];
        z[i] = precision * pack->gram[n * size + i];
    }
    for (int p = 0; p < m->n_pairs; p++) {
        const double *row = pack->distance + p * size;
        const double variance = sd2 + sigma * sigma * pack->variance[p], inverse = 1 / variance;
        quadratic += inverse * row[n] * row[n];
        log_variance += log(variance);
        for (int i = 0; i < n; i++) {
            z[i] += inverse * row[i] * row[n];
            for (int j = 0; j <= i; j++) L[i * n + j] += inverse * row[i] * row[j];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) L[i * n + j] *= prior[i] * prior[j];
        L[i * n + i] += 1;
        z[i] *= prior[i];
    }
    if (mukca_dense_cholesky(L, n)) return -HUGE_VAL;
    mukca_dense_forward(z, 1, L, n);
    for (int i = 0; i < n; i++) {
        quadratic -= z[i] * z[i];
        log_diagonal += log(L[i * n + i]);
    }
    m->quadratic = quadratic;
    if (mean) {
        memcpy(mean, z, sizeof *mean * (size_t)n);
        mukca_dense_backward(mean, 1, L, n);
        for (int i = 0; i < n; i++) mean[i] *= prior[i];
    }
    return -0.5 * quadratic - log_diagonal - pack->dof * log(sigma) - 0.5 * log_variance +
           pack->log_det;
}

double gap_model_standard_error(gap_model *m, int column, const double *direction, int terms)
{
    const int n = m->n_columns;
    double *x = m->work, variance = 0;
    memset(x, 0, sizeof *x * (size_t)n);
    for (int t = 0; t < terms; t++) x[column + t] = direction[t] * m->prior[column + t];
    mukca_dense_forward(x, 1, m->posterior_chol, n);
    for (int i = 0; i < n; i++) variance += x[i] * x[i];
    return sqrt(variance);
}

typedef struct {
    gap_model *m;
    const gap_pack *pack;
    const double *prior;
} sigma_context;

static double minus_evidence(void *context, double log_sigma)
{
    const sigma_context *c = context;
    return -gap_model_evidence(c->m, c->pack, c->prior, exp(log_sigma), NULL);
}

double gap_model_best_sigma(gap_model *m, const gap_pack *pack, const double *prior, double *value)
{
    sigma_context context = {m, pack, prior};
    double best, lo = log(m->sigma / 2), hi = log(2 * m->sigma);
    double x = mukca_stats_minimize(&best, minus_evidence, &context, lo, hi, 0.01);
    if (x < lo + 0.05 || x > hi - 0.05) /* the last noise was no guide: look everywhere */
        x = mukca_stats_minimize(&best, minus_evidence, &context, log(1e-6), log(5e-2), 0.01);
    if (value) *value = -best;
    return exp(x);
}

static void geometry_prior(gap_model *m)
{
    for (int k = 0; k < m->n_slots; k++) {
        const mukca_element *element = &m->chain->element[m->slot_element[k]];
        double *sigma = m->theta_sigma + 6 * k;
        const int width = k + 1 < m->n_slots ? 6 : m->slot_width;
        const bool tip = element->joint < 0;
        for (int a = 0; a < 3; a++) {
            sigma[a] = tip ? (m->options.free_tool ? 1.0 : TIP_SIGMA) : m->sigma_length;
            if (width < 6) continue;
            const double along = element->axis[a] * element->axis[a];
            sigma[3 + a] = tip ? (m->options.free_tool ? 3.0 : m->sigma_angle)
                               : sqrt(m->sigma_angle * m->sigma_angle * (1 - along) +
                                      ZERO_SIGMA * ZERO_SIGMA * along);
        }
    }
    m->theta_sigma[6 * (m->n_slots - 1) + m->slot_width] = SCALE_SIGMA;
    if (m->options.free_base)
        for (int a = 0; a < 6; a++) m->theta_sigma[m->n_geometry - 6 + a] = a < 3 ? 1.0 : 3.0;
}

int gap_model_prior(double *prior, const gap_model *m, int without)
{
    int n = m->n_geometry;
    memcpy(prior, m->theta_sigma, sizeof *prior * (size_t)n);
    for (int c = 0; c < m->n_causes; c++) {
        if (c == without) continue;
        const gap_cause *cause = &m->cause[c];
        for (int t = 0; t < cause->hypothesis.terms; t++)
            prior[n++] = cause->scale / cause->hypothesis.unit[t];
    }
    return n;
}

/* Prior scales by evidence: the geometry's two, then each cause's, one at a time. */
static void choose_scales(gap_model *m, const gap_pack *pack, double *prior)
{
    static const double lengths[] = {0.5e-3, 1e-3, 2e-3, 4e-3};
    static const double angles[] = {1e-3, 2.5e-3, 5e-3, 10e-3};
    double best = -HUGE_VAL, length = m->sigma_length, angle = m->sigma_angle;
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < 4; b++) {
            m->sigma_length = lengths[a], m->sigma_angle = angles[b];
            geometry_prior(m);
            gap_model_prior(prior, m, -1);
            const double value = gap_model_evidence(m, pack, prior, m->sigma, NULL);
            if (value > best) best = value, length = lengths[a], angle = angles[b];
        }
    m->sigma_length = length, m->sigma_angle = angle;
    geometry_prior(m);
    for (int c = 0; c < m->n_causes; c++) {
        const double *scales;
        const int n = gap_scales(&scales, &m->cause[c].hypothesis);
        double chosen = m->cause[c].scale;
        best = -HUGE_VAL;
        for (int i = 0; i < n; i++) {
            m->cause[c].scale = scales[i];
            gap_model_prior(prior, m, -1);
            const double value = gap_model_evidence(m, pack, prior, m->sigma, NULL);
            if (value > best) best = value, chosen = scales[i];
        }
        m->cause[c].scale = chosen;
    }
}

/* Orientation rows are weighted so that their noise equals the positions'. */
static void weigh_rotations(gap_model *m, const double *mean)
{
    double length = 0, angle = 0;
    const int size = m->n_columns + 1;
    for (int i = 0; i < m->n * 6; i++) {
        const double *x = m->columns + (size_t)i * (size_t)size;
        double residual = x[size - 1];
        for (int k = 0; k < size - 1; k++) residual -= x[k] * mean[k];
        if (i % 6 < 3)
            length += residual * residual;
        else
            angle += residual * residual;
    }
    if (angle > 0 && length > 0)
        m->rotation_weight = fmin(fmax(m->rotation_weight * sqrt(length / angle), 1e-2), 1e2);
}

void gap_model_fit(gap_model *m, int iterations, gap_freedom freedom)
{
    double *prior = m->prior, *mean = m->mean;
    geometry_prior(m);
    for (int it = 0; it < iterations; it++) {
        gap_model_linearise(m);
        const gap_pack *pack = &m->pack[0];
        gap_model_prior(prior, m, -1);
        /* Orientation rows get their weight on the way, so the noise must follow. */
        const bool again = it == 2 || (m->dim == 6 && !m->n_causes);
        if (it == 0 ? freedom != GAP_FIXED : again && freedom == GAP_FREE) {
            double best = -HUGE_VAL;
            for (int i = 0; i < GAP_RHOS; i++) {
                double value;
                if (m->weight && i) break; /* robust weights go with independent rows only */
                gap_model_pack(&m->pack[i], m, gap_rho[i]);
                const double sigma = gap_model_best_sigma(m, &m->pack[i], prior, &value);
                if (value > best) {
                    best = value, m->sigma = sigma, m->rho = gap_rho[i];
                    pack = &m->pack[i];
                }
            }
            if (freedom == GAP_FREE) {
                choose_scales(m, pack, prior);
                gap_model_prior(prior, m, -1);
                m->sigma = gap_model_best_sigma(m, pack, prior, NULL);
            }
        } else {
            for (int i = 0; i < GAP_RHOS; i++)
                if (gap_rho[i] == m->rho) pack = &m->pack[i];
            gap_model_pack(&m->pack[pack - m->pack], m, m->rho);
        }
        m->log_evidence = gap_model_evidence(m, pack, prior, m->sigma, mean);
        if (!isfinite(m->log_evidence)) break;
        if (m->dim == 6 && !m->n_causes && it + 1 < iterations) weigh_rotations(m, mean);
        double step = 0;
        for (int k = 0; k < m->n_geometry; k++) {
            step = fmax(step, fabs(mean[k] - m->theta[k]));
            m->theta[k] = mean[k];
        }
        if (m->options.free_base) { /* fold the tracker's frame away */
            double *t = m->theta + m->n_geometry - 6;
            mukca_frame local = {{0}, {t[0], t[1], t[2]}};
            mukca_rotation_exp(local.R, t + 3);
            mukca_frame_multiply(&m->tracker, &m->tracker, &local);
            memset(t, 0, 6 * sizeof *t);
        }
        int at = m->n_geometry;
        for (int c = 0; c < m->n_causes; c++)
            for (int t = 0; t < m->cause[c].hypothesis.terms; t++)
                m->cause[c].coefficient[t] = mean[at++];
        if (step < 1e-7 && it >= 1) break;
    }
    gap_model_linearise(m);
}
