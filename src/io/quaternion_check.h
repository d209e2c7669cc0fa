/* Whether the scalar of recorded quaternions is the first or the last number, by the arm's
 * kinematics. */
#ifndef MUKCA_IO_QUATERNION_CHECK_H
#define MUKCA_IO_QUATERNION_CHECK_H

#include "mukca/chain.h"

/* Start zeroed. */
typedef struct {
    mukca_geometry geometry;
    int n;                /* number of orientations so far */
    double last[3][9];    /* last orientation: predicted, in the file's order, in the other order */
    double turn[2][3][3]; /* last two rotations between orientations, likewise */
    double error[2];      /* sums over pairs of turns, rad^2 */
    int pairs;
} mukca_quaternion_check;

/* Add an orientation as read (w first; `w_last`: it was last in the file; `inverse`: of the fixed
 * frame in the target's) at joint angles q.  True if the orientations so far agree with the nominal
 * arm in the other order and disagree in the file's order. */
bool mukca_quaternion_check_wrong(mukca_quaternion_check *order, const mukca_chain *chain,
                                  const double *q, const double quaternion[4], bool w_last,
                                  bool inverse);

#endif
