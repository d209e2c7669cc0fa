/* The parts of `mukca serve`: its state on disk, jobs in child processes, poses. */
#ifndef MUKCA_CLI_SERVE_H
#define MUKCA_CLI_SERVE_H

#include <sys/types.h>

#include "record/recorder.h"

enum {
    SERVE_PATH = 1024,
    SERVE_BUCKETS = 512, /* of the latencies' histogram: 2 % wide each, from 0.1 us on */
    SERVE_POSE_SIZE = 128
};

typedef struct {
    cli_common common;
    recorder_options recorder;
    const char *state;
    bool publish_pose;
} serve_options;

/* What `mukca send` may send, ended by NULL. */
extern const char *const serve_verbs[];

/* What survives a restart. */
typedef struct {
    char session[MUKCA_NAME_SIZE]; /* name, without ending; empty: none */
    char placement[MUKCA_NAME_SIZE], socket[MUKCA_NAME_SIZE]; /* current ... */
    char rows[16];                    /* ... when the session had so many rows */
    char model[MUKCA_NAME_SIZE + 16]; /* file of the offsets table in use; empty: none */
    char model_stream[16];            /* what its rows were recorded from */
} serve_memory;

/* A calibration or diagnosis that runs in a child process. */
typedef struct {
    pid_t child; /* 0: none */
    int64_t id;  /* of the command */
    bool diagnosis;
    char session[MUKCA_NAME_SIZE];
    char offsets[SERVE_PATH], json[SERVE_PATH], errors[SERVE_PATH];
} serve_job;

/* Poses: all memory is here, so that a message costs no allocation. */
typedef struct {
    bool ready; /* a table is loaded */
    mukca_offsets offsets;
    mukca_geometry geometry;
    mukca_row_state states; /* of the stream */
    char channel[64];
    unsigned char buffer[SERVE_POSE_SIZE];
    int64_t sent;
    int64_t histogram[SERVE_BUCKETS]; /* of s from reception to having been sent */
} serve_pose;

typedef struct {
    recorder engine; /* first: hooks get the server */
    cli_call *call;
    const serve_options *options;
    cli_model model;
    const char *folder;
    serve_memory memory, saved;
    bool session_begun;
    serve_job job;
    serve_pose pose;
    mukca_message_result result; /* scratch */
    mukca_offset_row rows[MUKCA_MAX_OFFSET_ROWS];
    double published; /* s */
} server;

/* ---- state (serve_state.c) ---- */

/* "FOLDER/NAMEending" */
void serve_path(char path[SERVE_PATH], const server *s, const char *name, const char *ending);

/* Whether a session may be called so: letters, digits, _ - and . but not first; at most 40. */
bool serve_name_ok(const char *name);

/* Read the state; a folder without one is new.  Errors: MUKCA_INPUT. */
mukca_status serve_remember(server *s);

/* Write it, whole or not at all, if it has changed.  Errors: MUKCA_INPUT. */
mukca_status serve_save(server *s, mukca_error *error);

/* Tell the service manager ("READY=1"); nothing without one. */
void serve_notify(const char *text);

/* ---- jobs (serve_job.c) ---- */

/* Start calibrate or diagnose on the session; answered when it ends.  Errors: MUKCA_NEGATIVE (one
 * runs, no session), MUKCA_INPUT. */
mukca_status serve_start_job(server *s, bool diagnosis, int64_t id, mukca_error *error);

/* Look whether it has ended (or wait for it), and then send the result. */
void serve_finish_job(server *s, bool wait);
void serve_kill_job(server *s);

/* Send the result of a command; `table` (may be NULL) adds its rows, `json` (may be NULL) the text.
 */
void serve_answer(server *s, int64_t id, const char *verb, mukca_status code, const char *text,
                  const mukca_offsets *table, const char *json);

/* ---- poses (serve_pose.c) ---- */

/* Use the table that the memory names.  Errors: MUKCA_INPUT; of another kind of stream. */
mukca_status serve_load_model(server *s, mukca_error *error);

/* A recorder hook: the pose of one joint state. */
void serve_send_pose(void *server, int64_t time_us, const double *q);

/* Latency at or below which the share p of all poses was sent, s; NaN without any. */
double serve_latency(const serve_pose *pose, double p);

#endif
