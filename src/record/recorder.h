/* Live recording, shared by `capture` and `serve`: joint states and requests over LCM, or lines;
 * the session file. */
#ifndef MUKCA_RECORD_RECORDER_H
#define MUKCA_RECORD_RECORDER_H

#include "base/text.h"
#include "lcm/link.h"
#include "lcm/message.h"
#include "record/requests.h"
#include "record/session.h"
#include "record/stream.h"

enum { MUKCA_RECORDER_LINE = 448 };

/* Zeroed options mean defaults; `mukca help capture` describes them.  All texts must outlive the
 * recorder. */
typedef struct {
    mukca_lcm_network network;
    const char *channel, *prefix, *position, *names, *map, *placements, *sockets;
    const char *key;          /* key file for signed requests; NULL: signatures are not required */
    const char *const *types; /* [n_types] .lcm files */
    int n_types;
    int stream; /* index into mukca_recorder_streams */
    bool still;
    double window, motion, dwell; /* s, rad or m, s */
    double distance;              /* between the sockets, m; 0: 0.05 */
    bool triggers;                /* record on messages of PREFIX_TRIGGER */
    bool lines;                   /* read joint states as lines from standard input */
} mukca_recorder_options;

/* "raw", "corrected", NULL; and that of the options. */
extern const char *const mukca_recorder_streams[];
const char *mukca_recorder_stream(const mukca_recorder *r);

/* Callbacks; any may be NULL. */
typedef struct {
    mukca_note_fn *report;                                           /* one line for the user */
    void (*joints)(void *context, int64_t time_us, const double *q); /* each usable message */
    void (*command)(void *context, const mukca_lcm_packet *packet);  /* of PREFIX_COMMAND */
    /* whether a trigger may record; MUKCA_NEGATIVE: no */
    mukca_status (*trigger)(void *context, const mukca_lcm_packet *packet, mukca_error *error);
    bool (*interrupted)(void); /* true aborts the search for a stream */
    void *context;
} mukca_recorder_hooks;

/* Kinds of trouble, each reported at once and then at most every ten seconds. */
typedef enum {
    MUKCA_RECORDER_TYPE,
    MUKCA_RECORDER_MALFORMED,
    MUKCA_RECORDER_COUNT,
    MUKCA_RECORDER_RANGE,
    MUKCA_RECORDER_NAMES,
    MUKCA_RECORDER_BACKWARDS,
    MUKCA_RECORDER_TWO_SENDERS,
    MUKCA_RECORDER_OWN_MESSAGE,
    MUKCA_RECORDER_DROPPED,
    MUKCA_RECORDER_SILENT,
    MUKCA_RECORDER_RATE,
    MUKCA_RECORDER_TROUBLES
} mukca_recorder_trouble;

typedef struct {
    int64_t reported[MUKCA_RECORDER_TROUBLES], occurrences[MUKCA_RECORDER_TROUBLES];
    char last_line[MUKCA_RECORDER_LINE];
} mukca_recorder_reports;

struct mukca_recorder {
    const mukca_recorder_options *options;
    const mukca_chain *chain;
    mukca_recorder_hooks hooks;
    mukca_lcm_link *link;
    int64_t packet_time; /* us, of the packet in process; 0: none */
    mukca_stream stream;
    mukca_requests requests;
    mukca_sampling session;
    mukca_recorder_reports reports;
    unsigned char outgoing[8192];
};

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

/* ---- reports and messages (messages.c) ---- */

/* Send a message on its channel; false: it failed, which is reported. */
bool mukca_recorder_publish(mukca_recorder *r, mukca_message_kind kind, const void *message);

/* Report one line to the user and keep it for the status message. */
void mukca_recorder_report(mukca_recorder *r, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The same as a mukca_note_fn; `r` is the recorder. */
void mukca_recorder_note(void *r, const char *text);

/* Whether trouble of this kind was reported in the last ten seconds. */
bool mukca_recorder_reported(const mukca_recorder *r, mukca_recorder_trouble kind);

/* Report trouble at a limited rate; mukca_recorder_refuse also counts an unusable message. */
void mukca_recorder_warn(mukca_recorder *r, mukca_recorder_trouble kind, const char *text);
void mukca_recorder_refuse(mukca_recorder *r, mukca_recorder_trouble kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Append "no joint state on X; heard instead: PANDA_STATUS (drake.lcmt_panda_status, 7 joints)";
 * `since` is printed after the channel. */
void mukca_recorder_describe_silence(mukca_text *text, const mukca_recorder *r, const char *since);

/* The reason why no stream has been found so far. */
void mukca_recorder_describe_search(const mukca_recorder *r, char *text, size_t size);

static inline const char *mukca_recorder_joint(const mukca_recorder *r, int j)
{
    return mukca_chain_joint_name(r->chain, j);
}

#endif
