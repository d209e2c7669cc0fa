/* Faults of a recording that must be found before anything is fitted: wrong labels, wild rows,
 * repeated rows. */
#ifndef MUKCA_DIAGNOSE_SCREENING_H
#define MUKCA_DIAGNOSE_SCREENING_H

#include "diagnose/diagnose.h"
#include "diagnose/model.h"

/* Append a fault (dropped silently when the table is full). */
void gap_fault_add(mukca_diagnosis *diagnosis, const gap_model *m, mukca_fault_kind kind, int row,
                   double size_m);

/* Find wrong labels, wild rows and duplicates; the first two leave m->keep.  Fits a robust geometry
 * on the way (m->theta) and leaves the rows regrouped. */
void gap_screen(mukca_diagnosis *diagnosis, gap_model *m);

/* Rows that were cut as outliers or mislabelled and that the present model explains after all come
 * back; returns how many. */
int gap_reinstate(mukca_diagnosis *diagnosis, gap_model *m);

#endif
