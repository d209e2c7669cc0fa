/* Parts of the diagnosis screen about the recording. */
#ifndef MUKCA_CLI_DIAGNOSE_SCREEN_H
#define MUKCA_CLI_DIAGNOSE_SCREEN_H

#include "cli/diagnose.h"

/* Frames of several pose logs or targets; readings against commands; recording faults and efforts.
 */
void cli_screen_logs(FILE *stream, const mukca_diagnosed *diagnosed);
void cli_screen_streams(FILE *stream, const mukca_diagnosed *diagnosed);
void cli_screen_recording(FILE *stream, const mukca_diagnosed *diagnosed);

/* Detection limits and effects not testable.  `caveat`: missing masses have been mentioned
 * already. */
void cli_screen_limits(FILE *stream, const mukca_diagnosed *diagnosed, bool caveat);

#endif
