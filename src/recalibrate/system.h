/* A linear least-squares problem built row by row: block QR, then a minimum-norm solution and the
 * combinations that the rows do not determine. */
#ifndef MUKCA_RECALIBRATE_SYSTEM_H
#define MUKCA_RECALIBRATE_SYSTEM_H

#include "recalibrate/model.h"

/* A block and the triangular factor fit in 32 KiB of cache for 31 unknowns. */
enum { MUKCA_SYSTEM_WIDTH = MUKCA_MAX_UNKNOWNS + 1, MUKCA_SYSTEM_BLOCK = 96 };

typedef struct {
    int n;                     /* unknowns; a lag is the last */
    bool positions, rotations; /* equations of a pose that it uses */
    double metres_per_radian;  /* weight of rotation rows relative to position rows; 0: 1 */
    mukca_unknown unknown[MUKCA_MAX_UNKNOWNS];
    double value[MUKCA_MAX_UNKNOWNS]; /* sum of the steps so far */
    long equations;
    double rss, total;                                 /* of the weighted rows */
    double R[MUKCA_MAX_UNKNOWNS * MUKCA_SYSTEM_WIDTH]; /* [n][n + 1], with Q'b */
    /* Rows not yet absorbed: positions, rotations.  They are separate because lengths have no
     * effect on rotations: the leading columns of rotation rows are zero if the lengths are the
     * first unknowns. */
    double block[2][MUKCA_SYSTEM_BLOCK * MUKCA_SYSTEM_WIDTH];
    int filled[2];
} mukca_pose_system;

typedef struct {
    int rank;
    double sigma2;                /* residual variance of a weighted row */
    double x[MUKCA_MAX_UNKNOWNS]; /* step of minimum norm, first in the arm's unknowns, then in the
                                     tool's */
    double sigma[MUKCA_MAX_UNKNOWNS]; /* standard error within the identifiable subspace */
    bool identifiable[MUKCA_MAX_UNKNOWNS];
    int n_null;
    double null[MUKCA_MAX_UNKNOWNS][MUKCA_MAX_UNKNOWNS]; /* [n_null][n] unidentifiable; sparse */
    /* scratch: factors of the equations, products of the null space */
    double U[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS], V[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS],
        A[MUKCA_MAX_UNKNOWNS * MUKCA_MAX_UNKNOWNS];
} mukca_pose_solution;

/* Remove all rows. */
void mukca_pose_system_clear(mukca_pose_system *system);

/* Add the rows of one pose, both sides multiplied by `weight` (position) and `turn_weight`. */
void mukca_pose_system_add(mukca_pose_system *system, const mukca_pose_look *look, double weight,
                           double turn_weight);

/* Absorb all rows into R and rss. */
void mukca_pose_system_flush(mukca_pose_system *system);

/* Solve for the first `n` unknowns; the others stay 0.  An unknown with a standard error above
 * `loosest` (m or rad) is not identifiable.  False: the rows are not finite. */
bool mukca_pose_system_solve(mukca_pose_solution *solution, mukca_pose_system *system, int n,
                             double loosest);

/* Value of the last unknown, and its distance from 0 in standard errors (returned); call after
 * solve. */
double mukca_pose_system_last(double *value, const mukca_pose_system *system);

#endif
