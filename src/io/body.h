/* Mass, centre and inertia of a body, as robot models have them. */
#ifndef MUKCA_IO_BODY_H
#define MUKCA_IO_BODY_H

#include "mukca/chain.h"

/* The same body in axes R of another frame: R' x.  In place. */
void mukca_body_turn(mukca_mass *out, const mukca_mass *in, const double R[9]);

/* Add a body in frame T to the sum; one without mass is nothing. */
void mukca_body_add(mukca_mass *sum, const mukca_frame *T, const mukca_mass *body);

/* Add a change of its ten parameters (inverse_dynamics.h); `tensor`: that of the inertia, too.
 * Inertia that no body has becomes that of the masses at their centres.  False: no mass would be
 * left. */
bool mukca_body_change(mukca_mass *b, const double change[10], bool tensor);

#endif
