/* Fast re-calibration from measured poses (Kana et al., Sensors 2022, 22, 2295).
 *
 * Step one fits joint zeros to orientations: J_rot(q) dq = (R'R~ - I)^v, stacked; step two fits
 * link offsets to positions: dP/dp dp = P~ - P.  Each is one linear regression whose rows are
 * reduced while the log is read, once per pass. */
#ifndef MUKCA_RECALIBRATE_RECALIBRATE_H
#define MUKCA_RECALIBRATE_RECALIBRATE_H

#include "recalibrate/errors.h"
#include "recalibrate/system.h"

typedef struct {
    bool iterate;   /* repeat the linearisation until convergence */
    bool joint;     /* both steps as one problem; implied if no pose has an orientation */
    bool robust;    /* Huber weights; implies iterate */
    bool tilts;     /* also fit the tilts of the joint axes */
    bool free_base; /* the arm's base in the poses' frame is unknown */
    bool free_tool; /* the rotation of the measured frame relative to the tip is unknown */
    mukca_quaternion_order order;
    mukca_frame base, tool; /* of the poses: start values; R all 0: the identity */
    bool (*stop)(void);     /* true aborts with MUKCA_INTERRUPTED; may be NULL */
} mukca_recalibrate_options;

enum { MUKCA_BEFORE, MUKCA_WITH_ANGLES, MUKCA_WITH_BOTH, MUKCA_STAGES };

typedef struct {
    int n; /* number of unknowns */
    mukca_unknown unknown[MUKCA_MAX_UNKNOWNS];
    double value[MUKCA_MAX_UNKNOWNS], sigma[MUKCA_MAX_UNKNOWNS];
    bool identifiable[MUKCA_MAX_UNKNOWNS];
    int rank, n_null;
    double null[MUKCA_MAX_UNKNOWNS][MUKCA_MAX_UNKNOWNS]; /* [n_null][n] unidentifiable */
    mukca_pose_model stage[MUKCA_STAGES];
    mukca_pose_errors errors[MUKCA_STAGES]; /* on the log itself, by stage */
    bool has_angles;                        /* whether the stage "with angular offsets" exists */
    long rows, rotations;                   /* poses, and those with an orientation */
    double lowest[MUKCA_MAX_JOINTS], highest[MUKCA_MAX_JOINTS]; /* of q */
    bool lag_found, in_rows; /* whether a lag was found; its unit is rows, not s */
    double lag, lag_score;   /* score: in standard errors */
    double tail; /* ratio of rms to median of the remaining error, 1 for normal errors; the larger
                    of position and orientation */
    int passes;
    bool converged; /* the last of the repeated steps was small, or a single linear step was
                       requested */
} mukca_recalibration;

/* Input of a fit or a test. */
typedef struct {
    const mukca_chain *chain;
    const mukca_pose_log *logs;
    int n_logs;
    const mukca_recalibrate_options *options;
} mukca_recalibrate_task;

/* Fit the log.  Errors: MUKCA_UNIDENTIFIABLE (fewer equations than unknowns), MUKCA_INTERRUPTED,
 * MUKCA_MEMORY, MUKCA_INPUT (numbers that are not finite), and the log's own. */
mukca_status mukca_recalibrate(mukca_recalibration *result, const mukca_recalibrate_task *task,
                               mukca_error *error);

/* Compute the errors of models[n] on the task's logs. */
mukca_status mukca_recalibrate_test(mukca_pose_errors *errors, const mukca_pose_model *models,
                                    int n, const mukca_recalibrate_task *task, mukca_error *error);

/* Create a reader of the task's logs. */
mukca_pose_reader mukca_recalibrate_reader(const mukca_recalibrate_task *task);

/* Whether the poses contain a calibration: the part of the error that the fit removes must exceed
 * the remaining error (medians), in position or in orientation. */
typedef struct {
    bool calibrated;
    double position_nominal, position_left, position_systematic; /* m */
    double rotation_nominal, rotation_left, rotation_systematic; /* rad; 0 without orientations */
} mukca_oracle;
void mukca_recalibrate_oracle(mukca_oracle *oracle, const mukca_recalibration *result);

/* Checks of the first rows of a log: quaternion order, and the link of the poses (check.c). */
typedef struct {
    int rotations;                          /* samples with a quaternion */
    int position_element, rotation_element; /* elements whose child links the poses belong to */
    double position_median;                 /* median distance to that link in the nominal arm, m */
    mukca_quaternion_order order;
    mukca_frame base, tool; /* start values: base in the poses' frame, tool in the tip's */
} mukca_pose_check;

/* Determine these from the log.  With the task's free_base or free_tool the frames are unknown and
 * the last element is assumed.  Errors: MUKCA_INPUT with the defect (a stopped stream, poses of
 * other rows, of a link before a joint, a rotated frame), MUKCA_MEMORY, and those of the log. */
mukca_status mukca_pose_check_run(mukca_pose_check *check, const mukca_recalibrate_task *task,
                                  mukca_error *error);

#endif
