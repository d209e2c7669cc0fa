/* Live recording: the transport of joint states, triggers and commands. */
#ifndef MUKCA_RECORD_RECORDER_H
#define MUKCA_RECORD_RECORDER_H

#include "record/messages.h"

/* Connect to LCM and prepare a recording, without starting it.  theta[6 * n_elements] (NULL:
 * nominal) is the initial model.  `r` is large: allocate it.  Everything that it points to must
 * outlive it; close it after a failure, too.  Errors: MUKCA_USAGE, MUKCA_INPUT, MUKCA_TRANSPORT,
 * MUKCA_MEMORY. */
mukca_status mukca_recorder_open(mukca_recorder *r, const mukca_recorder_options *options,
                                 const mukca_chain *chain, const double *theta,
                                 const mukca_recorder_hooks *hooks, mukca_error *error);
void mukca_recorder_close(mukca_recorder *r);

/* Find channel, type and mapping; waits up to `wait` s (< 0: for ever).  A log is read ahead for
 * this and then restarted.  Errors: MUKCA_TRANSPORT (silence; lists the other channels heard),
 * MUKCA_INPUT, MUKCA_INTERRUPTED. */
mukca_status mukca_recorder_connect(mukca_recorder *r, double wait, mukca_error *error);

/* Whether all samples and answers were written.  Errors: MUKCA_MEMORY (the first failure). */
mukca_status mukca_recorder_finish(const mukca_recorder *r, mukca_error *error);

/* Process arrived messages and detect silence.  As mukca_lcm_link_wait. */
mukca_status mukca_recorder_step(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                 mukca_error *error);

/* ---- requests over LCM: a rate limit for each sender, signatures ---- */

/* Take one of a budget that begins with `first` and grows by `rate` per second to `most`; false:
 * none is left. */
bool mukca_budget_take(mukca_budget *budget, int64_t now, double rate, double first, double most);

/* Decode a request, if it is one and within the rate limit of its sender.  False: it is refused. */
bool mukca_requests_decode(void *message, mukca_recorder *r, mukca_message_kind kind,
                           const mukca_lcm_packet *packet);

/* Check the signature of a request with time stamp `utime`, us, if the options name a key: each is
 * accepted once, and only while fresh.  Errors: MUKCA_NEGATIVE. */
mukca_status mukca_requests_check_signature(mukca_recorder *r, const mukca_lcm_packet *packet,
                                            int64_t utime, mukca_error *error);

/* ---- joint states: from a message to a reading of the arm (stream.c) ---- */

/* Process a message of the stream's channel. */
void mukca_stream_take(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Process lines of standard input, or wait for some; as mukca_lcm_link_wait. */
mukca_status mukca_stream_wait_lines(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                     mukca_error *error);

/* ---- which reading of a message is which joint (map.c) ---- */

/* Read the numbers of --map; and set the mapping from the first message, with the reason of a
 * failure in r->stream.problem. */
mukca_status mukca_stream_check_map(mukca_recorder *r, mukca_error *error);
mukca_status mukca_stream_make_map(mukca_recorder *r);

/* Find the mapped names in the last message, at their previous positions or elsewhere (a driver may
 * list joints in any order, mixed with others).  False: joint *missing is not there. */
bool mukca_stream_find_names(mukca_stream *stream, int *missing, int n_joints);

/* Append the mapping as lines, with the sender's names next to the arm's. */
void mukca_stream_describe_map(mukca_text *text, const mukca_recorder *r);

/* ---- the session: samples on disk before they are acknowledged (session.c) ---- */

/* Initialise labels and capture; theta as for mukca_recorder_open. */
mukca_status mukca_sampling_prepare(mukca_recorder *r, const double *theta, mukca_error *error);

/* Create or resume the session file; its samples are loaded into the capture.  Errors: MUKCA_INPUT
 * (exists without `force`; see mukca_session_open), MUKCA_MEMORY. */
mukca_status mukca_sampling_begin(mukca_recorder *r, const char *path, bool resume, bool force,
                                  mukca_error *error);

/* Requests of the user; answer->text is the reply, also on success.  mukca_sampling_sample returns
 * after the sample is on disk, and sends a sample message in any case; labels NULL or "" mean the
 * current ones, utime 0: unknown; `time` is the request's arrival, us, 0: in order with the joint
 * states.  mukca_sampling_delete deletes the last sample.  mukca_sampling_select: `placement` NULL
 * is the current one, "" a new one; `socket` NULL is the next one, with a placement its first.
 * Errors: MUKCA_NEGATIVE (refused), MUKCA_INPUT (disk). */
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
