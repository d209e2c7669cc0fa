/* The texts and tables of the report, one function each. */
#ifndef MUKCA_REPORT_TABLES_H
#define MUKCA_REPORT_TABLES_H

#include <stdio.h>

#include "report/report.h"

/* Of the diagnosis (tables_diagnosis.c). */
void mukca_report_put_verdict(FILE *out, const mukca_report *report);
void mukca_report_put_next_poses(FILE *out, const mukca_report *report);
void mukca_report_put_causes(FILE *out, const mukca_report *report);
void mukca_report_put_faults(FILE *out, const mukca_report *report);
void mukca_report_put_limits(FILE *out, const mukca_report *report);

/* Of the calibration (tables_calibration.c). */
void mukca_report_put_key_figures(FILE *out, const mukca_report *report);
void mukca_report_put_placements(FILE *out, const mukca_report *report);
void mukca_report_put_offsets(FILE *out, const mukca_report *report);
void mukca_report_put_provenance(FILE *out, const mukca_report *report);

#endif
