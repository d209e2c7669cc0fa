/* Reading a fleet's summaries, for the commands fleet and report. */
#ifndef MUKCA_CLI_FLEET_H
#define MUKCA_CLI_FLEET_H

#include "cli/cli.h"
#include "fleet/fleet.h"

typedef struct {
    mukca_fleet fleet;
    mukca_fleet_result result;
} cli_fleet;

/* Read all arguments and pool the summaries. */
mukca_status cli_fleet_read(cli_call *call, cli_fleet *fleet);
void cli_fleet_free(void *fleet);

#endif
