/* The catalogue of effects upon joint torques: one row of a table for each. */
#ifndef MUKCA_MOTION_EFFECTS_H
#define MUKCA_MOTION_EFFECTS_H

#include <stdbool.h>

/* What a torque varies with: constant, name in JSON. */
#define MUKCA_TORQUE_FAMILY_LIST(X) \
    X(GRAVITY, "gravity")           \
    X(ACCELERATION, "acceleration") \
    X(DIRECTION, "direction")       \
    X(VELOCITY, "velocity")         \
    X(LOAD, "load")                 \
    X(ANGLE, "angle")               \
    X(TIME, "time")                 \
    X(SHIFT, "shift")               \
    X(TORQUE, "torque")

typedef enum {
#define MUKCA_TORQUE_FAMILY_ENUM(constant, name) MUKCA_TORQUE_##constant,
    MUKCA_TORQUE_FAMILY_LIST(MUKCA_TORQUE_FAMILY_ENUM)
#undef MUKCA_TORQUE_FAMILY_ENUM
        MUKCA_TORQUE_FAMILIES
} mukca_torque_family;

extern const char *const mukca_torque_family_name[MUKCA_TORQUE_FAMILIES];

enum {
    MUKCA_MOTION_PAYLOAD,
    MUKCA_MOTION_LINK_MASS,
    MUKCA_MOTION_LINK_CENTRE,
    MUKCA_MOTION_ARMATURE,
    MUKCA_MOTION_COULOMB,
    MUKCA_MOTION_VISCOUS,
    MUKCA_MOTION_STRIBECK,
    MUKCA_MOTION_LOAD_FRICTION,
    MUKCA_MOTION_ASYMMETRY,
    MUKCA_MOTION_OFFSET,
    MUKCA_MOTION_TORQUE_GAIN,
    MUKCA_MOTION_DELAY,
    MUKCA_MOTION_SPRING,
    MUKCA_MOTION_COGGING,
    MUKCA_MOTION_THERMAL_FRICTION,
    MUKCA_MOTION_EFFECTS /* rows from here on are unknown functions */
};

/* Quantity that the prior sizes are multiples of, in the unit of the coefficient. */
typedef enum {
    MUKCA_PER_RANGE,   /* of the joint's torque */
    MUKCA_PER_SPEED,   /* that over its largest velocity */
    MUKCA_PER_TRAVEL,  /* that over half of its travel */
    MUKCA_PER_INERTIA, /* about the joint */
    MUKCA_PER_MASS,    /* a third of the arm's mass: the load of arms */
    MUKCA_PER_UNIT     /* absolute */
} mukca_torque_scale;

/* Columns of an effect at a joint: `n` raw columns from `raw` on in steps of the number of
 * variants, for each variant the next ones (orders: `n` successive ones for each); n = 0: of
 * MUKCA_RIGID_...; -1: the joint's model torque, -2: the time derivative of its torque. */
/* NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): the order of the table's rows */
typedef struct {
    const char *name;               /* in JSON; NULL: unknown function */
    const char *title;              /* for people */
    const char *coefficient, *unit; /* what it is; NULL: the parameters of a body */
    mukca_torque_family family;
    int raw, n, variants;
    mukca_torque_scale scale;
    double size[5]; /* prior standard deviations, ended by 0 */
    double odds;    /* prior probability at one joint at all, in units of MUKCA_EFFECT_ODDS */
    bool links, orders;
} mukca_torque_effect;

enum { MUKCA_RIGID_LOAD, MUKCA_RIGID_MASS, MUKCA_RIGID_CENTRE, MUKCA_RIGID_ANY };
enum { MUKCA_COLUMNS_RIGID = 0, MUKCA_COLUMNS_MODEL = -1, MUKCA_COLUMNS_RATE = -2 };

/* Prior probability that an arm has an effect of one kind at some joint: one of the catalogue's
 * dozen of kinds. */
#define MUKCA_EFFECT_ODDS (1.0 / 12)

enum { MUKCA_TORQUE_ROWS = MUKCA_MOTION_EFFECTS + 20 };
extern const mukca_torque_effect mukca_torque_table[MUKCA_TORQUE_ROWS];

/* Index of an effect by its name, -1: none. */
int mukca_torque_effect_find(const char *name);

#endif
