/* Live recording: the transport of joint states, triggers and commands. */
#ifndef MUKCA_RECORD_RECORDER_H
#define MUKCA_RECORD_RECORDER_H

#include "record/messages.h"
#include "record/session.h"

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
