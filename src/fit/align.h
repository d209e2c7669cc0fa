/* Frames of measured poses: the tracker in the world and the target on the tool, from a closed
 * form.  Start values of every fit to poses. */
#ifndef MUKCA_FIT_ALIGN_H
#define MUKCA_FIT_ALIGN_H

#include "model/dataset.h"

/* measured = tracker * tip(q) * target, with the geometry's prediction tip(q). */
typedef struct {
    mukca_frame tracker, target; /* identity if not free */
    double median_m, mean_m;     /* distance after the alignment, m; NaN: none */
} mukca_alignment;

typedef struct {
    bool tracker, target;      /* which frames are unknown */
    const unsigned char *keep; /* [n_rows] samples to use, NULL: all */
} mukca_align_options;

/* Align the measured poses of `data` (samples of sockets are ignored).  Rotations are computed from
 * the orientations if there are any (hand-eye equation, Park and Martin 1994), else from the
 * positions: a linear system in the target and the tracker, then Horn's absolute orientation
 * (1987).  Robust Gauss-Newton steps refine the result.  Positions alone leave the target's
 * rotation at identity.  Fewer than three poses, or no free frame: identity.  False: no memory. */
bool mukca_align(mukca_alignment *alignment, const mukca_geometry *geometry,
                 const mukca_dataset *data, const mukca_align_options *options);

#endif
