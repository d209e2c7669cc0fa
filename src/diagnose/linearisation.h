/* Linearisation of the recording's predictions: levers of the joints, columns of all unknowns.
 *
 * The columns' local frames and the seat of each sample are the diagnosis' own: a candidate's
 * columns are a product of its basis with the levers kept here, without kinematics.
 */
#ifndef MUKCA_DIAGNOSE_LINEARISATION_H
#define MUKCA_DIAGNOSE_LINEARISATION_H

#include "diagnose/unknowns.h"

enum { MUKCA_MOST_HELD = 64 }; /* causes whose columns are held */

typedef struct {
    int n_columns;      /* in use, without y */
    int *at;            /* [n_columns + 1] where these and y are among the columns held */
    int stride, n_held; /* of a row of the columns held; their number, y among them */
    int most;           /* that the stride can grow to */
    int n_causes, at_cause[MUKCA_MOST_HELD]; /* causes whose columns are held, and where */
    mukca_candidate *cause;                  /* [MUKCA_MOST_HELD] */
    unsigned version;  /* counts the updates: what is formed from the columns is kept by it */
    double *reference; /* [stride] unknowns that y was taken at, and the frames there */
    mukca_log_frames log;
    mukca_frame target;
    double *change;         /* [stride] scratch: how far they have moved */
    double *tip;            /* [n_samples][3] predicted position */
    double *tip_frame;      /* [n_samples][9] orientation of the tip */
    double (*mean)[3];      /* [n_groups] of the predicted positions, m */
    double (*direction)[3]; /* [n_pairs] unit vector between the two means */
    double *lever;          /* [n_samples][n_joints][dim] tip per joint angle */
    double *rotation_lever; /* [n_samples][n_joints][dim][3] tip per rotation of the joint frame */
    double *base_lever;     /* [n_samples][dim][3] */
    double *columns;        /* [n_samples][dim][stride] those held */
    double *pair_columns;   /* [n_pairs][stride] what acts on a distance itself, and the distance */
} mukca_linearisation;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_linearisation_create(mukca_linearisation *linear, mukca_pool *pool,
                                const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Linearise at the present unknowns (sets their geometry, too).  With `spare` there is room for
 * columns of other causes behind. */
void mukca_linearisation_update(mukca_linearisation *linear, const mukca_recording *recording,
                                mukca_unknowns *unknowns, bool spare);

/* Select the columns of the present causes without linearising again; those of a cause that is new
 * are added to the columns held.  False: there is no room for them. */
bool mukca_linearisation_select(mukca_linearisation *linear, const mukca_recording *recording,
                                const mukca_unknowns *unknowns);

/* Rows that get a larger stride; they have room for it. */
typedef struct {
    int columns, old, new;
} mukca_strides;

/* Move the rows of x[rows][old stride] apart. */
void mukca_linearisation_spread(double *x, int rows, const mukca_strides *strides);

/* Take y at the present unknowns; the columns stay.  False: there is no room for another column. */
bool mukca_linearisation_refresh(mukca_linearisation *linear, const mukca_recording *recording,
                                 mukca_unknowns *unknowns);

/* How far predictions at these unknowns are from those of the columns, about the mean of
 * each socket, m rms. */
double mukca_linearisation_error(const mukca_linearisation *linear,
                                 const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Move the angles seated[n] the least so that the predicted tip moves by r (destroyed), to first
 * order. */
void mukca_linearisation_seat(double *seated, double r[3], int n, const mukca_geometry *geometry,
                              const mukca_displacement *displacement);

/* Samples [start, end) of a recording. */
typedef struct {
    int start, end;
} mukca_span;

/* Columns of a candidate, E[n_samples][dim][ld], from E on; or of these samples alone. */
void mukca_linearisation_columns(double *E, int ld, const mukca_linearisation *linear,
                                 const mukca_recording *recording,
                                 const mukca_candidate *candidate);
void mukca_linearisation_columns_of(double *E, int ld, const mukca_linearisation *linear,
                                    const mukca_recording *recording,
                                    const mukca_candidate *candidate, mukca_span of);

#endif
