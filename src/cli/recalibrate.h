/* Result of `mukca recalibrate`: screen and JSON. */
#ifndef MUKCA_CLI_RECALIBRATE_H
#define MUKCA_CLI_RECALIBRATE_H

#include "accept/accept.h"
#include "cli/cli.h"
#include "recalibrate/recalibrate.h"

/* The call's work. */
typedef struct {
    mukca_chain arm;               /* up to the link that the poses refer to */
    mukca_dataset *log, *test_log; /* of the session */
    int n_oriented;                /* rows of the log with an orientation */
    mukca_pose_check check;
    mukca_recalibration *fit;
    bool tested; /* --test */
    mukca_pose_errors test[MUKCA_STAGES];
    mukca_offsets offsets;    /* with verdict */
    const mukca_chain *chain; /* of these */
} cli_recalibrated;

/* Print one screen, after the files were written. */
mukca_status cli_recalibrate_print(cli_call *call);

json_t *cli_recalibrate_json(const cli_call *call);

#endif
