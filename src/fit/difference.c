/* Difference of the errors of two models on the same samples. */
#include "fit/difference.h"

#include <math.h>

#include "model/postures.h"

mukca_status mukca_difference_find(mukca_difference *d, const double *before, const double *after,
                                   const mukca_dataset *data, mukca_error *error)
{
    const int rows = data->n_rows;
    mukca_pool pool = {0};
    int *posture = MUKCA_TAKE(&pool, int, rows);
    double(*sum)[3] = MUKCA_TAKE(&pool, double[3], rows), squares = 0; /* before, after, number */
    *d = (mukca_difference){.sigma_m = HUGE_VAL};
    if (!pool.failed) mukca_postures_find(posture, &pool, data);
    for (int i = 0; i < rows && !pool.failed; i++) {
        if (!isfinite(before[i]) || !isfinite(after[i])) continue;
        double *of = sum[posture[i]];
        of[0] += before[i], of[1] += after[i], of[2]++;
    }
    for (int i = 0; i < rows && !pool.failed; i++) {
        if (!(sum[i][2] > 0)) continue;
        const double x = sum[i][0] / sum[i][2], y = sum[i][1] / sum[i][2];
        const double n = ++d->postures, off = y - x - d->mean_m;
        d->before_m += (x - d->before_m) / n;
        d->after_m += (y - d->after_m) / n;
        d->mean_m += off / n;
        squares += off * (y - x - d->mean_m);
    }
    if (d->postures > 1) d->sigma_m = sqrt(squares / d->postures / (d->postures - 1));
    const bool failed = pool.failed;
    mukca_pool_free(&pool);
    return failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
}
