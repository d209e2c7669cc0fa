/* Evidence of the linearised model: normal equations, posterior of all columns. */
#ifndef MUKCA_DIAGNOSE_EVIDENCE_H
#define MUKCA_DIAGNOSE_EVIDENCE_H

#include "diagnose/linearisation.h"

enum { MUKCA_RHOS = 3 };

/* AR(1) coefficients that the noise may have. */
extern const double mukca_evidence_rho[MUKCA_RHOS];

/* Normal equations at one AR(1) coefficient.  W is what whitening and the free means of the sockets
 * make of the samples: W = A'A - A'o o'A / o'o in each socket and coordinate, with A the whitening
 * and o the whitened ones.  Each pair of sockets adds one row. */
typedef struct {
    double rho, log_det;
    double behind; /* the best coefficient's log evidence, when they were last compared */
    int dof, n, n_pairs;
    unsigned version;      /* of the columns that they are formed from; 0: none, or weighted */
    double distance_sigma; /* m */
    double *gram;          /* [n + 1][n + 1] of the columns in use, and y */
    double *distance;      /* [n_pairs][n + 1] */
    double *variance;      /* [n_pairs]: of a distance row, in units of sigma^2 */
    /* A'A has three diagonals */
    double *diagonal, *off; /* [n_samples]; `off` with the sample before */
    double *mean_weight;    /* [n_samples] A'o / o'o: weights of a socket's mean */
    double *ones;           /* [n_groups] o'o */
    /* of all columns that the linearisation holds, `stride` apart */
    int done, stride;     /* columns that the rest is formed from, and their stride */
    double *weighted;     /* [n_samples][dim][stride] W times the columns */
    double *all_gram;     /* [stride][stride] */
    double *all_distance; /* [n_pairs][stride] */
    int *at;              /* [n + 1] which of them `gram` is of */
    /* their reduction to tridiagonal form, for noise.c */
    bool reduced;
    int units;             /* from this column on B has the unit vectors of the columns */
    double *reduced_prior; /* [n] priors that it was made with */
    double *T, *B; /* [4][n]: diagonal, off-diagonal, scratch; [n][1 + n_pairs + n - units] */
} mukca_normal_equations;

typedef struct {
    mukca_normal_equations normal[MUKCA_RHOS];
    double *prior;  /* [capacity] prior sigmas that the next evaluations use */
    double *mean;   /* [capacity] posterior mean of the last fit */
    double *factor; /* [n][n] Cholesky factor of the scaled posterior precision, of the last one */
    double *work;   /* [n] of the last one: factor^-1 of the scaled right side */
    double *marginal; /* [4][n + 1][n + 1], order[n], mark[n]: scratch of the choice of scales */
    int *order;
    unsigned char *mark;
    double best;      /* log evidence at the best coefficient, when they were last compared */
    double quadratic; /* of the last one: squared misfit and departure from the priors, each in
                         units of its sigma */
} mukca_evidence;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_recording *recording, const mukca_unknowns *unknowns);

/* Index of an AR(1) coefficient. */
int mukca_evidence_index(double rho);

/* Fill the normal equations of one AR(1) coefficient from the columns, where these are others than
 * the last time; returns them. */
mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_recording *recording,
                                               const mukca_unknowns *unknowns,
                                               const mukca_linearisation *linear);

/* n columns x[n_samples][dim][ld]: `weighted` (of the same shape) gets W x, and along[n_pairs][ld]
 * has added to it what they do to the distances. */
typedef struct {
    int n, ld;
    const double *x;
    double *weighted, *along;
} mukca_weighing;

void mukca_evidence_weigh(const mukca_weighing *columns, const mukca_normal_equations *normal,
                          const mukca_recording *recording, const mukca_linearisation *linear);

/* Log evidence with the priors evidence->prior and noise sigma (m).  mean[n] (may be NULL) gets the
 * posterior mean.  The factor stays.  -HUGE_VAL where it cannot be factored. */
double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean);

/* Standard error of the sum of direction[t] x[column + t], t < terms, among n columns in the
 * posterior whose factor the last evaluation left: |L^-1 D a| with the priors D that it used. */
double mukca_evidence_standard_error(mukca_evidence *evidence, int n, int column,
                                     const double *direction, int terms);

/* Coefficients of the i-th sample of a group in the AR(1) whitening: its own and its predecessor's.
 */
static inline void mukca_evidence_whitening(double *own, double *before, int i, double root,
                                            double rho)
{
    *own = i ? 1 / root : 1;
    *before = i ? rho / root : 0;
}

#endif
