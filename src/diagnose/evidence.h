/* Evidence of the linearised model: normal equations, posterior of all columns, noise. */
#ifndef MUKCA_DIAGNOSE_EVIDENCE_H
#define MUKCA_DIAGNOSE_EVIDENCE_H

#include "diagnose/linearisation.h"

enum { MUKCA_RHOS = 3 };

/* AR(1) coefficients that the noise may have. */
extern const double mukca_evidence_rho[MUKCA_RHOS];

/* Normal equations of the whitened and centred columns at one AR(1) coefficient, n of them; size =
 * n + 1, the last column being y.  Each pair of sockets adds one row. */
typedef struct {
    double rho, log_det;
    int dof, n, n_pairs;
    unsigned version;      /* of the columns that they are formed from; 0: none, or weighted */
    double distance_sigma; /* m */
    double *gram;          /* [size][size] */
    double *distance;      /* [n_pairs][size] */
    double *variance;      /* [n_pairs]: of a distance row, in units of sigma^2 */
    double *white;         /* [n_samples][dim][size] */
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

/* Log evidence with the priors evidence->prior and noise sigma (m).  mean[n] (may be NULL) gets the
 * posterior mean.  The factor stays.  -HUGE_VAL where it cannot be factored. */
double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean);

/* Noise sigma that maximises the evidence, near `guess` or anywhere; *value (may be NULL) gets the
 * evidence. */
double mukca_evidence_noise(mukca_evidence *evidence, const mukca_normal_equations *normal,
                            double guess, double *value);

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
