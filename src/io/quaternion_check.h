/* Is the scalar of recorded quaternions the first or the last number?  The arm's kinematics shows
 * it. */
#ifndef MUKCA_IO_QUATERNION_CHECK_H
#define MUKCA_IO_QUATERNION_CHECK_H

#include "mukca/chain.h"

/* Begin zeroed. */
typedef struct {
    mukca_geometry geometry;
    int n;                /* orientations so far */
    double last[3][9];    /* the last one: predicted, as given, the other way */
    double turn[2][3][3]; /* the last two turns between them, likewise */
    double error[2];      /* sums over pairs of turns, rad^2 */
    int pairs;
} mukca_quaternion_check;

/* Add an orientation as it was read (w first; `w_last`: in the file it was last; `inverse`: of the
 * fixed frame in the target's), at joint angles q.  True when the orientations so far agree with
 * the nominal arm in the other order and not in this. */
bool mukca_quaternion_check_wrong(mukca_quaternion_check *order, const mukca_chain *chain,
                                  const double *q, const double quaternion[4], bool w_last,
                                  bool inverse);

#endif
