/* The arm's chain from a URDF. */
#ifndef MUKCA_IO_URDF_H
#define MUKCA_IO_URDF_H

#include "mukca/chain.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *base;      /* link; NULL: the URDF's root */
    const char *tip;       /* link; NULL: ball_link, else ball, else the only leaf */
    const char *inertials; /* file of link masses that override the URDF's; or NULL */
    double gravity[3];     /* m/s^2, base frame; all 0: the URDF's root is upright */
} mukca_urdf_options;

/* Read the chain from base to tip with the masses that it carries: side branches (all joints at
 * zero) are lumped with their element, one point mass per element.  `options` and `note` may be
 * NULL.  Errors: MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_urdf_load(mukca_chain *chain, const char *path,
                             const mukca_urdf_options *options, mukca_note_fn *note, void *context,
                             mukca_error *error);

#ifdef __cplusplus
}
#endif
#endif
