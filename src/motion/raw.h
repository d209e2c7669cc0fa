/* Raw columns: functions of a joint's motion, of which all torques are linear combinations.
 *
 * Joint j of n has 10 columns for each link k >= j (the regressor's inertial parameters), then the
 * local ones below. */
#ifndef MUKCA_MOTION_RAW_H
#define MUKCA_MOTION_RAW_H

#include "dynamics/inverse_dynamics.h"
#include "motion/signals.h"

enum {
    MUKCA_SLOWS = 6,     /* velocities of Stribeck's curve */
    MUKCA_REVERSALS = 5, /* shapes of friction at a reversal: three even, two odd */
    MUKCA_ORDERS = 32,   /* waves per turn */
    MUKCA_HATS = 10,     /* pieces of a piecewise linear function of velocity or time */
    MUKCA_BURSTS = 32,   /* of a finer one of time: pushes */
    MUKCA_WARMINGS = 9,  /* time constants of friction that falls as the gear warms up */
    MUKCA_SHIFTS = 9     /* torques at neighbouring times */
};

/* Local columns, in order. */
enum {
    MUKCA_RAW_MODEL,                       /* T: torque of the model; T |T| */
    MUKCA_RAW_ANGLE = MUKCA_RAW_MODEL + 2, /* from the middle of its travel */
    MUKCA_RAW_ONE,
    MUKCA_RAW_SIGN, /* tanh(dq / v0) */
    MUKCA_RAW_SLOW, /* sign exp(-(dq / v)^2); by log v; by the exponent */
    MUKCA_RAW_REVERSAL = MUKCA_RAW_SLOW + 3 * MUKCA_SLOWS,
    MUKCA_RAW_PLAY = MUKCA_RAW_REVERSAL + MUKCA_REVERSALS,
    MUKCA_RAW_VELOCITY = MUKCA_RAW_PLAY + MUKCA_PLAYS,
    MUKCA_RAW_SPEED,                               /* |dq| */
    MUKCA_RAW_DRAG,                                /* dq |dq|, dq^3, over the fastest */
    MUKCA_RAW_BESIDE = MUKCA_RAW_DRAG + 2,         /* of both neighbours: velocity; sign of it minus
                                                      the own, of it, of it plus the own */
    MUKCA_RAW_ACCELERATION = MUKCA_RAW_BESIDE + 8, /* own, and of both neighbours */
    MUKCA_RAW_LOAD = MUKCA_RAW_ACCELERATION + 3,   /* sign |T|, of all and at rest: mean, half
                                                      difference; sign T^2, velocity |T| */
    MUKCA_RAW_WAVE = MUKCA_RAW_LOAD + 4,           /* cosine, sine of each order */
    MUKCA_RAW_CURVE = MUKCA_RAW_WAVE + 2 * MUKCA_ORDERS, /* of velocity */
    MUKCA_RAW_TIME = MUKCA_RAW_CURVE + MUKCA_HATS,
    MUKCA_RAW_BURST = MUKCA_RAW_TIME + MUKCA_HATS,    /* of time, finer */
    MUKCA_RAW_DRIFT = MUKCA_RAW_BURST + MUKCA_BURSTS, /* of time, times sign */
    MUKCA_RAW_WARMING = MUKCA_RAW_DRIFT + MUKCA_HATS,
    MUKCA_RAW_TORQUE = MUKCA_RAW_WARMING + 2 * MUKCA_WARMINGS, /* measured, from early to late */
    MUKCA_RAW_LOCAL = MUKCA_RAW_TORQUE + MUKCA_SHIFTS
};

/* Width of the smoothed sign of a velocity, rad/s: below any motion on purpose, above the noise of
 * differentiated encoders. */
#define MUKCA_SIGN_VELOCITY 0.01

/* Slower joints may stick, rad/s: friction is then any torque up to that of motion, and no function
 * of velocity. */
#define MUKCA_STICKING 0.03

/* Number of raw columns of a joint, and the index of a link's parameters or a local column. */
static inline int mukca_raw_width(int n_joints, int joint)
{
    return MUKCA_INERTIAL * (n_joints - joint) + MUKCA_RAW_LOCAL;
}
static inline int mukca_raw_link(int joint, int link, int parameter)
{
    return MUKCA_INERTIAL * (link - joint) + parameter;
}
static inline int mukca_raw_local(int n_joints, int joint, int column)
{
    return MUKCA_INERTIAL * (n_joints - joint) + column;
}

/* The model that the raw columns need. */
typedef struct {
    const mukca_signals *signals;
    mukca_dynamics dynamics;
    double inertial[MUKCA_MAX_JOINTS * MUKCA_INERTIAL];
    double load[MUKCA_MAX_JOINTS * MUKCA_INERTIAL]; /* of the arm with what it carries */
    double inertia[MUKCA_MAX_JOINTS]; /* mean about each joint, with the drive's, kg m^2 */
    int shift;                        /* samples between neighbouring torques */
} mukca_raw_model;

/* Samples first .. last - 1 of a stretch, with their regressors Y[last - first][n_joints][n_joints]
 * [MUKCA_INERTIAL] and the loads of gravity alone, [last - first][n_joints]. */
typedef struct {
    const mukca_stretch *stretch;
    int first, last;
    double *Y, *gravity;
} mukca_raw_block;

/* Raw columns x[last - first][ld] of a joint. */
void mukca_raw_fill(double *x, int ld, const mukca_raw_model *model, const mukca_raw_block *block,
                    int joint);

/* Weights of the torques at their places k - MUKCA_SHIFTS / 2 for the torque at place x, and for
 * its derivative: Lagrange's polynomials. */
void mukca_raw_interpolate(double value[MUKCA_SHIFTS], double slope[MUKCA_SHIFTS], double x);

/* The member [n_joints] that an effect adds to; NULL: none. */
const double *mukca_drives_of(const mukca_drives *drives, int effect);

/* The nominal torque as raw coefficients torque[width] of a joint, without the measured one. */
void mukca_raw_nominal(double *torque, const mukca_raw_model *model, const mukca_drives *drives,
                       int joint);

/* Products of filtered raw columns over the blocks of a part of the recording. */
typedef struct {
    int rows[MUKCA_MAX_JOINTS];           /* pairs of successive ones */
    double *square[MUKCA_MAX_JOINTS];     /* [width][width] mean of both rows of a pair */
    double *difference[MUKCA_MAX_JOINTS]; /* of the differences of successive rows */
} mukca_raw_products;

/* Parts of the recording: new runs in interleaved blocks, and all of these; reference runs, test
 * runs. */
enum {
    MUKCA_BLOCKS = 8,
    MUKCA_PART_NEW = MUKCA_BLOCKS,
    MUKCA_PART_REFERENCE,
    MUKCA_PART_TEST,
    MUKCA_PARTS
};

/* Products of all parts; memory comes from `pool`.  Errors: MUKCA_UNIDENTIFIABLE (too short),
 * MUKCA_MEMORY. */
mukca_status mukca_raw_products_make(mukca_raw_products products[MUKCA_PARTS], mukca_pool *pool,
                                     const mukca_raw_model *model, mukca_error *error);

/* products(rho)[width][width] := those of a part's rows whitened by an AR(1) of coefficient rho,
 * times `factor`, added.  The mean of the likelihoods forwards and backwards in time. */
void mukca_raw_products_add(double *out, const mukca_raw_products *part, int joint, int width,
                            double rho, double factor);

#endif
