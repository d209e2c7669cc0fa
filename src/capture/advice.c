/* Advice while recording: the posterior of the arm after each sample, and the gain by further
 * samples. */
#include <math.h>
#include <stdlib.h>

#include "base/pool.h"
#include "capture/capture.h"
#include "fit/evaluate.h"
#include "math/dense.h"
#include "math/random.h"

/* Postures for the mean error (known to a few %), and number of further samples considered. */
enum { PROBES = 32, MORE_ROWS = 10 };

/* Samples required of each of two labels before they count as one socket: two samples may coincide
 * by chance. */
enum { LEAST_TWINS = 3 };

/* Expected rms error over random configurations.  Rigid motions of the base are no error and are
 * projected out.  Check p->pool.failed. */
static double expected_error(mukca_arm_posterior *p)
{
    const int w = MUKCA_RIGID + p->m.linear.n_columns + 1, rows = 3 * PROBES, n = p->chain.n_joints;
    double *X = MUKCA_TAKE(&p->pool, double, rows *w), sum = 0;
    double *q = MUKCA_TAKE(&p->pool, double, PROBES *n);
    mukca_random random = mukca_random_seeded(1);
    for (int i = 0; i < PROBES && !p->pool.failed; i++)
        mukca_posture_draw(q + i * n, &p->chain, &random);
    p->pool.failed = p->pool.failed || !mukca_arm_posterior_probe(X, w, p, q, PROBES);
    if (p->pool.failed) return (double)NAN;
    mukca_dense_project(X, rows, w, 0, MUKCA_RIGID);
    for (int k = 0; k < rows; k++)
        sum += mukca_posterior_variance(X + k * w + MUKCA_RIGID, &p->m.evidence.posterior);
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

/* Advice from the posterior; with more samples like the present ones. */
static void advise(mukca_capture_advice *advice, const mukca_capture *capture,
                   mukca_arm_posterior *p)
{
    const int here = mukca_capture_count(capture, capture->socket);
    double *const weight = p->weight;
    advice->expected = expected_error(p);
    for (int more = 1; more >= -1; more -= 2) {
        for (int i = 0; i < p->data.n_rows; i++)
            if (p->data.socket[i] == capture->socket)
                weight[i] *= pow(1 + (double)MORE_ROWS / here, 0.5 * more);
        mukca_evidence_renew(&p->m.evidence);
        mukca_regression_factor(&p->m);
        if (more > 0) advice->expected_more = expected_error(p);
    }
    advice->more_rows_help =
        here < 3 || advice->expected - advice->expected_more > 0.03 * advice->expected;
}

void mukca_capture_forget(mukca_capture *capture)
{
    if (capture->posterior) mukca_arm_posterior_free(capture->posterior);
    free(capture->posterior);
    capture->posterior = NULL;
    capture->noise = MUKCA_PRIOR_NOISE;
    mukca_geometry_set(&capture->geometry, &capture->start, NULL);
}

/* Fit the posterior, which the capture keeps, and advise. */
static mukca_status renew(mukca_capture_advice *advice, mukca_capture *capture,
                          const mukca_dataset *view, mukca_error *error)
{
    const mukca_tip_change_task task = {.chain = &capture->start, .data = view};
    mukca_arm_posterior *p = capture->posterior = malloc(sizeof *p);
    if (!p) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    const mukca_status status = mukca_arm_posterior_fit(p, &task, error);
    if (status != MUKCA_OK) {
        mukca_capture_forget(capture);
        return status;
    }
    capture->noise = p->m.unknowns.sigma;
    capture->geometry = p->m.unknowns.arm.geometry;
    advise(advice, capture, p);
    return p->pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}

mukca_status mukca_capture_advise(mukca_capture_advice *advice, mukca_capture *capture,
                                  mukca_error *error)
{
    mukca_dataset view = capture->rows; /* with distances; owns no memory */
    const int pairs = view.n_sockets * view.n_sockets / 2 + 1;
    mukca_pool pool = {0};
    double *apart = MUKCA_TAKE(&pool, double, pairs);
    view.distances = MUKCA_TAKE(&pool, mukca_distance, pairs);
    *advice = (mukca_capture_advice){(double)NAN, (double)NAN, true};
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    mukca_capture_forget(capture);
    if (status == MUKCA_OK && view.n_rows > 0) {
        list_distances(&view, &capture->settings);
        status = mukca_coincide_drop(apart, &view, &capture->start, NULL, LEAST_TWINS) < 0
                     ? mukca_fail(error, MUKCA_MEMORY, "out of memory")
                     : renew(advice, capture, &view, error);
    }
    mukca_pool_free(&pool);
    return status;
}
