/* Result of `mukca recalibrate`: screen and JSON. */
#ifndef MUKCA_CLI_RECALIBRATE_H
#define MUKCA_CLI_RECALIBRATE_H

#include "cli/cli.h"
#include "recalibrate/recalibrate.h"

/* The call's work. */
typedef struct {
    mukca_recalibrate_options options;
    mukca_chain arm;               /* up to the link that the poses refer to */
    mukca_dataset *log, *test_log; /* of the session */
    mukca_dataset part[2];         /* of these, for the verdict */
    int n_oriented;                /* rows of the log with an orientation */
    mukca_pose_check check;
    mukca_recalibration *fit;
    bool tested; /* --test */
    mukca_pose_errors test[MUKCA_STAGES];
    mukca_recalibration *robust; /* basis of the verdict: fit, or a fit with Huber weights */
    mukca_offsets offsets;       /* with verdict */
} cli_recalibrated;

/* Print one screen, after the files were written. */
mukca_status cli_recalibrate_print(cli_call *call);

json_t *cli_recalibrate_json(const cli_call *call);

#endif
