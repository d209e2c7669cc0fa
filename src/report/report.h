/* The report: one self-contained HTML page of a calibration and its diagnosis. */
#ifndef MUKCA_REPORT_REPORT_H
#define MUKCA_REPORT_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "mukca/chain.h"
#include "mukca/dataset.h"
#include "mukca/status.h"

/* Consistency and distortion of training and held-out rows at each iteration, m. */
typedef struct {
    double train_consistency, train_distortion;
    double test_consistency, test_distortion; /* NaN where nothing was held out */
} mukca_report_step;

/* One calibration of the comparison "train on some placements, test on the others". */
typedef struct {
    char trained[128];      /* names of its placements */
    double mean, low, high; /* MAE over the other placements, m */
} mukca_report_bar;

typedef struct {
    const char *path, *sha256;
} mukca_report_file;

/* All that the page shows.  Arrays are the caller's; those marked so may be NULL or empty. */
typedef struct {
    const char *command;            /* that made the page */
    const char *when;               /* UTC */
    const mukca_report_file *files; /* URDF first, then data */
    int n_files;
    const mukca_chain *chain;
    const mukca_dataset *data;     /* all rows, training and held out */
    const unsigned char *held_out; /* [n_placements] */
    const json_t *calibration;     /* mukca.calibrate/1 */
    const json_t *diagnosis;       /* mukca.diagnose/1, or NULL */
    const double *nominal;         /* [n_rows][3] predicted tip, m */
    const double *calibrated;      /* [n_rows][3] */
    const double *joint_error;  /* [n_rows][n_joints] part of the row's error along which the ball
                                   moves with the joint, m; or NULL */
    const double *joint_effect; /* what of it the causes explain, or NULL */
    const mukca_report_step *steps;
    int n_steps; /* may be 0 */
    const mukca_report_bar *bars;
    int n_bars;           /* may be 0 */
    double repeatability; /* of the arm, m; 0: not known */
    bool (*stop)(void *); /* called with NULL before each figure, true: leave; or NULL */
} mukca_report;

/* Write the page.  Errors: as mukca_plot_svg. */
mukca_status mukca_report_write(FILE *out, const mukca_report *report, mukca_error *error);

/* Write each figure as DIRECTORY/<id>.<format>, format "png", "pdf" or "svg". */
mukca_status mukca_report_write_figures(const char *directory, const char *format,
                                        const mukca_report *report, mukca_error *error);

#endif
