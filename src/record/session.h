/* The session of a recording: samples on disk before they are acknowledged, labels, status. */
#ifndef MUKCA_RECORD_SESSION_H
#define MUKCA_RECORD_SESSION_H

#include "capture/capture.h"
#include "io/session_append.h"

enum { MUKCA_LABELS = 32 };

/* Names of --placement or --sockets. */
typedef struct {
    char store[512];
    int n;
    const char *name[MUKCA_LABELS];
} mukca_labels;

typedef struct {
    mukca_capture capture;
    mukca_session file; /* closed: nothing is recorded */
    mukca_capture_advice advice;
    mukca_labels placements, sockets;
    int refused;                   /* samples */
    mukca_capture_sample last;     /* the last sample; n = 0: none, or deleted */
    bool beyond[MUKCA_MAX_JOINTS]; /* a joint was reported beyond its limits */
    int unwritten;                 /* samples and answers lost for lack of disk space or memory */
    mukca_error first_unwritten;
} mukca_sampling;

/* A request for a sample; labels NULL or "" mean the current ones. */
typedef struct {
    int64_t id;
    int64_t time; /* us, its arrival; 0: it came in order with the joint states */
    int64_t sent; /* us, by its sender's clock; 0: unknown */
    const char *placement, *socket;
} mukca_sample_request;

typedef struct mukca_recorder mukca_recorder;

/* Initialise labels and capture; theta as for mukca_recorder_open. */
mukca_status mukca_sampling_prepare(mukca_recorder *r, const double *theta, mukca_error *error);

/* Create or resume the session file; its samples are loaded into the capture.  Errors: MUKCA_INPUT
 * (exists without `force`; see mukca_session_resume), MUKCA_MEMORY. */
mukca_status mukca_sampling_begin(mukca_recorder *r, const char *path, bool resume, bool force,
                                  mukca_error *error);

/* Requests of the user; answer->text is the reply, also on success.  mukca_sampling_sample returns
 * after the sample is on disk, and sends a sample message in any case.  The others delete sample
 * `row` (from 1; 0: the last), move the last sample to the socket that its remark offered, select a
 * socket, the next socket, or the first socket of a new placement.  Errors:
 * MUKCA_NEGATIVE (refused), MUKCA_INPUT (disk). */
mukca_status mukca_sampling_sample(mukca_recorder *r, const mukca_sample_request *request,
                                   mukca_error *answer);
mukca_status mukca_sampling_delete(mukca_recorder *r, int row, mukca_error *answer);
mukca_status mukca_sampling_move(mukca_recorder *r, mukca_error *answer);
mukca_status mukca_sampling_select(mukca_recorder *r, const char *placement, const char *socket,
                                   mukca_error *answer);
mukca_status mukca_sampling_next_socket(mukca_recorder *r, mukca_error *answer);
mukca_status mukca_sampling_next_placement(mukca_recorder *r, mukca_error *answer);

/* Reply to a trigger that is refused before decoding. */
void mukca_sampling_refuse(mukca_recorder *r, int64_t id, const char *text);

/* Count a failure with status MUKCA_MEMORY, for the exit code. */
void mukca_sampling_count_unwritten(mukca_recorder *r, const mukca_error *error);

/* State of the stream: "no_stream", "moving" or "still"; and send it, or another `state` unless
 * NULL, as a status message. */
const char *mukca_sampling_state(const mukca_recorder *r);
void mukca_sampling_publish_status(mukca_recorder *r, const char *state);

#endif
