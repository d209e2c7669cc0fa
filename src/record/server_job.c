/* The server's calibrations and diagnoses: the program's own commands in a child process.  Results
 * are identical to those of the commands, and the stream never waits. */
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "record/server.h"

extern char **environ;

/* As of nice(1): about a tenth of the processor under competition. */
static const int job_niceness = 10;

static mukca_status spawn(mukca_server *s, const char *const *arguments, mukca_error *error)
{
    posix_spawn_file_actions_t files;
    int reason = posix_spawn_file_actions_init(&files);
    if (reason) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, s->job.errors,
                                     O_WRONLY | O_CREAT | O_TRUNC, 0666);
    /* posix_spawn declares argv without const */
    reason = posix_spawn(&s->job.child, "/proc/self/exe", &files, NULL,
                         (char *const *)(uintptr_t)arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    if (!reason) { /* recording has priority */
        (void)setpriority(PRIO_PROCESS, (id_t)s->job.child, job_niceness);
        return MUKCA_OK;
    }
    s->job.child = 0;
    return mukca_fail(error, MUKCA_INPUT, "cannot start a calculation: %s", strerror(reason));
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

/* Summarise the command's JSON in one line for the user. */
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

static void read_error(char line[MUKCA_RECORDER_LINE], const mukca_server *s)
{
    char *text;
    mukca_error error;
    (void)mukca_file_read(&text, s->job.errors, &error);
    snprintf(line, MUKCA_RECORDER_LINE, "the calculation failed without a message");
    for (char *at = text ? strtok(text, "\n") : NULL; at; at = strtok(NULL, "\n"))
        snprintf(line, MUKCA_RECORDER_LINE, "%.300s", at);
    free(text);
    unlink(s->job.errors);
}

void mukca_server_answer(mukca_server *s, const mukca_offsets *table)
{
    mukca_message_result *m = &s->result;
    const mukca_chain *chain = s->recorder.chain;
    const int n = table ? mukca_offsets_rows(s->rows, table, chain) : 0;
    m->utime = mukca_lcm_link_clock(&s->recorder.link);
    m->robot = chain->robot;
    m->urdf_sha256 = chain->urdf_sha256;
    m->base = chain->base;
    m->tip = chain->tip;
    m->stream =
        table == &s->pose.offsets ? s->state.model_stream : mukca_recorder_stream(&s->recorder);
    m->n = n < MUKCA_MESSAGE_ROWS ? n : MUKCA_MESSAGE_ROWS;
    for (int i = 0; i < m->n; i++) {
        const mukca_offset_row *row = &s->rows[i];
        m->joint[i] = row->joint;
        m->parameter[i] = row->parameter;
        m->unit[i] = row->unit;
        m->nominal[i] = row->nominal;
        m->calibrated[i] = row->calibrated;
        m->offset[i] = row->offset;
        m->sigma[i] = row->sigma;
        m->identifiable[i] = row->identifiable;
    }
    (void)mukca_recorder_publish(&s->recorder, MUKCA_MESSAGE_RESULT, m);
}

static void add_verdict(char line[MUKCA_RECORDER_LINE], const mukca_acceptance *a)
{
    mukca_text text = {.at = line, .size = MUKCA_RECORDER_LINE, .used = strlen(line)};
    mukca_text_put(&text, "; ");
    mukca_acceptance_put_brief(&text, a);
    if (a->accepted) mukca_text_put(&text, "; `use` puts it into use");
}

static void report(mukca_server *s, mukca_status code)
{
    char line[MUKCA_RECORDER_LINE], *json = NULL;
    mukca_error error;
    const mukca_offsets *table = NULL;
    read_error(line, s);
    if (code == MUKCA_OK || code == MUKCA_NEGATIVE) {
        (void)mukca_file_read(&json, s->job.json, &error);
        if (json) summarise(line, s, json);
        const mukca_status kept = mukca_server_keep_result(s, &error);
        if (kept == MUKCA_OK) {
            table = &s->candidate;
            add_verdict(line, &s->candidate.acceptance);
        } else {
            snprintf(line, sizeof line, "%s", error.text);
            code = kept;
        }
    }
    if (code == MUKCA_MEMORY) {
        mukca_fail(&error, MUKCA_MEMORY, "%.200s", line);
        mukca_sampling_count_unwritten(&s->recorder, &error);
    }
    s->result = (mukca_message_result){
        .id = s->job.id, .verb = s->job.verb, .text = line, .code = (int)code, .json = json};
    mukca_server_answer(s, table);
    mukca_recorder_report(&s->recorder, "%s: %s", s->job.verb, line);
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
    job->verb = diagnosis ? "diagnose" : "calibrate";
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, session, ".tsv");
    mukca_server_path(job->offsets, s, MUKCA_SERVER_RESULTS, session,
                      diagnosis ? ".effects.tsv" : ".offsets.tsv");
    mukca_server_path(job->json, s, MUKCA_SERVER_RESULTS, session,
                      diagnosis ? ".diagnose.json" : ".calibrate.json");
    mukca_server_path(job->errors, s, MUKCA_SERVER_RESULTS, session, ".errors.txt");
    const char *const last[] = {"-o",      job->offsets, "--json", job->json,
                                "--force", "-q",         "--",     path};
    const char *arguments[MUKCA_SERVER_ARGUMENTS + 12] = {"mukca", job->verb};
    int n = 2;
    for (int i = 0; s->options->arguments[i]; i++) arguments[n++] = s->options->arguments[i];
    memcpy(arguments + n, last, sizeof last); /* the remaining elements are NULL */
    const mukca_status status = spawn(s, arguments, error);
    if (status == MUKCA_OK && s->recorder.link.replays) mukca_server_finish_job(s, true);
    return status;
}

void mukca_server_kill_job(mukca_server *s)
{
    if (!s->job.child) return;
    kill(s->job.child, SIGTERM);
    waitpid(s->job.child, NULL, 0);
    s->job.child = 0;
}
