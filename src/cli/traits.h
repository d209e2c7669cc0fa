/* Options of commands that write a summary for the fleet or use its traits. */
#ifndef MUKCA_CLI_TRAITS_H
#define MUKCA_CLI_TRAITS_H

#include "cli/cli.h"
#include "fleet/fleet.h"

/* The label of the arm: `given`, else the name of the data's folder.  Errors: MUKCA_USAGE (data of
 * several folders, no usable name). */
mukca_status cli_arm_label(cli_call *call, char label[MUKCA_NAME_SIZE], const char *given);

/* Contributions of the fleet and of this arm, on the screen and as JSON. */
void cli_adoption_print(cli_call *call, const mukca_adoption *adoption,
                        const mukca_diagnosis *diagnosis, const mukca_chain *chain);
json_t *cli_adoption_json(const mukca_adoption *adoption, const mukca_diagnosis *diagnosis,
                          const mukca_chain *chain);

/* Read the summaries of all arguments, for the commands fleet and report. */
mukca_status cli_fleet_read(cli_call *call, mukca_fleet *fleet);

#endif
