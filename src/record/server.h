/* The daemon of `mukca serve`: records, calibrates and diagnoses on commands over LCM.  Its parts:
 * state on disk, jobs in child processes, poses. */
#ifndef MUKCA_RECORD_SERVER_H
#define MUKCA_RECORD_SERVER_H

#include <sys/types.h>

#include "io/offsets.h"
#include "mukca/row_state.h"
#include "record/recorder.h"

enum { MUKCA_SERVER_PATH = 1024, MUKCA_SERVER_ARGUMENTS = 32 };

/* Commands: verb, usage, largest number of arguments, description */
#define MUKCA_SERVER_VERB_LIST(X)                                                             \
    X(start, " [NAME]", 1, "begin or resume the session NAME")                                \
    X(add, " [PLACEMENT [SOCKET]]", 2, "record a sample now")                                 \
    X(delete, "", 0, "delete the last sample")                                                \
    X(socket, " [LABEL]", 1, "select a socket of this placement; the next one without LABEL") \
    X(placement, " [NAME]", 1, "select a placement; a new one without NAME")                  \
    X(finish, "", 0, "close the session")                                                     \
    X(calibrate, "", 0, "calibrate on the session; the result contains the offsets table")    \
    X(diagnose, "", 0, "diagnose the session; the result adds the effects found")             \
    X(use, " [SESSION]", 1, "use the last result (of SESSION) for poses, if it is plausible") \
    X(result, "", 0, "send the offsets table in use")

/* Default rights of --accept.  Commands that remove data or change the model in use must be listed:
 * delete, use, and reopen (`start` of a session other than the current one). */
#define MUKCA_SERVER_ACCEPT "start,add,trigger,socket,placement,finish,calibrate,diagnose,result"

/* Names of the verbs, and status, ended by NULL. */
extern const char *const mukca_server_verbs[];

typedef struct {
    mukca_recorder_options recorder;
    const char *folder; /* of sessions, results and state */
    bool publish_pose;
    double most_change; /* largest change of the tip by `use` relative to the table in use, m */
    const char *accept; /* comma-separated verbs, trigger and reopen; "all"; NULL: the default */
    /* model options for calibrate and diagnose, as on the command line; ended by NULL */
    const char *arguments[MUKCA_SERVER_ARGUMENTS];
} mukca_server_options;

/* State that survives a restart, as texts; "": none.  Name, size, check of those that become paths
 * (labels are checked when they are selected). */
#define MUKCA_SERVER_STATE_LIST(X)                                                       \
    X(session, MUKCA_NAME_SIZE, mukca_server_name_ok) /* without ending */               \
    X(placement, MUKCA_NAME_SIZE, NULL)               /* current label */                \
    X(socket, MUKCA_NAME_SIZE, NULL)                                                     \
    X(rows, 16, NULL)    /* number of samples in the session when they were saved */     \
    X(finished, 2, NULL) /* not "": the session accepts no more samples */               \
    X(model, MUKCA_NAME_SIZE + 16, is_result)     /* file of the offsets table in use */ \
    X(model_stream, 16, NULL)                     /* kind of stream of its samples */    \
    X(candidate, MUKCA_NAME_SIZE + 16, is_result) /* last result, the input of `use` */  \
    X(candidate_stream, 16, NULL)

typedef struct {
#define MUKCA_SERVER_FIELD(name, size, ok) char name[size];
    MUKCA_SERVER_STATE_LIST(MUKCA_SERVER_FIELD)
#undef MUKCA_SERVER_FIELD
} mukca_server_state;

/* A calibration or diagnosis in a child process. */
typedef struct {
    pid_t child; /* 0: no job */
    int64_t id;  /* of the command */
    bool diagnosis;
    const char *verb; /* "diagnose", else "calibrate" */
    char offsets[MUKCA_SERVER_PATH], json[MUKCA_SERVER_PATH], errors[MUKCA_SERVER_PATH];
} mukca_server_job;

/* Poses; all memory is here, and a message needs no allocation. */
typedef struct {
    bool ready; /* a table is loaded */
    mukca_offsets offsets;
    mukca_geometry geometry;
    mukca_row_state states; /* of the stream */
    int64_t sent;
} mukca_server_pose;

/* The sender that may change the open session. */
typedef struct {
    uint32_t address; /* IPv4 */
    int64_t heard;    /* us, its last request; 0: no controller yet */
} mukca_server_controller;

typedef struct {
    mukca_recorder recorder;
    const mukca_server_options *options;
    mukca_server_state state, saved;
    unsigned rights; /* of --accept; all while a log is replayed */
    bool session_begun;
    bool locked;
    int lock;                  /* descriptor, if locked */
    mukca_budget new_sessions; /* that may still be started */
    mukca_server_controller controller;
    mukca_server_job job;
    mukca_server_pose pose;
    mukca_offsets candidate;     /* scratch */
    mukca_message_result result; /* the last answer */
    mukca_offset_row rows[MUKCA_MAX_OFFSET_ROWS];
} mukca_server;

/* Connect and read the state; theta as for mukca_recorder_open.  Hooks used: `report`, and
 * `interrupted`, which must not be NULL.  `s` is large: allocate it; close it after a failure, too.
 * Errors: as mukca_recorder_open; MUKCA_INPUT (the folder, a damaged state). */
mukca_status mukca_server_open(mukca_server *s, const mukca_server_options *options,
                               const mukca_chain *chain, const double *theta,
                               const mukca_recorder_hooks *hooks, mukca_error *error);

/* Serve until hooks.interrupted, or to the end of a log.  Errors: MUKCA_TRANSPORT; for a log
 * MUKCA_INPUT. */
mukca_status mukca_server_run(mukca_server *s, mukca_error *error);
void mukca_server_close(mukca_server *s);

/* ---- parts (server_folder.c, server_use.c, server_job.c) ---- */

/* Folders of --state: separate, so that session names cannot collide with other files. */
#define MUKCA_SERVER_SESSIONS "sessions"
#define MUKCA_SERVER_RESULTS "results"

/* "DIR/folder/NAMEending"; folder "": "DIR/NAMEending" */
void mukca_server_path(char path[MUKCA_SERVER_PATH], const mukca_server *s, const char *folder,
                       const char *name, const char *ending);

/* Create the folder, lock it until mukca_server_close, and remove temporary files of killed
 * writers.  Errors: MUKCA_INPUT (also: locked by another server). */
mukca_status mukca_server_open_folder(mukca_server *s, mukca_error *error);

/* Whether a name is valid for a session: at most 40 letters, digits, _ - and ., the last two not
 * first. */
bool mukca_server_name_ok(const char *name);

/* The session of a result's file name, NAME.offsets.tsv or NAME.effects.tsv; false: another name.
 */
bool mukca_server_session_of(char session[MUKCA_NAME_SIZE], const char *result);

/* Read the state; a folder without one is new.  Errors: MUKCA_INPUT. */
mukca_status mukca_server_load_state(mukca_server *s, mukca_error *error);

/* Write the state atomically if it has changed.  Errors: MUKCA_INPUT. */
mukca_status mukca_server_save_state(mukca_server *s, mukca_error *error);

/* Notify the service manager ("READY=1"), if there is one. */
void mukca_server_notify(const char *text);

/* Load the table in use.  Errors: MUKCA_INPUT (also: of another kind of stream, not accepted,
 * without a verdict). */
mukca_status mukca_server_load_model(mukca_server *s, mukca_error *error);

/* Read the table written by a job, accepted or not, into s->candidate, for `use`.  Errors:
 * MUKCA_INPUT. */
mukca_status mukca_server_keep_result(mukca_server *s, mukca_error *error);

/* Put the last result into use, if it is of `session` (NULL: any).  Conditions: acceptance, size,
 * error on the same samples and change relative to the table in use.  `error` has the reply.
 * Errors: MUKCA_NEGATIVE, MUKCA_INPUT. */
mukca_status mukca_server_use(mukca_server *s, const char *session, mukca_error *error);

/* A recorder hook: send the pose of one joint state. */
void mukca_server_send_pose(void *server, int64_t time_us, const double *q);

/* Complete s->result, which has id, verb, text, code and JSON of an answer, and send it; `table`
 * (may be NULL) adds its rows. */
void mukca_server_answer(mukca_server *s, const mukca_offsets *table);

/* Start calibrate or diagnose on the session; the reply follows at its end, which is waited for
 * while a log is replayed.  Errors: MUKCA_NEGATIVE (a job is running, no session), MUKCA_INPUT. */
mukca_status mukca_server_start_job(mukca_server *s, bool diagnosis, int64_t id,
                                    mukca_error *error);

/* Send the result of a job if it has ended; with `wait`, wait for its end. */
void mukca_server_finish_job(mukca_server *s, bool wait);
void mukca_server_kill_job(mukca_server *s);

#endif
