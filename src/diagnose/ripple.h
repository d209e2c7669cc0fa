/* Transmission ripple: waves of all orders of a joint. */
#ifndef MUKCA_DIAGNOSE_RIPPLE_H
#define MUKCA_DIAGNOSE_RIPPLE_H

#include "diagnose/recording.h"

enum { MUKCA_RIPPLE_ORDERS = 400 };

/* Log prior of an order among all scanned orders. */
double mukca_ripple_log_prior(int order);

/* Sine and cosine of one order at the angles of a joint. */
typedef struct {
    int n, order;
    double *sine, *cosine; /* [n] samples */
    double *first;         /* [2][n] those of order 1 */
} mukca_ripple;

/* Start at order 1 of a joint; the arrays are the caller's. */
void mukca_ripple_start(mukca_ripple *wave, const mukca_recording *recording, int joint);

/* Go to the next order. */
void mukca_ripple_next(mukca_ripple *wave);

#endif
