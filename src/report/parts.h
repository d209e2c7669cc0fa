/* The parts of the page: figures and tables, one function each. */
#ifndef MUKCA_REPORT_PARTS_H
#define MUKCA_REPORT_PARTS_H

#include "report/plot.h"
#include "report/report.h"

#define MUKCA_REPORT_MM 1e3 /* per m */

/* Draw figure `index` of a kind on an open `plot`; false where there is none. */
typedef bool mukca_report_figure(mukca_plot *plot, const mukca_report *report, int index);

mukca_report_figure mukca_report_ladder;         /* figures_error.c */
mukca_report_figure mukca_report_joints;         /* figures_error.c */
mukca_report_figure mukca_report_samples;        /* figures_error.c */
mukca_report_figure mukca_report_arm;            /* figures_arm.c */
mukca_report_figure mukca_report_centres;        /* figures_centres.c */
mukca_report_figure mukca_report_placements;     /* figures_calibration.c */
mukca_report_figure mukca_report_convergence;    /* figures_calibration.c */
mukca_report_figure mukca_report_generalisation; /* figures_calibration.c */
mukca_report_figure mukca_report_offsets;        /* figures_calibration.c */

double mukca_report_length(const double v[3]); /* figures_error.c */

/* Write a text or table. */
typedef void mukca_report_text(FILE *out, const mukca_report *report);

mukca_report_text mukca_report_put_verdict;     /* tables_diagnosis.c */
mukca_report_text mukca_report_put_causes;      /* tables_diagnosis.c */
mukca_report_text mukca_report_put_faults;      /* tables_diagnosis.c */
mukca_report_text mukca_report_put_limits;      /* tables_diagnosis.c */
mukca_report_text mukca_report_put_key_figures; /* tables_calibration.c */
mukca_report_text mukca_report_put_placements;  /* tables_calibration.c */
mukca_report_text mukca_report_put_terms;       /* tables_calibration.c */
mukca_report_text mukca_report_put_offsets;     /* tables_calibration.c */
mukca_report_text mukca_report_put_provenance;  /* tables_calibration.c */

#endif
