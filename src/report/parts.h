/* Parts of the page: figures and tables, one function each. */
#ifndef MUKCA_REPORT_PARTS_H
#define MUKCA_REPORT_PARTS_H

#include "report/plot.h"
#include "report/report.h"

#define MUKCA_REPORT_MM 1e3 /* mm per m */

/* Draw figure `index` of a kind on an open `plot`; false: there is none. */
typedef bool mukca_report_figure(mukca_plot *plot, const mukca_report *report, int index);

/* in figures_error.c, figures_centres.c, figures_calibration.c */
mukca_report_figure mukca_report_ladder, mukca_report_joints, mukca_report_samples,
    mukca_report_centres, mukca_report_placements;

/* Write a text or table. */
typedef void mukca_report_text(FILE *out, const mukca_report *report);

/* in tables_diagnosis.c, tables_calibration.c */
mukca_report_text mukca_report_put_verdict, mukca_report_put_causes, mukca_report_put_faults,
    mukca_report_put_limits;
mukca_report_text mukca_report_put_key_figures, mukca_report_put_placements,
    mukca_report_put_offsets, mukca_report_put_provenance;

#endif
