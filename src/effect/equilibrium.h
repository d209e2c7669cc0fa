/* Static equilibrium of the arm with its effects: the displacement caused by the loads at the
 * displaced posture.
 *
 * All vectors are in base coordinates, at the displaced posture.  The effects rotate a joint's
 * frame about its origin, then the joint turns by its angle.  S is the first moment of all bodies
 * distal of a joint about its origin, g gravity: the holding moment is g x S.  If the frame rotates
 * by W, and a motion of the distal bodies relative to it changes S by M, the moment changes in this
 * frame by g x M + S x N, with N = W x g.  A joint that turns about its axis a contributes a x g
 * per rad to N of all distal joints, and a x S to M of itself and of all proximal joints.  Effects
 * respond to the moments by angles and rotations.
 */
#ifndef MUKCA_EFFECT_EQUILIBRIUM_H
#define MUKCA_EFFECT_EQUILIBRIUM_H

#include "model/columns.h"
#include "mukca/effect.h"

/* The effects of an arm at the encoder angles state.q. */
typedef struct {
    const mukca_effect *effects; /* [n_effects] */
    int n_effects;
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    mukca_joint_state state;
} mukca_effect_task;

/* Derivatives by the joint angles, with all load-independent effects. */
typedef struct {
    /* of a joint's displaced angle, by the angle of the previous joint, its own, the next one's */
    double angle[MUKCA_MAX_JOINTS][3];
    double rotation[MUKCA_MAX_JOINTS][3]; /* of the rotation vector, by the joint's angle */
} mukca_effect_slopes;

typedef struct {
    LANES_ALIGNED columns frame; /* at its origin, between the effects' rotation and its own */
    lanes axis[ROWS];
    lanes first[ROWS];    /* S */
    lanes into_M[ROWS];   /* contribution to M per rad: a x S; prismatic, per m: kg a */
    lanes into_N[ROWS];   /* to N: a x g; prismatic: 0 */
    double twist, bend;   /* derivative of the angle by the torque, of the rotation by the moment
                             across the axis, rad/(N m); */
    double spring, blade; /* their elastic parts, which are constant */
    bool slides;
    bool rotates;         /* has an effect that rotates its frame */
    bool deflects, tilts; /* has a load-dependent effect; a load-dependent rotation */
    bool turns;           /* the effects' rotation depends on the joint's angle */
} mukca_joint_posture;

typedef struct {
    mukca_joint_posture joint[MUKCA_MAX_JOINTS];
    mukca_displacement displacement;
    LANES_ALIGNED columns tip;
    lanes gravity[ROWS];
    lanes first[ROWS];   /* S of the whole arm, about the base origin */
    double bend, spring; /* of the base, as above */
    int n_joints, n_deflecting, n_inelastic;
    unsigned char deflecting[MUKCA_MAX_JOINTS]; /* joints, from base to tip */
    unsigned char inelastic[MUKCA_MAX_EFFECTS]; /* indices of inelastic load-dependent effects */
    bool tilts;                                 /* some rotations depend on the load */
    bool loaded;                                /* some effects depend on the load */
} mukca_equilibrium;

/* Load-dependent part of a displacement: angles (rad, m), rotation vectors of joints and base.
 * Members without load-dependent effect are not set. */
typedef struct {
    double angle[MUKCA_MAX_JOINTS], rotation[MUKCA_MAX_JOINTS][3], base[3];
} mukca_deflection;

/* Axis of an effect's joint; NULL: no joint. */
static inline const double *effect_axis(const mukca_effect *effect, const mukca_effect_task *task)
{
    return effect->joint < 0 ? NULL
                             : task->geometry->axis[task->chain->joint_element[effect->joint]];
}

/* Displacement by the load-independent effects; slopes may be NULL.  `bare` receives the encoder
 * angles. */
void mukca_effects_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                            joint_angles *bare, const mukca_effect_task *task);

/* Static equilibrium under the load, to 1e-12 rad; slopes as above. */
void mukca_equilibrium_find(mukca_equilibrium *at, mukca_effect_slopes *slopes,
                            const mukca_effect_task *task);

/* J[6][n_joints] of mukca_corrected_jacobian() at such a posture and slopes (both are overwritten).
 */
void mukca_equilibrium_differentiate(double *J, mukca_equilibrium *at, mukca_effect_slopes *slopes);

/* Add to `change` the elastic response to the change of load that it causes.  Each response changes
 * the load again: fixed-point iteration, until a response is below `within`, rad.  Each round
 * multiplies the error by the deflection per rad of motion, 0.05 at most.  Changes of rotation
 * vectors are used as rotations: sufficient for Newton's method. */
void mukca_equilibrium_settle(mukca_deflection *change, const mukca_equilibrium *at, double within);

/* All terms of an effect := 0, by vector stores: for so few bytes gcc replaces memset by an
 * instruction that is slower than most effects. */
MUKCA_INLINE void clear_terms(double terms[MUKCA_MAX_TERMS][3])
{
    double *all = (double *)(void *)terms;
    for (int i = 0; i < 3 * MUKCA_MAX_TERMS; i += MUKCA_LANES) STORE_LANES(all + i, (lanes){0});
}

/* Transform a vector from base coordinates to a joint's frame; and back. */
MUKCA_INLINE void to_joint(double out[3], const columns *F, const double v[3])
{
    const double x = v[0], y = v[1], z = v[2];
    for (int c = 0; c < 3; c++)
        out[c] = COLUMN(F, c, 0) * x + COLUMN(F, c, 1) * y + COLUMN(F, c, 2) * z;
}

MUKCA_INLINE void to_base(double out[3], const columns *F, const double v[3])
{
    lanes turned[ROWS];
    columns_vector(turned, F, v);
    for (int i = 0; i < 3; i++) out[i] = XYZ(turned)[i];
}

#endif
