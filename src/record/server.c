/* The server: rights and limits of its clients, LCM commands, the main loop. */
#include "record/server.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"

/* ---- rights and limits ---- */

/* Our choice: a person starts few sessions; a sample takes some 500 bytes. */
static const double first_sessions = 10, sessions_per_s = 0.1, free_bytes = 16e6;

/* Our choice, s: longer than a usual pause between two samples. */
static const double longest_silence = 300;

#define VERB_NAME(name, usage, arguments, sentence) #name,
#define VERB_INDEX(name, usage, arguments, sentence) RIGHT_##name,
enum { MUKCA_SERVER_VERB_LIST(VERB_INDEX) STATUS, TRIGGER, REOPEN };
static const char *const rights[] = {MUKCA_SERVER_VERB_LIST(VERB_NAME) "status", "trigger",
                                     "reopen"};
const char *const mukca_server_verbs[] = {MUKCA_SERVER_VERB_LIST(VERB_NAME) "status", NULL};

#define VERB_ARGUMENTS(name, usage, arguments, sentence) arguments,
static const int most_arguments[] = {MUKCA_SERVER_VERB_LIST(VERB_ARGUMENTS)};

/* Read --accept: bit k for rights[k]. */
static mukca_status read_rights(mukca_server *s, mukca_error *error)
{
    const char *list = s->options->accept ? s->options->accept : MUKCA_SERVER_ACCEPT;
    char word[48];
    while (mukca_text_item(word, sizeof word, &list)) {
        unsigned found = strcmp(word, "all") == 0 ? ~0u : 0;
        for (int k = 0; k <= REOPEN; k++)
            if (strcmp(word, rights[k]) == 0) found = 1u << k;
        if (!found)
            return mukca_fail(
                error, MUKCA_USAGE,
                "--accept: %s is no command; delete, use, reopen and all are possible "
                "besides " MUKCA_SERVER_ACCEPT,
                word);
        s->rights |= found;
    }
    return MUKCA_OK;
}

/* Whether the packet's sender may change the open session, and becomes its controller: the sender
 * that started it, or any sender once it is finished or its controller has been silent for long. */
static mukca_status control(mukca_server *s, const mukca_lcm_packet *packet, mukca_error *error)
{
    mukca_server_controller *c = &s->controller;
    const uint32_t address = (uint32_t)(packet->sender >> 16); /* ports differ by client */
    const double silence = 1e-6 * (double)(packet->time - c->heard);
    if (!packet->sender) return MUKCA_OK;
    if (s->recorder.session.file.open && c->heard && c->address != address && silence >= 0 &&
        silence < longest_silence)
        return mukca_fail(
            error, MUKCA_NEGATIVE,
            "session %s is controlled from %u.%u.%u.%u: wait until it is finished, or "
            "for %.0f s without a request from there",
            s->state.session, c->address >> 24, c->address >> 16 & 255, c->address >> 8 & 255,
            c->address & 255, longest_silence);
    *c = (mukca_server_controller){address, packet->time};
    return MUKCA_OK;
}

/* Whether `start` may open the session of that name. */
static mukca_status may_start(mukca_server *s, const char *name, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH];
    struct statvfs disk;
    bool current = strcmp(name, s->state.session) == 0 && !s->state.finished[0];
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, name, ".tsv");
    if (current || s->recorder.link.replays) return MUKCA_OK;
    if (access(path, F_OK) == 0) {
        if (s->rights >> REOPEN & 1u) return MUKCA_OK;
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "%s is finished; choose another name, or start serve with --accept "
                          "naming reopen",
                          name);
    }
    if (statvfs(s->options->folder, &disk) == 0 &&
        (double)disk.f_bavail * (double)disk.f_frsize < free_bytes)
        return mukca_fail(error, MUKCA_NEGATIVE, "less than 16 MB are free in %.200s",
                          s->options->folder);
    if (!mukca_budget_take(&s->new_sessions, mukca_lcm_link_clock(&s->recorder.link),
                           sessions_per_s, first_sessions, first_sessions))
        return mukca_fail(error, MUKCA_NEGATIVE, "too many new sessions: wait 10 s");
    return MUKCA_OK;
}

/* ---- commands ---- */

/* Store the current placement and socket for a restart. */
static void keep_place(mukca_server *s)
{
    mukca_server_state *state = &s->state;
    const mukca_recorder *r = &s->recorder;
    if (!r->session.file.open) return;
    snprintf(state->placement, sizeof state->placement, "%s",
             mukca_capture_placement(&r->session.capture));
    snprintf(state->socket, sizeof state->socket, "%s", mukca_capture_socket(&r->session.capture));
    snprintf(state->rows, sizeof state->rows, "%d", r->session.file.n_rows);
}

/* Start or resume the session named by the state, once the stream is known; reports by itself. */
static mukca_status begin(mukca_server *s, mukca_error *answer)
{
    char path[MUKCA_SERVER_PATH];
    mukca_recorder *r = &s->recorder;
    if (s->session_begun || !s->state.session[0] || s->state.finished[0] || !r->stream.connected)
        return MUKCA_OK;
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, s->state.session, ".tsv");
    s->session_begun = true;
    mukca_status status = mukca_sampling_begin(r, path, true, false, answer);
    if (status == MUKCA_OK) {
        /* if a sample was recorded after the last save, its labels are more recent */
        if (s->state.placement[0] && strtol(s->state.rows, NULL, 10) == r->session.file.n_rows)
            mukca_sampling_select(r, s->state.placement, s->state.socket, answer);
        keep_place(s);
        mukca_fail(answer, MUKCA_OK, "session %s: %d samples", path, r->session.file.n_rows);
    }
    mukca_recorder_report(r, "%s", answer->text);
    return status;
}

static mukca_status start(mukca_server *s, const char *name, mukca_error *answer)
{
    mukca_recorder *r = &s->recorder;
    mukca_error ignored;
    const mukca_server_state before = s->state;
    if (!mukca_server_name_ok(name))
        return mukca_fail(answer, MUKCA_USAGE,
                          "a session's name: at most 40 letters, digits, _ - and .");
    if (!r->stream.connected)
        return mukca_fail(
            answer, MUKCA_TRANSPORT, "no joint states yet: %.200s",
            r->stream.problem.status ? r->stream.problem.text : "is the robot's driver running?");
    MUKCA_TRY(may_start(s, name, answer));
    memset(&s->state, 0, offsetof(mukca_server_state, model));
    snprintf(s->state.session, sizeof s->state.session, "%s", name);
    s->session_begun = false;
    mukca_status status = begin(s, answer);
    keep_place(s);
    if (status == MUKCA_OK) status = mukca_server_save_state(s, answer);
    if (status != MUKCA_OK) { /* resume the previous session */
        s->state = before;
        s->session_begun = false;
        (void)begin(s, &ignored);
    }
    return status;
}

static mukca_status finish(mukca_server *s, mukca_error *answer)
{
    mukca_session *session = &s->recorder.session.file;
    if (!session->open) return mukca_fail(answer, MUKCA_NEGATIVE, "no session is being recorded");
    s->state.finished[0] = '1';
    mukca_status status = mukca_server_save_state(s, answer);
    if (status == MUKCA_OK) {
        if (session->n_rows)
            mukca_fail(answer, MUKCA_OK, "%d samples in %s", session->n_rows, session->path);
        else
            mukca_fail(answer, MUKCA_OK, "no sample was recorded");
        mukca_session_close(session);
    } else {
        s->state.finished[0] = '\0';
    }
    return status;
}

static mukca_status send_table(mukca_server *s, int64_t id, mukca_error *answer)
{
    char text[MUKCA_RECORDER_LINE];
    if (!s->pose.ready)
        return mukca_fail(answer, MUKCA_NEGATIVE, "no table is in use: calibrate, then use");
    snprintf(text, sizeof text, "the table in use: %s", s->state.model);
    s->result = (mukca_message_result){.id = id, .verb = "result", .text = text};
    mukca_server_answer(s, &s->pose.offsets);
    return MUKCA_OK;
}

static mukca_status execute(mukca_server *s, int verb, const mukca_message_command *command,
                            mukca_error *answer)
{
    mukca_recorder *r = &s->recorder;
    const char *first = command->n > 0 ? command->argument[0] : NULL;
    const mukca_message_trigger trigger = {.id = command->id,
                                           .placement = first,
                                           .socket = command->n > 1 ? command->argument[1] : NULL};
    switch (verb) {
        case RIGHT_start:
            return start(s, first ? first : "session", answer);
        case RIGHT_add:
            return mukca_sampling_sample(r, &trigger, r->packet_time, answer);
        case RIGHT_delete:
            return mukca_sampling_delete(r, answer);
        case RIGHT_socket:
            return mukca_sampling_select(r, NULL, first, answer);
        case RIGHT_placement:
            return mukca_sampling_select(r, first ? first : "", NULL, answer);
        case RIGHT_finish:
            return finish(s, answer);
        case RIGHT_use:
            return mukca_server_use(s, first, answer);
        case RIGHT_result:
            return send_table(s, command->id, answer);
        default:
            return mukca_server_start_job(s, verb == RIGHT_diagnose, command->id, answer);
    }
}

/* Execute a command if its sender has the right to it.  The answer's text is sent unless it is
 * empty: the result was sent already, or follows later. */
static mukca_status obey(mukca_server *s, const mukca_lcm_packet *packet,
                         const mukca_message_command *command, mukca_error *answer)
{
    const char *verb = command->verb;
    MUKCA_TRY(mukca_requests_check_signature(&s->recorder, packet, command->utime, answer));
    for (int i = 0; i < STATUS; i++) {
        if (strcmp(verb, mukca_server_verbs[i]) != 0 || command->n > most_arguments[i]) continue;
        if (!(s->rights >> i & 1u))
            return mukca_fail(answer, MUKCA_NEGATIVE,
                              "not accepted: start serve with --accept naming %s", verb);
        const mukca_status status = i == RIGHT_result ? MUKCA_OK : control(s, packet, answer);
        if (status != MUKCA_OK) return status;
        answer->text[0] = '\0';
        return execute(s, i, command, answer);
    }
    return mukca_fail(answer, MUKCA_USAGE, "unknown verb or too many arguments: \"%.40s\"", verb);
}

static void on_command(void *context, const mukca_lcm_packet *packet)
{
    mukca_server *s = context;
    mukca_recorder *r = &s->recorder;
    mukca_message_command command;
    mukca_error line, error;
    if (!mukca_requests_decode(&command, r, MUKCA_MESSAGE_COMMAND, packet)) return;
    mukca_status status = obey(s, packet, &command, &line);
    keep_place(s);
    if (mukca_server_save_state(s, &error) != MUKCA_OK) /* retried later; samples are safe */
        mukca_recorder_report(r, "%s", error.text);
    line.status = status;
    if (strcmp(command.verb, "add") != 0) /* mukca_sampling_sample counts its own failures */
        mukca_sampling_count_unwritten(r, &line);
    if (!line.text[0]) return;
    s->result = (mukca_message_result){
        .id = command.id, .verb = command.verb, .text = line.text, .code = (int)status};
    mukca_server_answer(s, NULL);
    mukca_recorder_report(r, "%.40s: %s", command.verb, line.text);
}

/* ---- the daemon ---- */

static mukca_status may_trigger(void *context, const mukca_lcm_packet *packet, mukca_error *error)
{
    mukca_server *s = context;
    if (!(s->rights >> TRIGGER & 1u))
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not accepted: start serve with --accept naming trigger");
    return control(s, packet, error);
}

mukca_status mukca_server_open(mukca_server *s, const mukca_server_options *options,
                               const mukca_chain *chain, const double *theta,
                               const mukca_recorder_hooks *hooks, mukca_error *error)
{
    mukca_recorder_hooks forward = {.report = hooks->report,
                                    .interrupted = hooks->interrupted,
                                    .command = on_command,
                                    .trigger = may_trigger,
                                    .joints = options->publish_pose ? mukca_server_send_pose : NULL,
                                    .context = s};
    memset(s, 0, sizeof *s);
    s->options = options;
    mukca_row_state_stream(&s->pose.states, chain->n_joints);
    MUKCA_TRY(read_rights(s, error));
    MUKCA_TRY(mukca_server_open_folder(s, error));
    MUKCA_TRY(mukca_recorder_open(&s->recorder, &options->recorder, chain, theta, &forward, error));
    MUKCA_TRY(mukca_server_load_state(s, error));
    mukca_error problem; /* serves without a model, too */
    if (mukca_server_load_model(s, &problem))
        mukca_recorder_report(&s->recorder, "no table is in use: %s", problem.text);
    if (!s->recorder.link.replays) return MUKCA_OK;
    s->rights = ~0u;
    return mukca_recorder_connect(&s->recorder, -1, error);
}

/* Report a change of the stream's problem; `last` is the preceding report. */
static void report_problem(mukca_recorder *r, char last[MUKCA_RECORDER_LINE])
{
    if (r->stream.map.made && !r->stream.map.confirmed) /* mapped by order, unconfirmed */
        mukca_fail(&r->stream.problem, MUKCA_USAGE,
                   "%s sends no joint names: start serve with --map order", r->stream.channel);
    if (r->stream.problem.status && strcmp(last, r->stream.problem.text) != 0)
        mukca_recorder_report(r, "%s", r->stream.problem.text);
    snprintf(last, MUKCA_RECORDER_LINE, "%s",
             r->stream.problem.status ? r->stream.problem.text : "");
}

mukca_status mukca_server_run(mukca_server *s, mukca_error *error)
{
    const double publish_period = 0.5; /* s, as promised in data/lcm/mukca_status.lcm */
    mukca_recorder *r = &s->recorder;
    mukca_status status = MUKCA_OK;
    char last[MUKCA_RECORDER_LINE] = "";
    double published = mukca_clock_seconds();
    bool unsaved = false;
    mukca_server_notify("READY=1");
    while (!r->hooks.interrupted()) {
        mukca_error problem;
        status = mukca_recorder_step(r, 100, -1, NULL, error);
        if (status != MUKCA_OK) break;
        report_problem(r, last);
        (void)begin(s, &problem); /* reports by itself */
        mukca_server_finish_job(s, false);
        double now = mukca_clock_seconds();
        if (now - published < publish_period) continue;
        published = now;
        keep_place(s);
        bool failed = mukca_server_save_state(s, &problem) != MUKCA_OK;
        if (failed && !unsaved) mukca_recorder_report(r, "%s", problem.text);
        unsaved = failed;
        mukca_sampling_publish_status(r, s->job.child ? s->job.verb : NULL);
        mukca_server_notify("WATCHDOG=1");
    }
    mukca_server_notify("STOPPING=1");
    mukca_server_kill_job(s);
    mukca_sampling_publish_status(r, "stopped");
    if (status != MUKCA_OK && status != MUKCA_NEGATIVE) return status;
    MUKCA_TRY(mukca_server_save_state(s, error));
    return mukca_recorder_finish(r, error); /* MUKCA_NEGATIVE: end of the log */
}

void mukca_server_close(mukca_server *s)
{
    mukca_recorder_close(&s->recorder);
    if (s->locked) close(s->lock);
    s->locked = false;
}
