/* Joint torques of a moving arm: Newton and Euler along the chain, directly and as a regressor.
 *
 * Link j is everything that moves with joint j and not with joint j + 1: fixed joints, side
 * branches and the tool after the last joint included.  Its frame is the child frame of joint j.
 * Its ten inertial parameters are linear in the torques: m (kg), m c (x y z, kg m), inertia about
 * the frame's origin (xx yy zz xy xz yz, kg m^2) c is the centre of mass and the inertia is I_com +
 * m (c'c 1 - c c').
 *
 * The torque is that of the joint upon its link (N m, a force in N for a prismatic joint):
 *     torque = M(q) ddq + C(q, dq) dq + g(q) = Y(q, dq, ddq) p
 * It holds the arm up at rest, is positive along the URDF's axis, and has neither friction nor
 * armature.  q is in rad (m), dq in rad/s (m/s), ddq in rad/s^2 (m/s^2).
 */
#ifndef MUKCA_DYNAMICS_INVERSE_DYNAMICS_H
#define MUKCA_DYNAMICS_INVERSE_DYNAMICS_H

#include "mukca/chain.h"

enum { MUKCA_INERTIAL = 10 };

/* The arm as moving links, ready for the kernels; plain memory, set once. */
typedef struct {
    int n_joints;
    mukca_frame
        origin[MUKCA_MAX_JOINTS];     /* of joint j in the frame of link j - 1 (base) at q = 0 */
    double axis[MUKCA_MAX_JOINTS][3]; /* unit, in the frame of link j */
    bool slides[MUKCA_MAX_JOINTS];    /* prismatic */
    double gravity[3];                /* m/s^2, base frame */
} mukca_dynamics;

/* The arm from its chain. */
void mukca_dynamics_set(mukca_dynamics *dynamics, const mukca_chain *chain);

/* Inertial parameters p[n_joints][MUKCA_INERTIAL] of the chain's masses, lumped per link.  A link
 * without masses has zeros. */
void mukca_dynamics_inertials(double *p, const mukca_chain *chain);

/* Add a body to the parameters p[MUKCA_INERTIAL] of one link: com[3] in m, inertia[6] about com in
 * kg m^2 (xx yy zz xy xz yz; NULL: a point mass), both in the link's frame. */
void mukca_inertial_add(double *p, double kg, const double com[3], const double inertia[6]);

/* Regressor Y[n_joints][n_joints][MUKCA_INERTIAL]: Y[i][k] is the torque of joint i by unit
 * parameters of link k, zero for k < i. */
void mukca_dynamics_regressor(double *Y, const mukca_dynamics *dynamics, const double *q,
                              const double *dq, const double *ddq);

/* The torques alone, torque[n_joints], for p[n_joints][MUKCA_INERTIAL]. */
void mukca_dynamics_torque(double *torque, const mukca_dynamics *dynamics, const double *p,
                           const double *q, const double *dq, const double *ddq);

#endif
