/* Scores of faults: a moved socket, or samples with a badly seated ball. */
#ifndef MUKCA_DIAGNOSE_SCAN_FAULTS_H
#define MUKCA_DIAGNOSE_SCAN_FAULTS_H

#include "diagnose/scan.h"

/* Score all faults among the candidates; scan->u is the residual, and overwritten.  Their columns
 * are 0 but in a range of samples, and the same for each coordinate: sums over these samples
 * replace products with all columns. */
void mukca_scan_faults(mukca_scan *scan);

#endif
