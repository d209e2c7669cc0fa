/* Denavit-Hartenberg tables of a chain. */
#ifndef MUKCA_MODEL_DH_H
#define MUKCA_MODEL_DH_H

#include "mukca/chain.h"

/* Row k maps the frame of row k to that of row k - 1:
 *   standard  T = Rz(theta + q) Tz(d) Tx(a) Rx(alpha)   (Denavit, Hartenberg 1955; Paul 1981)
 *   modified  T = Rx(alpha) Tx(a) Rz(theta + q) Tz(d)   (Khalil 1986; Craig 1989)
 * A prismatic joint adds q to d. */
typedef enum { MUKCA_DH_STANDARD, MUKCA_DH_MODIFIED } mukca_dh_convention;

typedef struct {
    char name[MUKCA_NAME_SIZE];
    mukca_joint_type type;     /* fixed: a constant frame, as of the base and the tool */
    double a, alpha, d, theta; /* m, rad */
    double lower, upper;       /* rad or m; -HUGE_VAL, HUGE_VAL: no limit */
} mukca_dh_row;

typedef struct {
    mukca_dh_convention convention;
    int n_rows;
    mukca_dh_row row[MUKCA_MAX_ELEMENTS - 1];
} mukca_dh;

/* Convert the chain with theta[6 * n_elements] (NULL: nominal).  Exact: fixed rows before the first
 * and after the last joint contain what the joints' rows cannot represent; they are omitted if
 * zero.  d of nearly parallel axes is large, as their common normal is far away (Hayati 1983). */
void mukca_dh_from_chain(mukca_dh *dh, const mukca_chain *chain, const double *theta,
                         mukca_dh_convention convention);

#endif
