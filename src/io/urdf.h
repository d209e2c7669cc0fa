/* The arm's chain from a URDF and link masses. */
#ifndef MUKCA_IO_URDF_H
#define MUKCA_IO_URDF_H

#include "base/text.h"
#include "mukca/chain.h"

typedef struct {
    const char *base;      /* link; NULL: the URDF's root */
    const char *tip;       /* link; NULL: ball_link, else ball, else the only leaf */
    const char *inertials; /* table of link masses that override the URDF's (link, mass_kg, com_x_m,
                              com_y_m, com_z_m); or NULL */
    double gravity[3];     /* m/s^2, base frame; all 0: the URDF's root is upright */
    mukca_notes notes;
} mukca_urdf_options;

/* Read the chain from base to tip with the masses that it carries: side branches (all joints at
 * zero) are lumped with their element, one point mass per element.  `options` may be NULL.  Errors:
 * MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status mukca_urdf_load(mukca_chain *chain, const char *path,
                             const mukca_urdf_options *options, mukca_error *error);

/* ---- a URDF as text: checked for size, depth and xacro (urdf_text.c) ---- */

/* One <joint> of the robot. */
typedef struct {
    char *name; /* NULL: none */
    int line;
    double xyz[3], rpy[3]; /* of the origin, as written; 0 if absent */
} mukca_urdf_joint;

typedef struct {
    char *text;     /* the file's bytes, zero-terminated */
    char *elements; /* its elements and attributes only, UTF-8, as input of urdfdom */
    char sha256[65];
    int n_joints;
    mukca_urdf_joint *joints; /* in the order of the text */
} mukca_urdf_text;

/* Read and check a file.  Errors: MUKCA_INPUT (also: malformed XML, with its line; nested too
 * deeply; too large; unexpanded xacro; a document type), MUKCA_MEMORY. */
mukca_status mukca_urdf_text_read(mukca_urdf_text *urdf, const char *path, mukca_error *error);
void mukca_urdf_text_free(mukca_urdf_text *urdf); /* harmless on zeroed text */

/* The joint of that name; NULL: none. */
const mukca_urdf_joint *mukca_urdf_text_joint(const mukca_urdf_text *urdf, const char *name);

/* ---- mass, centre and inertia of a body, as robot models have them (body.c) ---- */

/* Whether a tensor (xx yy zz xy xz yz) is positive definite. */
bool mukca_tensor_positive(const double T[6]);

/* The same body in axes R of another frame: R' x.  In place. */
void mukca_body_turn(mukca_mass *out, const mukca_mass *in, const double R[9]);

/* Add a body in frame T to the sum; one without mass is nothing. */
void mukca_body_add(mukca_mass *sum, const mukca_frame *T, const mukca_mass *body);

/* Add a change of its ten parameters (inverse_dynamics.h); `tensor`: that of the inertia, too.
 * Inertia that no body has becomes that of the masses at their centres.  False: no mass would be
 * left. */
bool mukca_body_change(mukca_mass *b, const double change[10], bool tensor);

#endif
