/* Evidence of the linearised model: normal equations, posterior of all columns. */
#ifndef MUKCA_DIAGNOSE_EVIDENCE_H
#define MUKCA_DIAGNOSE_EVIDENCE_H

#include "diagnose/linearisation.h"

enum { MUKCA_RHOS = 3 };

/* Possible AR(1) coefficients of the noise. */
extern const double mukca_evidence_rho[MUKCA_RHOS];

/* Normal equations at one AR(1) coefficient.  W combines whitening and the free means of the
 * sockets: W = A'A - A'o o'A / o'o in each socket and coordinate, with A the whitening matrix and o
 * = A times the vector of ones.  Each pair of sockets adds one row. */
typedef struct {
    double rho, log_det;
    double behind; /* log evidence of the best coefficient minus its own, in the last comparison */
    int dof, n, n_pairs;
    unsigned version;      /* of the linearisation with these columns; 0: none, or robust weights */
    double distance_sigma; /* m */
    double *gram;          /* [n + 1][n + 1] of the columns in use, and y */
    double *distance;      /* [n_pairs][n + 1] */
    double *variance;      /* [n_pairs] of a distance row, in units of sigma^2 */
    /* A'A is tridiagonal */
    double *diagonal, *off; /* [n_samples]; `off`: with the preceding sample */
    double *mean_weight;    /* [n_samples] A'o / o'o: weights in a socket's mean */
    double *ones;           /* [n_groups] o'o */
    /* of all stored columns of the linearisation */
    int done, stride;     /* columns computed so far, and their stride */
    double *weighted;     /* [n_samples][dim][stride] W times the columns */
    double *all_gram;     /* [stride][stride] */
    double *all_distance; /* [n_pairs][stride] */
    int *at;              /* [n + 1] their indices for `gram` */
    /* reduction to tridiagonal form, for noise.c */
    bool reduced;
    int units;             /* first column with a unit vector in B */
    double *reduced_prior; /* [n] priors of the reduction */
    double *T, *B; /* [4][n]: diagonal, off-diagonal, scratch; [n][1 + n_pairs + n - units] */
} mukca_normal_equations;

typedef struct {
    mukca_normal_equations normal[MUKCA_RHOS];
    double *prior;    /* [capacity] prior sigmas of the next evaluations */
    double *mean;     /* [capacity] posterior mean of the last fit */
    double *factor;   /* [n][n] Cholesky factor of the scaled posterior precision, of the last
                         evaluation */
    double *work;     /* [n] factor^-1 times the scaled right-hand side, of the last evaluation */
    double *marginal; /* [4][n + 1][n + 1], order[n], mark[n]: scratch for the choice of scales */
    int *order;
    unsigned char *mark;
    double best;      /* log evidence of the best coefficient in the last comparison */
    double quadratic; /* of the last evaluation: squared residuals and deviations from the prior
                         means, each in units of its sigma */
} mukca_evidence;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Index of an AR(1) coefficient. */
int mukca_evidence_index(double rho);

/* Update the normal equations of one AR(1) coefficient if the columns have changed, and return
 * them. */
mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_recording *recording,
                                               const mukca_unknowns *unknowns,
                                               const mukca_linearisation *linear);

/* n columns x[n_samples][dim][ld]: `weighted` (of the same shape) receives W x; along[n_pairs][ld]
 * is incremented by their effect on the distances. */
typedef struct {
    int n, ld;
    const double *x;
    double *weighted, *along;
} mukca_weighing;

void mukca_evidence_weigh(const mukca_weighing *columns, const mukca_normal_equations *normal,
                          const mukca_recording *recording, const mukca_linearisation *linear);

/* Log evidence with the priors evidence->prior and noise sigma (m); mean[n] (may be NULL) receives
 * the posterior mean.  Keeps the factor.  -HUGE_VAL: not positive definite. */
double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean);

/* Standard error of the sum of direction[t] x[column + t], t < terms, among n columns, in the
 * posterior of the last evaluation: |L^-1 D a| with its priors D. */
double mukca_evidence_standard_error(mukca_evidence *evidence, int n, int column,
                                     const double *direction, int terms);

/* Coefficients of sample i of a group in the AR(1) whitening: its own and its predecessor's. */
static inline void mukca_evidence_whitening(double *own, double *before, int i, double root,
                                            double rho)
{
    *own = i ? 1 / root : 1;
    *before = i ? rho / root : 0;
}

#endif
