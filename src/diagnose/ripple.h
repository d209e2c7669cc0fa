/* The scan for gear ripple: all orders of all joints. */
#ifndef MUKCA_DIAGNOSE_RIPPLE_H
#define MUKCA_DIAGNOSE_RIPPLE_H

#include "diagnose/joint_view.h"

enum { MUKCA_RIPPLE_ORDERS = 400 };

/* Log prior of a gear harmonic of that order among all orders: part on low orders, part on the
 * ratios of usual gears and their doubles, part uniform over 2 .. 400. */
double mukca_ripple_log_prior(int order);

/* value[MUKCA_RIPPLE_ORDERS + 1]: log Bayes factor of each order 2 .. 400 of the view's joint (wave
 * and quadrature).  `waves` is scratch of 4 * n doubles. */
void mukca_ripple_scan(double *value, const mukca_joint_view *view, double *mean, double *waves);

#endif
