/* Derivatives of what effects do, by the joints' angles and by gravity's load. */
#ifndef MUKCA_EFFECT_SLOPES_H
#define MUKCA_EFFECT_SLOPES_H

#include "mukca/effect.h"

/* All effects together, per joint. */
typedef struct {
    /* of the angle that is added, by the angle of the joint before, its own, that of the next */
    double angle[MUKCA_MAX_JOINTS][3];
    double rotation[MUKCA_MAX_JOINTS][3]; /* of the rotation vector, by its own angle */
    double spring[MUKCA_MAX_JOINTS];      /* of the angle, by the torque, rad/(N m) */
    double bend[MUKCA_MAX_JOINTS]; /* of the rotation vector, by the moment across the axis */
    double base;                   /* of the base's rotation vector, by its moment */
} mukca_effect_slopes;

/* Add the slopes of `n` effects by angles.  `slopes` is zeroed at the start. */
void mukca_effects_slopes_by_angle(mukca_effect_slopes *slopes, const mukca_effect *effects, int n,
                                   const mukca_chain *chain, const mukca_joint_state *state);

/* The same by load, at state->torque. */
void mukca_effects_slopes_by_load(mukca_effect_slopes *slopes, const mukca_effect *effects, int n,
                                  const mukca_joint_state *state);

#endif
