/* Declarations shared by the files of the diagnose command; also used by serve and report. */
#ifndef MUKCA_CLI_DIAGNOSE_H
#define MUKCA_CLI_DIAGNOSE_H

#include "cli/cli.h"
#include "report/wording.h"

/* The diagnosis as mukca.diagnose/1. */
json_t *cli_diagnosis_json(const mukca_diagnosed *result);

/* Print one screen of 80 columns, causes first. */
void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *result);

/* Print the most probable sets of causes. */
void cli_diagnosis_print_sets(FILE *stream, const mukca_diagnosed *result);

/* Diagnose simulated recordings with the postures, the noise and the causes of a diagnosis (with
 * `applied`), and without causes: check->runs of each, in parallel processes.  Without testable
 * causes, or if they cannot be simulated, a note says so and result->check stays NULL.  Errors:
 * MUKCA_MEMORY, MUKCA_INTERRUPTED. */
mukca_status cli_diagnosis_check(cli_call *call, mukca_check *check, mukca_diagnosed *result,
                                 const mukca_diagnose_options *options);

#define CLI_CHECK_OPTION(type)                                                                  \
    CLI_RANGE_OPTION(type, check.runs, "check", CLI_INTEGER, "N", 1, 100000,                    \
                     "diagnose N simulated recordings with these postures, this noise and the " \
                     "causes found, and N without causes")

/* Fitted frames of measured poses. */
typedef struct {
    bool base, tool;
} cli_frames;

/* Offsets table of a diagnosis: geometry with standard errors, the causes that act on the arm, the
 * verdict.  `chain` gets the chain of the table: the arm's, preceded by the tracker's frame if that
 * was fitted.  *left_out: number of causes omitted because the arm lacks the masses they need.
 * Errors: MUKCA_UNIDENTIFIABLE (nothing was fitted), MUKCA_INPUT. */
mukca_status cli_diagnosis_offsets(mukca_offsets *offsets, mukca_chain *chain, int *left_out,
                                   const mukca_diagnosed *result, const cli_frames *frames,
                                   mukca_error *error);

/* ---- parts of the screen (diagnose_screen_data.c) ---- */

/* Frames of several pose logs or targets; readings against commands; recording faults and efforts.
 */
void cli_screen_logs(FILE *stream, const mukca_diagnosed *diagnosed);
void cli_screen_streams(FILE *stream, const mukca_diagnosed *diagnosed);
void cli_screen_recording(FILE *stream, const mukca_diagnosed *diagnosed);

/* Detection limits and effects not testable.  `caveat`: missing masses have been mentioned
 * already. */
void cli_screen_limits(FILE *stream, const mukca_diagnosed *diagnosed, bool caveat);

#endif
