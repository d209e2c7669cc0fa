/* The recording under diagnosis: samples, loads on the arm in each, and groups by socket.
 *
 * All members are constant after creation, except for the rows in use. */
#ifndef MUKCA_DIAGNOSE_RECORDING_H
#define MUKCA_DIAGNOSE_RECORDING_H

#include "base/workers.h"
#include "infer/whitening.h"
#include "model/dataset.h"
#include "mukca/effect.h"

enum { MUKCA_MAX_LOGS = 16 };

/* Samples of one socket, or of all pose logs. */
typedef struct {
    int start, count; /* samples */
    int socket;       /* of the dataset; -1: pose logs, compared with their measured poses */
    int placement;
} mukca_group;

/* Two groups whose sockets have a known distance, m. */
typedef struct {
    int a, b, artefact;
    double distance;
} mukca_socket_pair;

typedef struct {
    double mass_spread;        /* relative prior sigma of each mass in elastic effects; 0: exact */
    bool free_base, free_tool; /* pose logs: frame of the tracker, offset of the target */
    bool base_per_log, tool_per_log; /* if free: one frame, one offset per log */
    const double *mass_factor;       /* [n_bodies] fixed factors instead of estimates, or NULL */
    bool turned_efforts; /* without masses, measured efforts are those of the load on the joint */
    int threads;         /* as of mukca_workers_start */
} mukca_recording_options;

typedef struct {
    const mukca_chain *chain;
    const mukca_dataset *data;
    mukca_recording_options options;
    mukca_workers *workers; /* of loops over its samples; NULL: the caller's thread alone */
    int dim;                /* observed values per sample: 3, or 6 with orientations (pose logs) */
    int n_logs;             /* 1 without poses */

    /* loads: a body is an element with mass, or the payload */
    int n_bodies, body_element[MUKCA_MAX_ELEMENTS + 1];
    int payload_body;                           /* the last one; -1: payload unknown */
    double mass_factor[MUKCA_MAX_ELEMENTS + 1]; /* from measured efforts, else 1 */
    double efforts_correlation; /* cosine of measured and modelled holding torques; NaN: none */
    double *normal;             /* [n_bodies][n_bodies] scratch */
    bool have_moments, have_torques;
    double *moment;      /* [n_rows][n_bodies][n_joints][3] in the joint frames, N m */
    double *torque;      /* [n_rows][n_bodies][n_joints] about the axes, N m */
    double *base_moment; /* [n_rows][n_bodies][3] */
    double *total_moment, *total_torque, *total_base; /* [n_rows]... sums over the bodies */
    mukca_chain *turned;                              /* scratch: the same with another gravity */
    double *across; /* [n_rows][n_joints][2] torque with gravity along two axes across it, N m */
    double (*across_base)[2][3]; /* [n_rows] moment about the base's origin with these, N m */

    /* state of each row of the dataset */
    double *q; /* [n_rows][n_joints] angles of the bases, rad: seated, see mukca_recording_seat() */
    double *move;    /* [n_rows][n_joints] from the preceding posture, rad */
    int *posture;    /* [n_rows] first row with these angles */
    int *repeat;     /* [n_rows] readings since the arm arrived */
    bool repeats;    /* postures are read more than once, by design */
    bool targets;    /* these are readings of several targets, which share the posture's error */
    int *last;       /* [n_rows] scratch */
    double *command; /* [n_rows][n_joints] rad; NULL: not recorded */
    double *time;    /* [n_rows] s since the file's start */
    int *placement;  /* [n_rows] */
    int *log;        /* [n_rows] index of the pose log, 0 for samples of sockets */

    /* samples: the rows in use, by group */
    unsigned char *keep; /* [n_rows] */
    int n_samples, n_groups, n_pairs;
    int *order; /* [n_samples] row of the dataset */
    mukca_group *groups;
    mukca_samples samples; /* the same for inference */
    mukca_socket_pair *pairs;
} mukca_recording;

/* Memory comes from `pool`; `chain` and `data` must outlive it.  False: no memory. */
bool mukca_recording_create(mukca_recording *recording, mukca_pool *pool, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_recording_options *options);

/* Relative prior sigma of a body's mass: of a link from the options, of a payload that of a
 * weighing. */
double mukca_recording_mass_spread(const mukca_recording *recording, int body);

/* Group the rows in use, after changes of `keep`. */
void mukca_recording_regroup(mukca_recording *recording);

/* Use seated[n_samples][n_joints] as the angles of all functions of the angles: those at which the
 * ball is where the socket holds it.  At the recorded ones, functions contain the noise of their
 * own sample, and their product with the residual has a mean other than 0 (errors in variables: W.
 * A. Fuller, Measurement Error Models, 1987, section 1.1).  The tip moves by at most `most` (m), as
 * far as noise: larger distances[n_samples] are effects.  Poses are measured with noise of their
 * own, and keep the recorded angles.  True: an angle has changed.  Check `pool`. */
bool mukca_recording_seat(mukca_recording *recording, mukca_pool *pool, const double *seated,
                          const double *distance, double most);

/* State of a row of the dataset for the forward models. */
mukca_joint_state mukca_recording_state(const mukca_recording *recording, int row);

/* Smallest and largest value of column `column` of x[n_rows][columns]. */
void mukca_recording_range(double range[2], const mukca_recording *recording, const double *x,
                           int columns, int column);

/* Smallest and largest angle of a joint in the samples in use. */
void mukca_recording_travel(double range[2], const mukca_recording *recording, int joint);

/* Number the pose logs: rows of one file and one load, since a target with another mass is a new
 * mounting; or rows of one named target.  log[n_rows] (may be NULL) receives the index, 0 for
 * samples of sockets.  Returns their number; more than MUKCA_MAX_LOGS count as one. */
int mukca_recording_number_logs(int *log, const mukca_dataset *data);

/* Multiply weight[n_samples] by those of the targets of each posture, of whose errors the common
 * part has `ratio` times the variance of the rest: as their correlation is c = ratio / (1 + ratio),
 * the likelihood of m of them has the power of m / (1 + (m - 1) c) readings (design effect of
 * clusters: L. Kish, Survey Sampling, 1965, section 5.4).  A covariance would take their
 * differences, which turn with the arm, as exact.  Returns the mean power; 1 without targets. */
double mukca_recording_count_targets(double *weight, const mukca_recording *recording,
                                     double ratio);

/* Compute moments, torques and mass factors: part of mukca_recording_create. */
void mukca_recording_load(mukca_recording *recording);

#endif
