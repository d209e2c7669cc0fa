/* Evidence of the linearised model: normal equations, posterior of all columns. */
#ifndef MUKCA_DIAGNOSE_EVIDENCE_H
#define MUKCA_DIAGNOSE_EVIDENCE_H

#include "diagnose/linearisation.h"
#include "infer/posterior.h"

enum { MUKCA_NOISES = 15 };

/* Normal equations under one family of the noise, with the means of the sockets integrated out.
 * Each pair of sockets adds one row. */
typedef struct {
    mukca_whitening whitening;
    double behind; /* log evidence of the best family minus its own, in the last comparison */
    int n_pairs;
    unsigned version;     /* of the linearisation with these columns; 0: none, or robust weights */
    double *all_gram;     /* [stride][stride] of all stored columns of the linearisation */
    double *all_distance; /* [n_pairs][stride] */
    double *variance;     /* [n_pairs] of a distance row, in units of sigma^2 */
} mukca_normal_equations;

typedef struct {
    const mukca_linearisation *linear; /* that the columns are of */
    int n_noises;     /* families compared: with repeated postures also those that share errors */
    double ratio;     /* variance that readings of a posture share, over that of a reading */
    int further;      /* coordinates of readings beyond the first of their postures */
    double counted;   /* share of the readings that they count as */
    int angular[2];   /* share of the joint angles' noise in the variance, by number: of
                         postures, and of readings within a posture */
    double *shape[2]; /* [n_samples][dim][dim] factors of these covariances */
    unsigned shaped;  /* version of the linearisation of `shape`, 0: none */
    mukca_normal_equations normal[MUKCA_NOISES];
    struct { /* whitened stored columns of one family, [n_samples][dim][stride], and n_pairs rows */
        const mukca_normal_equations *equations;
        unsigned version; /* of the linearisation */
        double *x, *mean; /* mean[n_blocks][dim][stride] */
    } white;
    mukca_posterior posterior; /* of the last evaluation; its priors are those of the next ones */
    double *mean;              /* [capacity] posterior mean of the last fit */
    double *average;           /* [capacity] scratch */
    double best;               /* log evidence of the best coefficient in the last comparison */
    /* weight of the usual noise and geometry (model/prior.h), in numbers; 0: none */
    double expected;
} mukca_evidence;

/* Memory comes from `pool`; the linearisation must outlive it.  False: no memory. */
bool mukca_evidence_create(mukca_evidence *evidence, mukca_pool *pool,
                           const mukca_linearisation *linear, const mukca_unknowns *unknowns);

/* Residuals [n_samples][dim] at the last posterior mean, in the memory of evidence->white. */
double *mukca_evidence_residuals(mukca_evidence *evidence);

/* The same about the means of their groups, with weight[n_rows]. */
double *mukca_evidence_deviations(mukca_evidence *evidence, const double *weight);

/* Measure the noise by the residuals at the last posterior mean: the ratio of the
 * variances between postures and between readings of one, and the share of the joint angles' noise
 * in the latter; the families follow.  Returns the likeliest share between postures: the geometry
 * absorbs more of some directions, so that evidence must decide. */
int mukca_evidence_measure_noise(mukca_evidence *evidence);

/* Set the share of the joint angles' noise between postures. */
void mukca_evidence_set_share(mukca_evidence *evidence, int angular_share);

/* Log density of Student's noise of the residuals at the last posterior mean, minus that of
 * Gaussian noise weighted so that its log density touches it from below (T. Jaakkola, M. Jordan,
 * Bayesian parameter estimation via variational methods, Statistics and Computing 10, 2000).
 * weight[n_rows], of the last evaluation or 1, receives these weights. */
double mukca_evidence_weigh_tails(double *weight, mukca_evidence *evidence, double sigma);

/* Collect all normal equations again: their weights have changed. */
void mukca_evidence_renew(mukca_evidence *evidence);

/* A family of the noise, index < n_noises. */
mukca_noise_family mukca_evidence_family(const mukca_evidence *evidence, int index);

/* Update the normal equations of one family of the noise if the columns have changed, and return
 * them. */
mukca_normal_equations *mukca_evidence_collect(mukca_evidence *evidence, int index,
                                               const mukca_unknowns *unknowns);

/* Whitened stored columns evidence->white.x of that family; updated if necessary. */
const double *mukca_evidence_whiten(mukca_evidence *evidence, const mukca_normal_equations *normal);

/* gram[n][n] := products X'X of whitened columns X[n_samples][dim][n] over the samples whose row
 * has this number in fold[n_rows] (NULL: over all). */
void mukca_evidence_multiply(double *gram, const double *X, int n, const mukca_recording *recording,
                             const int *fold, int number);

/* along[n_pairs][ld] += effect of n columns on the distances, from their means
 * mean[n_blocks][dim][ld]. */
void mukca_evidence_along(double *along, const double *mean, int n, int ld,
                          const mukca_linearisation *linear);

/* Log evidence with the priors of evidence->posterior and noise sigma (m); mean[n] (may be NULL)
 * receives the posterior mean.  -HUGE_VAL: not positive definite. */
double mukca_evidence_evaluate(mukca_evidence *evidence, const mukca_normal_equations *normal,
                               double sigma, double *mean);

#endif
