/* Advice while recording: the posterior of the arm after each sample, and the gain by further
 * samples. */
#include <math.h>
#include <string.h>

#include "base/pool.h"
#include "capture/capture.h"
#include "fit/accept.h"
#include "fit/evaluate.h"
#include "math/dense.h"
#include "math/random.h"

/* Postures for the mean error (known to a few %), and number of further samples considered. */
enum { PROBES = 32, MORE_ROWS = 10 };

/* Samples required of each of two labels before they count as one socket: two samples may coincide
 * by chance. */
enum { LEAST_TWINS = 3 };

double mukca_capture_expected_offset(const mukca_capture *capture, int socket, const double *q,
                                     int without)
{
    const mukca_dataset *rows = &capture->rows;
    const mukca_arm_point *at = &capture->model;
    const int n = at->n, w = MUKCA_OWN + n + 1;
    double x[3 * (MUKCA_OWN + MUKCA_MAX_FREE + 1)] = {0}, mean[sizeof x / sizeof *x] = {0};
    mukca_joint_state state = {.placement = -1};
    int count = 0;
    for (int i = 0; i < rows->n_rows; i++) {
        if (rows->socket[i] != socket || i == without) continue;
        state.q = rows->q + i * rows->n_joints;
        mukca_arm_point_rows(mean, at, &at->geometry, at->theta, &state, MUKCA_OWN_SHIFT);
        count++;
    }
    if (!count) return HUGE_VAL;
    state.q = q;
    mukca_arm_point_rows(x, at, &at->geometry, at->theta, &state, MUKCA_OWN_SHIFT);
    double sum = 3 * capture->noise * capture->noise * (1 + 1. / count);
    for (int k = 0; k < 3 * w; k++) x[k] -= mean[k] / count;
    for (int k = 0; k < 3; k++)
        sum += mukca_dense_variance(x + k * w + MUKCA_OWN, capture->factor, n);
    return sqrt(sum);
}

/* Expected rms error over random configurations.  Rigid motions of the base are no error and are
 * projected out.  NaN: out of memory. */
static double expected_error(mukca_arm_posterior *p)
{
    const int w = p->groups.width, m = 3 * PROBES;
    double *X = MUKCA_TAKE(&p->pool, double, m *w), sum = 0;
    double *q = MUKCA_TAKE(&p->pool, double, PROBES * p->chain.n_joints);
    mukca_random random;
    if (p->pool.failed) return (double)NAN;
    mukca_arm_posterior_probe(X, w, q, p, &p->chain, PROBES, &random);
    mukca_dense_project(X, m, w, 0, MUKCA_OWN);
    for (int k = 0; k < m; k++)
        sum += mukca_posterior_variance(X + k * w + MUKCA_OWN, &p->groups.posterior);
    return sqrt(sum / PROBES);
}

/* Known distances: between all sockets of a placement. */
static void list_distances(mukca_dataset *view, const mukca_capture_settings *settings)
{
    for (int a = 0; a < view->n_sockets; a++)
        for (int b = a + 1; b < view->n_sockets; b++) {
            if (view->sockets[a].placement != view->sockets[b].placement) continue;
            view->distances[view->n_distances++] =
                (mukca_distance){a, b, settings->distance, settings->distance_sigma, 0};
            mukca_dataset_number_distance(view);
        }
}

/* Advice from the posterior, which the capture keeps. */
static void advise(mukca_capture_advice *advice, mukca_capture *capture, mukca_arm_posterior *p)
{
    const int here = mukca_capture_count(capture, capture->socket);
    const mukca_posterior *of = &p->groups.posterior;
    capture->noise = p->groups.noise;
    for (int i = 0; i < of->n; i++) capture->model.sigma[i] = p->at.sigma[i] * of->prior[i];
    memcpy(capture->factor, of->factor, (size_t)(of->n * of->n) * sizeof *of->factor);
    mukca_arm_point_move(&capture->model, p->at.theta);
    if (!p->n_list) return;
    advice->expected = expected_error(p);
    for (int i = 0; i < p->n_list; i++) /* more like the present ones */
        if (p->list[i].group == capture->socket) p->list[i].weight *= 1 + (double)MORE_ROWS / here;
    mukca_arm_posterior_solve(p);
    advice->expected_more = expected_error(p);
    advice->more_rows_help =
        here < 3 || advice->expected - advice->expected_more > 0.03 * advice->expected;
}

mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error)
{
    mukca_dataset view = capture->rows; /* with distances; owns no memory */
    const int pairs = view.n_sockets * view.n_sockets / 2 + 1;
    mukca_pool pool = {0};
    mukca_arm_posterior *p = MUKCA_TAKE(&pool, mukca_arm_posterior, 1);
    double *apart = MUKCA_TAKE(&pool, double, pairs);
    view.distances = MUKCA_TAKE(&pool, mukca_distance, pairs);
    *advice = (mukca_capture_advice){(double)NAN, (double)NAN, true};
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    if (status == MUKCA_OK) {
        list_distances(&view, &capture->settings);
        if (mukca_coincide_drop(apart, &view, &capture->start, NULL, LEAST_TWINS) < 0)
            status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    if (status == MUKCA_OK) {
        const mukca_tip_change_task task = {.chain = &capture->start, .data = &view};
        status = mukca_arm_posterior_fit(p, &task, error);
        if (status == MUKCA_OK) advise(advice, capture, p);
        mukca_arm_posterior_free(p);
    }
    mukca_pool_free(&pool);
    return status;
}
