/* Where LCM messages come from and go to: a network (udpm://, memq://) or a log (file://). */
#ifndef MUKCA_LCM_LINK_H
#define MUKCA_LCM_LINK_H

#include "lcm/receiver.h"

typedef struct mukca_lcm_link mukca_lcm_link;

typedef void mukca_lcm_packet_fn(void *context, const mukca_lcm_packet *packet);

/* Connect to network->url (NULL: LCM_DEFAULT_URL, else LCM's default); packets are delivered to
 * `receive`.
 * A log is replayed as fast as it can be read; `file://LOG?speed=1` in its own time.
 * Errors: MUKCA_TRANSPORT (no multicast route: what to do), MUKCA_INPUT (log), MUKCA_MEMORY. */
mukca_status mukca_lcm_link_open(mukca_lcm_link **link, const mukca_lcm_network *network,
                                 mukca_lcm_packet_fn *receive, void *context, mukca_error *error);

/* Receive a channel, taken literally; NULL is all channels.  No message is dropped or delivered
 * twice, unless more come than the receiver can hold (mukca_lcm_link_dropped).  Errors:
 * MUKCA_TRANSPORT, MUKCA_USAGE (no channel name; too many). */
mukca_status mukca_lcm_link_listen(mukca_lcm_link *link, const char *channel, mukca_error *error);

/* Stop receiving all channels; those that were named stay. */
void mukca_lcm_link_unlisten_all(mukca_lcm_link *link);

/* Deliver one message of a network, or some hundred of a log; wait up to `timeout_ms` for it, or
 * until descriptor `other` (-1: none) is readable; *readable (may be NULL) is set then.  Returns
 * MUKCA_OK, MUKCA_NEGATIVE at the end of a log, MUKCA_TRANSPORT.  A signal ends the wait. */
mukca_status mukca_lcm_link_wait(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                                 mukca_error *error);

/* Send; while a log is replayed this only reaches the record.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_link_publish(mukca_lcm_link *link, const char *channel, const void *data,
                                    size_t size, mukca_error *error);

/* Write the messages of named channels, and what is published, to an event log from now on.  When
 * that fails later, `note` gets one line and the record ends. */
mukca_status mukca_lcm_link_record(mukca_lcm_link *link, const char *path, bool force,
                                   mukca_note_fn *note, void *note_context, mukca_error *error);

/* End the record, if there is one.  Errors: MUKCA_MEMORY (not written whole, now or earlier). */
mukca_status mukca_lcm_link_finish_record(mukca_lcm_link *link, mukca_error *error);

/* Whether a log is replayed, and the clock: us since 1970, the log's own while replaying. */
bool mukca_lcm_link_replays(const mukca_lcm_link *link);
int64_t mukca_lcm_link_clock(const mukca_lcm_link *link);

/* Bytes of the replayed log that were no events. */
int64_t mukca_lcm_link_skipped(const mukca_lcm_link *link);

/* Messages and datagrams of a network that were dropped so far; where that grew, `reason` says
 * why. */
int64_t mukca_lcm_link_dropped(mukca_lcm_link *link, char reason[128]);

/* NULL is harmless. */
void mukca_lcm_link_close(mukca_lcm_link *link);

#endif
