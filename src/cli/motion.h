/* mukca motion: its work, shared by its files. */
#ifndef MUKCA_CLI_MOTION_H
#define MUKCA_CLI_MOTION_H

#include "cli/cli.h"
#include "report/motion_page.h"
#include "report/wording_motion.h"

typedef struct {
    mukca_motion_input input;
    mukca_motion motion;
    mukca_motion_trace trace; /* for the page */
} cli_motion;

json_t *cli_motion_json(const cli_call *call);
cli_writer cli_motion_table;

#endif
