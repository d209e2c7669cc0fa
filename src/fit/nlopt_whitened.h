/* The table of all solvers.  Not part of the core library. */
#ifndef MUKCA_FIT_NLOPT_WHITENED_H
#define MUKCA_FIT_NLOPT_WHITENED_H

#include "fit/solver.h"

/* "slsqp" (the default), "lbfgs", "gauss-newton"; ended by NULL. */
extern const mukca_solver *const mukca_solver_table[];

#endif
