/* Order of the numbers in recorded quaternions, by the arm's kinematics.
 *
 * measured = tracker * tip(q) * target.  The rotation between two rows, in the target's frame, is
 * that of the tip in a rotated frame: inner products of two such rotation vectors are independent
 * of the frames.  A cyclic shift of a quaternion's four numbers is an inversion between two fixed
 * rotations.  It preserves angles, and inner products of two rotations with a common row, but not
 * others.  Inverse poses behave alike. */
#include "io/rows.h"

#include <math.h>
#include <string.h>

#include "mukca/chain.h"

/* Smaller rotations of the tip contribute little, rad; number of pairs for a verdict; thresholds
 * far above the effect of errors of the nominal arm (some 10 mrad in rotations of 1 rad).  The
 * errors of a wrong order are of the size of the rotations squared. */
static const double least_turn = 0.2, least_error = 0.05, least_ratio = 10;
enum { LEAST_PAIRS = 5, MOST_PAIRS = 40 };

/* Rotation of quaternion[4] in the file's order, or (other) in the other order. */
static void rotation(double R[9], const double quaternion[4], bool other, bool w_last, bool inverse)
{
    double q[4], T[9];
    for (int i = 0; i < 4; i++) /* for w last, x y z w in the file: x would be w */
        q[i] = quaternion[!other ? i : w_last ? (i + 1) % 4 : (i + 3) % 4];
    mukca_rotation_from_quaternion(R, q);
    memcpy(T, R, sizeof T);
    for (int i = 0; i < 9 && inverse; i++) R[i] = T[3 * (i % 3) + i / 3];
}

/* Axis times sine of the rotation from A to B, in the frame of A: antisymmetric part of A' B.
 * Unlike the rotation vector it is continuous at half a turn. */
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
