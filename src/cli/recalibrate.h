/* Result of `mukca recalibrate`: screen and JSON. */
#ifndef MUKCA_CLI_RECALIBRATE_H
#define MUKCA_CLI_RECALIBRATE_H

#include "cli/cli.h"
#include "recalibrate/check.h"
#include "recalibrate/recalibrate.h"

typedef struct {
    mukca_chain arm; /* up to the link that the poses refer to */
    mukca_pose_check check;
    int n_models;
    mukca_recalibration *fit;                /* [n_models] */
    mukca_pose_errors (*test)[MUKCA_STAGES]; /* [n_models], or NULL without --test */
    mukca_recalibration *robust; /* basis of the verdict: fit[0], or a fit with Huber weights */
    mukca_oracle oracle;
    mukca_constants constants;
} cli_recalibrated;

/* Print one screen, after the files were written; `acceptance`: of the last model. */
void cli_recalibrate_print(cli_call *call, const cli_recalibrated *r,
                           const mukca_acceptance *acceptance);

/* `offsets`: of the last model. */
json_t *cli_recalibrate_json(const cli_call *call, const cli_recalibrated *r,
                             const mukca_offsets *offsets, const mukca_chain *chain);

/* Decrease from `before` to `after`, percent; 0 if `before` is 0. */
double cli_removed_percent(double before, double after);

/* True if joint j never moves in the log. */
bool cli_never_moved(const mukca_recalibration *fit, int j);

/* "joint_3 d" of a constant. */
void cli_constant_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_constants *constants, int i,
                       const mukca_chain *chain);

#endif
