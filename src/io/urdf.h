/* The arm's chain from a URDF and link masses; and as a URDF. */
#ifndef MUKCA_IO_URDF_H
#define MUKCA_IO_URDF_H

#include <stdio.h>

#include "mukca/chain.h"

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

/* ---- link masses (inertials.c): link, mass_kg, com_x_m, com_y_m, com_z_m ---- */

typedef struct {
    char link[MUKCA_NAME_SIZE];
    double kg;
    double com[3]; /* m, in the link's frame */
} mukca_inertial;

/* Whether `link` has that name, with or without a prefix ("left_panda_link1" is a "link1"). */
bool mukca_inertials_names(const char *link, const char *name);

/* Read the table into a new list of *n links; free *list with free.  Errors: MUKCA_INPUT (a
 * negative or implausible mass, a duplicate link), MUKCA_MEMORY. */
mukca_status mukca_inertials_read(mukca_inertial **list, int *n, const char *path,
                                  mukca_error *error);

/* ---- a chain as a URDF (urdf_write.c) ---- */

/* Print the chain's links and joints; a chain has no masses or shapes to print. */
void mukca_urdf_write(FILE *stream, const mukca_chain *chain);

#endif
