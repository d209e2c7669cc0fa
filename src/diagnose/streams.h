/* Commanded and read angles of one recording, compared before anything is fitted to either. */
#ifndef MUKCA_DIAGNOSE_STREAMS_H
#define MUKCA_DIAGNOSE_STREAMS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Compare the streams joint by joint: the difference is regressed on gravity's torque.  Leaves
 * `streams` empty where the recording has one stream only. */
void mukca_streams_compare(mukca_streams *streams, const mukca_recording *recording);

/* Noise of a fit of the geometry to each stream.  Errors: MUKCA_MEMORY. */
mukca_status mukca_streams_fit(mukca_streams *streams, const mukca_recording_options *options,
                               const mukca_chain *chain, const mukca_dataset *data,
                               mukca_error *error);

#endif
