/* Calibrations and diagnoses of `mukca serve`: the program's own commands in a child process, so
 * that the result is theirs to the last digit and the stream never waits. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli/serve.h"

extern char **environ;

enum { MAX_ARGUMENTS = 40, MAX_JSON = 1 << 24 };

static void option(const char **arguments, int *n, const char *name, const char *value)
{
    if (!value) return;
    arguments[(*n)++] = name;
    arguments[(*n)++] = value;
}

static mukca_status spawn(server *s, const char *const *arguments, mukca_error *error)
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

mukca_status serve_start_job(server *s, bool diagnosis, int64_t id, mukca_error *error)
{
    const cli_common *c = s->call->common;
    const char *arguments[MAX_ARGUMENTS] = {"mukca", diagnosis ? "diagnose" : "calibrate"};
    char path[SERVE_PATH], distance[32], gravity[96];
    serve_job *job = &s->job;
    int n = 2;
    if (job->child)
        return mukca_fail(error, MUKCA_NEGATIVE, "a %s is running: wait for its result",
                          job->diagnosis ? "diagnosis" : "calibration");
    if (!s->memory.session[0])
        return mukca_fail(error, MUKCA_NEGATIVE, "there is no session: start one");
    job->id = id;
    job->diagnosis = diagnosis;
    memcpy(job->session, s->memory.session, sizeof job->session);
    serve_path(path, s, job->session, ".tsv");
    serve_path(job->offsets, s, job->session, diagnosis ? ".effects.tsv" : ".offsets.tsv");
    serve_path(job->json, s, job->session, diagnosis ? ".diagnose.json" : ".calibrate.json");
    serve_path(job->errors, s, job->session, ".errors.txt");
    snprintf(distance, sizeof distance, "%.17g", c->distance);
    snprintf(gravity, sizeof gravity, "%.17g,%.17g,%.17g", c->gravity[0], c->gravity[1],
             c->gravity[2]);
    bool tilted = c->gravity[0] != 0 || c->gravity[1] != 0 || c->gravity[2] != 0;
    option(arguments, &n, "--urdf", c->urdf);
    option(arguments, &n, "--base", c->base);
    option(arguments, &n, "--tip", c->tip);
    option(arguments, &n, "--inertials", c->inertials);
    option(arguments, &n, "--distances", c->distances);
    option(arguments, &n, "--distance", c->distance > 0 ? distance : NULL);
    option(arguments, &n, "--gravity", tilted ? gravity : NULL);
    option(arguments, &n, "-o", job->offsets);
    option(arguments, &n, "--json", job->json);
    arguments[n++] = "--force";
    arguments[n++] = "-q";
    arguments[n++] = "--";
    arguments[n++] = path;
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

/* One line for people from the command's JSON. */
static void summarise(char line[RECORDER_LINE], const server *s, const char *text)
{
    json_t *root = text ? json_loads(text, 0, NULL) : NULL;
    const json_t *train = json_object_get(root, "train"), *causes = json_object_get(root, "causes");
    const char *verdict = json_string_value(json_object_get(root, "verdict"));
    if (s->job.diagnosis && verdict) {
        const json_t *first = json_array_get(causes, 0);
        const char *effect = json_string_value(json_object_get(first, "effect"));
        const char *joint = json_string_value(json_object_get(first, "joint"));
        snprintf(line, RECORDER_LINE, "verdict %s%s%s%s%s", verdict, effect ? ": " : "",
                 effect ? effect : "", joint ? " of " : "", joint ? joint : "");
    } else {
        snprintf(line, RECORDER_LINE, "mean error %.3f mm nominal, %.3f mm calibrated",
                 1e3 * mean_error(train, "mae_nominal_m"), 1e3 * mean_error(train, "mae_m"));
    }
    json_decref(root);
}

/* What the command said on standard error: its last line, without its name. */
static void last_words(char line[RECORDER_LINE], const server *s)
{
    char *text = read_text(s->job.errors);
    snprintf(line, RECORDER_LINE, "the calculation failed without a word");
    for (char *at = text; at && *at;) {
        char *end = at + strcspn(at, "\n");
        bool last = *end == '\0' || end[1] == '\0';
        *end = '\0';
        if (*at) snprintf(line, RECORDER_LINE, "%.300s", at);
        at = last ? NULL : end + 1;
    }
    free(text);
    unlink(s->job.errors);
}

static void report(server *s, mukca_status code)
{
    char line[RECORDER_LINE];
    mukca_error error;
    mukca_offsets *table = NULL;
    bool done = code == MUKCA_OK || code == MUKCA_NEGATIVE;
    char *json = done ? read_text(s->job.json) : NULL;
    last_words(line, s);
    if (json) summarise(line, s, json);
    if (done) {
        const char *name = strrchr(s->job.offsets, '/') + 1;
        serve_memory before = s->memory;
        snprintf(s->memory.model, sizeof s->memory.model, "%s", name);
        snprintf(s->memory.model_stream, sizeof s->memory.model_stream, "%s",
                 recorder_stream_name(&s->engine));
        mukca_status status = serve_load_model(s, &error);
        if (!status) status = serve_save(s, &error);
        if (status) {
            s->memory = before;
            snprintf(line, sizeof line, "%s", error.text);
            code = status;
        } else {
            table = &s->pose.offsets;
        }
    }
    const char *verb = s->job.diagnosis ? "diagnose" : "calibrate";
    serve_answer(s, s->job.id, verb, code, line, table, json);
    recorder_say(&s->engine, "%s: %s", verb, line);
    free(json);
}

void serve_finish_job(server *s, bool wait)
{
    int status;
    if (!s->job.child) return;
    pid_t ended = waitpid(s->job.child, &status, wait ? 0 : WNOHANG);
    if (ended == 0 || (ended < 0 && errno == EINTR)) return;
    s->job.child = 0;
    report(s, ended > 0 && WIFEXITED(status) ? (mukca_status)WEXITSTATUS(status) : MUKCA_INPUT);
}

void serve_kill_job(server *s)
{
    if (!s->job.child) return;
    kill(s->job.child, SIGTERM);
    waitpid(s->job.child, NULL, 0);
    s->job.child = 0;
}

void serve_answer(server *s, int64_t id, const char *verb, mukca_status code, const char *text,
                  const mukca_offsets *table, const char *json)
{
    mukca_message_result *m = &s->result;
    const mukca_chain *chain = &s->model.chain;
    int n = table ? mukca_offsets_rows(s->rows, table, chain) : 0;
    memset(m, 0, sizeof *m);
    m->utime = mukca_lcm_link_clock(s->engine.link);
    m->id = id;
    m->verb = verb;
    m->code = (int)code;
    m->text = text;
    m->robot = chain->robot;
    m->urdf_sha256 = chain->urdf_sha256;
    m->base = chain->base;
    m->tip = chain->tip;
    m->stream = table ? s->memory.model_stream : recorder_stream_name(&s->engine);
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
    m->json = json;
    recorder_publish(&s->engine, MUKCA_MESSAGE_RESULT, m);
}
