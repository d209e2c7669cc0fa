/* Pose logs that are diagnosed together: which frames each log has of its own. */
#ifndef MUKCA_DIAGNOSE_LOGS_H
#define MUKCA_DIAGNOSE_LOGS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Of the free frames of several logs, find those that differ from log to log: the tracker may have
 * been moved, the target mounted anew.  The evidence of a fit of the geometry decides among all
 * four cases; where loads differ, every joint may be compliant in it, so that a deflection is not
 * taken for another frame.  Sets options->base_per_log and tool_per_log, and what is reported.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_logs_compare(mukca_logs *logs, mukca_recording_options *options,
                                const mukca_chain *chain, const mukca_dataset *data,
                                mukca_error *error);

/* Give each log of the test regression the frames of the training log of its target; without names,
 * of the one that predicts it best.  Returns the first log of a target that was not trained on. */
int mukca_logs_match(mukca_regression *test, const mukca_regression *training);

/* Place the targets of the logs from `first` on by the present arm: their mean in the tip's frame.
 */
void mukca_logs_place_targets(mukca_regression *test, int first);

#endif
