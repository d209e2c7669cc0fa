/* Faults of a recording that must be found before anything is fitted: wrong labels, outliers,
 * repeated rows. */
#ifndef MUKCA_DIAGNOSE_SCREENING_H
#define MUKCA_DIAGNOSE_SCREENING_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

typedef struct {
    int count;
    mukca_data_fault list[MUKCA_MAX_FAULTS];
} mukca_faults;

/* Append a fault at a row of the dataset (dropped silently when the table is full). */
void mukca_screening_add(mukca_faults *faults, const mukca_recording *recording,
                         mukca_fault_kind kind, int row, double size_m);

/* Find wrong labels, outliers and duplicates; the first two are no longer kept.  Fits a robust
 * geometry on the way and leaves the samples regrouped. */
void mukca_screening_run(mukca_faults *faults, mukca_regression *m);

/* Rows that were cut as outliers or mislabelled and that the present model explains after all come
 * back; returns how many. */
int mukca_screening_reinstate(mukca_faults *faults, mukca_regression *m);

#endif
