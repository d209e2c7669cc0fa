/* The model so far: a Bayesian calibration after each row, and what more rows would bring. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "capture/capture.h"
#include "fit/observe.h"
#include "math/dense.h"
#include "math/random.h"

enum { PROBES = 32, ITERATIONS = 4, MAX_PAIRS = 4096, MORE_ROWS = 10 };

/* Prior: geometry within 3 mm and 3 mrad; noise 0.15 mm, as sure of it as ten measurements make. */
static const double prior_sigma = 3e-3, prior_noise = 1.5e-4, prior_weight = 10;

/* Derivatives of the tip by the free parameters, J[3][n]. */
static void free_jacobian(double *J, const mukca_capture *capture, const double *q)
{
    double all[3 * MUKCA_MAX_FREE], position[3];
    const mukca_parameters *p = &capture->parameters;
    int width = MUKCA_PARAMETERS * capture->chain->n_elements;
    mukca_fk_parameter_jacobian(all, position, &capture->geometry, capture->theta, q);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < p->n; i++) J[k * p->n + i] = all[k * width + p->index[i]];
}

/* a' C a with C the covariance; a[n] is spoilt. */
static double variance(const mukca_capture *capture, const double *factor, double *a)
{
    double sum = 0;
    mukca_dense_forward(a, 1, factor, capture->parameters.n);
    for (int i = 0; i < capture->parameters.n; i++) sum += a[i] * a[i];
    return sum;
}

double mukca_capture_expected_offset(const mukca_capture *capture, int socket, const double *q,
                                     int without)
{
    const mukca_dataset *rows = &capture->rows;
    double J[3 * MUKCA_MAX_FREE], other[3 * MUKCA_MAX_FREE], mean[3 * MUKCA_MAX_FREE] = {0};
    int n = capture->parameters.n, count = 0;
    for (int i = 0; i < rows->n_rows; i++) {
        if (rows->socket[i] != socket || i == without) continue;
        free_jacobian(other, capture, rows->q + i * rows->n_joints);
        for (int k = 0; k < 3 * n; k++) mean[k] += other[k];
        count++;
    }
    if (!count) return HUGE_VAL;
    free_jacobian(J, capture, q);
    double sum = 3 * capture->noise * capture->noise * (1 + 1. / count);
    for (int k = 0; k < 3 * n; k++) J[k] -= mean[k] / count;
    for (int k = 0; k < 3; k++) sum += variance(capture, capture->factor, J + k * n);
    return sqrt(sum);
}

/* Expected rms error over random configurations with the parameters' information factored in
 * `factor`: how the arm's base is placed is no error, so a rigid motion is taken out. */
static double expected_error(const mukca_capture *capture, const double *factor, double *A)
{
    const mukca_chain *chain = capture->chain;
    const int n = capture->parameters.n, m = 3 * PROBES;
    double B[6][3 * PROBES], q[MUKCA_MAX_JOINTS];
    mukca_random random;
    mukca_random_seed(&random, 1);
    memset(B, 0, sizeof B);
    for (int i = 0; i < PROBES; i++) {
        double x[3];
        for (int j = 0; j < chain->n_joints; j++) {
            const mukca_element *e = &chain->element[chain->joint_element[j]];
            double low = fmax(e->lower, e->type == MUKCA_PRISMATIC ? -1 : -M_PI);
            double high = fmin(e->upper, e->type == MUKCA_PRISMATIC ? 1 : M_PI);
            q[j] = low + (high - low) * (0.1 + 0.8 * mukca_random_uniform(&random));
        }
        free_jacobian(A + 3 * i * n, capture, q);
        mukca_fk_position(x, &capture->geometry, q, NULL);
        for (int k = 0; k < 3; k++) {
            B[k][3 * i + k] = 1;
            B[3 + k][3 * i + (k + 1) % 3] = -x[(k + 2) % 3];
            B[3 + k][3 * i + (k + 2) % 3] = x[(k + 1) % 3];
        }
    }
    for (int b = 0; b < 6; b++) { /* orthonormal, and out of the columns of A */
        double norm = 0;
        for (int c = 0; c < b; c++) {
            double dot = 0;
            for (int k = 0; k < m; k++) dot += B[b][k] * B[c][k];
            for (int k = 0; k < m; k++) B[b][k] -= dot * B[c][k];
        }
        for (int k = 0; k < m; k++) norm += B[b][k] * B[b][k];
        for (int k = 0; k < m; k++) B[b][k] *= norm > 1e-12 ? 1 / sqrt(norm) : 0;
        for (int i = 0; i < n; i++) {
            double dot = 0;
            for (int k = 0; k < m; k++) dot += B[b][k] * A[k * n + i];
            for (int k = 0; k < m; k++) A[k * n + i] -= dot * B[b][k];
        }
    }
    double sum = 0;
    for (int k = 0; k < m; k++) sum += variance(capture, factor, A + k * n);
    return sqrt(sum / PROBES);
}

/* Known distances: between all sockets of a placement. */
static int list_distances(mukca_distance *out, const mukca_capture *capture)
{
    const mukca_socket *sockets = capture->rows.sockets;
    int n = 0;
    for (int a = 0; a < capture->rows.n_sockets; a++)
        for (int b = a + 1; b < capture->rows.n_sockets && n < MAX_PAIRS; b++)
            if (sockets[a].placement == sockets[b].placement)
                out[n++] = (mukca_distance){a, b, capture->settings.distance};
    return n;
}

/* factor = Cholesky of gram / noise^2 + prior. */
static void factorise(double *factor, const double *gram, const mukca_capture *capture)
{
    int n = capture->parameters.n;
    for (int i = 0; i < n * n; i++) factor[i] = gram[i] / (capture->noise * capture->noise);
    for (int i = 0; i < n; i++) factor[i * n + i] += 1 / (prior_sigma * prior_sigma);
    mukca_dense_cholesky(factor, n); /* positive: the prior is on every parameter */
}

mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error)
{
    const mukca_parameters *p = &capture->parameters;
    const size_t n = (size_t)p->n, bytes = sizeof capture->theta;
    mukca_dataset view = capture->rows; /* with distances; owns nothing */
    mukca_observations observations;
    mukca_observe_options options = {0};
    void *memory = NULL;
    mukca_status status = MUKCA_OK;
    memset(advice, 0, sizeof *advice);
    advice->expected = advice->expected_more = (double)NAN;
    advice->more_rows_help = true;
    memcpy(capture->theta, capture->start, bytes);
    mukca_geometry_set(&capture->geometry, capture->chain, capture->theta);
    capture->noise = prior_noise;
    memset(capture->factor, 0, n * n * sizeof(double));
    if (!view.n_rows) {
        factorise(capture->factor, capture->factor, capture);
        return MUKCA_OK;
    }
    view.distances = malloc(MAX_PAIRS * sizeof *view.distances);
    if (!view.distances) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    view.n_distances = list_distances(view.distances, capture);
    size_t need = mukca_observe_setup(&observations, NULL, capture->chain, &view, &options, p->n);
    size_t most = (size_t)observations.n_residuals, probes = 3 * PROBES;
    memory = malloc(need + 64);
    double *J = malloc((most > probes ? most : probes) * (n + 1) * sizeof *J);
    double *gram = malloc((3 * n * n + 3 * n) * sizeof *gram);
    if (!memory || !J || !gram) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    void *aligned = (void *)(((uintptr_t)memory + 63) & ~(uintptr_t)63);
    mukca_observe_setup(&observations, aligned, capture->chain, &view, &options, p->n);
    const int m = observations.n_residuals;
    double *r = J + (size_t)m * n, *part = gram + n * n, *more = part + n * n;
    double *x = more + n * n, *start = x + n, *step = start + n;
    mukca_parameters_pack(start, p, capture->start);
    memcpy(x, start, n * sizeof *x);
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        mukca_parameters_unpack(capture->theta, p, x);
        mukca_observe_residuals(r, J, &observations, capture->theta, p, MUKCA_GRADIENT_ANALYTIC);
        memset(gram, 0, n * n * sizeof *gram);
        mukca_dense_syrk(gram, p->n, J, m, p->n);
        if (iteration) { /* noise: residuals, less what the parameters took up */
            double squares = 0, taken = 0;
            for (int i = 0; i < m; i++) squares += r[i] * r[i];
            memcpy(part, gram, n * n * sizeof *part); /* trace of C gram / noise^2 */
            mukca_dense_forward(part, p->n, capture->factor, p->n);
            mukca_dense_backward(part, p->n, capture->factor, p->n);
            for (size_t i = 0; i < n; i++)
                taken += part[i * n + i] / (capture->noise * capture->noise);
            double dof = fmax(observations.n_measured - taken, 0);
            capture->noise =
                sqrt((prior_weight * prior_noise * prior_noise + squares) / (prior_weight + dof));
        }
        factorise(capture->factor, gram, capture);
        for (size_t i = 0; i < n; i++) step[i] = (start[i] - x[i]) / (prior_sigma * prior_sigma);
        for (int k = 0; k < m; k++)
            for (size_t i = 0; i < n; i++)
                step[i] -= J[(size_t)k * n + i] * r[k] / (capture->noise * capture->noise);
        mukca_dense_forward(step, 1, capture->factor, p->n);
        mukca_dense_backward(step, 1, capture->factor, p->n);
        for (size_t i = 0; i < n; i++) x[i] += step[i];
    }
    mukca_parameters_unpack(capture->theta, p, x);
    mukca_geometry_set(&capture->geometry, capture->chain, capture->theta);
    int here = mukca_capture_count(capture, capture->socket);
    memcpy(part, gram, n * n * sizeof *part);
    memset(more, 0, n * n * sizeof *more);
    for (int i = 0; i < view.n_rows && here; i++)
        if (view.socket[i] == capture->socket)
            mukca_dense_syrk(more, p->n, J + 3 * (size_t)i * n, 3, p->n);
    for (size_t i = 0; i < n * n && here; i++) part[i] += more[i] * MORE_ROWS / here;
    advice->expected = expected_error(capture, capture->factor, J);
    factorise(more, part, capture);
    advice->expected_more = expected_error(capture, more, J);
    advice->more_rows_help =
        here < 3 || advice->expected - advice->expected_more > 0.03 * advice->expected;
out:
    free(gram);
    free(J);
    free(memory);
    free(view.distances);
    return status;
}
