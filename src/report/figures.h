/* The figures of the report: one row each in catalogue.c. */
#ifndef MUKCA_REPORT_FIGURES_H
#define MUKCA_REPORT_FIGURES_H

#include "report/report.h"
#include "report/sheet.h"

typedef enum {
    MUKCA_SECTION_CAUSES,
    MUKCA_SECTION_PLACEMENTS,
    MUKCA_SECTION_JOINTS,
    MUKCA_SECTION_LIMITS,
    MUKCA_SECTION_SAMPLES,
    MUKCA_SECTION_CENTRES,
    MUKCA_SECTION_CONVERGENCE,
    MUKCA_SECTION_GENERALISATION,
    MUKCA_SECTION_OFFSETS
} mukca_report_section;

typedef struct {
    mukca_report_section section;
    int (*count)(const mukca_report *report); /* figures of this kind; 0: nothing to show */
    void (*draw)(mukca_sheet *sheet, const mukca_report *report, int index);
} mukca_report_figure;

/* Ended by a row without `draw`. */
extern const mukca_report_figure mukca_report_figures[];

/* Figure `index` of a kind, on a fresh sheet.  Free the sheet with mukca_sheet_free.
 * Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status mukca_report_draw(mukca_figure *figure, mukca_sheet *sheet,
                               const mukca_report_figure *kind, int index,
                               const mukca_report *report, mukca_error *error);

/* `count` and `draw` of each kind. */
#define MUKCA_REPORT_FIGURE(name)                         \
    int mukca_report_count_##name(const mukca_report *r); \
    void mukca_report_draw_##name(mukca_sheet *sheet, const mukca_report *r, int index)
MUKCA_REPORT_FIGURE(ladder);         /* figures_error.c */
MUKCA_REPORT_FIGURE(joints);         /* figures_error.c */
MUKCA_REPORT_FIGURE(samples);        /* figures_error.c */
MUKCA_REPORT_FIGURE(arm);            /* figures_arm.c */
MUKCA_REPORT_FIGURE(placements);     /* figures_calibration.c */
MUKCA_REPORT_FIGURE(convergence);    /* figures_calibration.c */
MUKCA_REPORT_FIGURE(generalisation); /* figures_calibration.c */
MUKCA_REPORT_FIGURE(offsets);        /* figures_calibration.c */
MUKCA_REPORT_FIGURE(centres);        /* figures_centres.c */

#endif
