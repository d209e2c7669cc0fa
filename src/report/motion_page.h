/* The report of a motion: findings, torques over time, errors over angle and velocity. */
#ifndef MUKCA_REPORT_MOTION_PAGE_H
#define MUKCA_REPORT_MOTION_PAGE_H

#include "base/pool.h"
#include "motion/motion.h"
#include "report/page.h"

/* Torques of the new runs: first `n_start` samples in succession, then others, evenly spaced. */
enum { MUKCA_TRACE_MEASURED, MUKCA_TRACE_MODEL, MUKCA_TRACE_FITTED, MUKCA_TRACES };
typedef struct {
    int n, n_start, n_joints;
    double *time;                 /* [n] s, since the first run began */
    double *q, *dq;               /* [n][n_joints] */
    double *torque[MUKCA_TRACES]; /* [n][n_joints] N m: measured, of the model, with its parameters
                                     and the findings fitted */
} mukca_motion_trace;

/* Compute the torques; memory comes from `pool`.  As a mukca_motion_view.  False: no memory. */
bool mukca_motion_trace_make(mukca_motion_trace *trace, mukca_pool *pool,
                             const struct mukca_torques *torques,
                             const struct mukca_torque_columns *fitted);

/* Content of the page. */
typedef struct {
    const mukca_chain *chain;
    const mukca_motion *motion;
    const mukca_motion_trace *trace;
    mukca_plot_point *points; /* [MUKCA_TRACES * trace->n] scratch of a figure */
} mukca_motion_report;

mukca_page mukca_motion_page(const mukca_motion_report *report);

#endif
