/* Linearisation of the recording's predictions: levers of the joints, columns of all unknowns.
 *
 * The columns' local frames and the seat of each sample are the diagnosis' own: a candidate's
 * columns are a product of its basis with the levers kept here, without kinematics.
 */
#ifndef MUKCA_DIAGNOSE_LINEARISATION_H
#define MUKCA_DIAGNOSE_LINEARISATION_H

#include "diagnose/unknowns.h"

typedef struct {
    int n_columns;          /* in use, without y */
    unsigned version;       /* counts the updates: what is formed from the columns is kept by it */
    double *tip;            /* [n_samples][3] predicted position */
    double *tip_frame;      /* [n_samples][9] orientation of the tip */
    double (*mean)[3];      /* [n_groups] of the predicted positions, m */
    double (*direction)[3]; /* [n_pairs] unit vector between the two means */
    double *lever;          /* [n_samples][n_joints][dim] tip per joint angle */
    double *rotation_lever; /* [n_samples][n_joints][dim][3] tip per rotation of the joint frame */
    double *base_lever;     /* [n_samples][dim][3] */
    double *columns;        /* [n_samples][dim][n_columns + 1], the last one y */
    double *pair_columns;   /* [n_pairs][n_columns + 1] what acts on a distance itself */
} mukca_linearisation;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_linearisation_create(mukca_linearisation *linear, mukca_pool *pool,
                                const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Linearise at the present unknowns (sets their geometry, too). */
void mukca_linearisation_update(mukca_linearisation *linear, const mukca_recording *recording,
                                mukca_unknowns *unknowns);

/* Move the angles seated[n] the least so that the predicted tip moves by r (destroyed), to first
 * order. */
void mukca_linearisation_seat(double *seated, double r[3], int n, const mukca_geometry *geometry,
                              const mukca_displacement *displacement);

/* Columns of a candidate, E[n_samples][dim][ld], from E on. */
void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_recording *recording,
                                 const mukca_candidate *candidate);

#endif
