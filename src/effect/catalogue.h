/* The members of an effect: one const struct per effect, collected by catalogue.c. */
#ifndef MUKCA_EFFECT_CATALOGUE_H
#define MUKCA_EFFECT_CATALOGUE_H

#include "effect/survey.h"
#include "mukca/effect.h"

/* Units of coefficients, and those that people are shown. */
#define MUKCA_IN_MRAD .unit = "rad", .display_factor = 1e3, .display_unit = "mrad"
#define MUKCA_IN_MM .unit = "m", .display_factor = 1e3, .display_unit = "mm"
#define MUKCA_IN_MRAD_PER_RAD .unit = "rad/rad", .display_factor = 1e3, .display_unit = "mrad/rad"
#define MUKCA_IN_URAD_PER_NM \
    .unit = "rad/(N*m)", .display_factor = 1e6, .display_unit = "urad/(N*m)"

/* Text form and choice of the variants of an effect. */
typedef struct {
    const char *key;      /* in the offsets table, before "="; NULL: the word stands alone */
    const char *expected; /* for help and errors: "@ORDER, 2 to 400" */
    bool (*read)(mukca_effect_variant *variant, const char *text);
    void (*write)(char *text, size_t size, const mukca_effect_variant *variant);
    /* Set the usual variant where none was given (all zero); false: it must be given, or does not
     * fit the arm.  NULL: all variants fit, zero is the usual one. */
    bool (*complete)(mukca_effect *effect, int n_joints);
} mukca_variant_ops;

enum { MUKCA_MAX_SIZES = 8 };

/* Sizes of an effect in real arms: prior sigmas of a coefficient, ended by 0.  The first
 * `usual` ones are equally probable, the others MUKCA_RARE_SIZE times as much.  In the
 * coefficient's unit; site ANGLES: rms turn of the joints, rad. */
typedef struct {
    int usual;
    double sigma[MUKCA_MAX_SIZES];
} mukca_effect_sizes;

#define MUKCA_RARE_SIZE 0.01

/* Sizes that several effects share. */
extern const mukca_effect_sizes mukca_sizes_spring, mukca_sizes_backlash, mukca_sizes_angle,
    mukca_sizes_wobble, mukca_sizes_ripple, mukca_sizes_zero, mukca_sizes_ball, mukca_sizes_socket;

/* The point at which a basis is evaluated. */
typedef struct {
    const mukca_effect *effect;
    const double *axis; /* [3] of its joint, NULL where it has none */
    const mukca_joint_state *state;
    const double *sine, *cosine; /* [2] of a periodic one's angles: mukca_effect_wave */
} mukca_basis_input;

/* angle[2]: the effect's order times its joint's angle (no order: once), and that angle. */
void mukca_effect_wave(double angle[2], const mukca_effect *effect, const mukca_joint_state *state);

/* Members that do not apply are NULL. */
typedef struct {
    mukca_effect_info info;
    const mukca_effect_sizes *sizes;                               /* NULL: mukca_sizes_angle */
    void (*basis)(double basis[][3], const mukca_basis_input *in); /* [terms], zeroed before */
    /* Derivative of basis[terms], given, by a joint's angle; returns which joint's: 0 its own (the
     * only one for rotations), -1 and 1 the neighbours.  NULL: it depends on none. */
    int (*by_angle)(double slope[][3], const mukca_basis_input *in, const double basis[][3]);
    /* Needs masses: derivative of basis[0], given, by the joint's torque, by the moment across its
     * axis (rotations), by the base's moment.  NULL: MUKCA_TRAIT_ELASTIC, a basis of minus these.
     */
    double (*by_load)(const mukca_effect *effect, const double basis[3]);
    /* site ANGLES, instead of basis: direction[n_joints], zeroed before */
    void (*direction)(double *direction, int n_joints, const mukca_effect *effect,
                      const mukca_joint_state *state);
    const mukca_variant_ops *variant;
    const char *term_name[MUKCA_MAX_TERMS]; /* of several terms */
    /* the same where they depend on the variant, ended by NULL */
    const char *const *(*variant_terms)(const mukca_effect_variant *variant);
    int (*read_old_term)(mukca_effect *effect, const char *text); /* of older tables; -1: not one */
    void (*describe)(char *text, size_t size, const mukca_effect *effect, const mukca_chain *chain);
    /* The i-th variant to try with a recording, at effect->joint; false: no more. */
    bool (*candidate)(mukca_effect *effect, const mukca_effect_survey *survey, int i);
    const char *missing;  /* why there is no candidate at all though its needs are met */
    const char *untested; /* why there is none at a joint; NULL: the reason of all effects */
    const char
        *faint_at_first; /* why it cannot be detected at the first joint; NULL: as at any joint */
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

/* A spring at a joint: basis minus its torque. */
void mukca_effect_spring_basis(double basis[][3], const mukca_basis_input *in);

/* Candidates that several effects share: one where the joint moved, one per placement. */
bool mukca_survey_moved(mukca_effect *effect, const mukca_effect_survey *survey, int i);
bool mukca_survey_placement(mukca_effect *effect, const mukca_effect_survey *survey, int i);

/* Does gravity load the joint, and not alike in all samples? */
bool mukca_survey_loads(const mukca_effect_survey *survey, int joint);

#endif
