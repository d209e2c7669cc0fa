/* Posterior probability of sets of causes in a linear Gaussian regression.
 *
 * An item is a possible cause: a block of columns with a mixture prior, and prior odds.  A set
 * explains the data by the sum of its items.  Best-first search from the empty set adds, drops and
 * swaps items and replaces one by two; all sets that it meets are kept with their posterior. */
#ifndef MUKCA_INFER_SETS_H
#define MUKCA_INFER_SETS_H

#include "base/workers.h"
#include "infer/mixture.h"
#include "infer/posterior.h"

enum {
    MUKCA_SET_ITEMS = 40,    /* in a set */
    MUKCA_SET_COLUMNS = 160, /* of them together */
    MUKCA_MOST_SETS = 4096   /* a search meets some 1,300, of 40 causes 2,050 */
};

typedef struct {
    int at, terms; /* columns */
    mukca_mixture prior;
    double log_prior;
    int key; /* a set has at most one item of a key: variants of one cause */
    int kin; /* items of one kin (0: none) entail each other: each beyond the first has `kinship` */
    double kinship; /* in addition to its log prior */
} mukca_item;

enum { MUKCA_PANEL = 8 }; /* columns that are stored together: a cache line */

/* Columns E[stride / 8][n_rows][8], whitened, in units of the noise; the products of the last
 * n_projected rows are subtracted, as these rows are components along a model that was integrated
 * out.  g[]: products with the residual, which has the squared length `residual` and `dof` degrees
 * of freedom.  The stride is a multiple of 8; unused columns are 0.  Instead of E,
 * gram[n_columns][stride] may be given: all products. */
typedef struct {
    int n_items, n_columns, stride, n_rows, n_projected, dof;
    const mukca_item *item;
    const double *E, *gram, *g;
    double residual;
    mukca_workers *workers; /* of the search; NULL: the caller's thread alone */
} mukca_question;

typedef struct {
    int n;
    unsigned short item[MUKCA_SET_ITEMS]; /* ascending */
    unsigned char size[MUKCA_SET_ITEMS];  /* most probable one of each item's mixture */
    double value;                         /* log posterior against the empty set */
    /* exact: its sizes are at their maximum, and integrated; extended; members replaced */
    bool exact, expanded, swapped;
} mukca_set;

/* Scores of all items in addition to a set: log odds, and the most probable size. */
typedef struct {
    double *value;
    unsigned char *likeliest;
} mukca_scores;

typedef struct {
    const mukca_question *question;
    mukca_pool *pool;
    double **block;      /* [n_items] diagonal blocks of the Gram matrix */
    const double **gram; /* [n_items] its rows, [terms][stride]; NULL: not yet needed */
    int n_sets, best;
    mukca_set *set; /* [MUKCA_MOST_SETS] */
    int *table;     /* hash table: 1 + index of a set, 0: none */
    struct {
        mukca_posterior posterior; /* factor L of 1 + D G D; `quadratic`: the residual */
        int at[MUKCA_SET_ITEMS];   /* first column of each member */
        double *B;                 /* L^-1 D G */
        double *inverse;           /* L^-1 */
        double *x;                 /* (1 + D G D)^-1 D g */
    } integrated;                  /* the set integrated out last */
    double *left;                  /* scratch: columns of some items, close together */
    struct {
        double *row; /* rows of some items, or columns of neighbouring ones */
        mukca_mixture_scratch *mixture;
    } worker[MUKCA_MOST_WORKERS];         /* scratch */
    mukca_mixture_scratch *scratch;       /* of the caller's thread */
    double *given;                        /* blocks of all items given that set */
    double *g;                            /* [stride] the same of the products with the residual */
    double *added;                        /* [n_items] scores given that set */
    mukca_scores scores[MUKCA_SET_ITEMS]; /* scratch: of each replaced member */
} mukca_sets;

/* Start with the empty set.  Memory comes from `pool`.  False: no memory. */
bool mukca_sets_create(mukca_sets *sets, mukca_pool *pool, const mukca_question *question);

/* Index of the set of these items, ascending, with about these sizes (NULL: any), evaluated; -1:
 * too large. */
int mukca_sets_insert(mukca_sets *sets, const int *item, const double *size, int n);

/* Extend a set or replace its members, the most probable set first, until the best one has not
 * improved for `budget` times; `pairs`: replace those of the best set by two items each, too. */
void mukca_sets_explore(mukca_sets *sets, int budget, bool pairs);

/* Evaluate a set, or index[n], if it is only estimated.  False: no memory. */
void mukca_sets_evaluate(mukca_sets *sets, int set);
bool mukca_sets_evaluate_all(mukca_sets *sets, const int *index, int n);

/* Score all items in addition to a set: sets->added[].  False: no memory, or not positive. */
bool mukca_sets_weigh(mukca_sets *sets, const mukca_set *set);

/* An item or a set; order by falling odds, for qsort(). */
typedef struct {
    double odds;
    int index;
} mukca_ranked;
int mukca_by_odds(const void *a, const void *b);

/* Log Bayes factor of an item in addition to the set weighed last, which lacks it. */
double mukca_sets_gain(const mukca_sets *sets, const mukca_set *set, int item);

/* Posterior mean of the items' coefficients in a set: mean[stride]. */
void mukca_sets_mean(double *mean, mukca_sets *sets, const mukca_set *set);

/* Products of the displacements by a set's members at their posterior mean, product[n][n], in units
 * of the noise; mean[stride] is scratch. */
void mukca_sets_products(double *product, double *mean, mukca_sets *sets, const mukca_set *set);

/* Gram block G[a.terms][b.terms] of two items; without memory 0. */
void mukca_sets_products_of(double *G, mukca_sets *sets, int a, int b);

/* Posterior covariance[n][n] of the coefficients of the set integrated out last, in the order of
 * its members; returns n. */
int mukca_sets_covariance(double *covariance, mukca_sets *sets);

#endif
