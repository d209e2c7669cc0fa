/* The unknowns of the diagnosis: offsets of the geometry, accepted causes, noise and prior scales.
 *
 * All offsets and coefficients are zero-mean Gaussians before the data, but for coefficients whose
 * mean is known from elsewhere: the columns then count from that.
 */
#ifndef MUKCA_DIAGNOSE_UNKNOWNS_H
#define MUKCA_DIAGNOSE_UNKNOWNS_H

#include "diagnose/candidate.h"
#include "fit/align.h"

enum { MUKCA_MAX_ACCEPTED = 64 };

/* A candidate that was accepted. */
typedef struct {
    mukca_candidate candidate;
    double scale; /* prior sigma of coefficient * unit */
    /* Prior of one coefficient from elsewhere: its mean, and the scale is not to be chosen. */
    bool known;
    double centre;
    double coefficient[MUKCA_MAX_COLUMNS];
    int step;    /* of the competition, when it was accepted */
    double lead; /* log odds by which it led when it was last tested; 0: not yet */
} mukca_accepted;

/* Frames of the pose logs; those that logs share are equal. */
typedef struct {
    mukca_frame tracker[MUKCA_MAX_LOGS]; /* T_measured_base */
    mukca_frame shift[MUKCA_MAX_LOGS];   /* of the log's target in the first log's */
} mukca_log_frames;

typedef struct {
    /* The geometry's columns: slot k is an element with a free origin and has six, x y z and the
     * rotation vector, the last slot slot_width of them; then one common factor of all lengths;
     * then six of each tracker's frame that is free; then slot_width of each log's own target, from
     * the second log on. */
    int n_geometry, n_slots, slot_width;
    int n_trackers, n_targets;       /* free frames: of all logs together (1) or of each */
    int first_tracker, first_target; /* their columns; the factor's is before the first one */
    int slot_element[MUKCA_MAX_JOINTS + 1];
    bool free_base, free_tool;
    double *theta;       /* [n_geometry] offsets about the nominal geometry, in local frames */
    double *theta_prior; /* [n_geometry] prior sigmas */
    double sigma_length, sigma_angle; /* prior scales of the geometry, m and rad */
    mukca_geometry geometry;          /* the arm at theta */
    /* Pose logs: frames are composed with what theta adds, since large rotations do not add. */
    mukca_log_frames log;     /* of each log */
    mukca_frame target;       /* free_tool: of the first, in the last slot's nominal frame */
    mukca_log_frames nominal; /* the same, aligned with the nominal geometry */
    mukca_frame nominal_target;

    int n_causes;
    mukca_accepted *cause; /* [MUKCA_MAX_ACCEPTED] */

    double sigma, rho;      /* noise, m, and its AR(1) coefficient from sample to sample */
    double rotation_weight; /* m per rad: orientations in units of position noise */
    double *weight;         /* [n_rows] robust weights, NULL: none */
} mukca_unknowns;

/* An arm as it predicts samples: one step of the error breakdown. */
typedef struct {
    mukca_geometry geometry;
    mukca_log_frames log;
} mukca_arm_state;

mukca_arm_state mukca_unknowns_nominal_arm(const mukca_unknowns *unknowns,
                                           const mukca_chain *chain);
mukca_arm_state mukca_unknowns_arm(const mukca_unknowns *unknowns);
void mukca_unknowns_set_arm(mukca_unknowns *unknowns, const mukca_arm_state *arm);

/* Memory comes from `pool`.  False: no memory. */
bool mukca_unknowns_create(mukca_unknowns *unknowns, mukca_pool *pool,
                           const mukca_recording *recording);

/* A copy with memory of its own from `pool` (false: none), and copying the values back. */
bool mukca_unknowns_clone(mukca_unknowns *copy, mukca_pool *pool, const mukca_unknowns *unknowns);
void mukca_unknowns_assign(mukca_unknowns *unknowns, const mukca_unknowns *from);

/* Move what theta says of the free frames into them. */
void mukca_unknowns_fold_frames(mukca_unknowns *unknowns);

/* Origins from theta. */
void mukca_unknowns_set_geometry(mukca_unknowns *unknowns, const mukca_chain *chain);

/* Prior sigmas of the geometry from the two scales. */
void mukca_unknowns_set_geometry_prior(mukca_unknowns *unknowns, const mukca_recording *recording);

/* Number of columns: geometry, then the terms of the causes before `cause` (n_causes: of all).  It
 * is also the first column of that cause. */
int mukca_unknowns_column(const mukca_unknowns *unknowns, int cause);

/* Prior sigmas of all columns. */
void mukca_unknowns_prior(double *prior, const mukca_unknowns *unknowns);

/* The unknowns from the posterior mean of all columns. */
void mukca_unknowns_set(mukca_unknowns *unknowns, const double *mean);

/* Add a cause (fit afterwards); drop one.  Adding fails when the table or the columns are full. */
bool mukca_unknowns_add(mukca_unknowns *unknowns, const mukca_candidate *candidate);
void mukca_unknowns_drop(mukca_unknowns *unknowns, int cause);

/* Displacement of a dataset row by the causes (faults of sockets apart). */
void mukca_unknowns_displacement(mukca_displacement *displacement, const mukca_unknowns *unknowns,
                                 int n_joints, int row);

/* Predicted tip of a row with the present geometry and causes, m, in the base frame; the second in
 * the frame of the measurement (a pose log's: the tracker's). */
void mukca_unknowns_predict(double position[3], const mukca_unknowns *unknowns,
                            const mukca_recording *recording, int row);

void mukca_unknowns_predict_measured(double position[3], const mukca_unknowns *unknowns,
                                     const mukca_recording *recording, int row);

/* A measured position (m) of a log in the base frame. */
void mukca_unknowns_to_base(double position[3], const mukca_unknowns *unknowns, int log,
                            const double measured[3]);

/* Columns that all causes and geometry may take. */
int mukca_unknowns_capacity(const mukca_unknowns *unknowns);

#endif
