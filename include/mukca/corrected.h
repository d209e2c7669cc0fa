/* The corrected arm for controllers: load an offsets table once, then compute positions, poses and
 * Jacobians with the calibrated geometry and the identified effects.
 *
 * The comment lines of an offsets table contain the whole chain: neither the URDF nor an XML parser
 * is needed.  Except for the functions that load a file, nothing here allocates, locks or touches
 * anything but its arguments: several threads may share a model.  These functions need
 * libmukca_core; the others are also in libmukca_rt.
 */
#ifndef MUKCA_CORRECTED_H
#define MUKCA_CORRECTED_H

#include "mukca/effect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Some 30 kB of the caller's memory. */
typedef struct {
    mukca_chain chain;
    mukca_geometry geometry; /* calibrated */
    int n_effects;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    bool judged, accepted; /* the table has a verdict; its calibration was accepted */
    bool intact;           /* the table matches its digest */
} mukca_corrected;

/* Fill `model` from the `size` bytes of an offsets table in memory (as `mukca calibrate -o` writes
 * it).  A table whose calibration was not accepted (`judged`, not `accepted`) is an error, and so
 * is one that was edited or cut after it was written.  A table without a verdict (not `judged`) or
 * without a digest (not `intact`), from an older release or written by hand, is loaded.  Errors:
 * MUKCA_INPUT, with the line. */
mukca_status mukca_corrected_parse(mukca_corrected *model, const char *text, size_t size,
                                   mukca_error *error);

/* The same from a file (libmukca_core).  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_corrected_load(mukca_corrected *model, const char *path, mukca_error *error);

/* Tip in the base frame, m, for encoder angles q[n_joints] (rad, m).  `state`: further inputs of
 * some effects (last move, time since the start, command); NULL: none. */
void mukca_corrected_position(double position[3], const mukca_corrected *model, const double *q,
                              const mukca_joint_state *state);

void mukca_corrected_pose(mukca_frame *T_base_tip, const mukca_corrected *model, const double *q,
                          const mukca_joint_state *state);

/* Derivative of the pose with respect to q, J[6][n_joints] row-major: linear (m/rad, m/m), then
 * angular, in base coordinates.  The derivatives of load-independent effects are included;
 * deflections under load, last move, command and the other members of `state` are constant.
 * `T_base_tip` may be NULL. */
void mukca_corrected_jacobian(double *J, mukca_frame *T_base_tip, const mukca_corrected *model,
                              const double *q, const mukca_joint_state *state);

#ifdef __cplusplus
}
#endif
#endif
