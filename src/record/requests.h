/* Requests over LCM, triggers and commands: a rate limit for each sender, signatures. */
#ifndef MUKCA_RECORD_REQUESTS_H
#define MUKCA_RECORD_REQUESTS_H

#include "lcm/signature.h"

enum { MUKCA_REQUESTS_SENDERS = 32 };

typedef struct {
    uint64_t id;
    int64_t time;    /* us, of its last request */
    double requests; /* requests available (token bucket) */
} mukca_requests_sender;

typedef struct {
    char trigger_channel[64], command_channel[64];
    mukca_requests_sender sender[MUKCA_REQUESTS_SENDERS];
    mukca_lcm_key key;
    int64_t last_signed; /* us, time stamp of the last signed request */
} mukca_requests;

typedef struct mukca_recorder mukca_recorder;

/* Process a message on the trigger channel. */
void mukca_requests_trigger(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Whether a sender's request is within its rate limit.  False: it is refused. */
bool mukca_requests_may(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Check the signature of a request with time stamp `utime`, us, if the options name a key: each is
 * accepted once, and only while fresh.  Errors: MUKCA_NEGATIVE. */
mukca_status mukca_requests_check_signature(mukca_recorder *r, const mukca_lcm_packet *packet,
                                            int64_t utime, mukca_error *error);

#endif
