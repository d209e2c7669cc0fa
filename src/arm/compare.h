/* Comparison of two models of one arm, independent of gauge: of the base frame, the tool frame, and
 * the position of joint frames along and about their axes. */
#ifndef MUKCA_ARM_COMPARE_H
#define MUKCA_ARM_COMPARE_H

#include "math/dense.h"
#include "mukca/corrected.h"

enum { MUKCA_COMPARED = 1000 }; /* postures; gives the 95th percentile within 1.4 points (2 sd) */

/* One joint axis of B relative to A's, each in the frame of the preceding axis.  NaN: gauge, or
 * undefined. */
typedef struct {
    double angle;    /* between the axes, rad */
    double distance; /* of the axes at A's joint, m; NaN: prismatic joint */
    double zero;     /* joint zero of B minus that of A, rad; NaN: first and last joint */
    double slide;    /* translation of the following links along the axis, m; NaN: likewise, or the
                        next axis is parallel */
} mukca_axis_difference;

typedef struct {
    double mean, p95, max;
} mukca_compared_error;

typedef struct {
    mukca_axis_difference axis[MUKCA_MAX_JOINTS];
    mukca_frame base, tool;             /* alignment: A's tip is near base * B's tip * tool */
    mukca_compared_error position[2];   /* m: without and with alignment */
    mukca_compared_error rotation[2];   /* rad, likewise */
    mukca_frame tip[2][MUKCA_COMPARED]; /* of A and B in each posture, without alignment */
    mukca_meeting_point points[MUKCA_COMPARED];           /* scratch */
    double moved[MUKCA_COMPARED], turned[MUKCA_COMPARED]; /* scratch */
} mukca_comparison;

/* Compare `b` with `a`, arms with the same number of joints.  Axes are compared by geometry alone;
 * tips with their effects (unknown joint state) in random postures within the limits of `a`. */
void mukca_compare(mukca_comparison *comparison, const mukca_corrected *a,
                   const mukca_corrected *b);

#endif
