/* Residuals of the positions and the gradient of their sum of squares. */
#include "fit/observe.h"

#include <string.h>

static int rows_of_placement(const mukca_observations *o, const mukca_dataset *data, int placement)
{
    double n = 0;
    for (int s = 0; s < o->n_sockets; s++)
        n += data->sockets[s].placement == placement ? o->count[s] : 0;
    return (int)n;
}

static void load(mukca_observations *o, const mukca_dataset *data)
{
    for (int i = 0; i < o->n_rows; i++) {
        o->socket[i] = data->socket[i];
        if (o->socket[i] >= 0) o->count[o->socket[i]]++;
    }
    for (int p = 0; p < data->n_placements; p++) o->n_groups += rows_of_placement(o, data, p) > 0;
    for (int s = 0; s < o->n_sockets; s++) {
        o->socket_weight[s] = 1.0 / rows_of_placement(o, data, data->sockets[s].placement);
        if (o->count[s] > 0) o->n_measured += 3 * (int)o->count[s] - 3;
    }
    for (int i = 0; i < o->n_rows; i++)
        if (o->socket[i] >= 0) o->row_weight[i] = o->socket_weight[o->socket[i]];
    for (int d = 0; d < data->n_distances; d++) {
        const int a = data->distances[d].a, b = data->distances[d].b;
        if (!(o->count[a] > 0 && o->count[b] > 0)) continue;
        o->pair[o->n_pairs++] =
            (mukca_observed_pair){.a = a, .b = b, .distance = data->distances[d].distance};
    }
    o->n_measured += o->n_pairs;
    o->n_residuals = 3 * o->n_rows + o->n_pairs;
}

bool mukca_observe_setup(mukca_observations *o, mukca_pool *pool, const mukca_chain *chain,
                         const mukca_dataset *data)
{
    const int n = data->n_rows, sockets = data->n_sockets;
    *o = (mukca_observations){.n_rows = n, .n_sockets = sockets};
    mukca_sweep_take(&o->sweep, pool, chain, n);
    o->socket = MUKCA_TAKE(pool, int, n);
    o->row_weight = MUKCA_TAKE(pool, double, n);
    o->count = MUKCA_TAKE(pool, double, sockets);
    o->mean = MUKCA_TAKE(pool, double, 3 * sockets);
    o->socket_weight = MUKCA_TAKE(pool, double, sockets);
    o->socket_adjoint = MUKCA_TAKE(pool, double, 3 * sockets);
    o->pair = MUKCA_TAKE(pool, mukca_observed_pair, data->n_distances);
    o->residual = MUKCA_TAKE(pool, double, 3 * (n + MUKCA_SWEEP_PADDING));
    if (pool->failed) return false;

    load(o, data);
    mukca_sweep_load(&o->sweep, chain, data->q);
    return true;
}

static void predict_pairs(mukca_observations *o)
{
    for (mukca_observed_pair *p = o->pair; p < o->pair + o->n_pairs; p++) {
        const double *a = o->mean + 3 * p->a, *b = o->mean + 3 * p->b;
        double *u = p->direction;
        for (int i = 0; i < 3; i++) u[i] = a[i] - b[i];
        const double length = mukca_norm3(u);
        for (int i = 0; i < 3; i++) u[i] = length > 0 ? u[i] / length : 0;
        p->residual = length - p->distance;
    }
}

/* Store the predictions of the open window as residuals, and add them to the sums of the
 * sockets. */
static void predict_positions(mukca_observations *o)
{
    const mukca_sweep *s = &o->sweep;
    const int *socket = o->socket + s->from, padded = s->padded;
    mukca_sweep_forward(&o->sweep);
    memcpy(mukca_observe_window(o->residual, s), s->x, 3 * (size_t)padded * sizeof *s->x);
    for (int i = 0; i < s->rows; i++)
        if (socket[i] >= 0)
            for (int a = 0; a < 3; a++) o->mean[3 * socket[i] + a] += s->x[a * padded + i];
}

/* Turn the predictions of the open window into residuals. */
static void subtract(mukca_observations *o)
{
    const mukca_sweep *s = &o->sweep;
    double *residual = mukca_observe_window(o->residual, s);
    for (int i = 0; i < s->rows; i++) {
        const int row = s->from + i;
        const int at = o->socket[row];
        const double *about = at >= 0 ? o->mean + 3 * at : o->target ? o->target + 3L * row : NULL;
        for (int a = 0; a < 3; a++) {
            double *r = residual + a * s->padded + i;
            *r = about && o->row_weight[row] > 0 ? *r - about[a] : 0;
        }
    }
}

void mukca_observe_predict(mukca_observations *o, const double *theta)
{
    mukca_sweep *sweep = &o->sweep;
    o->theta = theta;
    mukca_sweep_origins(sweep, theta);
    memset(o->mean, 0, 3 * (size_t)o->n_sockets * sizeof *o->mean);
    for (int v = 0; mukca_sweep_open(sweep, v); v++) predict_positions(o);
    for (int s = 0; s < o->n_sockets; s++)
        for (int a = 0; a < 3 && o->count[s] > 0; a++) o->mean[3 * s + a] /= o->count[s];
    for (int v = 0; mukca_sweep_open(sweep, v); v++) subtract(o);
    predict_pairs(o);
}

double mukca_observe_sum(mukca_observations *o, double *residual, const double *weight)
{
    mukca_sweep *s = &o->sweep;
    double sum = 0;
    for (int v = 0; mukca_sweep_open(s, v); v++) {
        const double *r = mukca_observe_window(residual, s);
        for (int i = 0; i < s->rows; i++)
            for (int a = 0; a < 3; a++)
                sum += (weight ? weight[s->from + i] : 1) * r[a * s->padded + i] *
                       r[a * s->padded + i];
    }
    return sum;
}

double mukca_observe_squares(double *pairs, mukca_observations *o, bool weighted)
{
    if (pairs) *pairs = 0;
    for (int p = 0; pairs && p < o->n_pairs; p++)
        *pairs += o->pair[p].residual * o->pair[p].residual;
    return mukca_observe_sum(o, o->residual, weighted ? o->row_weight : NULL);
}

/* Contribution of the pairs' residuals to the adjoint of each sample of socket s. */
static void pair_adjoint(double add[3], const mukca_observations *o, int s)
{
    add[0] = add[1] = add[2] = 0;
    for (const mukca_observed_pair *p = o->pair; p < o->pair + o->n_pairs; p++) {
        const int sign = (p->a == s) - (p->b == s);
        const double f = 2 * sign * p->residual / o->count[s];
        for (int a = 0; a < 3; a++) add[a] += f * p->direction[a];
    }
}

void mukca_observe_adjoint(mukca_adjoint *adjoint, mukca_observations *o, double *residual,
                           const double *weight, double factor, const double *of_socket)
{
    mukca_sweep *s = &o->sweep;
    const double *r = mukca_observe_window(residual, s);
    double *h = s->h;
    memset(h, 0, 3 * (size_t)s->padded * sizeof *h);
    for (int i = 0; i < s->rows; i++) {
        const int row = s->from + i, at = of_socket ? o->socket[row] : -1;
        for (int a = 0; a < 3; a++)
            h[a * s->padded + i] = 2 * weight[row] * factor * r[a * s->padded + i] +
                                   (at >= 0 ? of_socket[3 * at + a] : 0);
    }
    mukca_sweep_backward(adjoint, s);
}

static void sum_adjoints(mukca_adjoint *adjoint, mukca_observations *o)
{
    for (int s = 0; s < o->n_sockets; s++) pair_adjoint(o->socket_adjoint + 3 * s, o, s);
    memset(adjoint, 0, sizeof *adjoint);
    for (int v = 0; mukca_sweep_open(&o->sweep, v); v++) {
        if (o->sweep.n_windows > 1) mukca_sweep_forward(&o->sweep); /* else still valid */
        mukca_observe_adjoint(adjoint, o, o->residual, o->row_weight, 1, o->socket_adjoint);
    }
}

void mukca_observe_gradient(double *gradient, mukca_observations *o)
{
    const mukca_parameters *parameters = o->parameters;
    mukca_adjoint adjoint;
    sum_adjoints(&adjoint, o);
    for (int i = 0; i < parameters->n;) {
        const int k = parameters->index[i] / MUKCA_PARAMETERS;
        double dR[3][9];
        mukca_sweep_element_derivative(dR, o->theta + 6 * k + 3, o->kind);
        for (; i < parameters->n && parameters->index[i] / MUKCA_PARAMETERS == k; i++) {
            const int parameter = parameters->index[i] % MUKCA_PARAMETERS;
            gradient[i] = parameter < 3 ? adjoint.sum[k][parameter] : 0;
            for (int c = 0; c < 9 && parameter >= 3; c++)
                gradient[i] += dR[parameter - 3][c] * adjoint.outer[k][c];
        }
    }
}
