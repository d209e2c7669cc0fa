/* Mass, centre and inertia of a body, as robot models have them. */
#ifndef MUKCA_IO_BODY_H
#define MUKCA_IO_BODY_H

#include <stdbool.h>

typedef struct {
    double kg, com[3]; /* m */
    double inertia[6]; /* about com, kg m^2: xx yy zz xy xz yz */
} mukca_body;

/* The same body in axes R of another frame: R' x.  In place. */
void mukca_body_turn(mukca_body *out, const mukca_body *in, const double R[9]);

/* Add a change of its ten parameters (inverse_dynamics.h); `tensor`: that of the inertia, too.
 * Inertia that no body has becomes that of the masses at their centres.  False: no mass would be
 * left. */
bool mukca_body_change(mukca_body *b, const double change[10], bool tensor);

#endif
