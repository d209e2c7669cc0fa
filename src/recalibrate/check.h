/* Checks of the first rows of a pose log: quaternion order, and the link of the poses. */
#ifndef MUKCA_RECALIBRATE_CHECK_H
#define MUKCA_RECALIBRATE_CHECK_H

#include "recalibrate/recalibrate.h"

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
