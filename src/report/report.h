/* The report: calibration and diagnosis on one self-contained HTML page. */
#ifndef MUKCA_REPORT_REPORT_H
#define MUKCA_REPORT_REPORT_H

#include "base/pool.h"
#include "fit/evaluate.h"
#include "fleet/fleet.h"
#include "io/offsets.h"
#include "report/page.h"
#include "report/wording.h"

/* Models: nominal; the table without its effects; the table. */
enum { MUKCA_NOMINAL, MUKCA_RIGID, MUKCA_CALIBRATED, MUKCA_REPORT_MODELS };

/* Content of the page. */
typedef struct {
    /* Set by the caller, who owns the memory. */
    mukca_pool *pool;
    const mukca_chain *chain;          /* nominal arm */
    const mukca_chain *fitted;         /* chain of `offsets`: with the frames of pose logs */
    const mukca_offsets *offsets;      /* geometry and effects, of the diagnosis or given */
    bool free_base, free_tool;         /* frames of pose logs are fitted */
    const mukca_dataset *train, *test; /* `test` may be empty */
    mukca_diagnosed diagnosed;         /* with `train` as its data */
    /* Set by mukca_report_prepare. */
    mukca_evaluation evaluation[MUKCA_REPORT_MODELS]; /* of `train` */
    mukca_geometry geometry;                          /* of `offsets` */
    mukca_offset_row *offset;                         /* [n_offsets] rows of `offsets` */
    int n_offsets;
    mukca_plot_point *points; /* [2 * train->n_rows] scratch of a figure */
    mukca_score *score[2][2]; /* of `train` and `test`, nominal and calibrated; [n_scores] each */
    int n_scores[2];
} mukca_report;

/* Compute the content of the page, in its pool.  Errors: MUKCA_MEMORY. */
mukca_status mukca_report_prepare(mukca_report *report, mukca_error *error);

/* The page, whose content `report` must outlive it. */
mukca_page mukca_report_page(const mukca_report *report);

/* ---- parts of the page, one function each, in tables_diagnosis.c, tables_calibration.c and
 * view.c; the content is the report ---- */

mukca_page_part mukca_report_put_accuracy, mukca_report_put_verdict, mukca_report_put_causes,
    mukca_report_put_faults, mukca_report_put_limits, mukca_report_put_placements,
    mukca_report_put_joints, mukca_report_put_offsets, mukca_report_put_view;

/* ---- the report of a fleet, and its wording, shared with the screen (fleet_page.c) ---- */

/* As wording.h: a shared coefficient with interval, spread and probability, or a shared order;
 * "arm7: joint compliance at joint_4 6.4 times softer than 7 sisters, ...". */
const char *mukca_wording_fleet_trait(char text[MUKCA_WORDING], const mukca_trait *trait,
                                      const mukca_fleet *fleet);
const char *mukca_wording_fleet_departure(char text[MUKCA_WORDING],
                                          const mukca_departure *departure,
                                          const mukca_fleet *fleet);

/* The page, whose content `fleet` must outlive it. */
mukca_page mukca_fleet_page(const mukca_fleet *fleet);

#endif
