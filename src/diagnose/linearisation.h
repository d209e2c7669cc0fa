/* Linearisation of the predictions of a recording: levers of the joints, columns of all unknowns.
 *
 * The local frames of the columns and the angles of each sample in its socket are the diagnosis'
 * own: a candidate's columns are products of its basis with the levers stored here, without
 * kinematics. */
#ifndef MUKCA_DIAGNOSE_LINEARISATION_H
#define MUKCA_DIAGNOSE_LINEARISATION_H

#include "diagnose/unknowns.h"

typedef struct {
    const mukca_recording *recording;
    int n_columns;          /* in use: the first ones, of the geometry or of all */
    int y, stride;          /* index of y, behind all stored columns; their number with it */
    int n_causes;           /* with stored columns */
    mukca_candidate *cause; /* [MUKCA_MAX_ACCEPTED] */
    unsigned version;     /* number of updates: identifies all that is computed from the columns */
    double *explained;    /* [stride] scratch: contribution of the present unknowns */
    double *tip;          /* [n_samples][3] predicted position */
    double *tip_frame;    /* [n_samples][9] orientation of the tip */
    double *seated;       /* [n_samples][n_joints] angles at which the columns are computed, and */
    double *distance;     /* [n_samples] of the tip from there, m */
    double *seated_frame; /* [n_samples][9] orientation of the tip there */
    double (*mean)[3];    /* [n_groups] mean of the predicted positions, m */
    double (*direction)[3]; /* [n_pairs] unit vector between the two means */
    double *lever;          /* [n_samples][n_joints][dim] derivative of the tip by a joint angle */
    double *rotation_lever; /* [n_samples][n_joints][dim][3] by a rotation of the joint frame */
    double *base_lever;     /* [n_samples][dim][3] by a rotation of the base */
    double *columns;        /* [n_samples][dim][stride] stored columns */
    double *pair_columns;   /* [n_pairs][stride] direct effect on a distance, and the distance */
} mukca_linearisation;

/* Memory comes from `pool`; the recording must outlive it.  False: no memory. */
bool mukca_linearisation_create(mukca_linearisation *linear, mukca_pool *pool,
                                const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Linearise at the present unknowns, and set their geometry. */
void mukca_linearisation_update(mukca_linearisation *linear, mukca_unknowns *unknowns);

/* Smallest change of the angles seated[n] that moves the predicted tip by r (overwritten), to first
 * order. */
void mukca_linearisation_seat(double *seated, double r[3], int n, const mukca_geometry *geometry,
                              const mukca_displacement *displacement);

/* Columns of a candidate, E[n_samples][dim][ld]. */
void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_candidate *candidate);

#endif
