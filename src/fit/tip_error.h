/* Expected error of the tip: the posterior of an offsets table, and of the model that it replaces,
 * given samples. */
#ifndef MUKCA_FIT_TIP_ERROR_H
#define MUKCA_FIT_TIP_ERROR_H

#include "arm/tip_change.h"

/* Postures of the prediction: joint ranges of the samples, joint limits. */
enum { MUKCA_HERE, MUKCA_ELSEWHERE, MUKCA_RANGES };

typedef struct {
    int postures;                                         /* different ones among the samples */
    unsigned char at_rest[MUKCA_MAX_JOINTS];              /* 1: the joint did not move */
    unsigned char stuck[MUKCA_MAX_JOINTS];                /* 1: nor did it, but the tip did */
    double before_m[MUKCA_RANGES], after_m[MUKCA_RANGES]; /* mean error of the tip */
    double low_m[MUKCA_RANGES], high_m[MUKCA_RANGES];     /* 95 % interval of after_m */
    double unscaled_m[MUKCA_RANGES];  /* after_m apart from the scale of an arm in sockets */
    double probability[MUKCA_RANGES]; /* that the table's mean error is the smaller one */
    int outliers, gross; /* postures that deviate from a robust fit, those by more than any arm */
    double worst_m;      /* the largest of these deviations */
    double tool_m;       /* displacement of the tip on its link, from the nominal one */
} mukca_tip_error;

/* Fit geometry and effects to task->data by Gauss-Newton, with the priors of posterior.h in a scale
 * chosen by the data, heavy-tailed noise, and readings of one posture as one sample; then draw arms
 * from the posterior.  The frames of the measurement are unknown, for each file and target of
 * several.  Long recordings are thinned.  Errors: MUKCA_MEMORY. */
mukca_status mukca_tip_error_expect(mukca_tip_error *expected, const mukca_tip_change_task *task,
                                    mukca_error *error);

/* Remove the columns first..end - 1 of X[rows][w] from those after them. */
void mukca_tip_error_project(double *X, int rows, int w, int first, int end);

#endif
