/* The catalogue of unmodelled effects: what each does to the arm, as one table.
 *
 * An effect turns the state of the joints into a small displacement that is linear in its
 * coefficients: displacement = sum_t coefficient[t] * basis_t(state).  The same forward model is
 * fitted, simulated, exported and compensated; deciding which effect is there is the diagnosis'.
 */
#ifndef MUKCA_EFFECT_H
#define MUKCA_EFFECT_H

#include "mukca/chain.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a hypothesis needs in the data (bits). */
enum {
    MUKCA_NEEDS_MASSES = 1,     /* link masses (URDF or --inertials), or measured efforts */
    MUKCA_NEEDS_ORDER = 2,      /* rows in recording order */
    MUKCA_NEEDS_TIME = 4,       /* time_s, else the row number stands in */
    MUKCA_NEEDS_PLACEMENTS = 8, /* two placements or more */
    MUKCA_NEEDS_SOCKETS = 16    /* socket rows (not a pose log) */
};

/* Where the displacement acts. */
typedef enum {
    MUKCA_SITE_ANGLE,    /* angle of one joint, about its axis */
    MUKCA_SITE_ROTATION, /* rotation vector of one joint's frame, before it turns */
    MUKCA_SITE_BASE,     /* rotation vector of the base */
    MUKCA_SITE_ANGLES,   /* all joints' angles together */
    MUKCA_SITE_TIP,      /* shift in the tip's frame */
    MUKCA_SITE_SOCKET    /* shift of a socket: a fault of the recording, not of the arm */
} mukca_effect_site;

/* kind, name, site, terms, unit, display factor, display unit, signed (1: coefficient >= 0), needs,
 * sentence for people */
#define MUKCA_EFFECT_LIST(X)                                                                    \
    X(JOINT_COMPLIANCE, "joint_compliance", ANGLE, 1, "rad/(N*m)", 1e6, "urad/(N*m)", 1,        \
      MUKCA_NEEDS_MASSES,                                                                       \
      "the joint's gear and bearing give way under gravity's torque about its axis")            \
    X(LINK_BENDING, "link_bending", ROTATION, 1, "rad/(N*m)", 1e6, "urad/(N*m)", 1,             \
      MUKCA_NEEDS_MASSES, "the link before the joint bends across the joint's axis under load") \
    X(BASE_COMPLIANCE, "base_compliance", BASE, 1, "rad/(N*m)", 1e6, "urad/(N*m)", 1,           \
      MUKCA_NEEDS_MASSES, "the base or its table tilts under the arm's weight")                 \
    X(BACKLASH, "backlash", ANGLE, 1, "rad", 1e3, "mrad", 1, MUKCA_NEEDS_MASSES,                \
      "play in the gear: gravity decides on which side the joint rests")                        \
    X(APPROACH_HYSTERESIS, "approach_hysteresis", ANGLE, 1, "rad", 1e3, "mrad", 0,              \
      MUKCA_NEEDS_ORDER, "the joint rests differently after moving up than after moving down")  \
    X(JOINT_SCALE, "joint_scale", ANGLE, 1, "rad/rad", 1e3, "mrad/rad", 0, 0,                   \
      "the encoder counts a little too much or too little per turn")                            \
    X(JOINT_COUPLING, "joint_coupling", ANGLE, 1, "rad/rad", 1e3, "mrad/rad", 0, 0,             \
      "a neighbour's motion leaks into this joint (belt, differential or cable drive)")         \
    X(ENCODER_ECCENTRICITY, "encoder_eccentricity", ANGLE, 2, "rad", 1e3, "mrad", 0, 0,         \
      "the encoder disk sits off centre: an error once per turn")                               \
    X(GEAR_HARMONIC, "gear_harmonic", ANGLE, 2, "rad", 1e3, "mrad", 0, 0,                       \
      "gear ripple: an error that repeats `order` times per turn")                              \
    X(AXIS_WOBBLE, "axis_wobble", ROTATION, 4, "rad", 1e3, "mrad", 0, 0,                        \
      "the joint's axis tumbles as it turns (bearing run-out)")                                 \
    X(JOINT_DRIFT, "joint_drift", ANGLE, 1, "rad", 1e3, "mrad", 0, MUKCA_NEEDS_ORDER,           \
      "the joint's zero wanders during the session, as a warming gear does")                    \
    X(READBACK_LAG, "readback_lag", ANGLES, 1, "rad", 1e3, "mrad", 0, MUKCA_NEEDS_ORDER,        \
      "the recorded angles are stale: they lag along the last move")                            \
    X(TOOL_MOTION, "tool_motion", SOCKET, 3, "m", 1e3, "mm", 0, MUKCA_NEEDS_SOCKETS,            \
      "the tool was pushed or crept while it was being recorded")                               \
    X(ZERO_JUMP, "zero_jump", ANGLE, 1, "rad", 1e3, "mrad", 0, MUKCA_NEEDS_PLACEMENTS,          \
      "the joint's zero differs in one placement from the others (slipped or re-homed)")        \
    X(BALL_SHIFT, "ball_shift", TIP, 3, "m", 1e3, "mm", 0, MUKCA_NEEDS_PLACEMENTS,              \
      "the ball sat differently on the arm in one placement (loose or re-mounted)")             \
    X(SOCKET_DISTANCE, "socket_distance", SOCKET, 1, "m", 1e3, "mm", 0, MUKCA_NEEDS_SOCKETS,    \
      "the sockets are not as far apart as --distance says")

typedef enum {
#define MUKCA_EFFECT_ENUM(kind, ...) MUKCA_EFFECT_##kind,
    MUKCA_EFFECT_LIST(MUKCA_EFFECT_ENUM)
#undef MUKCA_EFFECT_ENUM
        MUKCA_EFFECT_COUNT
} mukca_effect_kind;

typedef struct {
    const char *name; /* as in the contract, the JSON and the offsets table */
    mukca_effect_site site;
    int terms;                /* coefficients of one variant */
    const char *unit;         /* of the coefficients, SI */
    double display_factor;    /* times this ... */
    const char *display_unit; /* ... is what people are shown */
    int nonnegative;          /* 1: physics wants coefficient[0] >= 0 */
    int needs;                /* MUKCA_NEEDS_* */
    const char *sentence;
} mukca_effect_info;

extern const mukca_effect_info mukca_effect_table[MUKCA_EFFECT_COUNT];

/* A row for which no time is known stands for this long, s: people take some 8 s per sample. */
#define MUKCA_SECONDS_PER_ROW 8.0

enum { MUKCA_MAX_TERMS = 4, MUKCA_MAX_EFFECTS = 48 };

/* One effect at work.  `variant` by kind:
 *   backlash            torque scale tau0 in mN m (300, 1000, 3000)
 *   joint_coupling      which neighbour: -1 or +1
 *   gear_harmonic       order, 2 .. 400
 *   axis_wobble         order 1 or 2 in the frame before the turn, 11 or 12 in the frame after it,
 *                       100 + k (k = -2, -1, 2, 3) a conical motion, two terms
 *   joint_drift         time constant T in s of 1 - exp(-t / T); 0: linear, rad per 1000 s
 *   readback_lag        0: along the last move; 1: command minus reading
 * and 0 elsewhere. */
typedef struct {
    mukca_effect_kind kind;
    int joint;     /* -1 where the effect has none */
    int placement; /* zero_jump, ball_shift: index into the dataset's placements, else -1 */
    int variant;
    int terms;
    double coefficient[MUKCA_MAX_TERMS];
} mukca_effect;

/* What the forward models see of one configuration.  Pointers may be NULL where no effect in use
 * needs them (then that effect does nothing). */
typedef struct {
    const double *q;      /* [n_joints] encoder angles */
    const double *move;   /* [n_joints] q minus q of the row before; 0 in a session's first row */
    const double *torque; /* [n_joints] holding torque, N m */
    const double (*moment)[3]; /* [n_joints] holding moment in the joint frames, N m */
    const double *base_moment; /* [3] */
    const double *command;     /* [n_joints] commanded angles, or NULL */
    double time;               /* s since the session's start */
    double payload_kg;         /* at the tip, beyond the model */
    int placement;             /* index, -1 where unknown */
} mukca_joint_state;

/* Kind by its name, -1 (as int) where unknown. */
int mukca_effect_find(const char *name);

/* Number of terms of a kind's variant. */
int mukca_effect_terms(mukca_effect_kind kind, int variant);

/* Basis of an effect at a state: basis[terms][3].  Site ANGLE fills [t][0] only (rad about the
 * axis); site ANGLES is not covered here (see mukca_effect_lag_direction); SOCKET gives zeros. */
void mukca_effect_basis(double basis[MUKCA_MAX_TERMS][3], const mukca_effect *effect,
                        const double axis[3], const mukca_joint_state *state);

/* Basis of readback_lag, direction[n_joints]. */
void mukca_effect_lag_direction(double *direction, int n_joints, int variant,
                                const mukca_joint_state *state);

/* displacement += what `effect` does at `state`.  No allocation, no locks. */
void mukca_effect_apply(mukca_displacement *displacement, const mukca_effect *effect,
                        const mukca_chain *chain, const mukca_joint_state *state);

/* Displacement of `n` effects at a bare configuration q: computes the moments it needs itself, at
 * the place where the arm comes to rest under them (a fixed point to 1e-12 rad).
 * `state` supplies move, time, placement, command, payload_kg (may be NULL: all zero). */
void mukca_effects_displacement(mukca_displacement *displacement, const mukca_effect *effects,
                                int n, const mukca_chain *chain, const mukca_geometry *geometry,
                                const double *q, const mukca_joint_state *state);

/* Text of one term of an effect for the offsets table's `term` column ("order=240 sin"), and back.
 * Parsing sets variant, terms and placement of `effect` and returns the term's index, -1 when the
 * text is not of this kind. `text` holds at least 48 characters. */
void mukca_effect_term_text(char text[48], const mukca_effect *effect, int term);
int mukca_effect_term_parse(mukca_effect *effect, const char *text);

#ifdef __cplusplus
}
#endif
#endif
