/* The arm at rest under its load, with its effects: a displacement that the loads at the displaced
 * posture bring about.
 *
 * Everything is in base coordinates, at the displaced posture.  A joint's frame turns about its
 * origin by the effects' rotation, then the joint turns by its angle.  S is the first moment of
 * what a joint carries about its origin, g gravity: the holding moment is g x S.  As the frame
 * before the joint turns by W, and what the joint carries moves in it so that S changes by M, the
 * moment changes in this frame by g x M + S x N with N = W x g.  A joint that turns about its axis
 * a has a part in N of those further out, a x g per rad, and in M of those further in, a x S.
 * Effects answer with angles and rotations.
 */
#ifndef MUKCA_EFFECT_EQUILIBRIUM_H
#define MUKCA_EFFECT_EQUILIBRIUM_H

#include "model/turn.h"
#include "mukca/effect.h"

/* The effects of an arm at a bare posture; state.q is set. */
typedef struct {
    const mukca_effect *effects; /* [n_effects] */
    int n_effects;
    const mukca_chain *chain;
    const mukca_geometry *geometry;
    mukca_joint_state state;
} mukca_effect_task;

/* Derivatives by the joints' angles, with what all effects together do without load. */
typedef struct {
    /* of a joint's angle, with what is added, by the angle of the joint before, its own, the next
     */
    double angle[MUKCA_MAX_JOINTS][3];
    double rotation[MUKCA_MAX_JOINTS][3]; /* of the rotation vector, by its own angle */
} mukca_effect_slopes;

typedef struct {
    LANES_ALIGNED columns
        frame; /* after the effects' rotation, before it turns; its origin is the joint's */
    lanes axis[ROWS];
    lanes first[ROWS];    /* S */
    lanes into_M[ROWS];   /* per rad or m: a x S, or kg a of one that slides */
    lanes into_N[ROWS];   /* a x g, or 0 */
    double twist, bend;   /* slopes of the angle by the torque, of the rotation by the moment across
                             the axis, rad/(N m), */
    double spring, blade; /* and their parts that do not depend on the load */
    bool slides;
    bool rotates;       /* has an effect that rotates its frame */
    bool yields, tilts; /* has an effect that depends on the load; a rotation that does */
    bool turns;         /* what the effects rotate, as the joint turns */
} mukca_joint_posture;

typedef struct {
    mukca_joint_posture joint[MUKCA_MAX_JOINTS];
    mukca_displacement displacement;
    LANES_ALIGNED columns tip;
    lanes gravity[ROWS];
    lanes first[ROWS];   /* of all that moves, about the base's origin */
    double bend, spring; /* of the base, as above */
    int n_joints, n_yielding, n_other;
    unsigned char yielding[MUKCA_MAX_JOINTS]; /* joints, outwards */
    unsigned char other[MUKCA_MAX_EFFECTS];   /* indices of the effects that depend on the load and
                                                 are no springs */
    bool tilts;                               /* rotations depend on the load */
    bool loaded; /* some depend on the load, and it moves with the posture */
} mukca_equilibrium;

/* What yields to the load, by its own: angles (rad, m), rotation vectors of joints and of the base,
 * as in a displacement.  What does not yield is not set. */
typedef struct {
    double angle[MUKCA_MAX_JOINTS], rotation[MUKCA_MAX_JOINTS][3], base[3];
} mukca_deflection;

/* Axis of an effect's joint, NULL where it has none. */
static inline const double *effect_axis(const mukca_effect *effect, const mukca_effect_task *task)
{
    return effect->joint < 0 ? NULL
                             : task->geometry->axis[task->chain->joint_element[effect->joint]];
}

/* What the effects do without load; slopes may be NULL.  `bare`: the joints' angles. */
void mukca_effects_unloaded(mukca_displacement *displacement, mukca_effect_slopes *slopes,
                            joint_angles *bare, const mukca_effect_task *task);

/* The rest under the load, to 1e-12 rad; slopes as above. */
void mukca_equilibrium_find(mukca_equilibrium *at, mukca_effect_slopes *slopes,
                            const mukca_effect_task *task);

/* change += the answers to the change of the load that it brings about: a fixed point, as each
 * answer changes the load again, up to answers of `within`, rad.  A round leaves of what is missing
 * the deflection per radian that the arm turns, 0.05 at most.  Rotation vectors are taken for
 * rotations: right enough for Newton's method. */
void mukca_equilibrium_settle(mukca_deflection *change, const mukca_equilibrium *at, double within);

/* All terms of an effect := 0, by vectors: for so few bytes gcc takes an instruction that is slower
 * than most effects. */
MUKCA_INLINE void clear_terms(double terms[MUKCA_MAX_TERMS][3])
{
    double *all = (double *)(void *)terms;
    for (int i = 0; i < 3 * MUKCA_MAX_TERMS; i += MUKCA_LANES) STORE_LANES(all + i, (lanes){0});
}

/* A vector in base coordinates, in a joint's frame; and back. */
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
