/* Which reading of a message is which joint of the arm. */
#ifndef MUKCA_RECORD_MAP_H
#define MUKCA_RECORD_MAP_H

#include "record/state.h"

/* Read --map; and set the mapping from the first message, with the reason of a failure in
 * r->stream.problem. */
mukca_status mukca_stream_check_map(mukca_recorder *r, mukca_error *error);
mukca_status mukca_stream_make_map(mukca_recorder *r);

/* Find the mapped names in the last message, at their previous positions or elsewhere (a driver may
 * list joints in any order, mixed with others).  False: joint *missing is not there. */
bool mukca_stream_find_names(mukca_stream *stream, int *missing, int n_joints);

/* Whether the mapping follows from the order of readings alone; and the mapping as lines, with the
 * sender's names next to the arm's. */
bool mukca_stream_needs_confirmation(const mukca_recorder *r);
void mukca_stream_describe_map(const mukca_recorder *r, char *text, size_t size);

#endif
