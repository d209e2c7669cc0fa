/* Commanded and read angles of one recording, compared before any fit. */
#include "diagnose/logs.h"

#include <math.h>

#include "math/stats.h"

/* Resolution of an encoder, rad: smaller differences are rounding. */
#define RESOLUTION 1e-5
/* Least standard deviation of the torque, N m, for an estimate of the sag (catalogue.h). */
#define LEAST_SPREAD 0.05
/* Prior sigma of a sag, rad/(N m): the middle of the effect's sizes. */
#define SAG_SIGMA 300e-6

/* Reading minus command of a joint in a row; NaN: one is missing. */
static double difference(const mukca_dataset *data, int row, int joint)
{
    const int at = row * data->n_joints + joint;
    if (data->reading) return data->reading[at] - data->q[at];
    return data->command ? data->q[at] - data->command[at] : (double)NAN;
}

static void compare_joint(mukca_stream_difference *s, const mukca_recording *r, int joint)
{
    const int n_joints = r->chain->n_joints;
    double mean = 0, load = 0, square = 0, dd = 0, tt = 0, dt = 0;
    int n = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int row = 0; row < r->data->n_rows; row++) {
            const double d = difference(r->data, row, joint);
            const double torque = r->total_torque[row * n_joints + joint];
            if (!isfinite(d)) continue;
            if (pass == 0) {
                mean += d, load += torque, square += d * d, n++;
            } else {
                dd += (d - mean) * (d - mean);
                tt += (torque - load) * (torque - load);
                dt += (d - mean) * (torque - load);
            }
        }
        if (pass == 0 && n > 0) mean /= n, load /= n;
    }
    *s = (mukca_stream_difference){n, NAN, NAN, NAN, NAN, NAN, NAN};
    if (n == 0) return;
    s->mean = mean;
    s->rms = sqrt(square / n);
    if (!r->have_torques || n < 4 || !(tt > LEAST_SPREAD * LEAST_SPREAD * n)) return;
    s->sag = -dt / tt;
    const double left = fmax((dd - dt * dt / tt) / (n - 2), RESOLUTION * RESOLUTION);
    const double error = sqrt(left / tt);
    s->low = s->sag - MUKCA_SIGMAS_95 * error, s->high = s->sag + MUKCA_SIGMAS_95 * error;
    /* Savage-Dickey density ratio: a sag with this prior against none, with noise of this variance
     */
    const double known = SAG_SIGMA * SAG_SIGMA / (error * error), z = s->sag / error;
    s->log_bayes_factor = 0.5 * (z * z * known / (1 + known) - log(1 + known));
}

void mukca_streams_compare(mukca_streams *streams, const mukca_recording *r)
{
    *streams = (mukca_streams){.sigma_reading_m = NAN, .sigma_command_m = NAN};
    if (!r->data->command && !r->data->reading) return;
    streams->n_joints = r->chain->n_joints;
    for (int j = 0; j < streams->n_joints; j++) compare_joint(&streams->joint[j], r, j);
}

static mukca_status fit(double *sigma, const mukca_recording_options *options,
                        const mukca_chain *chain, const mukca_dataset *data, mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_regression *m = MUKCA_TAKE(&pool, mukca_regression, 1);
    if (!m) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the commands");
    const mukca_status status = mukca_regression_create(m, chain, data, options, error);
    if (status == MUKCA_OK) {
        mukca_regression_fit(m, 6, MUKCA_FIT_ALL);
        *sigma = m->unknowns.sigma;
    }
    mukca_regression_free(m);
    mukca_pool_free(&pool);
    return status;
}

mukca_status mukca_streams_fit(mukca_streams *streams, const mukca_recording_options *options,
                               const mukca_chain *chain, const mukca_dataset *data,
                               mukca_error *error)
{
    double *const sigma[] = {&streams->sigma_reading_m, &streams->sigma_command_m};
    const double *second = data->by_command ? data->reading : data->command;
    const size_t count = (size_t)data->n_rows * (size_t)data->n_joints;
    mukca_pool pool = {0};
    mukca_dataset swapped = *data; /* shares the other arrays */
    if (streams->n_joints == 0 || !second) return MUKCA_OK;
    swapped.q = MUKCA_TAKE(&pool, double, count);
    if (!swapped.q)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", data->n_rows);
    for (size_t i = 0; i < count; i++) swapped.q[i] = isfinite(second[i]) ? second[i] : data->q[i];
    mukca_status status = fit(sigma[data->by_command], options, chain, data, error);
    if (status == MUKCA_OK) status = fit(sigma[!data->by_command], options, chain, &swapped, error);
    mukca_pool_free(&pool);
    return status;
}
