/* Joint states: from a message to a reading of the arm. */
#ifndef MUKCA_RECORD_STREAM_H
#define MUKCA_RECORD_STREAM_H

#include "record/state.h"

/* Process a message of the stream's channel. */
void mukca_stream_take(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Process lines of standard input, or wait for some; as mukca_lcm_link_wait. */
mukca_status mukca_stream_wait_lines(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                     mukca_error *error);

#endif
