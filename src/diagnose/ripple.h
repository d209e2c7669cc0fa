/* The waves of gear ripple: all orders of a joint. */
#ifndef MUKCA_DIAGNOSE_RIPPLE_H
#define MUKCA_DIAGNOSE_RIPPLE_H

#include "diagnose/recording.h"

enum { MUKCA_RIPPLE_ORDERS = 400, MUKCA_RIPPLE_COLUMNS = 2 * (MUKCA_RIPPLE_ORDERS - 1) };

/* Log prior of an order among all that are scanned. */
double mukca_ripple_log_prior(int order);

/* Start at order 1 of a joint; wave[4 * n_samples + 1] holds the state: sine and cosine of the last
 * order and of the first one, and the last order. */
void mukca_ripple_start(double *wave, const mukca_recording *recording, int joint);

/* Sine and cosine of the next orders, which rise: F[n_samples][2 * count]. */
void mukca_ripple_advance(double *F, double *wave, int n_samples, const int *order, int count);

#endif
