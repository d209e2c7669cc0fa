/* Declarations shared by the files of the diagnose command; also used by serve and report. */
#ifndef MUKCA_CLI_DIAGNOSE_H
#define MUKCA_CLI_DIAGNOSE_H

#include "cli/cli.h"
#include "fleet/fleet.h"
#include "report/wording.h"

/* A diagnosis, for the commands diagnose and report; zeroed at first. */
typedef struct {
    mukca_diagnose_options options; /* input: disabled, go_on and its context */
    mukca_diagnosis diagnosis;
    mukca_next_poses next;
    mukca_offsets offsets; /* of cli_diagnosis_make_offsets */
    mukca_chain chain;     /* of these offsets: the arm's, preceded by the tracker's frame if that
                              was fitted */
    mukca_diagnosed result;
} cli_diagnosis;

/* Diagnose the condensed session and find the next poses.  Free also after an error. */
mukca_status cli_diagnosis_run(cli_call *call, cli_diagnosis *diagnosis);
void cli_diagnosis_free(cli_diagnosis *diagnosis);

/* Members of mukca.diagnose/1. */
json_t *cli_diagnosis_json(const mukca_diagnosed *result);

/* Print one screen of 80 columns, and with `details` errors, detection limits and probable sets. */
void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *result, bool details);

/* Offsets table of a diagnosis: geometry with standard errors, the causes that act on the arm, the
 * verdict.  Causes that need masses which the arm lacks are left out, with a note.  Errors:
 * MUKCA_UNIDENTIFIABLE (nothing was fitted), MUKCA_INPUT. */
mukca_status cli_diagnosis_make_offsets(cli_call *call, cli_diagnosis *diagnosis);

/* Contributions of the fleet's traits and of this arm, on the screen and as JSON. */
void cli_adoption_print(cli_call *call, const mukca_adoption *adoption,
                        const mukca_diagnosed *result);
json_t *cli_adoption_json(const mukca_adoption *adoption, const mukca_diagnosed *result);

/* Read the summaries of all arguments, for the commands fleet and report. */
mukca_status cli_fleet_read(cli_call *call, mukca_fleet *fleet);

#endif
