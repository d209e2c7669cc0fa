/* The table of all figures. */
#include "report/figures.h"

#define ROW(section, name)                                           \
    {                                                                \
        section, mukca_report_count_##name, mukca_report_draw_##name \
    }

const mukca_report_figure mukca_report_figures[] = {
    ROW(MUKCA_SECTION_CAUSES, ladder),           ROW(MUKCA_SECTION_CAUSES, arm),
    ROW(MUKCA_SECTION_PLACEMENTS, placements),   ROW(MUKCA_SECTION_JOINTS, joints),
    ROW(MUKCA_SECTION_SAMPLES, samples),         ROW(MUKCA_SECTION_CENTRES, centres),
    ROW(MUKCA_SECTION_CONVERGENCE, convergence), ROW(MUKCA_SECTION_GENERALISATION, generalisation),
    ROW(MUKCA_SECTION_OFFSETS, offsets),         {MUKCA_SECTION_CAUSES, NULL, NULL},
};

mukca_status mukca_report_draw(mukca_figure *figure, mukca_sheet *sheet,
                               const mukca_report_figure *kind, int index,
                               const mukca_report *report, mukca_error *error)
{
    enum { ROWS = sizeof mukca_report_figures / sizeof *mukca_report_figures };
    const double share = (double)(kind - mukca_report_figures) / ROWS;
    if (report->progress && !report->progress(report->progress_context, share, "drawing"))
        return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; the page was not written");
    mukca_status status = mukca_sheet_open(sheet, error);
    if (status != MUKCA_OK) return status;
    kind->draw(sheet, report, index);
    return mukca_sheet_close(figure, sheet, error);
}
