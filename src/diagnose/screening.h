/* Faults of a recording that must be found before anything is fitted: wrong labels, wild rows,
 * repeated rows. */
#ifndef MUKCA_DIAGNOSE_SCREENING_H
#define MUKCA_DIAGNOSE_SCREENING_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Append a fault (dropped silently when the table is full). */
void mukca_screening_add(mukca_diagnosis *diagnosis, const mukca_regression *m,
                         mukca_fault_kind kind, int row, double size_m);

/* Find wrong labels, wild rows and duplicates; the first two leave m->recording.keep.  Fits a
 * robust geometry on the way (m->unknowns.theta) and leaves the rows regrouped. */
void mukca_screening_run(mukca_diagnosis *diagnosis, mukca_regression *m);

/* Rows that were cut as outliers or mislabelled and that the present model explains after all come
 * back; returns how many. */
int mukca_screening_reinstate(mukca_diagnosis *diagnosis, mukca_regression *m);

#endif
