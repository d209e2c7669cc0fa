/* How far one offsets table moves the tip against another, or against the nominal model. */
#ifndef MUKCA_ARM_TIP_CHANGE_H
#define MUKCA_ARM_TIP_CHANGE_H

#include "arm/offsets.h"
#include "math/random.h"

typedef struct {
    const mukca_chain *chain;
    const mukca_offsets *from; /* NULL: the nominal model */
    const mukca_offsets *to;
    const mukca_dataset *data; /* its postures count, too; may be NULL */
    bool base_frame; /* the first element is a tracker's frame, the last one an unknown target: */
    bool tool_frame; /* they are no part of the arm, and their offsets do not count */
} mukca_tip_change_task;

/* Largest displacement of the tip, m, over the postures of the data and a fixed sample of those
 * within the joint limits; *sigma (may be NULL) is the largest ratio to the prior standard
 * deviation of the displacement in the same posture. */
double mukca_tip_change(double *sigma, const mukca_tip_change_task *task);

/* q[n_joints]: a posture within the joint limits; a joint without any turns once, or travels 1 m.
 */
void mukca_posture_draw(double *q, const mukca_chain *chain, mukca_random *random);

/* Fill the sizes in to->acceptance: tip_change and largest_offset, against the nominal model. */
void mukca_tip_change_judge(mukca_offsets *to, const mukca_tip_change_task *task);

#endif
