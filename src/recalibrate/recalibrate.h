/* Re-calibration from measured poses: the fit of mukca_fit_run and its restrictions to joint zeros
 * and link offsets (Kana et al., Sensors 2022, 22, 2295), of angles corrected for a lag. */
#ifndef MUKCA_RECALIBRATE_RECALIBRATE_H
#define MUKCA_RECALIBRATE_RECALIBRATE_H

#include "fit/fit.h"
#include "recalibrate/errors.h"

/* ---- logs of joint angles with measured tip poses (pose_log.c) ---- */

/* Make a dataset a log: keep the samples with a measured position, as samples of no socket, and
 * complete their velocities, per second, or per row without times: those that are not recorded are
 * differences between neighbours, 0 if neighbours are more than 0.2 rad or m apart.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_pose_log_prepare(mukca_dataset *data, mukca_error *error);

/* Add to the angles the lag times the velocities. */
void mukca_pose_log_shift(mukca_dataset *log, double lag);

/* ---- the arm with a parameter for each joint zero (split.c) ---- */

/* Each joint is a fixed element with the origin, whose x y z are the link offsets, and one that
 * turns about x, y or z from there, whose angle about that axis is the zero. */
typedef struct {
    mukca_chain chain;
    int of[MUKCA_MAX_ELEMENTS]; /* element of the arm */
    int axis[MUKCA_MAX_JOINTS]; /* of a joint's zero: 0, 1, 2; -1: none, it does not turn */
    double sign[MUKCA_MAX_JOINTS];
} mukca_split_arm;

/* Errors: MUKCA_INPUT (too many elements). */
mukca_status mukca_split_arm_set(mukca_split_arm *split, const mukca_chain *arm,
                                 mukca_error *error);

/* A parameter of a fit of split arms in the words of the arm. */
typedef struct {
    char text[MUKCA_NAME_SIZE + 16]; /* "joint zero", "joint x", "base turn z", ... */
    int element;                     /* of the arm; -1: a frame of the poses */
    double sign;
    bool angle; /* rad, else m */
} mukca_unknown;

void mukca_split_arm_name(mukca_unknown *unknown, const mukca_split_arm *split,
                          const mukca_chain *arm, const mukca_fit *fit, int i);

/* ---- the whole re-calibration (recalibrate.c) ---- */

enum { MUKCA_BEFORE, MUKCA_WITH_ANGLES, MUKCA_WITH_LENGTHS, MUKCA_WITH_ALL, MUKCA_STAGES };

/* Medians of the errors of the nominal and the fitted model, m or rad, and the part that the fit
 * removes; 0 without measurements. */
typedef struct {
    double nominal, left, systematic;
} mukca_pose_gain;

typedef struct {
    mukca_split_arm split;
    mukca_fit lengths;            /* of joint zeros and link offsets, in split.chain */
    mukca_fit all;                /* of all parameters: the result */
    double start[MUKCA_MAX_FREE]; /* of `lengths`: nominal, with the frames aligned */
    mukca_fit_options options;    /* of `all` */
    mukca_geometry stage[MUKCA_STAGES];
    mukca_pose_errors errors[MUKCA_STAGES]; /* on the log itself */
    bool has_angles;                        /* whether the stage "angular offsets" exists */
    mukca_pose_gain position, rotation;
    bool calibrated; /* the poses contain a calibration: one of the two removes more than it leaves
                      */
    double lag, lag_score;
    double tail;  /* ratio of rms to median of the remaining error, 1 for normal errors; the larger
                     of position and orientation */
    bool trimmed; /* the gains, and with `robust` the fits, are without outliers */
} mukca_recalibration;

/* Fit the arm to a log, whose angles are then corrected for a lag, with these frames and limits of
 * the options; `robust`: without outliers.  Errors: MUKCA_UNIDENTIFIABLE (fewer equations than
 * unknowns), those of mukca_fit_run. */
mukca_status mukca_recalibrate(mukca_recalibration *result, const mukca_chain *arm,
                               mukca_dataset *log, const mukca_fit_options *options, bool robust,
                               mukca_error *error);

/* Checks of the first rows of a log: the link of the poses (check.c). */
typedef struct {
    int position_element, rotation_element; /* elements whose child links the poses belong to */
    double turn[9];                         /* of the orientations' link in the positions' one */
} mukca_pose_check;

/* Determine these from the log; with free frames the last element is assumed.  Errors: MUKCA_INPUT
 * with the defect (no poses, a stopped stream, poses far from the arm, of a link before a joint, a
 * rotated frame), MUKCA_MEMORY. */
mukca_status mukca_pose_check_run(mukca_pose_check *check, const mukca_chain *chain,
                                  const mukca_dataset *log, bool free_frames, mukca_error *error);

#endif
