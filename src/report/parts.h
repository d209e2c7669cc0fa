/* Parts of the page: figures and tables, one function each. */
#ifndef MUKCA_REPORT_PARTS_H
#define MUKCA_REPORT_PARTS_H

#include "report/report.h"

#define MUKCA_REPORT_MM 1e3 /* mm per m */

/* Figures, in figures_error.c; `content` is the report. */
typedef bool mukca_report_figure(mukca_plot *plot, const void *content, int index);
mukca_report_figure mukca_report_joints, mukca_report_samples;

/* Texts and tables, in tables_diagnosis.c, tables_calibration.c and view.c. */
typedef void mukca_report_text(FILE *out, const void *content);
mukca_report_text mukca_report_put_causes, mukca_report_put_faults, mukca_report_put_limits,
    mukca_report_put_placements, mukca_report_put_joints, mukca_report_put_offsets,
    mukca_report_put_provenance, mukca_report_put_view;
void mukca_report_put_accuracy(FILE *out, const mukca_report *report);
void mukca_report_put_verdict(FILE *out, const mukca_report *report);
void mukca_report_put_steps(FILE *out, const mukca_report *report);

/* Rms of a model's errors along the motion by joint j, over all samples, m. */
double mukca_report_joint_rms(const mukca_report *report, int model, int j);

#endif
