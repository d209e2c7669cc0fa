/* Unknowns of the diagnosis: offsets of the geometry, accepted causes, noise and prior scales.
 *
 * The priors of offsets and coefficients are zero-mean Gaussians, except for coefficients with a
 * mean known from elsewhere: their columns refer to the deviation from it. */
#ifndef MUKCA_DIAGNOSE_UNKNOWNS_H
#define MUKCA_DIAGNOSE_UNKNOWNS_H

#include <stdint.h>

#include "diagnose/candidate.h"
#include "fit/align.h"
#include "infer/sets.h"
#include "model/prior.h"

enum { MUKCA_MAX_ACCEPTED = 64, MUKCA_MOST_MODELS = 8 };

/* An accepted candidate. */
typedef struct {
    mukca_candidate candidate;
    double scale; /* prior sigma of coefficient * unit */
    bool sized;   /* it was chosen by the search; otherwise a fit chooses it */
    /* Prior of a single coefficient from elsewhere: its mean; the scale is fixed. */
    bool known;
    double centre;
    double coefficient[MUKCA_MOST_TERMS];
} mukca_accepted;

/* Frames of the pose logs; shared frames are equal. */
typedef struct {
    mukca_frame tracker[MUKCA_MAX_LOGS]; /* T_measured_base */
    mukca_frame shift[MUKCA_MAX_LOGS];   /* target relative to that of the first log */
} mukca_log_frames;

/* State of the arm for predictions: one step of the error breakdown. */
typedef struct {
    mukca_geometry geometry;
    mukca_log_frames log; /* per log */
} mukca_arm_state;

typedef struct {
    /* Columns of the geometry: slot k is an element with a free origin and has six, x y z and the
     * rotation vector; the last slot has slot_width.  Then one common factor of all lengths; then
     * six per free tracker frame; then slot_width per log with its own target, from the second log
     * on; then the error of each artefact's distance. */
    int n_geometry, n_slots, slot_width;
    int n_trackers, n_targets; /* free frames: one of all logs together (1), or one per log */
    int first_tracker, first_target, first_artefact; /* first columns; the factor is at
                                                        first_tracker - 1 */
    int slot_element[MUKCA_MAX_JOINTS + 1];
    bool free_base, free_tool;
    double *theta;       /* [n_geometry] offsets from the nominal geometry, in local frames */
    double *theta_prior; /* [n_geometry] prior sigmas */
    mukca_geometry_prior prior; /* its lengths and angles are chosen by the evidence */
    /* The arm with offsets theta.  In pose logs they are composed into the frames, since large
     * rotations do not add. */
    mukca_arm_state arm;
    mukca_frame target; /* free_tool: of the first log, in the nominal frame of the last slot */
    mukca_log_frames nominal; /* the same, aligned to the nominal geometry */
    mukca_frame nominal_target;

    int n_causes;
    mukca_accepted *cause; /* [MUKCA_MAX_ACCEPTED] */
    /* A fit is the mean over models, each of which has some of the causes; 0: one, of all. */
    int n_models;
    uint64_t model[MUKCA_MOST_MODELS]; /* bit c: cause c */
    double model_weight[MUKCA_MOST_MODELS];

    double sigma;           /* noise, m */
    int family;             /* of the noise, index of the evidence's */
    double rotation_weight; /* m per rad: converts orientations to units of position noise */
    double *weight;         /* [n_rows] robust weights, NULL: none */
    double *tails;          /* [n_rows] weights of Student's noise, NULL: Gaussian noise */
} mukca_unknowns;

mukca_arm_state mukca_unknowns_nominal_arm(const mukca_unknowns *unknowns,
                                           const mukca_chain *chain);

/* Memory comes from `pool`.  False: no memory. */
bool mukca_unknowns_create(mukca_unknowns *unknowns, mukca_pool *pool,
                           const mukca_recording *recording);

/* A copy with its own memory from `pool` (false: no memory), and the assignment of values. */
bool mukca_unknowns_clone(mukca_unknowns *copy, mukca_pool *pool, const mukca_unknowns *unknowns);
void mukca_unknowns_assign(mukca_unknowns *unknowns, const mukca_unknowns *from);

/* Compose the offsets of the free frames into these frames, and zero the offsets. */
void mukca_unknowns_fold_frames(mukca_unknowns *unknowns);

/* Compute the origins from theta. */
void mukca_unknowns_set_geometry(mukca_unknowns *unknowns, const mukca_chain *chain);

/* Compute the geometry's prior sigmas from unknowns->prior. */
void mukca_unknowns_set_geometry_prior(mukca_unknowns *unknowns, const mukca_recording *recording);

/* Number of columns of the geometry and the causes before `cause` (n_causes: of all); also the
 * first column of that cause. */
int mukca_unknowns_column(const mukca_unknowns *unknowns, int cause);

/* Prior sigmas of all columns; in a model, 0 of the causes that it lacks (-1: of none). */
void mukca_unknowns_prior(double *prior, const mukca_unknowns *unknowns, int model);

/* Set the unknowns to the posterior mean of all columns. */
void mukca_unknowns_set(mukca_unknowns *unknowns, const double *mean);

/* Add a cause (to be fitted) to all models, or drop one.  Adding fails if the table or the columns
 * are full. */
bool mukca_unknowns_add(mukca_unknowns *unknowns, const mukca_candidate *candidate);
void mukca_unknowns_drop(mukca_unknowns *unknowns, int cause);

/* Displacement of a dataset row by the causes, without faults of sockets. */
void mukca_unknowns_displacement(mukca_displacement *displacement, const mukca_unknowns *unknowns,
                                 int n_joints, int row);

/* Predicted tip of a row with the present geometry and causes, m: in the base frame; of a pose log
 * in the frame of its measurement, the tracker's. */
void mukca_unknowns_predict(double position[3], const mukca_unknowns *unknowns,
                            const mukca_recording *recording, int row);

/* Transform a measured position (m) of a log to the base frame. */
void mukca_unknowns_to_base(double position[3], const mukca_unknowns *unknowns, int log,
                            const double measured[3]);

/* Largest number of columns of geometry and causes. */
int mukca_unknowns_capacity(const mukca_unknowns *unknowns);

#endif
