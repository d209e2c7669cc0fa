/* Compared before the diagnosis: pose logs, of which some frames are per log; commanded and read
 * angles of one recording. */
#ifndef MUKCA_DIAGNOSE_LOGS_H
#define MUKCA_DIAGNOSE_LOGS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Determine which free frames of several logs differ between logs: the tracker may have been moved,
 * the target remounted.  Chosen among four cases by the evidence of a fit of the geometry; with
 * different loads, every joint may be compliant in this fit, lest a deflection appear as another
 * frame.  Sets options->base_per_log and tool_per_log, and the reported values.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_logs_compare(mukca_logs *logs, mukca_recording_options *options,
                                const mukca_chain *chain, const mukca_dataset *data,
                                mukca_error *error);

/* ---- streams.c ---- */

/* Compare the angles joint by joint: regression of the difference on the gravity torque.  `streams`
 * stays empty if the recording has only one of them. */
void mukca_streams_compare(mukca_streams *streams, const mukca_recording *recording);

/* Noise of a fit of the geometry to each stream.  Errors: MUKCA_MEMORY. */
mukca_status mukca_streams_fit(mukca_streams *streams, const mukca_recording_options *options,
                               const mukca_chain *chain, const mukca_dataset *data,
                               mukca_error *error);

#endif
