/* The session: samples on disk before they are acknowledged. */
#ifndef MUKCA_RECORD_SESSION_H
#define MUKCA_RECORD_SESSION_H

#include "record/state.h"

/* Initialise labels and capture; theta as for mukca_recorder_open. */
mukca_status mukca_sampling_prepare(mukca_recorder *r, const double *theta, mukca_error *error);

/* Create or resume the session file; its samples are loaded into the capture.  Errors: MUKCA_INPUT
 * (exists without `force`; see mukca_session_open), MUKCA_MEMORY. */
mukca_status mukca_sampling_begin(mukca_recorder *r, const char *path, bool resume, bool force,
                                  mukca_error *error);

/* Requests of the user; answer->text is the reply, also on success.  mukca_sampling_sample returns
 * after the sample is on disk, and sends a sample message in any case; labels NULL or "" mean the
 * current ones, utime 0: unknown; `time` is the request's arrival, us, 0: in order with the joint
 * states.  mukca_sampling_delete
 * deletes the last sample.  mukca_sampling_select: `placement` NULL is the
 * current one, "" a new one; `socket` NULL is the next one, with a placement its first.  Errors:
 * MUKCA_NEGATIVE (refused), MUKCA_INPUT (disk). */
mukca_status mukca_sampling_sample(mukca_recorder *r, const mukca_message_trigger *request,
                                   int64_t time, mukca_error *answer);
mukca_status mukca_sampling_delete(mukca_recorder *r, mukca_error *answer);
mukca_status mukca_sampling_select(mukca_recorder *r, const char *placement, const char *socket,
                                   mukca_error *answer);

/* As mukca_sampling_sample; the reply is reported. */
void mukca_sampling_trigger(mukca_recorder *r, const mukca_message_trigger *request, int64_t time);

/* Count a failure with status MUKCA_MEMORY, for the exit code. */
void mukca_sampling_count_unwritten(mukca_recorder *r, const mukca_error *error);

#endif
