/* Lag between joint angles and poses: the minimum of the cost of fits to shifted angles. */
#include <stdlib.h>
#include <string.h>

#include "model/dataset_subset.h"
#include "recalibrate/recalibrate.h"

/* Samples that are enough for a lag, evenly spread; the most times that its parabola is renewed. */
enum { LAG_PART = 2000, ROUNDS = 4 };

/* Least distance from zero, in standard errors: rows that are correlated count as independent in
 * these.  Largest part of the cost that is left: 5 % of the error; outliers alone do not do that.
 */
static const double least_score = 8, most_left = 0.9;

/* Shift of the tip between the fits that define a parabola, m. */
static const double probe = 1e-4;

/* Root mean square velocity of the tip by its joints, m per unit of time. */
static double tip_velocity(const mukca_chain *chain, const mukca_dataset *log)
{
    const double step = 1e-6; /* of a forward difference, s or rows */
    double squares = 0;
    mukca_geometry g;
    mukca_geometry_set(&g, chain, NULL);
    for (int i = 0; i < log->n_rows; i++) {
        double a[3], b[3], q[MUKCA_MAX_JOINTS];
        const double *at = log->q + i * log->n_joints, *v = log->velocity + i * log->n_joints;
        for (int j = 0; j < log->n_joints; j++) q[j] = at[j] + step * v[j];
        mukca_fk_position(a, &g, at, NULL);
        mukca_fk_position(b, &g, q, NULL);
        squares += pow(mukca_distance3(a, b) / step, 2);
    }
    return sqrt(squares / log->n_rows);
}

/* Fits to a part of a log, whose angles are `now` later than recorded. */
typedef struct {
    const mukca_chain *chain;
    const mukca_fit_options *options;
    mukca_dataset part;
    double now;
    mukca_fit fit;
} shifted;

/* Cost with the angles `lag` later. */
static mukca_status cost_at(double *cost, shifted *s, double lag, mukca_error *error)
{
    double start[MUKCA_MAX_FREE];
    mukca_fit_options warm = *s->options;
    memcpy(start, s->fit.theta, sizeof start);
    if (s->fit.parameters.n) warm.start = start;
    mukca_pose_log_shift(&s->part, lag - s->now);
    s->now = lag;
    const mukca_status status = mukca_fit_run(&s->fit, s->chain, &s->part, &warm, error);
    *cost = s->fit.calibrated.total;
    return status;
}

mukca_status mukca_lag_find(double *lag, double *score, const mukca_chain *chain,
                            const mukca_dataset *log, const mukca_fit_options *options,
                            mukca_error *error)
{
    shifted *s = calloc(1, sizeof *s);
    double at = 0, cost[3], first = 0;
    if (!s) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the lag");
    s->chain = chain;
    s->options = options;
    *lag = *score = 0;
    mukca_status status = mukca_part_take(&s->part, log, LAG_PART, error);
    const double velocity = status == MUKCA_OK ? tip_velocity(chain, &s->part) : 0;
    const double step = probe / velocity;
    for (int round = 0; round < ROUNDS && velocity > 0; round++) {
        for (int k = 0; k < 3 && status == MUKCA_OK; k++)
            status = cost_at(&cost[k], s, at + (k - 1) * step, error);
        if (status != MUKCA_OK) break;
        const double bend = cost[0] - 2 * cost[1] + cost[2], slope = (cost[2] - cost[0]) / 2;
        const int spare = s->fit.n_measured - s->fit.parameters.n;
        if (!(bend > 0) || spare <= 0) break;
        if (round == 0) first = cost[1];
        const double left = fmax(cost[1] - slope * slope / (2 * bend), 1e-6 * first);
        *score = fmax(*score, sqrt(fmax(first - left, 0) / left * spare));
        if (!(*score > least_score && left < most_left * first)) break;
        at -= step * slope / bend;
        *lag = at;
        if (fabs(slope / bend) < 0.1) break; /* a hundredth of a millimetre */
    }
    mukca_dataset_free(&s->part);
    free(s);
    return status;
}
