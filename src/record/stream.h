/* The joint states of a recording: from a message to a reading of the arm. */
#ifndef MUKCA_RECORD_STREAM_H
#define MUKCA_RECORD_STREAM_H

#include "lcm/packet.h"
#include "lcm/type.h"
#include "record/joint_lines.h"

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
    double q[MUKCA_MAX_JOINTS], effort[MUKCA_MAX_JOINTS], command[MUKCA_MAX_JOINTS];
    int64_t time;    /* us, its sender's, else its arrival */
    int64_t arrival; /* us; 0: none yet */
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

typedef struct mukca_recorder mukca_recorder;

/* Process a message of the stream's channel. */
void mukca_stream_take(mukca_recorder *r, const mukca_lcm_packet *packet);

/* Process the joint states in r->stream.last.joints; `packet` has their arrival and sender. */
void mukca_stream_take_joints(mukca_recorder *r, const mukca_lcm_packet *packet, int type);

/* Process lines of standard input, or wait for some; as mukca_lcm_link_wait (lines.c). */
mukca_status mukca_stream_wait_lines(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                     mukca_error *error);

/* Read --map; and set the mapping from the first message, with the reason of a failure in
 * r->stream.problem (map.c). */
mukca_status mukca_stream_check_map(mukca_recorder *r, mukca_error *error);
mukca_status mukca_stream_make_map(mukca_recorder *r);

/* Whether the mapping follows from the order of readings alone; and the mapping as lines, with the
 * sender's names next to the arm's. */
bool mukca_stream_needs_confirmation(const mukca_recorder *r);
void mukca_stream_describe_map(const mukca_recorder *r, char *text, size_t size);

/* Type of the joint states; "": none (this and the next: messages.c). */
const char *mukca_stream_type(const mukca_recorder *r);

double mukca_stream_age(const mukca_recorder *r); /* s since the arrival of the last joint state */

/* Whether a second sender of joint states was heard recently. */
bool mukca_stream_doubted(const mukca_recorder *r);

#endif
