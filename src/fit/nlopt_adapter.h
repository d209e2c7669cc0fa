/* Solvers of the NLopt library, and the table of all solvers.  The only file that uses NLopt; not
 * part of the core library. */
#ifndef MUKCA_FIT_NLOPT_ADAPTER_H
#define MUKCA_FIT_NLOPT_ADAPTER_H

#include "fit/solver.h"

/* "slsqp" (the default), "lbfgs", "gauss-newton"; ended by NULL. */
extern const mukca_solver *const mukca_solver_table[];

#endif
