/* State of a live recording, shared by `capture` and `serve`: joint states and requests over LCM,
 * or lines; the session file. */
#ifndef MUKCA_RECORD_STATE_H
#define MUKCA_RECORD_STATE_H

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
    bool confirmed; /* they may be used: not yet if they follow from the order alone */
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

/* Callbacks; any may be NULL.  `context` is that of all but `report`. */
typedef struct {
    mukca_notes report;                                              /* lines for the user */
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

#endif
