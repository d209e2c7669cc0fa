/* Checks of the first rows of a pose log: units, quaternion order, and the link of the poses. */
#ifndef MUKCA_RECALIBRATE_CHECK_H
#define MUKCA_RECALIBRATE_CHECK_H

#include "recalibrate/recalibrate.h"

typedef struct {
    int rotations;                          /* samples with a quaternion */
    int position_element, rotation_element; /* whose child link the poses belong to */
    double position_median;                 /* m: measured to that link, nominal */
    mukca_quaternion_order order;
    mukca_frame base, tool; /* first guess: of the arm in the poses' frame, of these in the tip */
} mukca_pose_check;

/* Decide on these.  With the task's free_base or free_tool the frames are unknown (then the last
 * element is taken).  Errors: MUKCA_INPUT with what is wrong (millimetres, degrees, poses of
 * another row, of another link before a joint, a turned frame), MUKCA_MEMORY, and the log's own. */
mukca_status mukca_pose_check_run(mukca_pose_check *check, const mukca_recalibrate_task *task,
                                  mukca_error *error);

#endif
