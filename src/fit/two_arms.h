/* Pose of one arm's base in that of another, from sockets that both have recorded. */
#ifndef MUKCA_FIT_TWO_ARMS_H
#define MUKCA_FIT_TWO_ARMS_H

#include "mukca/rotation.h"
#include "mukca/status.h"

/* A socket as both arms predict it: mean of its samples in each base, m, and the variance of each
 * coordinate due to measurement noise, m^2.  Index 0: left, 1: right. */
typedef struct {
    double at[2][3], variance[2];
} mukca_shared_socket;

typedef struct {
    mukca_frame pose; /* left = pose * right */
    double sigma[6];  /* of the position (m) and of the rotation about the left base's axes (rad) */
    double width95[6]; /* half the width of the 95 % interval of each */
    double residual_m; /* rms distance between the sockets after the alignment, m */
    double expected_m; /* the same if caused by noise alone, m */
    double scale;      /* of sigma: root of chi squared per degree of freedom, at least 1 */
    int freedom;       /* 3 n - 6 */
} mukca_two_arms;

/* Weighted least squares over sockets[n].  If the residuals exceed the noise (errors of the arms'
 * geometry), sigma is scaled up accordingly.  Errors: MUKCA_UNIDENTIFIABLE (fewer than three
 * sockets, or all on one line). */
mukca_status mukca_two_arms_align(mukca_two_arms *result, const mukca_shared_socket *sockets, int n,
                                  mukca_error *error);

#endif
