/* Products of a candidate's columns with each other and with the columns that the linearisation
 * holds.  They do not depend on noise, priors or which causes are in the model, so each is formed
 * once for a linearisation. */
#ifndef MUKCA_DIAGNOSE_PRODUCTS_H
#define MUKCA_DIAGNOSE_PRODUCTS_H

#include "diagnose/regression.h"
#include "diagnose/ripple.h"

enum {
    MUKCA_PRODUCT_ROWS = 32, /* of a piece of `cross` behind the first, which has the geometry's */
    MUKCA_PRODUCT_PIECES = 1 + 3 * MUKCA_MAX_COLUMNS / MUKCA_PRODUCT_ROWS
};

enum { MUKCA_BATCH = MUKCA_MAX_COLUMNS + 8 }; /* columns that are treated together */

/* E are the columns and W as in mukca_normal_equations. */
typedef struct {
    unsigned version;   /* of the linearisation; 0: nothing formed */
    int done;           /* columns held that `cross` has */
    int columns, block; /* of E; they are candidates of `block` columns each */
    int first, rows;    /* columns held that cross[0], and all of it, has room for */
    double *cross[MUKCA_PRODUCT_PIECES]; /* [rows][columns] X'W E with the columns held */
    double *gram;                        /* [columns / block][block][block] E'W E */
    double *along;                       /* [n_pairs][columns] what E does to the distances */
} mukca_products;

/* The products with a column held. */
static inline double *mukca_products_row(const mukca_products *x, int held)
{
    if (held < x->first) return x->cross[0] + held * x->columns;
    const unsigned more = (unsigned)(held - x->first);
    return x->cross[1 + more / MUKCA_PRODUCT_ROWS] +
           more % MUKCA_PRODUCT_ROWS * (unsigned)x->columns;
}

/* A candidate and its products. */
typedef struct {
    const mukca_candidate *candidate;
    int joint; /* that its function of the samples turns, or -1 */
    mukca_products *products;
} mukca_product_item;

/* Scratch. */
typedef struct {
    double *E, *W; /* [n_samples][dim][MUKCA_BATCH] */
    double *U;     /* [n_samples][stride] W X along the levers of a joint */
    double *C;     /* [stride][MUKCA_BATCH] */
    double *along; /* [n_pairs + 1][MUKCA_BATCH] */
    double *mean;  /* [n_groups][3][MUKCA_BATCH] */
    double *tri;   /* [2][n_samples] W along the levers: diagonal, and with the sample before */
    mukca_ripple wave;
} mukca_product_scratch;

/* False: no memory. */
bool mukca_products_scratch(mukca_product_scratch *scratch, mukca_pool *pool,
                            const mukca_regression *m);
bool mukca_products_create(mukca_products *products, mukca_pool *pool, const mukca_regression *m,
                           int columns, int block);

/* Room for the products of a candidate with the columns that are held; what is formed stays.
 * `products` may be all 0.  False: no memory. */
bool mukca_products_reserve(mukca_products *products, mukca_pool *pool, const mukca_regression *m,
                            int columns);

/* Form what the items lack.  Items of one joint should be neighbours. */
void mukca_products_update(const mukca_product_item *item, int n, const mukca_regression *m,
                           const mukca_normal_equations *normal,
                           const mukca_product_scratch *scratch);

/* Form those of ripple of a joint: sine and cosine of columns / 2 orders, which rise. */
void mukca_products_ripple(mukca_products *products, int joint, const int *order,
                           const mukca_regression *m, const mukca_normal_equations *normal,
                           const mukca_product_scratch *scratch);

/* Products of the columns scratch->E[n_samples][dim][columns], those of `candidate` first; they are
 * one block. */
void mukca_products_of(mukca_products *products, const mukca_candidate *candidate,
                       const mukca_regression *m, const mukca_normal_equations *normal,
                       const mukca_product_scratch *scratch);

#endif
