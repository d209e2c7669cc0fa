/* Commanded and read angles of one recording, compared before any fit. */
#ifndef MUKCA_DIAGNOSE_STREAMS_H
#define MUKCA_DIAGNOSE_STREAMS_H

#include "diagnose/diagnose.h"
#include "diagnose/regression.h"

/* Compare the angles joint by joint: regression of the difference on the gravity torque.  `streams`
 * stays empty if the recording has only one of them. */
void mukca_streams_compare(mukca_streams *streams, const mukca_recording *recording);

/* Noise of a fit of the geometry to each stream.  Errors: MUKCA_MEMORY. */
mukca_status mukca_streams_fit(mukca_streams *streams, const mukca_recording_options *options,
                               const mukca_chain *chain, const mukca_dataset *data,
                               mukca_error *error);

#endif
