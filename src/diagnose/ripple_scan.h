/* Scores of the orders of transmission ripple of a joint. */
#ifndef MUKCA_DIAGNOSE_RIPPLE_SCAN_H
#define MUKCA_DIAGNOSE_RIPPLE_SCAN_H

#include "diagnose/projector.h"

/* value[MUKCA_RIPPLE_ORDERS + 1]: log Bayes factors of the orders of ripple of a joint, from 2 on.
 * `products` has blocks of 2: MUKCA_RIPPLE_COLUMNS columns for all orders, or two per order for the
 * most promising ones; the others score -HUGE_VAL. */
void mukca_ripple_scan(double *value, mukca_projector *p, mukca_products *products, int joint);

#endif
