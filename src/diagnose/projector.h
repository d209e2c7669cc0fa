/* Projection of the present model out of candidates: projected normal equations and evidence. */
#ifndef MUKCA_DIAGNOSE_PROJECTOR_H
#define MUKCA_DIAGNOSE_PROJECTOR_H

#include "diagnose/bayes_factor.h"
#include "diagnose/products.h"

/* With the present columns X (geometry and causes, prior sigmas D), the weights W (and the distance
 * rows) and H = 1 + D X'WX D = LL', a candidate E has the projected normal equations G = E'WE -
 * T'T,  g = E'W y - T'z,  T = L^-1 D X'W E,  z = L^-1 D X'W y.  All products with W are computed
 * beforehand: a candidate costs one triangular solve. */
typedef struct {
    mukca_regression *m;
    const mukca_normal_equations *normal;
    mukca_product_scratch scratch;
    int n, rows;        /* columns; observation rows, dim * n_samples */
    double precision;   /* 1 / sigma^2 */
    double residual;    /* quadratic form of the present model's residual */
    double *inverse;    /* [n_pairs] 1 / variance of the distance rows */
    double *z;          /* [n] */
    double *factor;     /* [n + 1] precision * D, and the precision */
    double *distance;   /* [n_pairs][n + 1] distance rows times D over their variance */
    double *T, *along;  /* [n + 1][], [n_pairs][] scratch of MUKCA_BATCH columns */
    double *near;       /* scratch: products of neighbouring columns of T */
    mukca_products own; /* scratch of mukca_projector_project() */
    bool have_rows;     /* Zt and u belong to the present normal equations */
    unsigned version;   /* of the linearisation */
    double *u;          /* [rows] W y - Zt z */
    double *Zt;         /* [rows][n] W X D L'^-1 */
    struct {            /* running sums over the samples of a step of a socket */
        int group, from;
        double square, mean, g[3], *T; /* square and mean with weights, g, T[3][n] */
    } step;
} mukca_projector;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_projector_create(mukca_projector *p, mukca_pool *pool, mukca_regression *m);

/* Set up for these normal equations and m->evidence.prior. */
void mukca_projector_aim(mukca_projector *p, const mukca_normal_equations *normal, double sigma);

/* Compute Zt and u, for many faults and for access to single samples. */
void mukca_projector_rows(mukca_projector *p);

/* Compute G[k][k] and g[k] of the columns p->scratch.E[n_samples][dim][k]: those of candidate h,
 * followed by any others. */
void mukca_projector_project(double *G, double *g, mukca_projector *p, int k,
                             const mukca_candidate *h);

/* A candidate, or all orders of ripple of a joint, and the destination of its scores. */
typedef struct {
    const mukca_products *products;
    const mukca_candidate *candidate;
    double *value, *information; /* [columns / block] */
} mukca_scored;

/* Log Bayes factors of n items from their products. */
void mukca_projector_score(mukca_projector *p, const mukca_scored *item, int n);

/* Log Bayes factor of a fault of one socket or sample; needs mukca_projector_rows(). */
double mukca_projector_fault(mukca_projector *p, const mukca_candidate *h, double *information);

#endif
