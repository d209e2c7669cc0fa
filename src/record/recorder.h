/* Live recording, shared by `capture` and `serve`: joint states and requests over LCM, or lines;
 * the session file. */
#ifndef MUKCA_RECORD_RECORDER_H
#define MUKCA_RECORD_RECORDER_H

#include "base/text.h"
#include "capture/capture.h"
#include "io/session_append.h"
#include "lcm/link.h"
#include "lcm/message.h"
#include "lcm/packet.h"
#include "lcm/type.h"
#include "record/joint_lines.h"

enum { MUKCA_RECORDER_LINE = 448 };

typedef struct mukca_recorder mukca_recorder;

enum { MUKCA_STREAM_HEARD = 24 };

/* Which reading of a message is which joint. */
typedef struct {
    bool made;      /* `reading` and n are set */
    bool confirmed; /* they may be used */
    bool by_name;
    int reading[MUKCA_MAX_JOINTS], n;             /* index of each joint's; readings of a message */
    char name[MUKCA_MAX_JOINTS][MUKCA_NAME_SIZE]; /* the sender's, of each joint; "": none */
} mukca_stream_map;

/* The last joint state. */
typedef struct {
    mukca_lcm_joints joints;
    mukca_capture_reading reading; /* of the arm's joints */
    int64_t time;                  /* us, its sender's, else its arrival */
    int64_t arrival;               /* us; 0: none yet */
} mukca_stream_last;

typedef struct {
    int64_t received, refused;
    int64_t dropped; /* datagrams and messages lost in the network */
    int64_t rate_since, rate_count;
    double rate, longest_gap; /* Hz; s between two arrivals */
} mukca_stream_count;

/* A channel heard while searching, or in silence. */
typedef struct {
    char channel[64];
    int type; /* index of the type; -1: unknown */
    int joints;
} mukca_stream_heard;

typedef struct {
    bool listens_to_all;
    int64_t opened;    /* us */
    int64_t fit_heard; /* us, arrival of the first stream that fits the arm; 0: none */
    int n_heard;
    mukca_stream_heard heard[MUKCA_STREAM_HEARD];
} mukca_stream_search;

typedef struct {
    double duration; /* s of waiting without a joint state */
    bool begun, reported;
} mukca_stream_silence;

/* The accepted sender of joint states, and its last message and that of another, us; 0: never. */
typedef struct {
    uint64_t id;
    int64_t heard, second_heard;
} mukca_stream_sender;

typedef struct {
    mukca_lcm_types types;
    mukca_joint_lines *lines; /* NULL: joint states come over the link */
    char channel[64];         /* empty while searching */
    int type;                 /* of its messages; -1 before the first */
    bool connected;           /* messages are used; before, they are only read ahead */
    mukca_error problem;      /* why the stream is unusable; OK: no problem found */
    mukca_stream_map map;
    mukca_stream_last last;
    mukca_stream_count count;
    mukca_stream_search search;
    mukca_stream_silence silence;
    mukca_stream_sender sender;
} mukca_stream;

enum { MUKCA_REQUESTS_SENDERS = 32 };

/* Token bucket: requests available, and when they were counted, us; zeroed: not used yet. */
typedef struct {
    double left;
    int64_t time;
} mukca_budget;

typedef struct {
    uint64_t id;
    mukca_budget budget;
} mukca_requests_sender;

typedef struct {
    char trigger_channel[64], command_channel[64];
    mukca_requests_sender sender[MUKCA_REQUESTS_SENDERS];
    mukca_lcm_key key;
    int64_t last_signed; /* us, time stamp of the last signed request */
} mukca_requests;

enum { MUKCA_LABELS = 32 };

/* Names of --placement or --sockets. */
typedef struct {
    char store[512];
    int n;
    char *name[MUKCA_LABELS];
} mukca_labels;

typedef struct {
    mukca_capture capture;
    mukca_session file; /* closed: nothing is recorded */
    mukca_capture_advice advice;
    mukca_labels placements, sockets;
    int refused;                   /* samples */
    bool beyond[MUKCA_MAX_JOINTS]; /* a joint was reported beyond its limits */
    int unwritten;                 /* samples and answers lost for lack of disk space or memory */
    mukca_error first_unwritten;
} mukca_sampling;

/* Of --type: .lcm files, and the fields with the joints' positions and names. */
typedef struct {
    const char *const *file; /* [n] */
    int n;
    const char *position, *names;
} mukca_recorder_types;

/* Zeroed options mean defaults; `mukca help capture` describes them.  All texts must outlive the
 * recorder. */
typedef struct {
    mukca_lcm_network network;
    const char *channel, *prefix, *map, *placements, *sockets;
    const char *key; /* key file for signed requests; NULL: signatures are not required */
    mukca_recorder_types types;
    int stream; /* index into mukca_recorder_streams */
    bool still;
    mukca_capture_settings capture; /* its labels: those of `sockets` */
    bool triggers;                  /* record on messages of PREFIX_TRIGGER */
    bool lines;                     /* read joint states as lines from standard input */
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
    mukca_lcm_link link;
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

/* Report one line to the user and keep it for the status message: a mukca_note_fn, `r` is the
 * recorder; formatted. */
void mukca_recorder_note(void *r, const char *text);
#define mukca_recorder_report(r, ...) mukca_note_format(mukca_recorder_note, r, __VA_ARGS__)

/* Whether trouble of this kind was reported in the last ten seconds. */
bool mukca_recorder_reported(const mukca_recorder *r, mukca_recorder_trouble kind);

/* Report trouble at a limited rate; mukca_recorder_refuse also counts an unusable message. */
void mukca_recorder_warn(mukca_recorder *r, mukca_recorder_trouble kind, const char *text);
void mukca_recorder_refuse(mukca_recorder *r, mukca_recorder_trouble kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Append "no joint state on X; heard instead: PANDA_STATUS (drake.lcmt_panda_status, 7 joints)";
 * `since` is printed after the channel. */
void mukca_recorder_describe_silence(mukca_text *text, const mukca_recorder *r, const char *since);

/* ---- joint states: from a message to a reading of the arm (stream.c) ---- */

/* Process a message of the stream's channel. */
void mukca_stream_take(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Process lines of standard input, or wait for some; as mukca_lcm_link_wait. */
mukca_status mukca_stream_wait_lines(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                     mukca_error *error);

/* Read --map; and set the mapping from the first message, with the reason of a failure in
 * r->stream.problem (map.c). */
mukca_status mukca_stream_check_map(mukca_recorder *r, mukca_error *error);
mukca_status mukca_stream_make_map(mukca_recorder *r);

/* Find the mapped names in the last message, at their previous positions or elsewhere (a driver may
 * list joints in any order, mixed with others).  False: joint *missing is not there. */
bool mukca_stream_find_names(mukca_stream *stream, int *missing, int n_joints);

/* Whether the mapping follows from the order of readings alone; and the mapping as lines, with the
 * sender's names next to the arm's. */
bool mukca_stream_needs_confirmation(const mukca_recorder *r);
void mukca_stream_describe_map(const mukca_recorder *r, char *text, size_t size);

/* Type of the joint states; "": none (this and the next: messages.c). */
const char *mukca_stream_type(const mukca_recorder *r);

double mukca_stream_age(const mukca_recorder *r); /* s since the arrival of the last joint state */

/* ---- requests over LCM: a rate limit for each sender, signatures (recorder.c) ---- */

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
 * states.  mukca_sampling_delete
 * deletes sample `row` (from 1; 0: the last).  mukca_sampling_select: `placement` NULL is the
 * current one, "" a new one; `socket` NULL is the next one, with a placement its first.  Errors:
 * MUKCA_NEGATIVE (refused), MUKCA_INPUT (disk). */
mukca_status mukca_sampling_sample(mukca_recorder *r, const mukca_message_trigger *request,
                                   int64_t time, mukca_error *answer);
mukca_status mukca_sampling_delete(mukca_recorder *r, int row, mukca_error *answer);
mukca_status mukca_sampling_select(mukca_recorder *r, const char *placement, const char *socket,
                                   mukca_error *answer);

/* As mukca_sampling_sample; the reply is reported. */
void mukca_sampling_trigger(mukca_recorder *r, const mukca_message_trigger *request, int64_t time);

/* Count a failure with status MUKCA_MEMORY, for the exit code. */
void mukca_sampling_count_unwritten(mukca_recorder *r, const mukca_error *error);

/* State of the stream: "no_stream", "moving" or "still"; and send it, or another `state` unless
 * NULL, as a status message. */
const char *mukca_sampling_state(const mukca_recorder *r);
void mukca_sampling_publish_status(mukca_recorder *r, const char *state);

static inline const char *mukca_recorder_joint(const mukca_recorder *r, int j)
{
    return mukca_chain_joint_name(r->chain, j);
}

#endif
