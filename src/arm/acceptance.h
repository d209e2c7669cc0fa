/* Whether an offsets table may be used: the verdict of the run that wrote it.
 *
 * The table holds it in comment lines "# key: value", so that every reader can refuse a table that
 * did not pass.
 */
#ifndef MUKCA_ARM_ACCEPTANCE_H
#define MUKCA_ARM_ACCEPTANCE_H

#include <stdbool.h>
#include <stddef.h>

/* Numbers of the verdict: member, and key in the table and in JSON.  NaN: not known, and left out.
 */
#define MUKCA_ACCEPTANCE_LIST(X)                                                         \
    X(noise_m)            /* measurement noise per axis */                               \
    X(parameters)         /* free ones */                                                \
    X(identified)         /* combinations of them that the data identify */              \
    X(determined)         /* those that the data determine better than regularisation */ \
    X(error_nominal_m)    /* mean error of the nominal model ... */                      \
    X(error_m)            /* ... and of this one, on the samples of `error_of` */        \
    X(tip_change_m)       /* largest displacement of the tip in the workspace */         \
    X(tip_change_sigma)   /* the same over its prior standard deviation */               \
    X(largest_offset_m)   /* of one parameter that is a length, */                       \
    X(largest_offset_rad) /* of one that is an angle; without frames of measurement */

enum { MUKCA_ACCEPTANCE_TEXT = 160, MUKCA_ACCEPTANCE_SENTENCE = 256 };

typedef struct {
    bool given; /* false: nobody has judged the table */
    bool accepted, converged;
    char reason[MUKCA_ACCEPTANCE_TEXT]; /* why it is not accepted, what to do; else empty */
    char error_of[64];                  /* samples of the error: "cross-validation, 3 folds" */
#define MUKCA_ACCEPTANCE_MEMBER(key) double key;
    MUKCA_ACCEPTANCE_LIST(MUKCA_ACCEPTANCE_MEMBER)
#undef MUKCA_ACCEPTANCE_MEMBER
} mukca_acceptance;

/* The numbers by their keys; ended by a NULL key. */
typedef struct {
    const char *key;
    size_t offset; /* of the double in mukca_acceptance */
} mukca_acceptance_number;
extern const mukca_acceptance_number mukca_acceptance_numbers[];

/* Nothing is known: no verdict, numbers NaN. */
void mukca_acceptance_init(mukca_acceptance *acceptance);

/* Accept or refuse by `converged` and the numbers; `stop` (may be NULL) tells why the solver ended.
 * Numbers that are NaN are not judged, but error_m is needed. */
void mukca_acceptance_judge(mukca_acceptance *acceptance, const char *stop);

/* Refuse the table for this reason (a printf format): it is given and not accepted. */
void mukca_acceptance_refuse(mukca_acceptance *acceptance, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The verdict as a sentence for people, without a full stop; `factory`: the fit began with a
 * factory file, not with the URDF's origins. */
void mukca_acceptance_sentence(char text[MUKCA_ACCEPTANCE_SENTENCE],
                               const mukca_acceptance *acceptance, bool factory);

/* Take up a comment line of a table; other lines are left alone. */
void mukca_acceptance_read(mukca_acceptance *acceptance, const char *line);

#endif
