/* The server's calibrations and diagnoses: the program's own commands in a child process.  The
 * result is theirs to the last digit, and the stream never waits. */
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "record/server.h"

extern char **environ;

enum { MAX_JSON = 1 << 24 /* bytes; that of seven joints takes some 100 kB */ };

static const char *verb_of(const mukca_server_job *job)
{
    return job->diagnosis ? "diagnose" : "calibrate";
}

static mukca_status spawn(mukca_server *s, const char *const *arguments, mukca_error *error)
{
    posix_spawn_file_actions_t files;
    int reason = posix_spawn_file_actions_init(&files);
    if (reason) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, s->job.errors,
                                     O_WRONLY | O_CREAT | O_TRUNC, 0666);
    /* posix_spawn's type of argv is older than const */
    reason = posix_spawn(&s->job.child, "/proc/self/exe", &files, NULL,
                         (char *const *)(uintptr_t)arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    if (!reason) return MUKCA_OK;
    s->job.child = 0;
    return mukca_fail(error, MUKCA_INPUT, "cannot start a calculation: %s", strerror(reason));
}

mukca_status mukca_server_start_job(mukca_server *s, bool diagnosis, int64_t id, mukca_error *error)
{
    mukca_server_job *job = &s->job;
    const char *session = s->state.session;
    char path[MUKCA_SERVER_PATH];
    if (job->child)
        return mukca_fail(error, MUKCA_NEGATIVE, "a %s is running: wait for its result",
                          job->diagnosis ? "diagnosis" : "calibration");
    if (!session[0]) return mukca_fail(error, MUKCA_NEGATIVE, "there is no session: start one");
    job->id = id;
    job->diagnosis = diagnosis;
    mukca_server_path(path, s, session, ".tsv");
    mukca_server_path(job->offsets, s, session, diagnosis ? ".effects.tsv" : ".offsets.tsv");
    mukca_server_path(job->json, s, session, diagnosis ? ".diagnose.json" : ".calibrate.json");
    mukca_server_path(job->errors, s, session, ".errors.txt");
    const char *const last[] = {"-o",      job->offsets, "--json", job->json,
                                "--force", "-q",         "--",     path};
    const char *arguments[MUKCA_SERVER_ARGUMENTS + 12] = {"mukca", verb_of(job)};
    int n = 2;
    for (int i = 0; s->options->arguments[i]; i++) arguments[n++] = s->options->arguments[i];
    memcpy(arguments + n, last, sizeof last); /* the rest is NULL */
    return spawn(s, arguments, error);
}

/* A whole text file; NULL where there is none.  Free it. */
static char *read_text(const char *path)
{
    FILE *file = fopen(path, "r");
    if (!file) return NULL;
    char *text = malloc(MAX_JSON + 1);
    size_t n = text ? fread(text, 1, MAX_JSON, file) : 0;
    fclose(file);
    if (text) text[n] = '\0';
    return text;
}

static double mean_error(const json_t *train, const char *key)
{
    double sum = 0;
    size_t i, n = json_array_size(train);
    const json_t *placement;
    json_array_foreach(train, i, placement) sum +=
        json_number_value(json_object_get(placement, key));
    return n ? sum / (double)n : (double)NAN;
}

/* One line for people from the JSON of the command. */
static void summarise(char line[MUKCA_RECORDER_LINE], const mukca_server *s, const char *text)
{
    json_t *root = text ? json_loads(text, 0, NULL) : NULL;
    const json_t *train = json_object_get(root, "train"), *causes = json_object_get(root, "causes");
    const char *verdict = json_string_value(json_object_get(root, "verdict"));
    if (s->job.diagnosis && verdict) {
        const json_t *first = json_array_get(causes, 0);
        const char *effect = json_string_value(json_object_get(first, "effect"));
        const char *joint = json_string_value(json_object_get(first, "joint"));
        snprintf(line, MUKCA_RECORDER_LINE, "verdict %s%s%s%s%s", verdict, effect ? ": " : "",
                 effect ? effect : "", joint ? " of " : "", joint ? joint : "");
    } else {
        snprintf(line, MUKCA_RECORDER_LINE, "mean error %.3f mm nominal, %.3f mm calibrated",
                 1e3 * mean_error(train, "mae_nominal_m"), 1e3 * mean_error(train, "mae_m"));
    }
    json_decref(root);
}

/* The last line of the command's standard error. */
static void read_error(char line[MUKCA_RECORDER_LINE], const mukca_server *s)
{
    char *text = read_text(s->job.errors);
    snprintf(line, MUKCA_RECORDER_LINE, "the calculation failed without a message");
    for (char *at = text; at && *at;) {
        char *end = at + strcspn(at, "\n");
        bool last = *end == '\0' || end[1] == '\0';
        *end = '\0';
        if (*at) snprintf(line, MUKCA_RECORDER_LINE, "%.300s", at);
        at = last ? NULL : end + 1;
    }
    free(text);
    unlink(s->job.errors);
}

void mukca_server_send_answer(mukca_server *s, const mukca_server_answer *answer)
{
    mukca_message_result *m = &s->result;
    const mukca_chain *chain = s->recorder.chain;
    int n = answer->table ? mukca_offsets_rows(s->rows, answer->table, chain) : 0;
    memset(m, 0, sizeof *m);
    m->utime = mukca_lcm_link_clock(s->recorder.link);
    m->id = answer->id;
    m->verb = answer->verb;
    m->code = (int)answer->code;
    m->text = answer->text;
    m->robot = chain->robot;
    m->urdf_sha256 = chain->urdf_sha256;
    m->base = chain->base;
    m->tip = chain->tip;
    m->stream = answer->table ? s->state.model_stream : mukca_recorder_stream(&s->recorder);
    m->n = n < MUKCA_MESSAGE_ROWS ? n : MUKCA_MESSAGE_ROWS;
    for (int i = 0; i < m->n; i++) {
        m->joint[i] = s->rows[i].joint;
        m->parameter[i] = s->rows[i].parameter;
        m->unit[i] = s->rows[i].unit;
        m->nominal[i] = s->rows[i].nominal;
        m->calibrated[i] = s->rows[i].calibrated;
        m->offset[i] = s->rows[i].offset;
        m->sigma[i] = s->rows[i].sigma;
        m->identifiable[i] = s->rows[i].identifiable;
    }
    m->json = answer->json;
    (void)mukca_recorder_publish(&s->recorder, MUKCA_MESSAGE_RESULT, m);
}

static void report(mukca_server *s, mukca_status code)
{
    char line[MUKCA_RECORDER_LINE];
    mukca_error error;
    mukca_offsets *table = NULL;
    bool done = code == MUKCA_OK || code == MUKCA_NEGATIVE;
    char *json = done ? read_text(s->job.json) : NULL;
    read_error(line, s);
    if (json) summarise(line, s, json);
    if (done) {
        const char *name = strrchr(s->job.offsets, '/') + 1;
        mukca_server_state before = s->state;
        snprintf(s->state.model, sizeof s->state.model, "%s", name);
        snprintf(s->state.model_stream, sizeof s->state.model_stream, "%s",
                 mukca_recorder_stream(&s->recorder));
        mukca_status status = mukca_server_load_model(s, &error);
        if (status == MUKCA_OK) status = mukca_server_save_state(s, &error);
        if (status) {
            s->state = before;
            snprintf(line, sizeof line, "%s", error.text);
            code = status;
        } else {
            table = &s->pose.offsets;
        }
    }
    mukca_server_answer answer = {.id = s->job.id,
                                  .verb = verb_of(&s->job),
                                  .text = line,
                                  .json = json,
                                  .code = code,
                                  .table = table};
    mukca_server_send_answer(s, &answer);
    mukca_recorder_report(&s->recorder, "%s: %s", answer.verb, line);
    free(json);
}

void mukca_server_finish_job(mukca_server *s, bool wait)
{
    int status;
    if (!s->job.child) return;
    pid_t ended = waitpid(s->job.child, &status, wait ? 0 : WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return;
    s->job.child = 0;
    report(s, ended > 0 && WIFEXITED(status) ? (mukca_status)WEXITSTATUS(status) : MUKCA_INPUT);
}

void mukca_server_kill_job(mukca_server *s)
{
    if (!s->job.child) return;
    kill(s->job.child, SIGTERM);
    waitpid(s->job.child, NULL, 0);
    s->job.child = 0;
}
