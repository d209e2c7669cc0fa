/* What the present model leaves of a candidate's columns: projected normal equations and evidence.
 */
#ifndef MUKCA_DIAGNOSE_PROJECTOR_H
#define MUKCA_DIAGNOSE_PROJECTOR_H

#include "diagnose/model.h"

/* With the present columns X (geometry and causes, prior sigmas D) and H = 1 + D X'WX D = LL', a
 * candidate E with W the whitening and centring (and the distance rows) has the projected normal
 * equations  G = E'WE - T'T,  g = E'u,  T = L^-1 D X'W E,  u = W y - (L^-1 D X'W)' z.  So W X is
 * formed once, and each candidate costs one product with it. */
typedef struct {
    gap_model *m;
    const gap_pack *pack;
    int n, rows;         /* columns; observation rows d * m->n */
    double precision;    /* 1 / sigma^2 */
    double residual;     /* quadratic form that the present model leaves */
    double *inverse;     /* [n_pairs] 1 / variance of the distance rows */
    double *weights;     /* [n_groups] o'o */
    double *z;           /* [n] */
    double *mean_weight; /* [m->n] weight of each kept row in its socket's whitened mean */
    double *u;           /* [rows] */
    double *Q;           /* [rows][n + 1]: W X and W y */
    double *Zt;          /* [rows][n] */
    double *E, *white;   /* [rows][GAP_MAX_TERMS] scratch */
    double *T;           /* [n][2 * GAP_MAX_TERMS] scratch */
} gap_projector;

/* Doubles that a projector of that model needs, and laying it out in that memory. */
size_t gap_projector_size(const gap_model *m);
gap_projector gap_projector_lay_out(gap_model *m, double *memory);

/* Make it ready for a filled pack and m->prior. */
void gap_projector_aim(gap_projector *p, const gap_pack *pack, double sigma);

/* Coefficients of row i in the inner AR(1) whitening: own and previous. */
void gap_ar_row(double *own, double *before, int i, double rho);

/* Log Bayes factor of a block with projected Gram G[k][k] (leading dimension k) and gradient g[k]
 * (both destroyed), averaged over prior scales; noise profiled, sign of the first coefficient
 * honoured.  *information (may be NULL): largest diagonal entry of the effect's own
 * terms in units, 1/rad^2. */
double gap_block_log_bayes(double *G, double *g, const gap_hypothesis *h, double residual, int dof,
                           double *information);

/* G[k][k] and g[k] of k columns E[rows][k] of any kind. */
void gap_project(double *G, double *g, gap_projector *p, const double *E, int k,
                 const gap_hypothesis *h);

/* Log Bayes factors: of any effect by its columns, and of a fault of one socket or row. */
double gap_field_log_bayes(gap_projector *p, const gap_hypothesis *h, double *information);
double gap_fault_log_bayes(gap_projector *p, const gap_hypothesis *h, double *information);

/* The same for functions of state that turn one joint about its axis: the joint's levers make one
 * row of the three of a sample. */
typedef struct {
    gap_projector *p;
    int joint;
    double *Z;        /* [m->n][n] */
    double *u;        /* [m->n] */
    double *diagonal; /* [m->n] of W seen through the levers, sockets' means apart */
    double *off;      /* [m->n] twice the entry with the row before */
    double *F, *H;    /* [m->n][2 * GAP_MAX_TERMS] scratch */
} gap_joint_view;

size_t gap_joint_view_size(const gap_model *m);
gap_joint_view gap_joint_view_aim(gap_projector *p, int joint, double *memory);

/* Projected normal equations of the functions F[m->n][width] in the view: T[n][width] (in p->T),
 * g[width], and mean[n_groups][3][width] of what they do to each socket's mean. */
void gap_joint_view_project(double *g, double *mean, const gap_joint_view *v, int width);

/* G[k][k] of the functions [at, at + k) of those in F, after gap_joint_view_project. */
void gap_joint_view_gram(double *G, const gap_joint_view *v, const double *mean, int width, int at,
                         int k);

#endif
