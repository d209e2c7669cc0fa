/* Columns of the regression as combinations of raw columns: parameters near the model's, and the
 * items of the search. */
#ifndef MUKCA_MOTION_ITEMS_H
#define MUKCA_MOTION_ITEMS_H

#include "infer/sets.h"
#include "motion/raw.h"

#define MUKCA_MASS_ERROR 0.03 /* of a link, relative, and so of the load that it is for a joint */

/* `weight` times a raw column of a joint. */
typedef struct {
    short joint, raw;
    double weight;
} mukca_raw_term;

/* Columns: first the parameters, in units of their prior sigma, then the value, then the items'. */
typedef struct {
    int n_parameters, n_columns, n_terms;
    int n_gains; /* the last ones of the parameters */
    int drift;   /* the last columns: for each joint, friction that falls in the recording or not */
    int *first;  /* [n_columns + 1] terms of a column */
    mukca_raw_term *term;
    int n_items;
    mukca_item *item; /* `at`: column behind the value */
    int *row;         /* [n_items] of mukca_torque_table */
    mukca_label *label;
    double *unit; /* [n_items] coefficient per unit of the first column's */
} mukca_items;

/* The point of linearisation: what is nonlinear in the coefficients. */
typedef struct {
    double delay[MUKCA_MAX_JOINTS];   /* s */
    double coulomb[MUKCA_MAX_JOINTS]; /* N m: the scale of its shape at reversals */
    /* of the links, with what they carry: the load of friction */
    double load[MUKCA_MAX_JOINTS * MUKCA_INERTIAL];
    /* raw coefficients of the arm's torque, on which a gain acts */
    double *torque[MUKCA_MAX_JOINTS];
} mukca_motion_point;

/* List all columns at a point; memory comes from `pool`.  False: no memory. */
bool mukca_items_list(mukca_items *items, mukca_pool *pool, const mukca_motion_input *input,
                      const mukca_raw_model *model, const mukca_motion_point *point);

#endif
