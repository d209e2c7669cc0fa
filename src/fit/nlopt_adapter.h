/* SLSQP and LBFGS of the NLopt library.  Not part of the core library. */
#ifndef MUKCA_FIT_NLOPT_ADAPTER_H
#define MUKCA_FIT_NLOPT_ADAPTER_H

#include <stdbool.h>

#include "mukca/status.h"

/* Reasons to stop: a result, not an error. */
#define MUKCA_STOP_LIST(X)                              \
    X(GRADIENT, "the gradient vanished")                \
    X(TOLERANCE, "no further decrease within rounding") \
    X(LIMIT, "out of evaluations or time")              \
    X(NOT_FINITE, "the cost is not a finite number")    \
    X(FAILED, "the solver gave up")                     \
    X(STOPPED, "interrupted")

typedef enum {
#define MUKCA_STOP_ENUM(name, text) MUKCA_STOP_##name,
    MUKCA_STOP_LIST(MUKCA_STOP_ENUM)
#undef MUKCA_STOP_ENUM
} mukca_stop;

extern const char *const mukca_stop_text[];

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
