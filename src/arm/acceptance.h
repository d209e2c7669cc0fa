/* The verdict of an offsets table: whether the calibration or diagnosis that wrote it was
 * acceptable.
 *
 * The table contains it in comment lines "# key: value": every reader can refuse a table that was
 * not accepted. */
#ifndef MUKCA_ARM_ACCEPTANCE_H
#define MUKCA_ARM_ACCEPTANCE_H

#include <stdbool.h>

#include "base/text.h"

/* Numbers of the verdict: member, key in the table and in JSON.  NaN: unknown, omitted. */
#define MUKCA_ACCEPTANCE_LIST(X)                                                           \
    X(noise_m)          /* measurement noise per axis */                                   \
    X(parameters)       /* free parameters */                                              \
    X(identified)       /* combinations that the data identify */                          \
    X(postures)         /* different ones among the samples */                             \
    X(error_here_m)     /* expected error of the tip in the joint ranges of the samples */ \
    X(error_here_low_m) /* its 95 % interval */                                            \
    X(error_here_high_m)                                                                   \
    X(error_here_distance_m) /* part of error_here_m by the sockets' distances */          \
    X(error_lacking_m)       /* part of error_here_m by effects that the table lacks */    \
    X(error_before_here_m)   /* that of the model which the table replaces */              \
    X(error_workspace_m)     /* the same within the joint limits */                        \
    X(error_workspace_low_m)                                                               \
    X(error_workspace_high_m)                                                              \
    X(error_before_m)                                                                      \
    X(error_nominal_m)    /* mean error of the replaced model on held-out samples */       \
    X(error_m)            /* of this model on the same samples, `error_of` */              \
    X(error_sigma_m)      /* standard error of their difference */                         \
    X(tip_change_m)       /* largest displacement of the tip in the workspace */           \
    X(size_change)        /* of the workspace, relative; the socket distance sets it */    \
    X(largest_offset_m)   /* largest change of a length parameter */                       \
    X(largest_offset_rad) /* of an angle parameter; without frames of measurement */

enum {
#define MUKCA_ACCEPTANCE_ENUM(key) MUKCA_ACCEPTANCE_##key,
    MUKCA_ACCEPTANCE_LIST(MUKCA_ACCEPTANCE_ENUM)
#undef MUKCA_ACCEPTANCE_ENUM
        MUKCA_ACCEPTANCE_NUMBERS,
    MUKCA_ACCEPTANCE_SENTENCE = 1280
};

typedef struct {
    bool given; /* false: there is no verdict */
    bool accepted, converged;
    bool intact;       /* the table that was read matches its digest */
    char reason[512];  /* reason of the refusal and remedy; empty if accepted */
    char error_of[64]; /* samples of the error: "cross-validation, 3 folds" */
    char at_rest[96];  /* joints that did not move: "joint_6, joint_7" */
    union {
        struct {
#define MUKCA_ACCEPTANCE_MEMBER(key) double key;
            MUKCA_ACCEPTANCE_LIST(MUKCA_ACCEPTANCE_MEMBER)
#undef MUKCA_ACCEPTANCE_MEMBER
        };
        double number[MUKCA_ACCEPTANCE_NUMBERS]; /* the same */
    };
} mukca_acceptance;

/* Keys of the numbers. */
extern const char *const mukca_acceptance_key[MUKCA_ACCEPTANCE_NUMBERS];

/* Initialise without verdict, numbers NaN. */
void mukca_acceptance_init(mukca_acceptance *acceptance);

/* Refuse the table for this reason (a printf format); sets `given`, clears `accepted`. */
void mukca_acceptance_refuse(mukca_acceptance *acceptance, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Expected error of the tip: "0.71 mm [0.52, 0.93] in the joint ranges of the samples, ...";
 * nothing if unknown.  `factory`: the fit started from a factory file instead of the URDF's
 * origins. */
void mukca_acceptance_put_tip(mukca_text *text, const mukca_acceptance *a, bool factory);

/* Whether to use the table: "yes: held-out error ..." or "no: ..."; no full stop. */
void mukca_acceptance_put_use(mukca_text *text, const mukca_acceptance *a, bool factory);

/* The verdict in brief: "accepted; expected error of the tip ..." or "not accepted: ...". */
void mukca_acceptance_put_brief(mukca_text *text, const mukca_acceptance *acceptance);

/* Parse a comment line of a table; other lines are ignored. */
void mukca_acceptance_read(mukca_acceptance *acceptance, const char *line);

#endif
