/* The numbers that the report shows, computed from the arm, the data and the results. */
#ifndef MUKCA_CLI_REPORT_PREPARE_H
#define MUKCA_CLI_REPORT_PREPARE_H

#include "base/pool.h"
#include "cli/calibrate_say.h"
#include "cli/diagnose.h"
#include "report/report.h"

/* Training and held-out rows as one dataset, in this order; the placements of `test` follow those
 * of `train`.  held_out[n_placements of both], in the pool.  Free `all` with mukca_dataset_free.
 * Errors: MUKCA_MEMORY. */
mukca_status report_join(mukca_dataset *all, unsigned char **held_out, mukca_pool *pool,
                         const mukca_dataset *train, const mukca_dataset *test, mukca_error *error);

/* Tip of each row, [n_rows][3]; in the pool, NULL when that is exhausted. */
double *report_positions(mukca_pool *pool, const mukca_model *model, const mukca_dataset *data);

/* Each row's residual (position less its socket's mean, or less the measurement) along the way that
 * the ball moves with each joint, r . J_j / |J_j|, [n_rows][n_joints], m. */
double *report_joint_errors(mukca_pool *pool, const mukca_chain *chain, const double *theta,
                            const double *positions, const mukca_dataset *data);

/* Consistency and distortion of a point of the fit. */
void report_step(mukca_report_step *step, const mukca_chain *chain, const double *theta,
                 const mukca_dataset *train, const mukca_dataset *test, mukca_score *scores);

/* Train on each placement, each pair and all of `train`, test on the rest and on `test`:
 * bars[report_bar_count(train)], in the pool.  Errors: as mukca_fit_run. */
mukca_status report_bars(mukca_report_bar **bars, int *n_bars, mukca_pool *pool, cli_call *call,
                         const mukca_chain *chain, const mukca_dataset *train,
                         const mukca_dataset *test);

#endif
