/* What the files of the report share. */
#ifndef MUKCA_REPORT_PARTS_H
#define MUKCA_REPORT_PARTS_H

#include "report/plot.h"
#include "report/report.h"

/* A figure being written. */
typedef struct {
    FILE *script, *description; /* write here */
    char *text, *words;         /* what was written */
    size_t sizes[2];
    char id[64], title[160];
    int width, height; /* px */
} report_sheet;

/* Draw figure number `index` of its kind into an empty sheet. */
typedef void report_draw_fn(report_sheet *sheet, const mukca_report *report, int index);

typedef enum {
    REPORT_GAP,
    REPORT_TRAINING,
    REPORT_PLACEMENTS,
    REPORT_CENTRES,
    REPORT_MATRIX,
    REPORT_JOINTS,
    REPORT_ROWS,
    REPORT_OFFSETS
} report_section;

typedef struct {
    report_section section;
    int (*count)(const mukca_report *report); /* how many of the kind; 0: nothing to show */
    report_draw_fn *draw;
} report_figure;

extern const report_figure report_figures[];
extern const int report_n_figures;

/* Draw into a fresh sheet; `figure` points into it.  Free with report_sheet_free.
 * Errors: MUKCA_MEMORY. */
mukca_status report_draw(mukca_figure *figure, report_sheet *sheet, const report_figure *kind,
                         int index, const mukca_report *report, mukca_error *error);
void report_sheet_free(report_sheet *sheet);

/* The number at `object.key`, NaN where absent or null. */
double report_real(const json_t *object, const char *key);

/* The text at `object.key`, "" where absent or null. */
const char *report_text(const json_t *object, const char *key);

/* Effect and joint (or placement) of a cause or tie in words: "joint compliance of joint_4". */
void report_name_cause(char *text, size_t size, const json_t *cause);

/* Tables and texts, one function each (report_tables.c). */
void report_put_verdict(FILE *out, const mukca_report *report);
void report_put_causes(FILE *out, const mukca_report *report);
void report_put_placements(FILE *out, const mukca_report *report);
void report_put_faults(FILE *out, const mukca_report *report);
void report_put_untestable(FILE *out, const mukca_report *report);
void report_put_offsets(FILE *out, const mukca_report *report);
void report_put_next_poses(FILE *out, const mukca_report *report);
void report_put_provenance(FILE *out, const mukca_report *report);

/* Parts of figures that both figure files use (report_figures.c). */
void report_begin(report_sheet *sheet, const char *id, const char *title, int width, int height);
void report_describe(report_sheet *sheet, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void report_draw_ladder(report_sheet *sheet, const mukca_report *report, int index);
void report_draw_joint(report_sheet *sheet, const mukca_report *report, int index);
void report_draw_rows(report_sheet *sheet, const mukca_report *report, int index);
void report_draw_offsets(report_sheet *sheet, const mukca_report *report, int index);

/* |calibrated position - mean of its socket|, m, for each row; the caller frees it; NULL when out
 * of memory. */
double *report_row_errors(const double *positions, const mukca_dataset *data);

#endif
