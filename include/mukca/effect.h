/* The catalogue of unmodelled effects, with the displacement of the arm by each, as one table.
 *
 * An effect maps the state of the joints to a small displacement, linear in its coefficients:
 * displacement = sum_t coefficient[t] * basis_t(state).  The same forward model is fitted,
 * simulated, exported and compensated; src/diagnose decides which effects are present.
 */
#ifndef MUKCA_EFFECT_H
#define MUKCA_EFFECT_H

#include <stdbool.h>
#include <stddef.h>

#include "mukca/chain.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One row per effect: constant and name.  A new effect is one row here and one file in src/effect
 * that defines `const mukca_effect_ops mukca_NAME_effect` (src/effect/catalogue.h). */
#define MUKCA_EFFECT_LIST(X)                      \
    X(JOINT_COMPLIANCE, joint_compliance)         \
    X(LINK_BENDING, link_bending)                 \
    X(BASE_COMPLIANCE, base_compliance)           \
    X(BACKLASH, backlash)                         \
    X(APPROACH_HYSTERESIS, approach_hysteresis)   \
    X(JOINT_SCALE, joint_scale)                   \
    X(JOINT_COUPLING, joint_coupling)             \
    X(ENCODER_ECCENTRICITY, encoder_eccentricity) \
    X(GEAR_HARMONIC, gear_harmonic)               \
    X(AXIS_WOBBLE, axis_wobble)                   \
    X(JOINT_DRIFT, joint_drift)                   \
    X(READBACK_LAG, readback_lag)                 \
    X(TOOL_MOTION, tool_motion)                   \
    X(ZERO_JUMP, zero_jump)                       \
    X(BALL_SHIFT, ball_shift)                     \
    X(SOCKET_DISTANCE, socket_distance)           \
    X(SERVO_SAG, servo_sag)

typedef enum {
#define MUKCA_EFFECT_ENUM(kind, name) MUKCA_EFFECT_##kind,
    MUKCA_EFFECT_LIST(MUKCA_EFFECT_ENUM)
#undef MUKCA_EFFECT_ENUM
        MUKCA_EFFECT_COUNT
} mukca_effect_kind;

/* Data that an effect requires (bits). */
enum {
    MUKCA_NEEDS_MASSES = 1,     /* link masses (URDF or --inertials), or measured efforts */
    MUKCA_NEEDS_ORDER = 2,      /* samples in recording order */
    MUKCA_NEEDS_PLACEMENTS = 4, /* at least two placements */
    MUKCA_NEEDS_SOCKETS = 8,    /* socket data (not a pose log) */
    MUKCA_NEEDS_COMMANDS = 16   /* commanded angles, not readings */
};

/* Traits of an effect that the rest of the program uses (bits). */
enum {
    MUKCA_TRAIT_ELASTIC = 1,           /* proportional to gravity's moment: a spring */
    MUKCA_TRAIT_PLAY = 2,              /* free motion between two stops */
    MUKCA_TRAIT_PERIODIC = 4,          /* sines of the joint's angle; rotary joints only */
    MUKCA_TRAIT_OWN_ANGLE = 8,         /* a function of the joint's own angle */
    MUKCA_TRAIT_OTHER_ANGLE = 16,      /* a function of another joint's angle */
    MUKCA_TRAIT_OF_TIME = 32,          /* a function of time */
    MUKCA_TRAIT_SMOOTH = 64,           /* in the angles; periodic effects: low orders only */
    MUKCA_TRAIT_PER_PLACEMENT = 128,   /* acts in one placement */
    MUKCA_TRAIT_RECORDING_FAULT = 256, /* of the data, not of the arm: nothing to correct */
    MUKCA_TRAIT_FLEXIBLE = 512,        /* a flexible part: alike in the arms of a model */
    /* periodic, at any order from 2 to MUKCA_LAST_ORDER, which is searched; the order is that of a
     * gear, as in other joints and arms of the model */
    MUKCA_TRAIT_ORDERS = 1024
};

/* Where the displacement acts. */
typedef enum {
    MUKCA_SITE_ANGLE,    /* angle of one joint, about its axis */
    MUKCA_SITE_ROTATION, /* rotation vector of one joint's frame, before its rotation */
    MUKCA_SITE_BASE,     /* rotation vector of the base */
    MUKCA_SITE_ANGLES,   /* all joints' angles together */
    MUKCA_SITE_TIP,      /* shift in the tip's frame */
    MUKCA_SITE_SOCKET,   /* shift of a socket */
    MUKCA_SITE_DISTANCE  /* distance between the sockets of a pair */
} mukca_effect_site;

/* What a displacement varies with: the family of its effect.  Constant, name in JSON. */
#define MUKCA_VARIES_LIST(X) \
    X(LOAD, "load")          \
    X(SIDE, "load side")     \
    X(MOVE, "last move")     \
    X(ANGLE, "joint angle")  \
    X(TIME, "time")          \
    X(PLACEMENT, "placement")

typedef enum {
#define MUKCA_VARIES_ENUM(constant, name) MUKCA_VARIES_##constant,
    MUKCA_VARIES_LIST(MUKCA_VARIES_ENUM)
#undef MUKCA_VARIES_ENUM
        MUKCA_VARIES_COUNT
} mukca_varies;

extern const char *const mukca_varies_name[MUKCA_VARIES_COUNT];

typedef struct {
    const char *name;  /* as in the contract, the JSON and the offsets table */
    const char *title; /* for display: "joint compliance" */
    mukca_effect_site site;
    mukca_varies varies_with;
    int terms;            /* coefficients, at most MUKCA_MAX_TERMS */
    const char *unit;     /* of the coefficients, SI */
    bool nonnegative;     /* physical only with coefficient[0] >= 0 */
    int needs, traits;    /* MUKCA_NEEDS_*, MUKCA_TRAIT_* */
    const char *sentence; /* for display: the mechanism in the arm */
    const char *remedy;   /* for display; NULL: compensate it, inspect the transmission */
} mukca_effect_info;

extern const mukca_effect_info *const mukca_effect_table[MUKCA_EFFECT_COUNT];

/* True for an effect of sockets or placements only: a pose log has neither. */
static inline bool mukca_effect_of_sockets(mukca_effect_kind kind)
{
    return (mukca_effect_table[kind]->needs & (MUKCA_NEEDS_SOCKETS | MUKCA_NEEDS_PLACEMENTS)) != 0;
}

/* True for an effect of time, of the moves before or of one placement: no function of the posture.
 */
static inline bool mukca_effect_of_history(mukca_effect_kind kind)
{
    return (mukca_effect_table[kind]->needs & (MUKCA_NEEDS_ORDER | MUKCA_NEEDS_PLACEMENTS)) != 0;
}

/* Duration of a sample without recorded time, s: recording by hand takes some 8 s per sample. */
#define MUKCA_SECONDS_PER_ROW 8.0

enum { MUKCA_MAX_TERMS = 4, MUKCA_EFFECT_TEXT = 48, MUKCA_LAST_ORDER = 400 };

/* The frame in which an axis wobbles. */
typedef enum {
    MUKCA_WOBBLE_FIXED,   /* before the joint's rotation; order 1 or 2 */
    MUKCA_WOBBLE_TURNING, /* after it; order 1 or 2 */
    MUKCA_WOBBLE_CONE     /* a conical motion, two terms; order -2, -1, 2 or 3 */
} mukca_wobble_frame;

/* Variant of an effect; each effect uses one or two members, the others are zero. */
typedef struct {
    int order;                /* gear_harmonic (2 .. 400), axis_wobble: per turn of the joint */
    mukca_wobble_frame frame; /* axis_wobble */
    int neighbour;            /* joint_coupling: -1 or +1, the joint before or after */
    bool to_command;          /* readback_lag: along command minus reading, not the last move */
    double torque_scale;      /* backlash: tau0, N m */
    /* joint_drift: T of 1 - exp(-t / T), s; 0: linear, per 1000 s.  readback_lag: readings of a
     * posture until 1/e is left; 0: all readings lag alike */
    double time_constant;
} mukca_effect_variant;

/* One effect with its coefficients. */
typedef struct {
    mukca_effect_kind kind;
    int joint;     /* -1: none */
    int placement; /* MUKCA_TRAIT_PER_PLACEMENT: index into the dataset's placements, else -1 */
    int terms;
    mukca_effect_variant variant;
    double coefficient[MUKCA_MAX_TERMS];
} mukca_effect;

/* Input of the forward models: one configuration.  A pointer may be NULL; effects that need it then
 * have no influence. */
typedef struct {
    const double *q;    /* [n_joints] encoder angles */
    const double *move; /* [n_joints] q minus q of the previous sample; 0 in a session's first */
    /* of mukca_effect_basis alone; a displacement has its own: */
    const double *torque;      /* [n_joints] holding torque, N m */
    const double (*moment)[3]; /* [n_joints] holding moment in the joint frames, N m */
    const double *base_moment; /* [3] */
    const double *command;     /* [n_joints] commanded angles, or NULL */
    double time;               /* s since the session's start */
    double payload_kg;         /* at the tip, beyond the model */
    int placement;             /* index, -1: unknown */
    int repeat;                /* readings of this posture since the arm arrived */
} mukca_joint_state;

/* Kind by its name; -1 (as int): unknown. */
int mukca_effect_find(const char *name);

/* Does the effect have one of these traits?  False for a kind outside the catalogue. */
bool mukca_effect_has(int kind, int traits);

/* The first effect of the catalogue at a site with all of these traits; there is one. */
mukca_effect_kind mukca_effect_at(mukca_effect_site site, int traits);

/* Does the effect act at one joint (sites ANGLE and ROTATION)? */
bool mukca_effect_has_joint(int kind);

/* Does it vary slowly with the joints' angles, as flexibility does? */
bool mukca_effect_is_smooth(const mukca_effect *effect);

/* Same kind, joint, placement and variant? */
bool mukca_effect_same(const mukca_effect *a, const mukca_effect *b);

/* Number of coefficients of an effect's variant. */
int mukca_effect_terms(const mukca_effect *effect);

/* Basis of an effect at a state, basis[terms][3].  Site ANGLE fills [t][0] only (rad about the
 * axis); for site ANGLES use mukca_effect_direction; SOCKET and DISTANCE yield zeros.  `axis` [3]:
 * of the joint; may be NULL for an effect without a joint. */
void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state);

/* Basis of an effect of site ANGLES, direction[n_joints]; zero for other effects. */
void mukca_effect_direction(double *direction, int n_joints, const mukca_effect *effect,
                            const mukca_joint_state *state);

/* Displacement by `n` effects at the configuration state->q, with the gravity moments of the arm in
 * static equilibrium (rounds of a fixed point: within 0.1 um for real arms).  `state`, not
 * NULL, also supplies move, time, placement (-1: none), command, payload_kg. */
void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const mukca_joint_state *state);

/* Set variant and terms from text ("160", "300mNm", "turning2"; NULL: the usual variant), for an
 * effect whose kind and joint are set.  Returns NULL, or a description of the expected text. */
const char *mukca_effect_set_variant(mukca_effect *effect, const char *text, int n_joints);

/* Text of the variant as mukca_effect_set_variant reads it; "" for an effect without variants. */
void mukca_effect_variant_text(char text[MUKCA_EFFECT_TEXT], const mukca_effect *effect);

/* Text of one term of an effect for the offsets table's `term` column ("order=240 sin"), and back.
 * Parsing sets variant, terms and placement of an effect whose kind and joint are set and returns
 * the term's index, -1 if the text is not of this kind or names a joint that does not exist. */
void mukca_effect_term_text(char text[MUKCA_EFFECT_TEXT], const mukca_effect *effect, int term);
int mukca_effect_term_parse(mukca_effect *effect, const char *text, int n_joints);

/* SI unit of an effect's coefficients at its joint: "rad", or "m" at a prismatic joint. */
const char *mukca_effect_unit(const mukca_effect *effect, const mukca_chain *chain);

#ifdef __cplusplus
}
#endif
#endif
