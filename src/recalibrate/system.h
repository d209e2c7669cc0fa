/* A linear least-squares problem whose rows come one at a time: block QR, then a minimum-norm
 * solution with the combinations that the rows do not determine. */
#ifndef MUKCA_RECALIBRATE_SYSTEM_H
#define MUKCA_RECALIBRATE_SYSTEM_H

#include "recalibrate/model.h"

/* A block and the triangle fit in 32 KiB of cache for 31 unknowns. */
enum { MUKCA_SYSTEM_WIDTH = 2 * MUKCA_MAX_UNKNOWNS + 1, MUKCA_SYSTEM_BLOCK = 96 };

typedef struct {
    int n;                     /* unknowns; a lag is the last one */
    int carried;               /* more that another system determines: unknown[n ..] */
    bool positions, rotations; /* which equations of a pose it uses */
    double metres_per_radian;  /* weight of rotation rows against position rows; 0: 1 */
    mukca_unknown unknown[MUKCA_SYSTEM_WIDTH];
    double value[MUKCA_MAX_UNKNOWNS]; /* sum of the steps taken so far */
    long equations;
    double rss[MUKCA_SYSTEM_WIDTH], total;             /* of weighted rows */
    double R[MUKCA_MAX_UNKNOWNS * MUKCA_SYSTEM_WIDTH]; /* [n][n + carried + 1], with Q'b */
    /* Rows not yet absorbed: positions, rotations.  Apart, because lengths do not turn the tip: the
     * first columns of rotations are zero where the lengths are the first unknowns. */
    double block[2][MUKCA_SYSTEM_BLOCK * MUKCA_SYSTEM_WIDTH];
    int filled[2];
} mukca_pose_system;

typedef struct {
    int rank;
    double sigma2;                    /* variance of a weighted row */
    double x[MUKCA_MAX_UNKNOWNS];     /* step; minimum norm of the arm's, then of the tool's */
    double sigma[MUKCA_MAX_UNKNOWNS]; /* standard error within the identifiable part */
    bool identifiable[MUKCA_MAX_UNKNOWNS];
    int n_null;
    double null[MUKCA_MAX_UNKNOWNS][MUKCA_MAX_UNKNOWNS]; /* [n_null][n] combinations that are not
                                                            identifiable, with few entries */
} mukca_pose_solution;

/* Forget all rows. */
void mukca_pose_system_clear(mukca_pose_system *system);

/* Take the rows of one pose, each side multiplied by `weight` (position) and `turn_weight`. */
void mukca_pose_system_add(mukca_pose_system *system, const mukca_pose_look *look, double weight,
                           double turn_weight);

/* Bring R, rss up to date with all rows. */
void mukca_pose_system_flush(mukca_pose_system *system);

/* Move the carried unknowns by these steps: the right-hand side changes accordingly. */
void mukca_pose_system_move_carried(mukca_pose_system *system, const double *steps);

/* Solve for the first `n` unknowns; the others stay 0.  An unknown with a standard error
 * above `loosest` (m or rad) is not identified.  False where the rows are not finite. */
bool mukca_pose_system_solve(mukca_pose_solution *solution, mukca_pose_system *system, int n,
                             double loosest);

/* How many standard errors the last unknown is away from 0, and its value; call after solve. */
double mukca_pose_system_last(double *value, const mukca_pose_system *system);

#endif
