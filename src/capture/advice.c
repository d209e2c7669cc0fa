/* Advice while recording: a Bayesian calibration after each sample, and the gain by further
 * samples. */
#include <math.h>
#include <string.h>

#include "base/pool.h"
#include "capture/capture.h"
#include "fit/evaluate.h"
#include "fit/poses.h"
#include "math/dense.h"
#include "math/random.h"

/* Postures for the mean error (known to a few %), Gauss-Newton steps (enough from errors of mm),
 * pairs of sockets, and number of further samples considered. */
enum { PROBES = 32, ITERATIONS = 4, MORE_ROWS = 10, RIGID = 6 };

/* Samples required of each of two labels before they count as one socket: two samples may coincide
 * by chance. */
enum { LEAST_TWINS = 3 };

/* Prior of the noise, m (repeatability of a printed socket: 0.1 to 0.2 mm), and its weight in
 * measurements. */
static const double prior_noise = 1.5e-4, prior_weight = 10;

double mukca_capture_expected_offset(const mukca_capture *capture, int socket, const double *q,
                                     int without)
{
    const mukca_dataset *rows = &capture->rows;
    double J[3 * MUKCA_MAX_FREE], mean[3 * MUKCA_MAX_FREE] = {0};
    const int n = capture->model.parameters.n;
    int count = 0;
    for (int i = 0; i < rows->n_rows; i++) {
        if (rows->socket[i] != socket || i == without) continue;
        mukca_linearisation_tip(J, n, NULL, &capture->model, rows->q + i * rows->n_joints);
        for (int k = 0; k < 3 * n; k++) mean[k] += J[k];
        count++;
    }
    if (!count) return HUGE_VAL;
    mukca_linearisation_tip(J, n, NULL, &capture->model, q);
    double sum = 3 * capture->noise * capture->noise * (1 + 1. / count);
    for (int k = 0; k < 3 * n; k++) J[k] -= mean[k] / count;
    for (int k = 0; k < 3; k++) sum += mukca_posterior_variance(capture->factor, J + k * n, n);
    return sqrt(sum);
}

/* Expected rms error over random configurations, from the Cholesky factor `factor` of the
 * parameters' information.  Rigid motions of the base are no error and are projected out. */
static double expected_error(const mukca_capture *capture, const double *factor, double *A)
{
    const mukca_chain *chain = capture->chain;
    const int n = capture->model.parameters.n, m = 3 * PROBES;
    const int width = RIGID + n;
    double q[MUKCA_MAX_JOINTS];
    mukca_random random;
    mukca_random_seed(&random, 1);
    for (int i = 0; i < PROBES; i++) {
        double x[3], *rows = A + 3 * i * width; /* rigid motions, then parameters */
        for (int j = 0; j < chain->n_joints; j++) {
            const mukca_element *e = &chain->element[chain->joint_element[j]];
            double low = fmax(e->lower, e->type == MUKCA_PRISMATIC ? -1 : -M_PI);
            double high = fmin(e->upper, e->type == MUKCA_PRISMATIC ? 1 : M_PI);
            q[j] = low + (high - low) * (0.1 + 0.8 * mukca_random_uniform(&random));
        }
        mukca_linearisation_tip(rows + RIGID, width, x, &capture->model, q);
        for (int k = 0; k < 3; k++)
            for (int a = 0; a < 3; a++) {
                rows[a * width + k] = a == k;
                rows[a * width + 3 + k] = a == k             ? 0
                                          : a == (k + 1) % 3 ? -x[3 - a - k]
                                                             : x[3 - a - k];
            }
    }
    mukca_dense_project(A, m, width, 0, RIGID);
    double sum = 0;
    for (int k = 0; k < m; k++) sum += mukca_posterior_variance(factor, A + k * width + RIGID, n);
    return sqrt(sum / PROBES);
}

/* Known distances: between all sockets of a placement. */
static int list_distances(mukca_distance *out, const mukca_capture *capture)
{
    const mukca_socket *sockets = capture->rows.sockets;
    int n = 0;
    for (int a = 0; a < capture->rows.n_sockets; a++)
        for (int b = a + 1; b < capture->rows.n_sockets; b++)
            if (sockets[a].placement == sockets[b].placement)
                out[n++] = (mukca_distance){a, b, capture->settings.distance};
    return n;
}

/* Remove the distance of two labels that appear to be one socket; apart[n_distances]: scratch. */
static mukca_status drop_coincident(mukca_dataset *view, double *apart,
                                    const mukca_capture *capture, mukca_error *error)
{
    int kept = 0;
    if (mukca_coincide_find(apart, capture->chain, capture->start, view) < 0)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    for (int k = 0; k < view->n_distances; k++) {
        const mukca_distance d = view->distances[k];
        const bool enough = mukca_capture_count(capture, d.a) >= LEAST_TWINS &&
                            mukca_capture_count(capture, d.b) >= LEAST_TWINS;
        if (isnan(apart[k]) || !enough) view->distances[kept++] = d;
    }
    view->n_distances = kept;
    return MUKCA_OK;
}

/* Memory of one update: n parameters, m residuals. */
typedef struct {
    mukca_observations observations;
    int n, m;
    double *J, *r;            /* [max(m, 3 PROBES)][n + RIGID], [m] */
    double *gram, *part;      /* [n][n] */
    double *x, *start, *step; /* [n] */
    mukca_pool pool;
} workspace;

static mukca_status workspace_take(workspace *w, const mukca_capture *capture,
                                   const mukca_dataset *rows, mukca_error *error)
{
    const int n = capture->model.parameters.n;
    memset(w, 0, sizeof *w);
    mukca_observe_setup(&w->observations, &w->pool, capture->chain, rows, n);
    const int m = w->observations.n_residuals;
    w->n = n;
    w->m = m;
    w->J = MUKCA_TAKE(&w->pool, double, (m > 3 * PROBES ? m : 3 * PROBES) * (n + RIGID));
    w->r = MUKCA_TAKE(&w->pool, double, m);
    w->gram = MUKCA_TAKE(&w->pool, double, n *n);
    w->part = MUKCA_TAKE(&w->pool, double, n *n);
    w->x = MUKCA_TAKE(&w->pool, double, n);
    w->start = MUKCA_TAKE(&w->pool, double, n);
    w->step = MUKCA_TAKE(&w->pool, double, n);
    return w->pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}

/* Update the noise from the residuals, its prior and the effective number of parameters. */
static void update_noise(mukca_capture *capture, workspace *w)
{
    double squares = 0, taken = 0;
    const int n = w->n;
    for (int i = 0; i < w->m; i++) squares += w->r[i] * w->r[i];
    memcpy(w->part, w->gram, (size_t)(n * n) * sizeof *w->part); /* trace of C gram / noise^2 */
    mukca_dense_forward(w->part, n, capture->factor, n);
    mukca_dense_backward(w->part, n, capture->factor, n);
    for (int i = 0; i < n; i++) taken += w->part[i * n + i] / (capture->noise * capture->noise);
    const double freedom = fmax(w->observations.n_measured - taken, 0);
    capture->noise =
        sqrt((prior_weight * prior_noise * prior_noise + squares) / (prior_weight + freedom));
}

/* Gauss-Newton on the posterior: updates the model, its factor and the noise. */
static void fit(mukca_capture *capture, workspace *w)
{
    const mukca_parameters *p = &capture->model.parameters;
    const int n = w->n;
    double theta[MUKCA_MAX_FREE];
    memcpy(theta, capture->start, sizeof theta);
    mukca_parameters_pack(w->start, p, theta);
    memcpy(w->x, w->start, (size_t)n * sizeof *w->x);
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        mukca_parameters_unpack(theta, p, w->x);
        mukca_observe_residuals(w->r, w->J, &w->observations, theta, p, MUKCA_GRADIENT_ANALYTIC);
        memset(w->gram, 0, (size_t)(n * n) * sizeof *w->gram);
        mukca_dense_syrk(w->gram, n, w->J, w->m, n);
        if (iteration) update_noise(capture, w);
        mukca_posterior_factor(capture->factor, w->gram, capture->sigma, capture->noise, n);
        for (int i = 0; i < n; i++)
            w->step[i] = (w->start[i] - w->x[i]) / (capture->sigma[i] * capture->sigma[i]);
        for (int k = 0; k < w->m; k++)
            for (int i = 0; i < n; i++)
                w->step[i] -= w->J[k * n + i] * w->r[k] / (capture->noise * capture->noise);
        mukca_dense_forward(w->step, 1, capture->factor, n);
        mukca_dense_backward(w->step, 1, capture->factor, n);
        for (int i = 0; i < n; i++) w->x[i] += w->step[i];
    }
    mukca_parameters_unpack(theta, p, w->x);
    mukca_linearisation_move(&capture->model, theta);
}

mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error)
{
    const int n = capture->model.parameters.n, here = mukca_capture_count(capture, capture->socket);
    mukca_dataset view = capture->rows; /* with distances; owns no memory */
    const int pairs = view.n_sockets * view.n_sockets / 2;
    mukca_pool pool = {0};
    workspace w = {.n = 0};
    *advice = (mukca_capture_advice){(double)NAN, (double)NAN, true};
    mukca_linearisation_move(&capture->model, capture->start);
    capture->noise = prior_noise;
    memset(capture->factor, 0, (size_t)(n * n) * sizeof *capture->factor);
    mukca_posterior_factor(capture->factor, capture->factor, capture->sigma, capture->noise, n);
    if (!view.n_rows) return MUKCA_OK;
    view.distances = MUKCA_TAKE(&pool, mukca_distance, pairs);
    double *apart = MUKCA_TAKE(&pool, double, pairs);
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    if (status == MUKCA_OK) {
        view.n_distances = list_distances(view.distances, capture);
        status = drop_coincident(&view, apart, capture, error);
    }
    if (status == MUKCA_OK) status = workspace_take(&w, capture, &view, error);
    if (status != MUKCA_OK) goto out;
    fit(capture, &w);
    /* ten more samples here add ten times the mean information of the present ones */
    memset(w.part, 0, (size_t)(n * n) * sizeof *w.part);
    for (int i = 0; i < view.n_rows && here; i++)
        if (view.socket[i] == capture->socket) mukca_dense_syrk(w.part, n, w.J + 3 * i * n, 3, n);
    for (int i = 0; i < n * n && here; i++) w.gram[i] += w.part[i] * MORE_ROWS / here;
    advice->expected = expected_error(capture, capture->factor, w.J);
    mukca_posterior_factor(w.part, w.gram, capture->sigma, capture->noise, n);
    advice->expected_more = expected_error(capture, w.part, w.J);
    advice->more_rows_help =
        here < 3 || advice->expected - advice->expected_more > 0.03 * advice->expected;
out:
    mukca_pool_free(&w.pool);
    mukca_pool_free(&pool);
    return status;
}
