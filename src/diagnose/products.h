/* Products of a candidate's columns with each other and with the stored columns of the
 * linearisation.  They depend neither on noise and priors nor on the causes in the model: each is
 * computed once for a linearisation. */
#ifndef MUKCA_DIAGNOSE_PRODUCTS_H
#define MUKCA_DIAGNOSE_PRODUCTS_H

#include "diagnose/regression.h"
#include "diagnose/ripple.h"

enum {
    MUKCA_PRODUCT_ROWS = 32, /* of a piece of `cross` after the first, which has the geometry's */
    MUKCA_PRODUCT_PIECES = 1 + 3 * MUKCA_MAX_COLUMNS / MUKCA_PRODUCT_ROWS
};

enum { MUKCA_BATCH = MUKCA_MAX_COLUMNS + 8 }; /* columns processed together */

/* E: the candidate's columns; W as in mukca_normal_equations. */
typedef struct {
    unsigned version;   /* of the linearisation; 0: nothing computed */
    int done;           /* stored columns included in `cross` */
    int columns, block; /* number of E's, and of each candidate's */
    int first, rows;    /* capacity of cross[0], and of all pieces, in stored columns */
    double *cross[MUKCA_PRODUCT_PIECES]; /* [rows][columns] X'W E, X: the stored columns */
    double *gram;                        /* [columns / block][block][block] E'W E */
    double *along;                       /* [n_pairs][columns] effect of E on the distances */
} mukca_products;

/* Products with one stored column. */
static inline double *mukca_products_row(const mukca_products *x, int stored)
{
    if (stored < x->first) return x->cross[0] + stored * x->columns;
    const unsigned more = (unsigned)(stored - x->first);
    return x->cross[1 + more / MUKCA_PRODUCT_ROWS] +
           more % MUKCA_PRODUCT_ROWS * (unsigned)x->columns;
}

/* A candidate and its products. */
typedef struct {
    const mukca_candidate *candidate;
    int joint; /* rotated by the candidate's function of the samples; -1: none */
    mukca_products *products;
} mukca_product_item;

/* Scratch. */
typedef struct {
    double *E, *W; /* [n_samples][dim][MUKCA_BATCH] */
    double *U;     /* [n_samples][stride] W X projected on the levers of a joint */
    double *C;     /* [stride][MUKCA_BATCH] */
    double *along; /* [n_pairs + 1][MUKCA_BATCH] */
    double *mean;  /* [n_groups][3][MUKCA_BATCH] */
    double *tri;   /* [2][n_samples] W on the levers: diagonal; with the preceding sample */
    mukca_ripple wave;
} mukca_product_scratch;

/* False: no memory. */
bool mukca_products_scratch(mukca_product_scratch *scratch, mukca_pool *pool,
                            const mukca_regression *m);
bool mukca_products_create(mukca_products *products, mukca_pool *pool, const mukca_regression *m,
                           int columns, int block);

/* Reserve memory for the products of a candidate with the stored columns; computed products are
 * kept.  `products` may be all 0.  False: no memory. */
bool mukca_products_reserve(mukca_products *products, mukca_pool *pool, const mukca_regression *m,
                            int columns);

/* Compute the missing products of n items.  Items of one joint should be adjacent. */
void mukca_products_update(const mukca_product_item *item, int n, const mukca_regression *m,
                           const mukca_normal_equations *normal,
                           const mukca_product_scratch *scratch);

/* Compute the products of ripple of a joint: sine and cosine of columns / 2 orders, ascending. */
void mukca_products_ripple(mukca_products *products, int joint, const int *order,
                           const mukca_regression *m, const mukca_normal_equations *normal,
                           const mukca_product_scratch *scratch);

/* Compute the products of the columns scratch->E[n_samples][dim][columns] as one block; the columns
 * of `candidate` come first. */
void mukca_products_of(mukca_products *products, const mukca_candidate *candidate,
                       const mukca_regression *m, const mukca_normal_equations *normal,
                       const mukca_product_scratch *scratch);

#endif
