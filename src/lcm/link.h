/* Transport of LCM messages: a network (udpm://) or a log (file://). */
#ifndef MUKCA_LCM_LINK_H
#define MUKCA_LCM_LINK_H

#include <stdio.h>

#include "lcm/packet.h"
#include "mukca/status.h"

/* url NULL: LCM_DEFAULT_URL, else LCM's default.  interface: address of the receiving interface;
 * NULL: that of the multicast route, local senders only.  from: comma-separated addresses of
 * accepted senders, instead; may be NULL.  none: neither a network nor a log. */
typedef struct {
    const char *url, *interface, *from;
    bool none;
} mukca_lcm_network;

typedef void mukca_lcm_packet_fn(void *context, const mukca_lcm_packet *packet);

/* An event log.  Zeroed: closed. */
typedef struct {
    FILE *file;
    int64_t skipped; /* bytes outside events */
    char channel[MUKCA_LCM_CHANNEL_SIZE];
    unsigned char *data; /* of the last event */
} mukca_lcm_log;

/* Zeroed: closed. */
typedef struct {
    void *lcm;                      /* an lcm_t, which sends; NULL: nothing is sent */
    mukca_lcm_multicast *multicast; /* receives; NULL: a log is replayed, or nothing is received */
    bool replays;
    mukca_lcm_packet_fn *receive;
    void *context;
    mukca_lcm_log log; /* replayed */
    int64_t clock;     /* time of the last event delivered, us */
} mukca_lcm_link;

/* Connect to `network`; `receive` gets the packets.  A log is replayed as fast as possible.  Close
 * it after a failure, too.  Errors: MUKCA_TRANSPORT (no multicast route, with the remedy),
 * MUKCA_INPUT (log), MUKCA_MEMORY. */
mukca_status mukca_lcm_link_open(mukca_lcm_link *link, const mukca_lcm_network *network,
                                 mukca_lcm_packet_fn *receive, void *context, mukca_error *error);

/* Deliver what has arrived from a network, or some hundred events of a log.  Waits up to
 * `timeout_ms`, or until descriptor `other` (-1: none) is readable, which sets *readable (may be
 * NULL).  A signal ends the wait.  Returns MUKCA_OK, MUKCA_NEGATIVE at the end of a log,
 * MUKCA_TRANSPORT. */
mukca_status mukca_lcm_link_wait(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                                 mukca_error *error);

/* Send a message; not during a replay.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_link_publish(mukca_lcm_link *link, const char *channel, const void *data,
                                    size_t size, mukca_error *error);

/* The time in us since 1970, in a replay that of the log. */
int64_t mukca_lcm_link_clock(const mukca_lcm_link *link);

void mukca_lcm_link_close(mukca_lcm_link *link);

/* ---- event logs of lcm-logger, read with bounded lengths ---- */

/* First bytes of an event, and so of a log. */
extern const unsigned char mukca_lcm_log_sync[4];

/* Errors: MUKCA_INPUT (cannot be opened). */
mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error);

/* Read the next event, which is valid until the next call; false at the end.  Skips damaged parts
 * up to the next sync word. */
bool mukca_lcm_log_read(mukca_lcm_packet *event, mukca_lcm_log *log);

/* Harmless on a closed log. */
void mukca_lcm_log_close(mukca_lcm_log *log);

#endif
