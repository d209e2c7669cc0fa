/* The arm with its effects, approximated by a model that cannot hold them. */
#ifndef MUKCA_FIT_REFIT_H
#define MUKCA_FIT_REFIT_H

#include "arm/offsets.h"

typedef enum {
    MUKCA_REFIT_ORIGINS, /* of the joints that move */
    MUKCA_REFIT_ZEROS    /* numbers added to the joints' angles, and nothing else */
} mukca_refit_kind;

typedef struct {
    const mukca_chain *chain;
    const mukca_offsets *arm; /* origins and effects */
    const mukca_effect *held; /* [n_held] effects that the model has, too */
    int n_held;
    mukca_refit_kind kind;
    const double *postures; /* [n_postures][n_joints] where the arm works; NULL: joint ranges */
    int n_postures;
} mukca_refit_task;

typedef struct {
    double theta[MUKCA_MAX_THETA];  /* of the model; fixed elements keep the arm's */
    double zeros[MUKCA_MAX_JOINTS]; /* rad, m; 0 for MUKCA_REFIT_ORIGINS */
    /* distance of the model's tip from the arm's, m, in postures that were not fitted: */
    double mean, largest;
    double mean_before; /* of the model that merely leaves out what it cannot hold */
} mukca_refit;

/* Least squares over the tip's pose.  Effects that depend on the last move, on time, or on
 * commands take no part: a posture alone does not show them.  Errors: MUKCA_MEMORY. */
mukca_status mukca_refit_run(mukca_refit *refit, const mukca_refit_task *task, mukca_error *error);

#endif
