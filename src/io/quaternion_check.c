/* The order of recorded quaternions, by the arm's kinematics.
 *
 * measured = tracker * tip(q) * target: the turn between two rows, seen from the target, is that of
 * the tip in a turned frame, so that products of two such turns do not depend on the frames.  A
 * quaternion with its numbers rotated by one place is an inverse between two fixed rotations: then
 * angles, and products of two turns that share a row, are right still, but others are not.  Poses
 * that were measured the other way round look the same. */
#include "io/quaternion_check.h"

#include <math.h>
#include <string.h>

#include "mukca/chain.h"

/* Rows that turn the tip by less say little, rad; enough pairs for a verdict; and what an error of
 * the nominal arm (some 10 mrad of turns of a radian) stays far below: the other order's errors are
 * of the size of the turns squared. */
static const double least_turn = 0.2, least_error = 0.05, least_ratio = 10;
enum { LEAST_PAIRS = 5, MOST_PAIRS = 40 };

/* The rotation of quaternion[4] in the order given or (other) in the other one. */
static void rotation(double R[9], const double quaternion[4], bool other, bool w_last, bool inverse)
{
    double q[4], T[9];
    for (int i = 0; i < 4; i++) /* w last: x y z w in the file, and x would be w */
        q[i] = quaternion[!other ? i : w_last ? (i + 1) % 4 : (i + 3) % 4];
    mukca_rotation_from_quaternion(R, q);
    memcpy(T, R, sizeof T);
    for (int i = 0; i < 9 && inverse; i++) R[i] = T[3 * (i % 3) + i / 3];
}

/* Axis times sine of the turn from A to B, seen from A: of A' B what is antisymmetric.  It does not
 * jump at half a turn as the rotation vector does. */
static void turn_between(double w[3], const double A[9], const double B[9])
{
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        w[i] = 0;
        for (int r = 0; r < 3; r++)
            w[i] += 0.5 * (A[3 * r + b] * B[3 * r + a] - A[3 * r + a] * B[3 * r + b]);
    }
}

bool mukca_quaternion_check_wrong(mukca_quaternion_check *o, const mukca_chain *chain,
                                  const double *q, const double quaternion[4], bool w_last,
                                  bool inverse)
{
    mukca_frame tip;
    double R[3][9], turn[3][3], product[3] = {0};
    if (o->pairs == MOST_PAIRS) return false;
    if (o->n == 0) mukca_geometry_set(&o->geometry, chain, NULL);
    mukca_fk_pose(&tip, &o->geometry, q, NULL);
    memcpy(R[0], tip.R, sizeof R[0]);
    for (int k = 0; k < 2; k++) rotation(R[1 + k], quaternion, k == 1, w_last, inverse);
    if (o->n > 0 && mukca_rotation_between(o->last[0], R[0]) < least_turn) return false;
    for (int k = 0; k < 3 && o->n > 0; k++) {
        turn_between(turn[k], o->last[k], R[k]);
        product[k] = mukca_dot3(o->turn[1][k], turn[k]);
    }
    if (o->n > 2) {
        for (int k = 0; k < 2; k++) o->error[k] += fabs(product[1 + k] - product[0]);
        o->pairs++;
    }
    memcpy(o->turn[1], o->turn[0], sizeof turn);
    if (o->n > 0) memcpy(o->turn[0], turn, sizeof turn);
    memcpy(o->last, R, sizeof R);
    o->n++;
    return o->pairs >= LEAST_PAIRS && o->error[0] > least_error * o->pairs &&
           o->error[0] > least_ratio * o->error[1];
}
