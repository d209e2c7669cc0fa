/* Fast re-calibration from measured poses (Kana et al., Sensors 2022, 22, 2295).
 *
 * Step one fits joint zeros to orientations: J_rot(q) dq = (R'R~ - I)^v, stacked; step two fits
 * link offsets to positions: dP/dp dp = P~ - P.  Each is one linear regression, whose rows are
 * reduced block by block, once per pass. */
#ifndef MUKCA_RECALIBRATE_RECALIBRATE_H
#define MUKCA_RECALIBRATE_RECALIBRATE_H

#include <math.h>
#include <stddef.h>

#include "model/dataset.h"

/* ---- logs of joint angles with measured tip poses (pose_log.c) ---- */

/* Make a dataset a log: keep the samples with a measured position, as samples of no socket, and
 * complete their velocities, per second, or per row without times: those that are not recorded are
 * differences between neighbours, 0 if neighbours are more than 0.2 rad or m apart.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_pose_log_prepare(mukca_dataset *data, mukca_error *error);

/* Whether a row has an orientation. */
static inline bool mukca_pose_oriented(const mukca_dataset *log, int row)
{
    return log->quaternion && isfinite(log->quaternion[4 * (size_t)row]);
}

/* ---- unknowns: the arm's constants, the frames of its poses, a time lag (model.c) ---- */

/* kind, name, one letter per axis, whether it is an angle */
#define MUKCA_UNKNOWN_LIST(X)                                                                  \
    X(SHIFT, "", "xyz", false)   /* of an origin in its parent frame */                        \
    X(ZERO, "zero", "", true)    /* added to the encoder angle of a revolute joint */          \
    X(TILT, "tilt", "12", true)  /* of a revolute joint's axis about a transverse one */       \
    X(TURN, "turn", "xyz", true) /* of the base about the axes of the poses, of the tool about \
                                    its own */                                                 \
    X(LAG, "lag", "", false)     /* s (or samples): delay of the recorded angles */

typedef enum {
#define MUKCA_UNKNOWN_ENUM(kind, name, axes, angle) MUKCA_UNKNOWN_##kind,
    MUKCA_UNKNOWN_LIST(MUKCA_UNKNOWN_ENUM)
#undef MUKCA_UNKNOWN_ENUM
} mukca_unknown_kind;

/* Frames of the poses in place of an element: the arm's base, and the measured frame on the last
 * link. */
enum { MUKCA_UNKNOWN_BASE = -1, MUKCA_UNKNOWN_TOOL = MUKCA_MAX_ELEMENTS };

typedef struct {
    mukca_unknown_kind kind;
    int element; /* whose origin it is a part of */
    int axis;    /* 0, 1 or 2; of a tilt 0 or 1 */
    bool tool;   /* of the tool, which has no nominal value */
} mukca_unknown;

enum { MUKCA_MAX_UNKNOWNS = MUKCA_MAX_JOINTS * 6 + 3 + 12 + 1, MUKCA_UNKNOWN_TEXT = 64 + 16 };

/* "joint zero", "joint x", "base turn z", ... */
void mukca_unknown_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_unknown *unknown,
                        const mukca_chain *chain);

/* The element that it is a part of; NULL: a frame of the poses. */
const mukca_element *mukca_unknown_element(const mukca_unknown *unknown, const mukca_chain *chain);

/* Whether it is an angle (rad) rather than a length (m). */
bool mukca_unknown_is_angle(mukca_unknown_kind kind);

/* Predicted pose = base * arm(q + zero + lag * velocity) * tool. */
typedef struct {
    mukca_geometry geometry, placed; /* placed: in the poses' frame */
    double zero[MUKCA_MAX_JOINTS];
    mukca_frame base, tool;
    double lag;
} mukca_pose_model;

/* The nominal arm; R of a frame all 0: the identity. */
void mukca_pose_model_set(mukca_pose_model *model, const mukca_chain *chain,
                          const mukca_frame *base, const mukca_frame *tool);

/* Add `by` to the value of `unknown`. */
void mukca_pose_model_add(mukca_pose_model *model, const mukca_unknown *unknown, double by);

/* theta[6 * n_elements] with joint zeros expressed as origins; base, tool and lag are ignored. */
void mukca_pose_model_theta(double *theta, const mukca_pose_model *model, const mukca_chain *chain);

/* Frames of one pose, for residual and derivatives. */
typedef struct {
    const mukca_pose_model *model;          /* of the caller */
    const double *velocity;                 /* likewise: of the joints in this row */
    mukca_frame before[MUKCA_MAX_ELEMENTS]; /* pose of each element before its joint's rotation */
    mukca_frame tip;
    double position[3];       /* measured minus predicted, m; NaN: not measured */
    double rotation[3];       /* log of predicted' measured, rad; NaN: not measured */
    double rotation_error[3]; /* vector of predicted' measured - I */
} mukca_pose_look;

/* Row of a log that is prepared. */
void mukca_pose_look_at(mukca_pose_look *look, const mukca_pose_model *model,
                        const mukca_dataset *log, int row);

/* Derivatives of the predicted position (3 rows, m) and rotation (3 rows, about the tip's own axes)
 * by each unknown; the rows are `stride` doubles apart.  Either may be NULL. */
void mukca_pose_derivatives(double *position, double *rotation, int stride,
                            const mukca_pose_look *look, const mukca_unknown *unknowns, int n);

/* ---- statistics of pose errors, accumulated row by row in constant memory ---- */

typedef struct {
    long n;
    double max, mean, m2; /* m2: sum of squares about the mean */
} mukca_moments;

/* Lengths kept for medians: evenly spread rows, which determine it to 1 %. */
enum { MUKCA_KEPT_LENGTHS = 8192 };

typedef struct {
    mukca_moments length;  /* m; rad */
    mukca_moments axis[3]; /* absolute; of a rotation: vector of R'R~ - I */
    double median;         /* length; 0 without errors */
    double kept[MUKCA_KEPT_LENGTHS];
    int n_kept;
    long between; /* rows from one kept length to the next; 0: none is kept yet */
} mukca_vector_errors;

typedef struct {
    mukca_vector_errors position, rotation;
} mukca_pose_errors;

void mukca_pose_errors_add(mukca_pose_errors *errors, const mukca_pose_look *look);

/* Set the medians after the last row. */
void mukca_pose_errors_finish(mukca_pose_errors *errors);

/* Standard deviation, 1 / (n - 1); 0 for n < 2. */
double mukca_moments_std(const mukca_moments *moments);

/* ---- a linear least-squares problem built row by row (system.c) ----
 *
 * Block QR, then a minimum-norm solution and the combinations that the rows do not determine. */

/* A block and the triangular factor fit in 32 KiB of cache for 31 unknowns. */
enum { MUKCA_SYSTEM_WIDTH = MUKCA_MAX_UNKNOWNS + 1, MUKCA_SYSTEM_BLOCK = 96 };

typedef struct {
    int n;                     /* unknowns; a lag is the last */
    bool positions, rotations; /* equations of a pose that it uses */
    double metres_per_radian;  /* weight of rotation rows relative to position rows; 0: 1 */
    mukca_unknown unknown[MUKCA_MAX_UNKNOWNS];
    long equations;
    double rss;                                        /* of the weighted rows */
    double R[MUKCA_MAX_UNKNOWNS * MUKCA_SYSTEM_WIDTH]; /* [n][n + 1], with Q'b */
    /* Rows not yet absorbed: positions, rotations.  They are separate because lengths have no
     * effect on rotations: the leading columns of rotation rows are zero if the lengths are the
     * first unknowns. */
    double block[2][MUKCA_SYSTEM_BLOCK * MUKCA_SYSTEM_WIDTH];
    int filled[2];
    double x[MUKCA_MAX_UNKNOWNS]; /* solution: of minimum norm, first in the arm's unknowns, then in
                                     the tool's */
    /* scratch: factors of the equations, products of the null space */
    double U[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS], V[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS],
        A[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS];
} mukca_pose_system;

/* Estimates of the unknowns of one or two systems, one after the other. */
typedef struct {
    int n, rank;
    mukca_unknown unknown[MUKCA_MAX_UNKNOWNS];
    double value[MUKCA_MAX_UNKNOWNS]; /* sum of the steps */
    double sigma[MUKCA_MAX_UNKNOWNS]; /* standard error within the identifiable subspace */
    bool identifiable[MUKCA_MAX_UNKNOWNS];
    int n_null;
    double null[MUKCA_MAX_UNKNOWNS][MUKCA_MAX_UNKNOWNS]; /* [n_null][n] unidentifiable; sparse */
} mukca_pose_estimates;

/* Remove all rows. */
void mukca_pose_system_clear(mukca_pose_system *system);

/* Add the rows of one pose, both sides multiplied by `weight` (position) and `turn_weight`. */
void mukca_pose_system_add(mukca_pose_system *system, const mukca_pose_look *look, double weight,
                           double turn_weight);

/* Solve for the first `n` unknowns; the others stay 0.  Appends them to the estimates, without a
 * lag.  An unknown with a standard error above `loosest` (m or rad) is not identifiable.  False:
 * the rows are not finite. */
bool mukca_pose_system_solve(mukca_pose_estimates *estimates, mukca_pose_system *system, int n,
                             double loosest);

/* Distance of the last unknown from 0, in standard errors. */
double mukca_pose_system_last(mukca_pose_system *system);

typedef struct {
    bool iterate;           /* repeat the linearisation until convergence */
    bool joint;             /* both steps as one problem; implied if no pose has an orientation */
    bool robust;            /* Huber weights; implies iterate */
    bool tilts;             /* also fit the tilts of the joint axes */
    bool free_base;         /* the arm's base in the poses' frame is unknown */
    bool free_tool;         /* the rotation of the measured frame relative to the tip is unknown */
    mukca_frame base, tool; /* of the poses: start values; R all 0: the identity */
    bool (*stop)(void);     /* true aborts with MUKCA_INTERRUPTED; may be NULL */
} mukca_recalibrate_options;

enum { MUKCA_BEFORE, MUKCA_WITH_ANGLES, MUKCA_WITH_BOTH, MUKCA_STAGES };

/* Medians of the errors of the nominal and the fitted model, m or rad, and the part that the fit
 * removes; 0 without measurements. */
typedef struct {
    double nominal, left, systematic;
} mukca_pose_gain;

typedef struct {
    mukca_pose_estimates found;
    mukca_pose_model stage[MUKCA_STAGES];
    mukca_pose_errors errors[MUKCA_STAGES]; /* on the log itself, by stage */
    bool has_angles;                        /* whether the stage "with angular offsets" exists */
    mukca_pose_gain position, rotation;
    bool calibrated; /* the poses contain a calibration: one of the two removes more than it leaves
                      */
    double lag,
        lag_score; /* lag: s, or rows without times; 0: none found; score: in standard errors */
    double tail;   /* ratio of rms to median of the remaining error, 1 for normal errors; the larger
                      of position and orientation */
    int passes;
    bool converged; /* the last of the repeated steps was small, or a single linear step was
                       requested */
} mukca_recalibration;

/* Input of a fit or a test. */
typedef struct {
    const mukca_chain *chain;
    const mukca_dataset *log; /* prepared */
    const mukca_recalibrate_options *options;
} mukca_recalibrate_task;

/* Fit the log.  Errors: MUKCA_UNIDENTIFIABLE (fewer equations than unknowns), MUKCA_INTERRUPTED,
 * MUKCA_MEMORY, MUKCA_INPUT (numbers that are not finite). */
mukca_status mukca_recalibrate(mukca_recalibration *result, const mukca_recalibrate_task *task,
                               mukca_error *error);

/* Compute the errors of models[n] on the task's log.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_recalibrate_test(mukca_pose_errors *errors, const mukca_pose_model *models,
                                    int n, const mukca_recalibrate_task *task, mukca_error *error);

/* Checks of the first rows of a log: the link of the poses (check.c). */
typedef struct {
    int position_element, rotation_element; /* elements whose child links the poses belong to */
    mukca_frame base, tool; /* start values: base in the poses' frame, tool in the tip's */
    const char *open;       /* what the poses leave open of these, NULL: nothing */
} mukca_pose_check;

/* Determine these from the log.  With the task's free_base or free_tool the frames are unknown and
 * the last element is assumed.  Errors: MUKCA_INPUT with the defect (no poses, a stopped
 * stream, poses far from the arm, of a link before a joint, a rotated frame), MUKCA_MEMORY. */
mukca_status mukca_pose_check_run(mukca_pose_check *check, const mukca_recalibrate_task *task,
                                  mukca_error *error);

#endif
