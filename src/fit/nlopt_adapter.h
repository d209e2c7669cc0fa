/* SLSQP and LBFGS of the NLopt library.  Not part of the core library. */
#ifndef MUKCA_FIT_NLOPT_ADAPTER_H
#define MUKCA_FIT_NLOPT_ADAPTER_H

#include <stdbool.h>

#include "fit/stop.h"
#include "mukca/status.h"

typedef enum { MUKCA_NLOPT_SLSQP, MUKCA_NLOPT_LBFGS } mukca_nlopt_method;

/* A function to minimise; variables and values of order one. */
typedef struct {
    /* Value at y[n], and gradient[n] unless NULL; sets *halt: stop here. */
    double (*value)(void *context, double *gradient, const double *y, bool *halt);
    void *context;
    int n, max_evaluations;
    double max_seconds;
} mukca_nlopt_problem;

/* Minimise from y[n] (in/out).  `stop` is one of TOLERANCE, LIMIT, FAILED, or STOPPED by `halt`.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_nlopt_minimise(double *y, mukca_stop *stop, const mukca_nlopt_problem *problem,
                                  mukca_nlopt_method method, mukca_error *error);

#endif
