/* What the present model leaves of a candidate's columns: projected normal equations and evidence.
 */
#ifndef MUKCA_DIAGNOSE_PROJECTOR_H
#define MUKCA_DIAGNOSE_PROJECTOR_H

#include "diagnose/regression.h"

/* With the present columns X (geometry and causes, prior sigmas D) and H = 1 + D X'WX D = LL', a
 * candidate E with W the whitening and centring (and the distance rows) has the projected normal
 * equations  G = E'WE - T'T,  g = E'u,  T = L^-1 D X'W E,  u = W y - (L^-1 D X'W)' z.  So W X is
 * formed once, and each candidate costs one product with it. */
typedef struct {
    mukca_regression *m;
    const mukca_normal_equations *normal;
    int n, rows;         /* columns; observation rows d * n_samples */
    double precision;    /* 1 / sigma^2 */
    double root;         /* sqrt(1 - rho^2) */
    double residual;     /* quadratic form that the present model leaves */
    double *inverse;     /* [n_pairs] 1 / variance of the distance rows */
    double *weights;     /* [n_groups] o'o */
    double *z;           /* [n] */
    double *mean_weight; /* [n_samples] weight of each kept row in its socket's
                            whitened mean */
    double *u;           /* [rows] */
    double *Q;           /* [rows][n + 1]: W X and W y */
    double *Zt;          /* [rows][n] */
    double *E, *white;   /* [rows][MUKCA_MAX_COLUMNS] scratch */
    double *T;           /* [n][2 * MUKCA_MAX_COLUMNS] scratch */
} mukca_projector;

/* Doubles that a projector of that model needs, and laying it out in that memory. */
size_t mukca_projector_size(const mukca_regression *m);
mukca_projector mukca_projector_lay_out(mukca_regression *m, double *memory);

/* Prepare it for these normal equations and m->evidence.prior. */
void mukca_projector_aim(mukca_projector *p, const mukca_normal_equations *normal, double sigma);

/* Log Bayes factor of a block with projected Gram G[k][k] (leading dimension k) and gradient g[k]
 * (both destroyed), averaged over prior scales; noise profiled, sign of the first coefficient
 * honoured.  *information (may be NULL): largest diagonal entry of the effect's own
 * terms in units, 1/rad^2. */
double mukca_projector_block(double *G, double *g, const mukca_candidate *h, double residual,
                             int dof, double *information);

/* G[k][k] and g[k] of k columns E[rows][k] of any kind. */
void mukca_projector_project(double *G, double *g, mukca_projector *p, const double *E, int k,
                             const mukca_candidate *h);

/* Log Bayes factors: of any effect by its columns, and of a fault of one socket or row. */
double mukca_projector_field(mukca_projector *p, const mukca_candidate *h, double *information);
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information);

#endif
