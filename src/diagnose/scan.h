/* Scan: log Bayes factors of all candidate causes against the present model, and the columns of a
 * few of them for the search among sets. */
#ifndef MUKCA_DIAGNOSE_SCAN_H
#define MUKCA_DIAGNOSE_SCAN_H

#include "base/workers.h"
#include "diagnose/candidates.h"
#include "diagnose/regression.h"
#include "infer/sets.h"

enum { MUKCA_SCAN_WIDTH = 64 }; /* columns processed together: with their rows in cache */

/* Log prior odds against each further member of a set. */
#define MUKCA_SET_RATE 1.5

/* Candidates whose columns are processed together. */
typedef struct {
    int n, width, at[MUKCA_SCAN_WIDTH]; /* first columns */
    const mukca_candidate *member[MUKCA_SCAN_WIDTH];
    double by[MUKCA_SCAN_WIDTH]; /* factors of the columns: they are per unit of the coefficient */
    double *W;                   /* [n_rows] columns, then whitened, as `white` */
    double *mean;                /* of the sockets */
    double *C, *T, *g;           /* X'E; L^-1 D X'E; projected products with the residual */
    mukca_mixture_scratch *scratch;
} mukca_scan_batch;

typedef struct {
    mukca_regression *m;
    mukca_candidates *all;
    /* the model that is projected out: geometry and the present causes */
    const mukca_normal_equations *normal;
    const double *white; /* its whitened columns; a row for each coordinate of a sample, then one
                            for each pair of sockets, also in units of sigma */
    int n_rows, n, dof;
    double precision, residual;  /* 1 / sigma^2; squared residual in units of the noise */
    double evidence;             /* log evidence, with the scale of the noise at its maximum */
    double *z, *prior, *link;    /* [n], [n], [n_pairs] sigma over that of the pair's row */
    mukca_scan_batch *batch;     /* one for each worker of m */
    int *start;                  /* [capacity + 1] scratch: first candidates of the batches */
    double *value, *information; /* [capacity] log Bayes factors, and 1/rad^2 of a unit size */
} mukca_scan;

/* Memory comes from `pool`.  False: no memory. */
bool mukca_scan_create(mukca_scan *scan, mukca_pool *pool, mukca_regression *m,
                       mukca_candidates *all);

/* Project out the present unknowns under a family of the noise.  False: singular. */
bool mukca_scan_aim(mukca_scan *scan, int family);

/* Score all candidates, and add the promising orders of periodic effects to them.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_scan_run(mukca_scan *scan, mukca_error *error);

/* Score n candidates but those with skip[n] != 0 (NULL: none): value[n] and information[n] as of
 * the scan. */
void mukca_scan_score(double *value, double *information, mukca_scan *scan,
                      const mukca_candidate *list, const unsigned char *skip, int n);

/* Columns of candidates index[n] as a question for the search among sets; memory from `pool`.
 * False: no memory. */
bool mukca_scan_question(mukca_question *question, mukca_scan *scan, mukca_pool *pool,
                         const int *index, int n);

/* Replace the question's columns by what the geometry leaves of them in the samples.  Without that
 * its products are those squares, and in addition the deviation of the geometry from its prior and
 * errors of the sockets' distances, which displace no tip.  False: no memory. */
bool mukca_scan_leave(mukca_question *question, const mukca_scan *scan, mukca_pool *pool);

/* value[MUKCA_LAST_ORDER + 1]: log Bayes factors of the orders of an effect of the trait
 * MUKCA_TRAIT_ORDERS at its joint, from 2 on.  False: no memory. */
bool mukca_scan_orders(double *value, mukca_scan *scan, const mukca_effect *effect);

#endif
