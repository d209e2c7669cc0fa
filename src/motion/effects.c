/* The table of effects upon joint torques. */
#include "motion/effects.h"

#include <string.h>

#include "motion/raw.h"

const char *const mukca_torque_family_name[MUKCA_TORQUE_FAMILIES] = {
#define FAMILY_NAME(constant, name) name,
    MUKCA_TORQUE_FAMILY_LIST(FAMILY_NAME)
#undef FAMILY_NAME
};

/* Prior sizes: multiples of 1 % of the joint's range, below which nothing matters; published
 * friction of arms is 3 to 30 % of it.  Shares of a mass, of a load or of a gain; metres of a link;
 * seconds of a bus. */
#define SMALL .size = {0.01, 0.03, 0.1}
#define LARGE .size = {0.01, 0.03, 0.1, 0.3}
#define INERTIAS .size = {0.03, 0.1, 0.3, 1}
#define MASSES .size = {0.05, 0.15, 0.5}
#define GAINS .size = {0.02, 0.06, 0.2}
#define DELAYS .size = {0.002, 0.008, 0.03}
/* Of an unknown function's values. */
#define FUNCTION .size = {0.003, 0.01, 0.03, 0.1}
/* One kind in five of what separates an arm from its model is outside the catalogue; its functions
 * are alternatives of each other. */
#define RARE 0.2

#define NAMED(called, words, what, in, with, first, count, options, of, ...)                \
    {                                                                                       \
        .name = (called), .title = (words), .coefficient = (what), .unit = (in),            \
        .family = MUKCA_TORQUE_##with, .raw = (first), .n = (count), .variants = (options), \
        .scale = MUKCA_PER_##of, .odds = 1, __VA_ARGS__                                     \
    }
#define UNKNOWN(with, first, count, of, in, ...)                                            \
    {                                                                                       \
        .title = "outside the catalogue", .unit = (in), .family = MUKCA_TORQUE_##with,      \
        .raw = (first), .n = (count), .variants = 1, .scale = MUKCA_PER_##of, .odds = RARE, \
        __VA_ARGS__                                                                         \
    }
/* Orders from a to b: waves of that length. */
#define WAVES(a, b) \
    UNKNOWN(ANGLE, MUKCA_RAW_WAVE + 2 * ((a)-1), 2 * ((b) - (a) + 1), RANGE, "N*m", FUNCTION)

const mukca_torque_effect mukca_torque_table[MUKCA_TORQUE_ROWS] = {
    [MUKCA_MOTION_PAYLOAD] = NAMED("payload", "payload", NULL, "kg", GRAVITY, MUKCA_RIGID_LOAD,
                                   MUKCA_COLUMNS_RIGID, 1, MASS, LARGE, .links = true),
    [MUKCA_MOTION_LINK_MASS] = NAMED("link_mass", "mass", NULL, "kg", GRAVITY, MUKCA_RIGID_MASS,
                                     MUKCA_COLUMNS_RIGID, 1, UNIT, MASSES, .links = true),
    [MUKCA_MOTION_LINK_CENTRE] =
        NAMED("link_centre", "centre of mass", NULL, "m", GRAVITY, MUKCA_RIGID_CENTRE,
              MUKCA_COLUMNS_RIGID, 1, UNIT, SMALL, .links = true),
    [MUKCA_MOTION_ARMATURE] = NAMED("armature", "armature", "inertia", "kg*m^2", ACCELERATION,
                                    MUKCA_RAW_ACCELERATION, 1, 1, INERTIA, INERTIAS),
    [MUKCA_MOTION_COULOMB] = NAMED("coulomb", "Coulomb friction", "torque", "N*m", DIRECTION,
                                   MUKCA_RAW_SIGN, 1, 1, RANGE, LARGE),
    [MUKCA_MOTION_VISCOUS] = NAMED("viscous", "viscous friction", "damping", "N*m*s/rad", VELOCITY,
                                   MUKCA_RAW_VELOCITY, 1, 1, SPEED, LARGE),
    [MUKCA_MOTION_STRIBECK] = NAMED("stribeck", "Stribeck friction", "torque", "N*m", VELOCITY,
                                    MUKCA_RAW_SLOW, 3, MUKCA_SLOWS, RANGE, SMALL),
    /* between that under gravity and that under all torques */
    [MUKCA_MOTION_LOAD_FRICTION] = NAMED("load_friction", "friction under load", "share", "1", LOAD,
                                         MUKCA_RAW_LOAD, 2, 1, UNIT, SMALL),
    [MUKCA_MOTION_ASYMMETRY] = NAMED("asymmetry", "asymmetric friction", "damping", "N*m*s/rad",
                                     VELOCITY, MUKCA_RAW_SPEED, 1, 1, SPEED, SMALL),
    [MUKCA_MOTION_OFFSET] = NAMED("offset", "torque offset", "torque", "N*m", TORQUE, MUKCA_RAW_ONE,
                                  1, 1, RANGE, SMALL),
    [MUKCA_MOTION_TORQUE_GAIN] = NAMED("torque_gain", "torque gain", "share", "1", TORQUE, 0,
                                       MUKCA_COLUMNS_MODEL, 1, UNIT, GAINS),
    [MUKCA_MOTION_DELAY] =
        NAMED("delay", "delay", "time", "s", SHIFT, 0, MUKCA_COLUMNS_RATE, 1, UNIT, DELAYS),
    [MUKCA_MOTION_SPRING] = NAMED("spring", "spring", "stiffness", "N*m/rad", ANGLE,
                                  MUKCA_RAW_ANGLE, 2, 1, TRAVEL, SMALL),
    [MUKCA_MOTION_COGGING] = NAMED("cogging", "cogging", "amplitude", "N*m", ANGLE, MUKCA_RAW_WAVE,
                                   2, MUKCA_ORDERS, RANGE, SMALL, .orders = true),
    [MUKCA_MOTION_THERMAL_FRICTION] =
        NAMED("thermal_friction", "friction that falls with warming", "torque", "N*m", TIME,
              MUKCA_RAW_WARMING, 2, MUKCA_WARMINGS, RANGE, SMALL),
    UNKNOWN(DIRECTION, MUKCA_RAW_SIGN, 3, RANGE, "N*m", FUNCTION),
    UNKNOWN(DIRECTION, MUKCA_RAW_PLAY, MUKCA_PLAYS, RANGE, "N*m", FUNCTION),
    UNKNOWN(VELOCITY, MUKCA_RAW_SLOW, MUKCA_SLOWS, RANGE, "N*m", FUNCTION),
    UNKNOWN(VELOCITY, MUKCA_RAW_DRAG, 2, SPEED, "N*m*s/rad", FUNCTION),
    UNKNOWN(VELOCITY, MUKCA_RAW_CURVE, MUKCA_HATS, RANGE, "N*m", FUNCTION),
    UNKNOWN(VELOCITY, MUKCA_RAW_BESIDE, 8, RANGE, "N*m", FUNCTION),
    UNKNOWN(ACCELERATION, MUKCA_RAW_ACCELERATION, 3, INERTIA, "kg*m^2", FUNCTION),
    UNKNOWN(LOAD, MUKCA_RAW_LOAD, 4, UNIT, "1", FUNCTION),
    WAVES(1, 4),
    WAVES(4, 10),
    WAVES(10, 17),
    WAVES(17, 24),
    UNKNOWN(TIME, MUKCA_RAW_TIME, MUKCA_HATS, RANGE, "N*m", FUNCTION),
    UNKNOWN(TIME, MUKCA_RAW_BURST, MUKCA_BURSTS, RANGE, "N*m", FUNCTION),
    UNKNOWN(TIME, MUKCA_RAW_DRIFT, MUKCA_HATS, RANGE, "N*m", FUNCTION),
    UNKNOWN(TORQUE, MUKCA_RAW_MODEL, 2, UNIT, "1", FUNCTION),
    UNKNOWN(TORQUE, 0, MUKCA_COLUMNS_MODEL, UNIT, "1", GAINS),
    UNKNOWN(TORQUE, MUKCA_RAW_ONE, 1, RANGE, "N*m", FUNCTION),
    UNKNOWN(GRAVITY, MUKCA_RIGID_ANY, MUKCA_COLUMNS_RIGID, UNIT, "kg", MASSES, .links = true),
    UNKNOWN(SHIFT, 0, MUKCA_COLUMNS_RATE, UNIT, "s", DELAYS)};

int mukca_torque_effect_find(const char *name)
{
    for (int e = 0; e < MUKCA_MOTION_EFFECTS; e++)
        if (strcmp(mukca_torque_table[e].name, name) == 0) return e;
    return -1;
}
