/* The engine that `capture` and `serve` share: joint states from LCM, triggers, the session file.
 */
#ifndef MUKCA_RECORD_RECORDER_H
#define MUKCA_RECORD_RECORDER_H

#include "capture/capture.h"
#include "cli/cli.h"
#include "io/session_append.h"
#include "lcm/decode.h"
#include "lcm/link.h"
#include "lcm/message.h"

enum { RECORDER_MAX_LABELS = 32, RECORDER_MAX_HEARD = 24, RECORDER_LINE = 448 };

/* What both commands let the user choose; zeroed means the defaults. */
typedef struct {
    const char *lcm_url, *channel, *prefix, *position, *names, *map, *placement, *sockets, *record;
    cli_list types; /* .lcm files */
    int stream;     /* 0 not said, 1 raw, 2 corrected: see recorder_streams */
    bool still;
    double window, motion, dwell;
} recorder_options;

extern const char *const recorder_streams[];

/* Rows of an option table; `type` is the options struct, whose member `recorder` this is. */
#define RECORDER_OPTION(type, name, kind, argument, member, help, choices)      \
    {                                                                           \
        name, 0, kind, argument, help, choices, offsetof(type, recorder.member) \
    }
#define RECORDER_OPTIONS(type)                                                                     \
    RECORDER_OPTION(type, "lcm-url", CLI_TEXT, "URL", lcm_url,                                     \
                    "LCM network, or file://LOG to replay a log (default: LCM_DEFAULT_URL, else "  \
                    "LCM's own)",                                                                  \
                    NULL),                                                                         \
        RECORDER_OPTION(type, "channel", CLI_TEXT, "NAME", channel,                                \
                        "channel of the joint states (default: the one heard that fits the arm)",  \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "type", CLI_TEXTS, "FILE", types,                                    \
                        "a .lcm description of the joint states, where mukca does not know them",  \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "position", CLI_TEXT, "FIELD", position,                             \
                        "the field of --type that holds the joint positions, as in q or head.q",   \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "names", CLI_TEXT, "FIELD", names,                                   \
                        "the field of --type that holds the joints' names", NULL),                 \
        RECORDER_OPTION(type, "map", CLI_TEXT, "HOW", map,                                         \
                        "which reading is which joint: name, order, or numbers as in 8-14 or "     \
                        "1,2,4 (default: by name, else by order once you confirm it)",             \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "stream", CLI_CHOICE, "KIND", stream,                                \
                        "raw: the encoders as they are; corrected: the driver has added stored "   \
                        "offsets; the session says which (default: raw)",                          \
                        recorder_streams),                                                         \
        RECORDER_OPTION(type, "still", CLI_FLAG, NULL, still,                                      \
                        "record by itself when the arm stands still in a socket in a new posture", \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "dwell", CLI_POSITIVE, "S", dwell,                                   \
                        "how long it must stand for that, s (default: 1)", NULL),                  \
        RECORDER_OPTION(type, "window", CLI_POSITIVE, "S", window,                                 \
                        "a sample is the mean over this time, s (default: 0.2)", NULL),            \
        RECORDER_OPTION(type, "motion", CLI_POSITIVE, "RAD", motion,                               \
                        "most that a joint may move meanwhile, rad or m (default: 0.001)", NULL),  \
        RECORDER_OPTION(type, "placement", CLI_TEXT, "LIST", placement,                            \
                        "names of the placements in order, commas between (default: placement_1 "  \
                        "and so on)",                                                              \
                        NULL),                                                                     \
        RECORDER_OPTION(type, "sockets", CLI_TEXT, "LIST", sockets,                                \
                        "labels of the sockets, commas between (default: 0,1)", NULL),             \
        RECORDER_OPTION(type, "record", CLI_TEXT, "LOG", record,                                   \
                        "keep the raw LCM stream in this log, too", NULL),                         \
        RECORDER_OPTION(type, "prefix", CLI_TEXT, "NAME", prefix,                                  \
                        "of our own channels, NAME_TRIGGER and so on (default: MUKCA)", NULL)

typedef struct recorder recorder;

/* What the commands hear from the engine; any may be NULL. */
typedef struct {
    void (*say)(void *context, const char *line);                    /* one line for people */
    void (*joints)(void *context, int64_t time_us, const double *q); /* each usable message */
    void (*packet)(void *context, const mukca_lcm_packet *packet);   /* of other named channels */
    void *context;
} recorder_hooks;

typedef struct {
    char channel[64];
    int type; /* -1: unknown */
    int joints;
    int64_t count;
} recorder_heard;

/* Trouble that is told once, then at most every ten seconds. */
typedef enum {
    RECORDER_TYPE,
    RECORDER_MALFORMED,
    RECORDER_COUNT,
    RECORDER_RANGE,
    RECORDER_NAMES,
    RECORDER_BACKWARDS,
    RECORDER_TWO_SENDERS,
    RECORDER_OWN_MESSAGE,
    RECORDER_TROUBLES
} recorder_trouble;

struct recorder {
    cli_call *call;
    const recorder_options *options;
    const cli_model *model;
    recorder_hooks hooks;
    mukca_lcm_types types;
    mukca_lcm_link *link;
    bool takes_triggers;
    char trigger_channel[64], command_channel[64];
    /* the stream */
    char channel[64]; /* empty while searching */
    int type;         /* of its messages, -1 before the first */
    bool mapped;      /* `map` and n_readings are known ... */
    bool confirmed;   /* ... and may be used */
    bool connected;   /* what comes is no longer only read ahead */
    bool by_name;
    int map[MUKCA_MAX_JOINTS], n_readings;
    mukca_error problem;     /* why the stream cannot be used at all; OK: nothing found */
    mukca_lcm_joints joints; /* the last message */
    double q[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS];
    int64_t received, refused, last_arrival, opened; /* arrival: us */
    int64_t packet_time;                             /* us, of the message at hand, 0: none is */
    int64_t rate_since, rate_count;
    double rate, longest_gap; /* Hz; s between arrivals */
    bool listens_to_all, silent;
    int n_heard;
    recorder_heard heard[RECORDER_MAX_HEARD];
    int64_t fit_heard; /* us, when the first stream that could be ours was heard; 0: none */
    int64_t told[RECORDER_TROUBLES], times[RECORDER_TROUBLES];
    /* the session */
    mukca_capture capture;
    mukca_session session; /* closed: nothing is recorded */
    mukca_capture_advice advice;
    char labels[2][512];
    int n_placements, n_sockets;
    const char *placements[RECORDER_MAX_LABELS], *sockets[RECORDER_MAX_LABELS];
    char last_line[RECORDER_LINE];
    mukca_message_status status; /* scratch */
    unsigned char outgoing[8192];
};

/* Open the link and prepare; nothing is recorded yet.  `r` is large: allocate it.  All that it
 * points to must outlive it.  Errors, here and below in call->error: MUKCA_USAGE, MUKCA_INPUT,
 * MUKCA_TRANSPORT, MUKCA_MEMORY. */
mukca_status recorder_open(recorder *r, cli_call *call, const recorder_options *options,
                           const cli_model *model, bool takes_triggers,
                           const recorder_hooks *hooks);
void recorder_close(recorder *r);

/* Parts of it: labels and the capture; --map.  And of the first good message: the mapping, where
 * r->problem says what is wrong. */
mukca_status recorder_prepare(recorder *r);
mukca_status recorder_check_map(recorder *r);
mukca_status recorder_make_map(recorder *r);

static inline const char *recorder_joint_name(const recorder *r, int j)
{
    return r->model->chain.element[r->model->chain.joint_element[j]].name;
}

/* Begin the --record log, if one is wanted. */
mukca_status recorder_keep_log(recorder *r);

/* Find channel, type and mapping; waits up to `wait` s (< 0: for ever).  A log is read ahead for
 * this and then begun anew.  Errors: MUKCA_TRANSPORT (silence: what was heard instead),
 * MUKCA_INPUT. */
mukca_status recorder_connect(recorder *r, double wait);

/* The mapping as lines for people, and whether it was made by order, without anybody's word for it.
 */
void recorder_describe_map(const recorder *r, char *text, size_t size);
bool recorder_needs_confirmation(const recorder *r);

/* Begin or resume the session file; the capture's rows follow it. */
mukca_status recorder_begin(recorder *r, const char *path, bool resume, bool force);

/* Hand over what has come, look after silence and standing still.  As mukca_lcm_link_wait. */
mukca_status recorder_step(recorder *r, int timeout_ms, int other, bool *readable);

/* Take a sample now; placement and socket as labels, NULL or "" for the current ones.  It is on
 * disk when this returns; a sample message goes out either way.  `line` gets what to tell people.
 * Returns MUKCA_NEGATIVE when refused, MUKCA_INPUT when the disk failed. */
mukca_status recorder_take(recorder *r, int64_t id, const char *placement, const char *socket,
                           char line[RECORDER_LINE]);

/* Other things that people ask for, answered in the same way. */
mukca_status recorder_undo(recorder *r, char line[RECORDER_LINE]);
mukca_status recorder_select(recorder *r, const char *placement, const char *socket,
                             char line[RECORDER_LINE]);
mukca_status recorder_other_socket(recorder *r, char line[RECORDER_LINE]);
mukca_status recorder_next_placement(recorder *r, char line[RECORDER_LINE]);

/* Send a status message; `state` NULL: what the stream does. */
void recorder_publish_status(recorder *r, const char *state);
const char *recorder_state(const recorder *r);

/* Send one of our messages on its channel. */
void recorder_publish(recorder *r, mukca_message_kind kind, const void *message);

/* The handler of all packets; `r` is the recorder. */
void recorder_on_packet(void *r, const mukca_lcm_packet *packet);

/* Say that something is wrong, but not a thousand times a second; and count a message that cannot
 * be used for it. */
void recorder_complain(recorder *r, recorder_trouble kind, const char *text);
void recorder_refuse(recorder *r, recorder_trouble kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Say one line to people and remember it for the status. */
void recorder_say(recorder *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

double recorder_age(const recorder *r);              /* s since the last joint state arrived */
const char *recorder_stream_name(const recorder *r); /* "raw" or "corrected" */

#endif
