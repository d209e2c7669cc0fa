/* Displacement of an arm by its effects, and its derivatives by the joint angles. */
#ifndef MUKCA_EFFECT_APPLY_H
#define MUKCA_EFFECT_APPLY_H

#include "mukca/effect.h"

/* The effects of an arm at the encoder angles state.q. */
typedef struct {
    const mukca_effect *effects; /* [n_effects] */
    int n_effects;
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    mukca_joint_state state;
} mukca_effect_task;

/* Derivatives by the joint angles, of load-independent effects. */
typedef struct {
    /* of a joint's displaced angle, by the angle of the previous joint, its own, the next one's */
    double angle[MUKCA_MAX_JOINTS][3];
    double rotation[MUKCA_MAX_JOINTS][3]; /* of the rotation vector, by the joint's angle */
    bool rotates;                         /* false: `rotation` is zero */
} mukca_effect_slopes;

/* Displacement by the effects, under the gravity load of the displaced posture; slopes may be NULL.
 */
void mukca_effects_apply(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                         const mukca_effect_task *task);

#endif
