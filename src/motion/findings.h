/* Findings of the search: groups of effects, their sizes, held-out errors. */
#ifndef MUKCA_MOTION_FINDINGS_H
#define MUKCA_MOTION_FINDINGS_H

#include "motion/search.h"

/* The effects in a posterior over sets, and the torques that they cause. */
typedef struct {
    mukca_torque_search *search;
    int n_labels, *label_of; /* [n_kept] */
    mukca_label *label;
    mukca_torque_columns columns;    /* of all items in the sets */
    int *at;                         /* [n_kept] first of these columns, -1: in no set */
    double *plain[MUKCA_MAX_JOINTS]; /* [columns][columns] products of a joint */
    double rows[MUKCA_MAX_JOINTS];   /* in these */
    mukca_labelled_sets posterior;
} mukca_torque_posterior;

/* Set the findings of a motion.  Errors: MUKCA_MEMORY. */
mukca_status mukca_torque_findings(mukca_motion *motion, mukca_torque_search *search,
                                   mukca_error *error);

/* Mean square of the torque at a joint of columns column[n] of `plain` times mean[n]; half of its
 * derivative, slope[n], may be NULL. */
double mukca_torque_square(double *slope, const mukca_torque_posterior *p, int joint,
                           const int *column, const double *mean, int n);

/* Sizes, coefficients and alternatives of the groups of all findings. */
bool mukca_torque_sizes(mukca_motion *motion, mukca_pool *pool,
                        const mukca_torque_posterior *posterior);

/* Held-out errors of all joints and findings, and what these errors refute.  False: no memory. */
bool mukca_torque_held_out(mukca_motion *motion, const mukca_torque_posterior *posterior);

#endif
