/* Sweeps over many samples at once: predictions, adjoint gradient, Jacobian (docs/method.md, 2).
 *
 * Samples are processed in windows, one open at a time: the intermediate results of a window stay
 * in the cache, and their memory does not grow with the samples.  All arrays run along the samples
 * of the open window (structure of arrays, padded to a multiple of 8).  Each joint frame is first
 * rotated to make its axis z: with A_k e_z = axis_k, the tip in element k's parent frame is
 *     u_k = (A_{k-1}' R_k A_k) Rz(q) u_{k+1} + A_{k-1}' p_k.
 * Sines and cosines of the joint angles are constants of a fit and are computed once.
 */
#ifndef MUKCA_FIT_SWEEP_H
#define MUKCA_FIT_SWEEP_H

#include "base/pool.h"
#include "fit/parameters.h"

typedef enum { MUKCA_GRADIENT_FD, MUKCA_GRADIENT_ANALYTIC } mukca_gradient;

/* Samples of a window: 1 MB of a Jacobian with 48 columns, which stays in the cache. */
enum { MUKCA_SWEEP_WINDOW = 1024, MUKCA_SWEEP_PADDING = 7 /* at most, of the last one */ };

typedef struct {
    int n_elements, n_joints, n_rows, n_windows;
    int type[MUKCA_MAX_ELEMENTS], joint[MUKCA_MAX_ELEMENTS];
    double align[MUKCA_MAX_ELEMENTS + 1][9];                   /* A_{k-1} at k; align[0] = I */
    double R[MUKCA_MAX_ELEMENTS][9], p[MUKCA_MAX_ELEMENTS][3]; /* aligned origins in use */
    double *turns; /* [n_windows][2][n_joints][padded] sines and cosines of all samples */
    /* Of the open window: */
    int from, rows, padded; /* samples from, from + 1, ..., from + rows - 1 */
    double *sine, *cosine;  /* [n_joints][padded]; prismatic: sine holds q */
    double *x;              /* [3][padded] predicted tip */
    double *h;              /* [3][padded] adjoint of x, or derivatives of a tip */
    double *w; /* [n_elements][3][padded] tip in the frame after the origin of each element */
    double *Q; /* [9][padded] of poses.c */
} mukca_sweep;

/* Allocate the arrays for `rows` samples from the pool. */
void mukca_sweep_take(mukca_sweep *sweep, mukca_pool *pool, const mukca_chain *chain, int rows);

/* Load joint angles q[n_rows][n_joints]; opens the last window. */
void mukca_sweep_load(mukca_sweep *sweep, const mukca_chain *chain, const double *q);

/* Open a window: the functions below apply to its samples.  False: there is none of this number. */
bool mukca_sweep_open(mukca_sweep *sweep, int window);

/* Set the origins from theta[6 * n_elements]. */
void mukca_sweep_origins(mukca_sweep *sweep, const double *theta);

/* Compute x and w for the origins in use. */
void mukca_sweep_forward(mukca_sweep *sweep);

/* Sums over the samples for the gradient, per element, in true (not aligned) coordinates: of the
 * adjoints in its parent frame (derivative with respect to its translation), and of their outer
 * products with w (to be multiplied by a derivative of its rotation). */
typedef struct {
    double sum[MUKCA_MAX_ELEMENTS][3], outer[MUKCA_MAX_ELEMENTS][9];
} mukca_adjoint;

/* Propagate the adjoint h of the predictions from base to tip (destroyed; zero in the padding), and
 * add to the sums.  Needs mukca_sweep_forward. */
void mukca_sweep_backward(mukca_adjoint *adjoint, mukca_sweep *sweep);

/* dR[3][9]: derivatives of an element's rotation with respect to roll, pitch, yaw, analytic or by
 * central differences.  (Positions are linear in the translation, whose derivative is exact.) */
void mukca_sweep_element_derivative(double dR[3][9], const double rpy[3], mukca_gradient gradient);

#endif
