/* What each effect tells the program: one const struct per effect, collected by catalogue.c. */
#ifndef MUKCA_EFFECT_CATALOGUE_H
#define MUKCA_EFFECT_CATALOGUE_H

#include "effect/survey.h"
#include "mukca/effect.h"

/* How the variants of an effect are written and chosen. */
typedef struct {
    const char *key;      /* in the offsets table, before "="; NULL: the word stands alone */
    const char *expected; /* for help and errors: "@ORDER, 2 to 400" */
    bool (*read)(mukca_effect_variant *variant, const char *text);
    void (*write)(char *text, size_t size, const mukca_effect_variant *variant);
    /* the variant to take where none is given; false: it must be given; NULL: all zero */
    bool (*usual)(mukca_effect *effect, int n_joints);
    bool (*fits)(const mukca_effect *effect, int n_joints); /* NULL: always */
} mukca_variant_ops;

enum { MUKCA_MAX_SIZES = 8 };

/* How large an effect is in real arms: prior sigmas of a coefficient, ended by 0.  The first
 * `usual` ones are equally probable, the others MUKCA_RARE_SIZE times as much.  In the
 * coefficient's unit; site ANGLES: rms turn of the joints, rad. */
typedef struct {
    int usual;
    double sigma[MUKCA_MAX_SIZES];
} mukca_effect_sizes;

#define MUKCA_RARE_SIZE 0.01

/* Sizes that several effects share; sizes.c names the sources. */
extern const mukca_effect_sizes mukca_sizes_spring, mukca_sizes_play, mukca_sizes_angle,
    mukca_sizes_ripple, mukca_sizes_zero, mukca_sizes_ball, mukca_sizes_socket;

/* Members that do not apply are NULL. */
typedef struct {
    mukca_effect_info info;
    const mukca_effect_sizes *sizes; /* NULL: mukca_sizes_angle */
    void (*basis)(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                  const double axis[3], const mukca_joint_state *state);
    /* site ANGLES, instead of basis: direction[n_joints], zeroed before */
    void (*direction)(double *direction, int n_joints, const mukca_effect *effect,
                      const mukca_joint_state *state);
    const mukca_variant_ops *variant;
    int (*terms)(const mukca_effect_variant *variant);                     /* NULL: info.terms */
    const char *const *(*term_names)(const mukca_effect_variant *variant); /* of several terms */
    int (*read_old_term)(mukca_effect *effect, const char *text); /* of older tables; -1: not one */
    void (*describe)(char *text, size_t size, const mukca_effect *effect, const mukca_chain *chain);
    /* The i-th variant to try with a recording, at effect->joint; false: no more. */
    bool (*candidate)(mukca_effect *effect, const mukca_effect_survey *survey, int i);
    const char *missing; /* why there is no candidate at all though its needs are met */
    /* Why there is none at this joint; NULL: the reason that holds for all effects. */
    const char *(*untested)(const mukca_effect_survey *survey, int joint);
    const char *(*faint)(
        int joint); /* why it cannot be seen there; NULL result: the usual reason */
} mukca_effect_ops;

#define MUKCA_EFFECT_OPS(kind, name) extern const mukca_effect_ops mukca_##name##_effect;
MUKCA_EFFECT_LIST(MUKCA_EFFECT_OPS)
#undef MUKCA_EFFECT_OPS

extern const mukca_effect_ops *const mukca_effect_catalogue[MUKCA_EFFECT_COUNT];

/* What varies less than this, rad or m, did not move. */
#define MUKCA_LEAST_RANGE 1e-3

/* A smaller torque, N m, does not load a joint: it deflects a soft gear (300 urad/(N m)) by less
 * than 0.015 mrad, below what any recording shows. */
#define MUKCA_LEAST_TORQUE 0.05

/* "300mNm" -> 300: a number with that unit behind it, or none. */
bool mukca_effect_read_number(double *value, const char *text, const char *unit);

/* A whole number from `lowest` to `highest`, with or without a plus sign. */
bool mukca_effect_read_integer(int *value, const char *text, int lowest, int highest);

/* Candidates that several effects share: one, one where the joint moved, one per placement. */
bool mukca_survey_moved(mukca_effect *effect, const mukca_effect_survey *survey, int i);
bool mukca_survey_placement(mukca_effect *effect, const mukca_effect_survey *survey, int i);

/* Does gravity load the joint, and not alike in all samples? */
bool mukca_survey_loads(const mukca_effect_survey *survey, int joint);

#endif
