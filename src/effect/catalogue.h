/* Definition of an effect: one const struct per effect, collected by catalogue.c. */
#ifndef MUKCA_EFFECT_CATALOGUE_H
#define MUKCA_EFFECT_CATALOGUE_H

#include "mukca/effect.h"

/* ---- survey of a recording: the facts that determine testable effects and variants ---- */

typedef struct {
    int n_joints, n_placements;
    bool moments, torques; /* holding moments, torques about the axes are known in each sample */
    bool moved;            /* some joint moved between samples */
    bool dwelled;          /* some posture was read several times in succession */
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

/* Causes of one kin entail each other: the links and joints of an arm are flexible or they are not,
 * and its joints have the same gear.  0: none. */
int mukca_effect_kin(const mukca_effect *effect);

/* Orders up to it are long waves, of which the geometry may absorb a part: candidates of every
 * recording.  The others are listed where they promise. */
enum { MUKCA_LONG_ORDER = 32 };

/* Least travel that shows a wave, rad: half a turn of the finest order, 400. */
#define MUKCA_WAVE_TRAVEL 1e-2

/* Text form and defaults of an effect's variants. */
typedef struct {
    const char *key;      /* in the offsets table, before "="; NULL: value without key */
    const char *expected; /* for help and errors: "@ORDER, 2 to 400" */
    bool (*read)(mukca_effect_variant *variant, const char *text);
    void (*write)(char *text, size_t size, const mukca_effect_variant *variant);
    mukca_effect_variant usual; /* if none is given */
    bool required;              /* there is no usual one */
    /* Set the usual variant of the joint if it is all zero; false: this variant does not exist
     * there.  NULL: all variants exist. */
    bool (*complete)(mukca_effect *effect, int n_joints);
} mukca_variant_ops;

enum { MUKCA_MAX_SIZES = 8 };

/* Sizes of an effect in real arms: prior sigmas of a coefficient, terminated by 0, in the
 * coefficient's unit; site ANGLES: rms rotation of the joints, rad.  The first `usual` ones are
 * equally probable, the others MUKCA_RARE_SIZE times as probable. */
typedef struct {
    int usual;
    double sigma[MUKCA_MAX_SIZES];
    double most; /* of the others: largest rms rotation in a recording, rad; 0: any */
} mukca_effect_sizes;

#define MUKCA_RARE_SIZE 0.01

/* Sizes common to several effects. */
extern const mukca_effect_sizes mukca_sizes_spring, mukca_sizes_angle, mukca_sizes_socket;

/* Argument of a basis. */
typedef struct {
    const mukca_effect *effect;
    const double *axis; /* [3] of its joint, NULL: no joint */
    const mukca_joint_state *state;
    const double *sine, *cosine; /* [2] of the joint's angle times the order, and of the angle */
} mukca_basis_input;

/* Inapplicable members are NULL. */
typedef struct {
    mukca_effect_info info;
    const mukca_effect_sizes *sizes;                               /* NULL: mukca_sizes_angle */
    void (*basis)(double basis[][3], const mukca_basis_input *in); /* [terms], zero on entry */
    /* Derivative of the given basis[terms] by a joint's angle; returns the joint relative to its
     * own: 0 (always for rotations), -1 or 1.  NULL: independent of the angles. */
    int (*by_angle)(double slope[][3], const mukca_basis_input *in, const double basis[][3]);
    /* site ANGLES, instead of basis: direction[n_joints], zero on entry */
    void (*direction)(double *direction, int n_joints, const mukca_effect *effect,
                      const mukca_joint_state *state);
    const mukca_variant_ops *variant;
    const char *term_name[MUKCA_MAX_TERMS]; /* if several terms */
    /* the same if it depends on the variant, terminated by NULL */
    const char *const *(*variant_terms)(const mukca_effect_variant *variant);
    /* The i-th candidate variant for a recording, at effect->joint; false: no more. */
    bool (*candidate)(mukca_effect *effect, const mukca_effect_survey *survey, int i);
    /* MUKCA_TRAIT_ORDERS: prior probability of an order; orders of one gear yield the same number
     * above 0, and 0 is an order of no gear */
    double (*order_prior)(int order);
    int (*gear)(int order);
    const char *missing;        /* reason why there is no candidate despite sufficient data */
    const char *untested;       /* reason why there is none at a joint; NULL: the general one */
    const char *faint_at_first; /* reason why it is not detectable at the first joint; NULL: the
                                   general one */
} mukca_effect_ops;

#define MUKCA_EFFECT_OPS(kind, name) extern const mukca_effect_ops mukca_##name##_effect;
MUKCA_EFFECT_LIST(MUKCA_EFFECT_OPS)
#undef MUKCA_EFFECT_OPS

extern const mukca_effect_ops *const mukca_effect_catalogue[MUKCA_EFFECT_COUNT];

/* Smallest range, rad or m, that counts as a motion. */
#define MUKCA_LEAST_RANGE 1e-3

/* Smallest torque, N m, that counts as a load: it deflects a soft gear (300 urad/(N m)) by 0.015
 * mrad, below the detection limit of any recording. */
#define MUKCA_LEAST_TORQUE 0.05

/* Parse "300mNm" as 300: a number with this unit, or without one. */
bool mukca_effect_read_number(double *value, const char *text, const char *unit);

/* Parse an integer from `lowest` to `highest`, with or without a plus sign. */
bool mukca_effect_read_integer(int *value, const char *text, int lowest, int highest);

/* One candidate if the joint moved. */
bool mukca_survey_moved(mukca_effect *effect, const mukca_effect_survey *survey, int i);

/* Does gravity load the joint, by different torques? */
bool mukca_survey_loads(const mukca_effect_survey *survey, int joint);

/* ---- displacement of an arm by its effects (apply.c) ---- */

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
