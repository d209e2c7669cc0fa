/* The projector for functions that turn one joint about its axis: its levers reduce the rows of a
 * sample to one. */
#ifndef MUKCA_DIAGNOSE_JOINT_VIEW_H
#define MUKCA_DIAGNOSE_JOINT_VIEW_H

#include "diagnose/projector.h"

typedef struct {
    mukca_projector *p;
    int joint;
    double *Z;        /* [n_samples][n] */
    double *u;        /* [n_samples] */
    double *diagonal; /* [n_samples] of W times the levers, without the sockets' means */
    double *off;      /* [n_samples] twice the entry with the row before */
    double *F, *H;    /* [n_samples][2 * MUKCA_MAX_COLUMNS] scratch */
} mukca_joint_view;

size_t mukca_joint_view_size(const mukca_regression *m);
mukca_joint_view mukca_joint_view_aim(mukca_projector *p, int joint, double *memory);

/* Projected normal equations of the functions F[n_samples][width] in the view:
 * T[n][width] (in p->T), g[width], and mean[n_groups][3][width] of their effect on each socket's
 * mean. */
void mukca_joint_view_project(double *g, double *mean, const mukca_joint_view *v, int width);

/* G[k][k] of the functions [at, at + k) of those in F, after mukca_joint_view_project. */
void mukca_joint_view_gram(double *G, const mukca_joint_view *v, const double *mean, int width,
                           int at, int k);

#endif
