/* Survey of a recording: the facts that determine testable effects and variants. */
#ifndef MUKCA_EFFECT_SURVEY_H
#define MUKCA_EFFECT_SURVEY_H

#include "mukca/effect.h"

typedef struct {
    int n_joints, n_placements;
    bool moments, torques; /* holding moments, torques about the axes are known in each sample */
    bool moved;            /* some joint moved between samples */
    bool by_command;       /* the angles were commanded, not read */
    bool commanded;        /* some commanded angle differs from the read angle */
    bool sockets;          /* socket data, not a pose log */
    bool pairs;            /* two pairs of sockets with a known distance */
    struct {
        bool turns;                       /* not prismatic */
        double range;                     /* of the angle, rad or m */
        double torque_low, torque_high;   /* N m (forces: N) */
        double torque_most, torque_least; /* largest and smallest magnitude */
    } joint[MUKCA_MAX_JOINTS];
} mukca_effect_survey;

/* The i-th candidate variant of a kind at a joint (-1: not at a joint); false: no more.  Sets all
 * of `effect` but its coefficients. */
bool mukca_effect_candidate(mukca_effect *effect, mukca_effect_kind kind, int joint,
                            const mukca_effect_survey *survey, int i);

/* Reason why a kind has no candidate in a recording, none at a joint, or is not detectable. */
const char *mukca_effect_missing(mukca_effect_kind kind, const mukca_effect_survey *survey);
const char *mukca_effect_untested(mukca_effect_kind kind, const mukca_effect_survey *survey,
                                  int joint);
const char *mukca_effect_faint(mukca_effect_kind kind, int joint);

#endif
