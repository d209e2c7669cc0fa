/* The linearised model of a recording: geometry and causes as columns, rows grouped by socket.
 *
 * This is what the diagnosis reasons with.  All unknowns are zero-mean Gaussians: six local offsets
 * of each joint's origin and of the last one before the tip, and the coefficients of the causes
 * that were accepted so far.  Sockets' means are free, so rows and columns are centred per socket
 * (after whitening with an AR(1) coefficient) and one row per known distance is added; rows of a
 * pose log are compared with their measured tip instead.
 */
#ifndef MUKCA_DIAGNOSE_MODEL_H
#define MUKCA_DIAGNOSE_MODEL_H

#include <stdint.h>

#include "base/pool.h"
#include "mukca/dataset.h"
#include "mukca/effect.h"

enum { GAP_TIME = -1 };

enum { GAP_RHOS = 3, GAP_MAX_CAUSES = 24, GAP_MAX_TERMS = 64, GAP_MAX_LUMPS = MUKCA_MAX_ELEMENTS };

/* What a candidate cause is: an effect of the catalogue, or a rival that explains structure by
 * something else (a flexible function of a joint's angle, a single bad row). */
typedef enum {
    GAP_EFFECT,   /* of the catalogue, acting on the arm */
    GAP_STEP,     /* tool_motion: the socket moved once, at a row */
    GAP_CREEP,    /* tool_motion: the socket crept through all its rows */
    GAP_SPIKE,    /* outlier: one row is off, or a few in a row are off alike */
    GAP_DISTANCE, /* socket_distance */
    GAP_BUMPS,    /* unknown: a smooth function of angles or of time turns a joint */
    GAP_STRETCH   /* unknown: a link changes its length with time */
} gap_kind;

/* One candidate.  `basis` is the forward model, computed once: [n_rows][terms][width], width 1 for
 * a joint's angle, 3 for rotations, n_joints for all angles. */
typedef struct {
    gap_kind kind;
    mukca_effect effect; /* kind, joint, placement, variant; GAP_BUMPS: joint and variant */
    int driver;          /* GAP_BUMPS: the joint whose angle is the argument (with products, one of
                            them beside the joint's own), GAP_TIME: time */
    double lo, hi;       /* the argument's range, rad or s */
    int group, row; /* GAP_STEP, GAP_CREEP, GAP_SPIKE: group, and first row of the step (data) */
    int last;       /* GAP_SPIKE: last row that is off */
    int terms, width;
    float *basis;
    double unit[GAP_MAX_TERMS]; /* coefficient size that moves the joint by 1 rad rms (m: 1) */
    double log_prior;
} gap_hypothesis;

typedef struct {
    gap_hypothesis hypothesis;
    double scale; /* prior sigma of coefficient * unit */
    double coefficient[GAP_MAX_TERMS];
    int step; /* of the competition, when it was accepted */
} gap_cause;

typedef struct {
    int start, count; /* in the kept order */
    int socket;       /* of the dataset; -1: a pose log, not centred */
    int placement;
    double mean[3]; /* of the predictions at the linearisation, m */
} gap_group;

typedef struct {
    int a, b; /* groups */
    double distance, direction[3];
} gap_pair;

typedef struct {
    double mass_spread;    /* relative prior sigma of each mass when it loads an effect; 0: exact */
    double distance_sigma; /* how well the sockets' distance is known, m */
    bool free_base, free_tool; /* pose logs: frame of the tracker, offset of the target */
    const double *lump_scale;  /* mass factors to use instead of estimating them, or NULL */
} gap_options;

/* Normal equations of one AR(1) coefficient; size = columns + 1, the last column being y. */
typedef struct {
    double rho, log_det;
    int dof;
    double *gram;     /* [size][size] */
    double *distance; /* [n_pairs][size] */
    double *variance; /* [n_pairs]: of a distance row, in units of sigma^2 */
    double *white;    /* [d * n][size] whitened and centred, rows of the kept order */
} gap_pack;

typedef struct {
    const mukca_chain *chain;
    const mukca_dataset *data;
    gap_options options;
    mukca_pool pool;
    int dim;                /* observed per row: 3, or 6 with orientations (pose logs) */
    double rotation_weight; /* m per rad: orientation rows in units of position noise */

    /* state of each row of the dataset (not linearised) */
    int n_lumps; /* masses, one per element that carries any */
    int lump_element[GAP_MAX_LUMPS];
    double lump_scale[GAP_MAX_LUMPS]; /* from measured efforts, else 1 */
    double efforts_correlation; /* cosine of measured and modelled holding torques; NaN: none */
    bool have_moments, have_torques;
    double *moment; /* [n_rows][n_lumps][n_joints][3], torque [n_rows][n_lumps][n_joints] */
    double *torque, *base_moment, *total_moment, *total_torque, *total_base;
    double *move, *command, *time;
    int *placement;

    /* rows in use, by group */
    unsigned char *keep; /* [n_rows] */
    int n, n_groups, n_pairs;
    int *order; /* [n] row of the dataset */
    gap_group *groups;
    gap_pair *pairs;
    double *weight; /* [n_rows] robust weights, NULL: none */

    /* unknowns */
    int n_geometry; /* columns of the geometry */
    int n_slots;    /* elements with free origins; slot k has element slot_element[k] and six
                     * columns x y z and the rotation vector, the last slot slot_width of them;
                     * then one common factor of all lengths; with
                     * free_base six more columns follow */
    int slot_width;
    mukca_frame tracker; /* pose logs: T_measured_base */
    int slot_element[MUKCA_MAX_JOINTS + 1];
    double *theta;       /* [n_geometry] offsets about the nominal geometry (local frame) */
    double *theta_sigma; /* [n_geometry] prior */
    double sigma_length, sigma_angle; /* hyperparameters of the geometry's prior, m and rad */
    int n_causes;
    gap_cause *cause;
    double sigma, rho, log_evidence;
    double quadratic; /* of the last evidence: squared misfit and departure from the priors, each in
                         units of its sigma */

    /* linearisation */
    mukca_geometry geometry;
    int n_columns, capacity; /* columns in use (without y), columns allocated */
    double *tip;             /* [n][3] predicted position */
    double *tip_frame;       /* [n][9] orientation of the tip */
    double *lever;           /* [n][n_joints][dim] tip per joint angle */
    double *rotation_lever;  /* [n][n_joints][dim][3] tip per rotation vector of the joint frame */
    double *base_lever;      /* [n][dim][3] */
    double *columns;         /* [n][dim][n_columns + 1] */
    double *direct;          /* [n_pairs][n_columns + 1] parts of the distance rows beside means */
    gap_pack pack[GAP_RHOS];
    double *work, *posterior_chol; /* [capacity + 1]^2 each */
    double *prior, *mean;          /* [capacity]: of the last fit */
} gap_model;

extern const double gap_rho[GAP_RHOS];

/* Build the model of a dataset; `data` must outlive it.  mass factors come from measured efforts
 * where there are any.  Errors: MUKCA_MEMORY. */
mukca_status gap_model_create(gap_model *m, const mukca_chain *chain, const mukca_dataset *data,
                              const gap_options *options, mukca_error *error);
void gap_model_free(gap_model *m);

/* Regroup the kept rows (after `keep` changed). */
void gap_model_regroup(gap_model *m);

/* Linearise at the present unknowns: levers, columns of geometry and causes, y. */
void gap_model_linearise(gap_model *m);

/* Origins from theta: local offsets about the nominal ones (done by gap_model_linearise too). */
void gap_model_set_geometry(gap_model *m);

/* Normal equations of one rho. */
void gap_model_pack(gap_pack *pack, const gap_model *m, double rho);

/* Log evidence of the present columns with prior sigmas `prior` [n_columns] and noise sigma;
 * mean [n_columns] (may be NULL) gets the posterior mean; the Cholesky factor of the scaled
 * posterior precision stays in m->posterior_chol.  -HUGE_VAL where it cannot be factored. */
double gap_model_evidence(gap_model *m, const gap_pack *pack, const double *prior, double sigma,
                          double *mean);

/* Standard error of the sum of direction[t] x[column + t], t < terms, in the posterior whose factor
 * the last evidence left: |L^-1 D a| with the priors D that it used, m->prior. */
double gap_model_standard_error(gap_model *m, int column, const double *direction, int terms);

/* Noise sigma that maximises the evidence; *value gets it. */
double gap_model_best_sigma(gap_model *m, const gap_pack *pack, const double *prior, double *value);

/* Prior sigmas of all columns: geometry, then causes except `without` (-1: none). */
int gap_model_prior(double *prior, const gap_model *m, int without);

/* What a fit may choose besides the unknowns themselves. */
typedef enum {
    GAP_FIXED, /* nothing: noise, AR(1) and prior scales stay */
    GAP_NOISE, /* noise and AR(1), in the first step */
    GAP_FREE   /* noise, AR(1) and prior scales by evidence, in the first and third step */
} gap_freedom;

/* Fit geometry and causes in at most `iterations` Gauss-Newton steps.  Ends linearised. */
void gap_model_fit(gap_model *m, int iterations, gap_freedom freedom);

/* Displacement of a dataset row by the present causes (socket faults apart). */
void gap_model_displacement(mukca_displacement *d, const gap_model *m, int row);

/* Predicted tip (m, base frame) of a row with the present geometry and causes. */
void gap_model_predict(double position[3], const gap_model *m, int row);

/* Columns of a hypothesis at the linearisation: E[n][dim][ld], `terms` columns from E on. */
void gap_hypothesis_columns(double *E, int ld, const gap_model *m, const gap_hypothesis *h);

/* Does a GAP_DISTANCE cause change the distance of that pair of sockets? */
bool gap_distance_acts(const gap_model *m, const gap_hypothesis *h, int pair);

/* Add a cause (refit afterwards); drop one.  Adding fails when the table is full. */
bool gap_model_add(gap_model *m, const gap_hypothesis *h);
void gap_model_drop(gap_model *m, int index);

/* Prior scales that a hypothesis is averaged over; returns their number. */
int gap_scales(const double **scales, const gap_hypothesis *h);

/* State of a dataset row for the forward models. */
mukca_joint_state gap_model_state(const gap_model *m, int row);

#endif
