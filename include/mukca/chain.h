/* The arm as a chain of URDF joints from base to tip, its masses, and forward kinematics.
 *
 * Element k maps coordinates of its child frame to its parent frame:
 *     T_k(q) = [ R(rpy_k) R(axis_k, q) , xyz_k ]      revolute, continuous (fixed: no q)
 *     T_k(q) = [ R(rpy_k) , xyz_k + R(rpy_k) axis_k q ]  prismatic
 *     T_base_tip = T_0 T_1 ... T_{n-1}
 * All structures are plain caller-owned memory of fixed size; nothing here allocates.
 */
#ifndef MUKCA_CHAIN_H
#define MUKCA_CHAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "mukca/capacities.h"
#include "mukca/rotation.h"
#include "mukca/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    MUKCA_NAME_SIZE = 64,
    MUKCA_PARAMETERS = 6 /* per element: x y z roll pitch yaw */
};

typedef enum { MUKCA_FIXED, MUKCA_REVOLUTE, MUKCA_CONTINUOUS, MUKCA_PRISMATIC } mukca_joint_type;

static inline bool mukca_joint_turns(int type)
{
    return type == MUKCA_REVOLUTE || type == MUKCA_CONTINUOUS;
}

typedef struct {
    char name[MUKCA_NAME_SIZE];  /* of the URDF joint */
    char child[MUKCA_NAME_SIZE]; /* its child link */
    mukca_joint_type type;
    int joint;           /* index among the actuated joints; -1: fixed */
    double xyz[3];       /* nominal origin, m */
    double rpy[3];       /* nominal origin, rad */
    double axis[3];      /* unit, in the joint frame */
    double lower, upper; /* rad or m; -HUGE_VAL, HUGE_VAL: unlimited */
} mukca_element;

/* A mass that moves with the child frame of `element`. */
typedef struct {
    int element;
    double kg;
    double com[3];     /* m, in the child frame of `element` */
    double inertia[6]; /* xx yy zz xy xz yz about com, in that frame, kg m^2; 0: unknown */
} mukca_mass;

typedef struct {
    char robot[MUKCA_NAME_SIZE], base[MUKCA_NAME_SIZE], tip[MUKCA_NAME_SIZE];
    char urdf_sha256[65];       /* lower-case hex; empty: not from a file */
    char kinematics_sha256[65]; /* of the factory file that replaced origins; empty: none */
    char kinematics_hash[MUKCA_NAME_SIZE]; /* UR's robot identifier in that file; empty: none */
    uint64_t urdf_geometry; /* hash of the origins in the URDF, which name the model; 0: none */
    int n_elements, n_joints, n_masses;
    mukca_element element[MUKCA_MAX_ELEMENTS];
    int joint_element[MUKCA_MAX_JOINTS]; /* element of each actuated joint */
    mukca_mass mass[MUKCA_MAX_MASSES];
    double gravity[3]; /* m/s^2 in the base frame; (0, 0, -9.80665) for an upright base */
} mukca_chain;

/* The origins in use (nominal or corrected), ready for the kernels. */
typedef struct {
    int n_elements, n_joints;
    mukca_frame origin[MUKCA_MAX_ELEMENTS];
    double axis[MUKCA_MAX_ELEMENTS][3];
    signed char type[MUKCA_MAX_ELEMENTS]; /* mukca_joint_type */
    signed char joint[MUKCA_MAX_ELEMENTS];
    signed char axis_z[MUKCA_MAX_ELEMENTS]; /* +1, -1: axis exactly +z, -z; 0: any other axis */
} mukca_geometry;

/* Names of the six parameters, in order: x y z roll pitch yaw. */
extern const char *const mukca_parameter_name[MUKCA_PARAMETERS];

/* Names of the types: fixed, revolute, continuous, prismatic. */
extern const char *const mukca_joint_type_name[4];

/* Name of an actuated joint; NULL for -1. */
const char *mukca_chain_joint_name(const mukca_chain *chain, int joint);

/* Index of the actuated joint (element) with that name, -1 if there is none. */
int mukca_chain_find_joint(const mukca_chain *chain, const char *name);
int mukca_chain_find_element(const mukca_chain *chain, const char *name);

/* Nominal parameters theta[6 * n_elements]: x y z roll pitch yaw of each element. */
void mukca_chain_theta(double *theta, const mukca_chain *chain);

/* Origins from theta[6 * n_elements] (NULL: nominal). */
void mukca_geometry_set(mukca_geometry *geometry, const mukca_chain *chain, const double *theta);

/* The inverse: theta[6 * n_elements] from origins, RPY near the nominal ones. */
void mukca_geometry_theta(double *theta, const mukca_chain *chain, const mukca_geometry *geometry);

/* Displacement of one configuration by unmodelled effects (effect.h), on top of its geometry.
 * Zeroed: none.  Rotations are small but applied exactly (exponential map). */
typedef struct {
    double q[MUKCA_MAX_JOINTS];           /* added to the encoder's angle, rad or m */
    double rotation[MUKCA_MAX_JOINTS][3]; /* rotation vector before the joint turns, joint frame */
    double base[3];                       /* rotation vector of the base about its origin */
    double tip[3];                        /* shift of the tip in the tip's frame, m */
    bool any_rotation;                    /* false: `rotation` and `base` are all zero */
} mukca_displacement;

/* Position of the tip in the base frame, m, for q[n_joints].  `displacement` may be NULL. */
void mukca_fk_position(double position[3], const mukca_geometry *geometry, const double *q,
                       const mukca_displacement *displacement);

/* Positions [rows][3] for q[rows][n_joints], without displacements: bitwise equal to those of
 * mukca_fk_position, computed several rows at a time. */
void mukca_fk_positions(double *positions, const mukca_geometry *geometry, const double *q,
                        int rows);

/* Pose of the tip.  `displacement` may be NULL. */
void mukca_fk_pose(mukca_frame *T_base_tip, const mukca_geometry *geometry, const double *q,
                   const mukca_displacement *displacement);

/* Frame of each element before its joint's motion (origin applied), before[n_elements], and the
 * tip.  `tip` may be NULL. */
void mukca_fk_frames(mukca_frame *before, mukca_frame *tip, const mukca_geometry *geometry,
                     const double *q, const mukca_displacement *displacement);

/* Geometric Jacobian of the tip in base coordinates, J[6][n_joints] row-major: linear velocity
 * (m/rad or m/m) first, then angular.  `T_base_tip` (may be NULL): the pose at q. */
void mukca_fk_jacobian(double *J, mukca_frame *T_base_tip, const mukca_geometry *geometry,
                       const double *q, const mukca_displacement *displacement);

/* Parameter Jacobian of the tip's position, J[3][6 * n_elements] row-major, with respect to x y z
 * roll pitch yaw of each element (m/m, m/rad).  `theta` must be the one that `geometry` was set
 * from. */
void mukca_fk_parameter_jacobian(double *J, double position[3], const mukca_geometry *geometry,
                                 const double *theta, const double *q);

#ifdef __cplusplus
}
#endif
#endif
