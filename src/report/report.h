/* The report: one self-contained HTML page of a calibration and its diagnosis. */
#ifndef MUKCA_REPORT_REPORT_H
#define MUKCA_REPORT_REPORT_H

#include "base/pool.h"
#include "fit/evaluate.h"
#include "io/offsets.h"
#include "report/wording.h"

/* Errors at one iteration of the fit, m: consistency and distortion of the training data, then of
 * the test data (NaN without any). */
typedef struct {
    double error[4];
} mukca_report_step;

/* Errors of one placement, nominal and calibrated. */
typedef struct {
    const char *placement; /* "poses" for all samples of a pose log */
    bool test;
    mukca_score nominal, calibrated;
} mukca_report_score;

/* One calibration of the comparison "trained on some placements, tested on the others". */
typedef struct {
    char trained[2 * MUKCA_NAME_SIZE]; /* its placements, as in mukca_cross_training */
    double mean, low, high;            /* MAE over the other placements, m */
} mukca_report_bar;

typedef struct {
    const char *path, *sha256;
} mukca_report_file;

/* All that the page shows. */
typedef struct {
    /* Filled by the caller, who keeps the memory. */
    const char *command;            /* that made the page */
    const char *when;               /* UTC */
    const mukca_report_file *files; /* URDF first, then data */
    int n_files;
    const mukca_chain *chain;          /* the arm */
    const mukca_chain *fitted;         /* of `offsets`: the arm, with a pose log's frames */
    const mukca_offsets *offsets;      /* calibrated parameters, and effects of a given table */
    bool free_base, free_tool;         /* frames of pose logs that were fitted */
    const mukca_fit *fit;              /* NULL: the offsets come from a table */
    const char *solver;                /* of `fit` */
    const mukca_dataset *train, *test; /* `test` may be empty */
    mukca_diagnosed diagnosed;         /* of `train` */
    const mukca_report_step *steps;    /* [n_steps], may be empty */
    int n_steps;
    double repeatability;        /* of the arm, m; 0: unknown */
    mukca_progress_fn *progress; /* NULL: none; returning false interrupts */
    void *progress_context;
    /* Filled by mukca_report_prepare. */
    mukca_dataset data;         /* samples of `train`, then of `test` */
    const double *nominal;      /* [n_rows][3] predicted tip, m */
    const double *calibrated;   /* [n_rows][3] */
    const double *residual;     /* [n_rows][3] calibrated tip minus its socket's mean, or minus
                                   the measured position; NaN where that is unknown */
    const double *explained;    /* [n_rows][3] residual with the causes modelled; NULL: none */
    const double *joint_error;  /* [n_rows][n_joints] part of the residual along which the ball
                                   moves with the joint, m */
    const double *joint_effect; /* part of it that the causes explain; NULL without causes */
    mukca_report_score *scores; /* [n_scores] of `train`, then of `test` */
    int n_scores;
    double nominal_m, calibrated_m; /* mean MAE over the placements of `test`, else of `train` */
    mukca_report_bar *bars;         /* [n_bars] */
    int n_bars;
    mukca_pool pool;
} mukca_report;

/* Compute the numbers that the page shows.  Free with mukca_report_free, also after an error.
 * Errors: MUKCA_MEMORY, MUKCA_INTERRUPTED, those of mukca_fit_run. */
mukca_status mukca_report_prepare(mukca_report *report, mukca_error *error);
void mukca_report_free(mukca_report *report); /* harmless on a zeroed one */

/* Write the page.  Errors: MUKCA_INTERRUPTED, those of mukca_plot_svg. */
mukca_status mukca_report_write(FILE *out, const mukca_report *report, mukca_error *error);

/* Write each figure as DIRECTORY/<id>.<format>, format "png", "pdf" or "svg".  Errors: as above. */
mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *report, mukca_error *error);

#endif
