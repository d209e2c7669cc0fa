/* Alignment: of measured poses to the arm, of two arms to each other.  Frames of measured poses,
 * the tracker in the world and the target on the tool, are start values of every fit to poses. */
#ifndef MUKCA_FIT_ALIGN_H
#define MUKCA_FIT_ALIGN_H

#include "model/dataset.h"

/* measured = tracker * tip(q) * target, with the geometry's prediction tip(q). */
typedef struct {
    mukca_frame tracker, target; /* identity if not free */
    double median_m, mean_m;     /* distance after the alignment, m; NaN: none */
    bool open_target, open_turn; /* the poses do not determine the target's offset, or the tracker's
                                    rotation */
} mukca_alignment;

typedef struct {
    bool tracker, target; /* which frames are unknown */
    const int *group;     /* [n_rows] only the samples of group `only` are used; NULL: all */
    int only;
    int steps; /* at most so many Gauss-Newton steps; 0: until they converge */
} mukca_align_options;

/* Align the measured poses of `data` (samples of sockets are ignored): the least squares of
 * positions and orientations over both frames, with Huber weights, and a weak prior of the target's
 * offset for what the poses do not determine.  Several starts: Horn's absolute orientation (1987)
 * with the target on the flange, or at the solution of a linear system in the target and the
 * tracker, or the hand-eye equation (Park and Martin 1994).  Positions alone leave the target's
 * rotation at identity.  Fewer than three poses, or no free frame: identity.  False: no memory. */
bool mukca_align(mukca_alignment *alignment, const mukca_geometry *geometry,
                 const mukca_dataset *data, const mukca_align_options *options);

/* What the poses leave open and what to do, NULL: nothing. */
const char *mukca_alignment_open(const mukca_alignment *alignment);

/* ---- frames of measured poses as elements of the chain ---- */

/* Copy of `chain` with a fixed element in front (from the tracker's frame to the arm's base) and,
 * if the chain does not end in a fixed joint, one at the end (target on the flange).  Errors:
 * MUKCA_INPUT (too many elements). */
mukca_status mukca_chain_with_frames(mukca_chain *out, const mukca_chain *chain, bool base,
                                     bool tool, mukca_error *error);

/* Initial theta[6 * n_elements]: nominal, with the added frames aligned to the measured poses (with
 * several targets, to those of the first).  Errors: MUKCA_MEMORY. */
mukca_status mukca_frames_start(double *theta, const mukca_chain *with_frames,
                                const mukca_dataset *data, bool base, bool tool,
                                mukca_error *error);

/* ---- pose of one arm's base in that of another, from shared sockets ---- */

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
