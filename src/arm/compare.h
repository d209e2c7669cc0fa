/* Two models of one arm compared independently of gauge: the base frame, the place of the tool and
 * where the frames lie along and about the joints' axes mean nothing. */
#ifndef MUKCA_ARM_COMPARE_H
#define MUKCA_ARM_COMPARE_H

#include "mukca/corrected.h"

enum {
    MUKCA_COMPARED = 1000
}; /* postures; the 95th percentile is then known to 1.4 points (2 sd)
    */

/* One joint axis of B against that of A, each seen from the axis before it.  NaN: gauge, or not
 * defined. */
typedef struct {
    double angle;    /* between the axes, rad */
    double distance; /* of the axes at A's joint, m; NaN for a joint that slides */
    double zero;     /* joint zero of B minus that of A, rad; NaN for the first and last joint */
    double slide;    /* shift of what follows along the axis, m; NaN likewise, and where the next
                        axis is parallel */
} mukca_axis_difference;

typedef struct {
    double mean, p95, max;
} mukca_compared_error;

typedef struct {
    mukca_axis_difference axis[MUKCA_MAX_JOINTS];
    mukca_frame base, tool;             /* A's tip is near base * B's tip * tool */
    mukca_compared_error position[2];   /* m: as the models are, and so aligned */
    mukca_compared_error rotation[2];   /* rad, likewise */
    mukca_frame tip[2][MUKCA_COMPARED]; /* of A and of B in each posture, as they are */
    double error[2][MUKCA_COMPARED];    /* m, of each posture, ascending: as they are, aligned */
} mukca_comparison;

/* Compare `b` with `a`, which have as many joints, paired in order: axes by their geometry alone,
 * tips with the effects (of a joint state that nothing is known of) in postures drawn within the
 * limits of `a`. */
void mukca_compare(mukca_comparison *comparison, const mukca_corrected *a,
                   const mukca_corrected *b);

#endif
