/* Simulated runs of a moving arm: joint angles and the torques of its drives, with chosen effects.
 *
 * Every joint follows a sum of sines below `band` between two standstills, exactly; a drive's
 * torque is that of the rigid body plus the effects.  Link collisions are not looked at. */
#ifndef MUKCA_SIMULATE_MOTION_H
#define MUKCA_SIMULATE_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "mukca/chain.h"

typedef enum {
    MUKCA_SIMULATED_AT_JOINT,
    MUKCA_SIMULATED_AT_ALL, /* or at one joint */
    MUKCA_SIMULATED_AT_TIP
} mukca_simulated_where;

typedef struct {
    const char *name, *unit;
} mukca_simulated_value;

/* A row of the catalogue. */
typedef struct {
    const char *name;
    mukca_simulated_where where;
    int least, most; /* number of values */
    bool masses;     /* it changes the inertial parameters, others torques */
    mukca_simulated_value value[4], variant; /* variant: after @; NULL: none */
    double usual;                            /* its default; 0: it must be given */
} mukca_simulated_kind;

extern const mukca_simulated_kind mukca_simulated_kinds[];

int mukca_simulated_kind_find(const char *name); /* -1: none */

typedef struct {
    int kind, joint; /* joint -1: all, or the tip */
    double value[4], variant;
} mukca_simulated_torque;

typedef struct {
    const mukca_chain *chain;
    const mukca_simulated_torque *effects;
    int n_effects;
    int runs;                  /* one after the other, with MUKCA_RUN_PAUSE between them */
    double seconds;            /* of a run */
    double rate;               /* rows per second */
    double speed;              /* largest velocity, rad/s */
    double noise;              /* of the torques, sigma as a part of half a joint's range */
    uint64_t seed;             /* of paths and noise */
    bool (*interrupted)(void); /* polled at each row; may be NULL */
} mukca_simulated_motion;

#define MUKCA_RUN_PAUSE 10.0 /* s, in which the arm is brought to the start of the next run */

/* A row: s, rad, N m. */
typedef void mukca_motion_writer(void *context, double time, const double *q, const double *effort);

/* Write all rows.  Errors: MUKCA_INTERRUPTED. */
mukca_status mukca_simulate_motion(const mukca_simulated_motion *motion, mukca_motion_writer *write,
                                   void *context);

#endif
