/* A set integrated out, and all items given it: the algebra of the search among sets. */
#ifndef MUKCA_INFER_GIVEN_H
#define MUKCA_INFER_GIVEN_H

#include "infer/sets.h"
#include "math/dense.h"

/* Columns whose rows of the Gram matrix are computed together. */
enum { MUKCA_GIVEN_TOGETHER = 72 };

/* Some successive rows or columns. */
typedef struct {
    int from, n;
} mukca_span;

/* Copy columns of a question: out[rows.n][ld]. */
void mukca_question_copy(double *out, int ld, const mukca_question *question, mukca_span columns,
                         mukca_span rows);

/* Compute the rows of the Gram matrix of these items, as many of them together as fit.  False: no
 * memory. */
bool mukca_given_rows(mukca_sets *s, const unsigned short *item, int n);

/* Fill s->block[] of the items from `item` to end - 1. */
void mukca_given_blocks(const mukca_sets *s, int item, int end, int worker);

/* Integrate out a set: s->integrated.posterior.  False: not positive. */
bool mukca_given_integrate(mukca_sets *s, const mukca_set *set);

/* T := L^-1 and x := V D g of the set integrated out, V = T'T = (1 + D G D)^-1. */
void mukca_given_invert(mukca_sets *s);

/* Columns of T of a member; the rows above its own are 0. */
mukca_columns mukca_given_inverse_of(const mukca_sets *s, int member, int terms);

/* With a member left out of the set, its block of V^-1 is that of 1 + D G' D with the others
 * integrated out.  M M' := the block of V, w := M^-1 x.  False: not positive. */
bool mukca_given_leave_out(double *M, double *w, const mukca_sets *s, int member, int terms);

/* Integrate out a set: s->integrated.B, s->g.  False: no memory, or not positive. */
bool mukca_given_condition(mukca_sets *s, const mukca_set *set);

/* Block of an item, [terms][terms], of the Gram matrix given that set; `reduce` computes it, with
 * scratch[terms][terms]. */
double *mukca_given_of(const mukca_sets *s, int item);
void mukca_given_reduce(const mukca_sets *s, int item, double *scratch);

/* ---- sets (sets.c) ---- */

double mukca_set_square(const double *x, int n);
int mukca_set_largest(const double *x, int n);

/* Evidence of a member given the others; by_size as in mukca_mixture_evidence(). */
double mukca_set_score_member(double *by_size, const mukca_sets *s, const mukca_set *set,
                              int member, mukca_mixture_scratch *scratch);

/* Log prior of an item in addition to its own, given the first n members of a set. */
double mukca_set_kinship(const mukca_sets *s, const mukca_set *set, int n, int item);

/* Index of a set with these members, which is stored if it is new; -1: no room. */
int mukca_set_find(mukca_sets *s, const mukca_set *set);

/* Set with another item; false: no room, or its key is in the set. */
bool mukca_set_extend(mukca_set *out, const mukca_sets *s, const mukca_set *set, int item,
                      int size);

#endif
