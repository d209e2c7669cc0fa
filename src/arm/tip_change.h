/* Displacement of the tip from one offsets table, or the nominal model, to another. */
#ifndef MUKCA_ARM_TIP_CHANGE_H
#define MUKCA_ARM_TIP_CHANGE_H

#include "arm/offsets.h"
#include "model/dataset_subset.h"

/* Largest displacement of the tip by any calibration, m: four times that at which samples are of
 * another arm (accept/accept.c). */
#define MUKCA_MOST_TIP_CHANGE 0.2

typedef struct {
    const mukca_chain *chain;
    const mukca_offsets *from; /* NULL: the nominal model */
    const mukca_offsets *to;
    const mukca_dataset *data; /* adds its postures; may be NULL */
    bool base_frame; /* the first element is a tracker's frame, the last one an unknown target: */
    bool tool_frame; /* they are not part of the arm, and their offsets are ignored */
    bool free_base;  /* poses are in an unknown frame, for which the chain has no element */
    int threads;     /* of a posterior, as of mukca_workers_start */
} mukca_tip_change_task;

/* Pose of the tip in the posture and state, with effects[n]. */
void mukca_tip_pose(mukca_frame *tip, const mukca_effect *effects, int n, const mukca_chain *chain,
                    const mukca_geometry *geometry, const mukca_joint_state *state);

/* The same with the effects of a table (NULL: none), in an unknown state of the joints. */
void mukca_offsets_tip(mukca_frame *tip, const mukca_offsets *table, const mukca_chain *chain,
                       const mukca_geometry *geometry, const double *q);

/* Remove the first element, the frame of a tracker: gravity and effects are of the arm's base. */
void mukca_chain_remove_first(mukca_chain *chain);

/* Whether an element is a frame of the measurement. */
bool mukca_tip_change_is_frame(const mukca_tip_change_task *task, int element);

/* Over the postures of the data and a fixed random sample within the joint limits. */
typedef struct {
    double m;    /* largest displacement of the tip */
    double size; /* relative change of the tip's standard deviation over the random sample, with
                    the same tool: of all lengths */
} mukca_tip_change;

/* Errors: MUKCA_MEMORY. */
mukca_status mukca_tip_change_find(mukca_tip_change *change, const mukca_tip_change_task *task,
                                   mukca_error *error);

/* Set tip_change, size_change and largest_offset in to->acceptance, relative to the nominal model.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_tip_change_judge(mukca_offsets *to, const mukca_tip_change_task *task,
                                    mukca_error *error);

#endif
