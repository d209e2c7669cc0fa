/* Screening: recording faults that must be found before any fit (wrong labels, outliers, repeated
 * rows). */
#ifndef MUKCA_DIAGNOSE_SCREENING_H
#define MUKCA_DIAGNOSE_SCREENING_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Noise per axis, m, that no arm exceeds: above it, the samples do not fit the model. */
#define MUKCA_MOST_SIGMA 10e-3

/* Append a fault at a row of the dataset; ignored if the table is full. */
void mukca_screening_add(mukca_diagnosis *d, const mukca_recording *recording,
                         mukca_fault_kind kind, int row, double size_m);

/* Find wrong labels, outliers and duplicates, and exclude the first two.  Fits a robust geometry;
 * regroups the samples.  False: the samples do not fit this arm; several, apparently outliers, are
 * used. */
bool mukca_screening_run(mukca_diagnosis *d, mukca_regression *m);

/* Reinstate rows excluded as outliers or mislabelled that the present model explains; returns their
 * number. */
int mukca_screening_reinstate(mukca_diagnosis *d, mukca_regression *m);

#endif
