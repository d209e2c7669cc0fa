/* Approximation of the arm with its effects by a model that cannot represent them. */
#ifndef MUKCA_FIT_REFIT_H
#define MUKCA_FIT_REFIT_H

#include "arm/offsets.h"

typedef struct {
    const mukca_chain *chain;
    const mukca_offsets *arm; /* origins and effects */
    const mukca_effect *held; /* [n_held] effects that the model can represent */
    int n_held;
    bool zeros_only; /* fit offsets of the joints' angles, not origins of the actuated joints */
    const double *postures; /* [n_postures][n_joints] working postures; NULL: joint ranges */
    int n_postures;
} mukca_refit_task;

typedef struct {
    double theta[MUKCA_MAX_THETA];  /* of the model; nominal with `zeros_only` */
    double zeros[MUKCA_MAX_JOINTS]; /* rad, m; 0 without */
    /* Distance between the tips of model and arm, m, in held-out postures. */
    double mean, largest;
    double mean_before; /* before the fit: effects merely omitted */
} mukca_refit;

/* Least squares over the tip's pose.  Effects that depend on the last move, on time or on commands
 * are ignored: they are no function of the posture.  Errors: MUKCA_MEMORY. */
mukca_status mukca_refit_run(mukca_refit *refit, const mukca_refit_task *task, mukca_error *error);

#endif
