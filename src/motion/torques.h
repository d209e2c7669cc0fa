/* The regression of measured torques: products of columns, noise of each joint, questions for the
 * search among sets. */
#ifndef MUKCA_MOTION_TORQUES_H
#define MUKCA_MOTION_TORQUES_H

#include "infer/halves.h"
#include "motion/items.h"

/* A set of items with the sizes of their priors. */
typedef struct {
    int n, item[MUKCA_SET_ITEMS];
    double size[MUKCA_SET_ITEMS];
} mukca_torque_set;

typedef struct mukca_torques {
    const mukca_motion_input *input;
    mukca_raw_model model;
    mukca_raw_products part[MUKCA_PARTS];
    mukca_items items;
    mukca_motion_point point;
    int n; /* joints */
    bool reference, test;
    double sigma[MUKCA_MAX_JOINTS], rho[MUKCA_MAX_JOINTS]; /* N m; of successive rows */
} mukca_torques;

/* Some columns of the regression times factors. */
typedef struct mukca_torque_columns {
    int n, *column;
    double *factor;
} mukca_torque_columns;

/* Room for n columns. */
mukca_torque_columns mukca_torque_columns_take(mukca_pool *pool, int n);
/* Append the parameters; the value; an item. */
void mukca_torque_columns_parameters(mukca_torque_columns *columns, const mukca_torques *t);
void mukca_torque_columns_value(mukca_torque_columns *columns, const mukca_torques *t);
void mukca_torque_columns_item(mukca_torque_columns *columns, const mukca_torques *t, int item,
                               double size);

/* Parameters, items of a set (NULL: none), value, with room for more columns; -1: also all effects
 * of one column at a joint, and Coulomb friction that drifts.  Check pool->failed. */
mukca_torque_columns mukca_torque_columns_of(mukca_pool *pool, const mukca_torques *t,
                                             const mukca_torque_set *set, int room);

/* Weights of the parts; the whole: those that are fitted. */
typedef struct {
    double of[MUKCA_PARTS];
} mukca_part_weights;
extern const mukca_part_weights mukca_torques_whole;

/* G[n][n] += products of the columns: of joint `joint` alone, or (-1) of all joints over their
 * variances; plain, or whitened by the correlation of the noise. */
bool mukca_torques_multiply(double *G, const mukca_torques *t, const mukca_torque_columns *columns,
                            const mukca_part_weights *parts, int joint, bool whitened);

/* Rows of a joint in these parts; at least a tiny number. */
double mukca_torques_rows(const mukca_torques *t, const mukca_part_weights *parts, int joint);

/* Noise of each joint, of a fit of the parameters, a set and more: friction that the set lacks is
 * nearly constant between reversals, and would pass for noise of a correlation that hides it.
 * False: no memory, or not positive. */
bool mukca_torques_measure_noise(mukca_torques *t, const mukca_torque_set *set);

/* Posterior mean mean[parameters and columns of the set], in units of their priors, from these
 * parts. */
bool mukca_torques_fit(double *mean, const mukca_torques *t, const mukca_torque_columns *columns,
                       const mukca_part_weights *parts);

/* Some items of the regression, beside the parameters and a set that is held (NULL: none). */
typedef struct {
    int n;
    const int *item;
    const mukca_torque_set *held;
} mukca_torque_choice;

/* Question of these items, in their order.  Memory comes from `pool`. */
bool mukca_torques_ask(mukca_question *question, mukca_pool *pool, const mukca_torques *t,
                       const mukca_torque_choice *choice, const mukca_part_weights *parts);

#endif
