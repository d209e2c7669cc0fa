/* The recorder's session: samples on disk before they are acknowledged, labels, status. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/cells.h"
#include "io/dataset.h"
#include "record/recorder.h"

/* ---- labels ---- */

/* Split a comma-separated list into names. */
static mukca_status split_labels(mukca_labels *labels, const char *list, const char *option,
                                 mukca_error *error)
{
    if (!list) return MUKCA_OK;
    labels->n = mukca_cells_count(list, ',');
    if (strlen(list) >= sizeof labels->store || labels->n > MUKCA_LABELS)
        return mukca_fail(error, MUKCA_USAGE, "%s: the list is too long", option);
    memcpy(labels->store, list, strlen(list) + 1);
    mukca_cells_split(labels->name, labels->n, labels->store, ',');
    for (int i = 0; i < labels->n; i++) {
        if (!mukca_session_label_ok(labels->name[i]))
            return mukca_fail(error, MUKCA_USAGE, "%s \"%.60s\": at most %d names, commas between",
                              option, list, MUKCA_LABELS);
        for (int k = 0; k < i; k++)
            if (strcmp(labels->name[k], labels->name[i]) == 0)
                return mukca_fail(error, MUKCA_USAGE, "%s: '%s' comes twice", option,
                                  labels->name[i]);
    }
    return MUKCA_OK;
}

mukca_status mukca_sampling_prepare(mukca_recorder *r, const double *theta, mukca_error *error)
{
    const mukca_recorder_options *o = r->options;
    mukca_sampling *s = &r->session;
    MUKCA_TRY(split_labels(&s->placements, o->placements, "--placement", error));
    MUKCA_TRY(split_labels(&s->sockets, o->sockets, "--sockets", error));
    if (s->sockets.n == 1)
        return mukca_fail(error, MUKCA_USAGE, "--sockets: a tool has two or more");
    mukca_capture_settings settings = o->capture;
    settings.n_labels = s->sockets.n;
    settings.labels = (const char *const *)s->sockets.name;
    s->advice.expected = (double)NAN; /* no session yet */
    return mukca_capture_init(&s->capture, r->chain, theta, &settings, error);
}

static bool placement_used(const mukca_recorder *r, const char *name)
{
    const mukca_dataset *rows = &r->session.capture.rows;
    for (int i = 0; i < rows->n_rows; i++)
        if (strcmp(rows->placements[mukca_dataset_placement(rows, i)].name, name) == 0) return true;
    return false;
}

/* The first name of --placement that is unused, else placement_K. */
static void new_placement(const mukca_recorder *r, char name[MUKCA_NAME_SIZE])
{
    const mukca_sampling *s = &r->session;
    for (int i = 0; i < s->placements.n; i++) {
        snprintf(name, MUKCA_NAME_SIZE, "%s", s->placements.name[i]);
        if (!placement_used(r, name)) return;
    }
    int k = 0;
    do snprintf(name, MUKCA_NAME_SIZE, "placement_%d", ++k);
    while (placement_used(r, name));
}

/* ---- the file ---- */

static mukca_status load_rows(mukca_recorder *r, const char *path, mukca_error *error)
{
    mukca_sampling *s = &r->session;
    mukca_dataset data;
    const mukca_dataset_options options = {.distance = r->options->capture.distance,
                                           .partial = true,
                                           .notes = {mukca_recorder_note, r}};
    char text[MUKCA_RECORDER_LINE];
    mukca_status status = mukca_dataset_load(&data, r->chain, &path, 1, &options, error);
    if (status != MUKCA_OK) return status;
    for (int i = 0; i < data.n_rows && !status; i++) {
        const mukca_socket *where = &data.sockets[data.socket[i]];
        status = mukca_capture_select(&s->capture, data.placements[where->placement].name,
                                      where->label, error);
        if (status == MUKCA_OK)
            status = mukca_capture_keep(text, &s->capture, data.q + i * data.n_joints, error);
    }
    mukca_dataset_free(&data);
    return status;
}

mukca_status mukca_sampling_begin(mukca_recorder *r, const char *path, bool resume, bool force,
                                  mukca_error *error)
{
    mukca_sampling *s = &r->session;
    mukca_stream *stream = &r->stream;
    const mukca_session_task task = {.path = path,
                                     .resume = resume,
                                     .force = force,
                                     .chain = r->chain,
                                     .stream = mukca_recorder_stream(r),
                                     .channel = stream->channel,
                                     .type = mukca_stream_type(r),
                                     .has_effort = stream->last.joints.has[MUKCA_LCM_ROLE_EFFORT],
                                     .has_command = stream->last.joints.has[MUKCA_LCM_ROLE_COMMAND],
                                     .notes = {mukca_recorder_note, r}};
    mukca_capture_clear(&s->capture);
    mukca_session_close(&s->file);
    mukca_status status = mukca_session_open(&s->file, &task, error);
    if (!status && s->file.n_rows) status = load_rows(r, path, error);
    if (!status && !s->file.n_rows) {
        char name[MUKCA_NAME_SIZE];
        new_placement(r, name);
        status =
            mukca_capture_select(&s->capture, name, mukca_capture_next_label(&s->capture), error);
    }
    if (status == MUKCA_OK) status = mukca_capture_advise(&s->advice, &s->capture, error);
    if (status) mukca_session_close(&s->file);
    return status;
}

/* ---- requests ---- */

/* Report that no session is open, with the reason why no stream has been found. */
static mukca_status no_session(const mukca_recorder *r, mukca_error *error)
{
    const mukca_error *problem = &r->stream.problem;
    char line[sizeof error->text];
    mukca_text text = MUKCA_TEXT(line);
    if (r->stream.map.made)
        return mukca_fail(error, MUKCA_NEGATIVE, "no session is being recorded");
    if (!problem->status) mukca_recorder_describe_silence(&text, r, "");
    return mukca_fail(error, MUKCA_NEGATIVE, "no session is being recorded: %s",
                      problem->status ? problem->text : line);
}

/* Replace labels that are NULL or "" by the current ones.  Errors: MUKCA_NEGATIVE (no session, or
 * an invalid label). */
static mukca_status complete_labels(const mukca_recorder *r, const char **placement,
                                    const char **socket, mukca_error *error)
{
    const mukca_sampling *s = &r->session;
    if (!*placement || !**placement) *placement = mukca_capture_placement(&s->capture);
    if (!*socket || !**socket) *socket = mukca_capture_socket(&s->capture);
    if (!s->file.open) return no_session(r, error);
    if (mukca_session_label_ok(*placement) && mukca_session_label_ok(*socket)) return MUKCA_OK;
    return mukca_fail(error, MUKCA_NEGATIVE,
                      "\"%.40s\" or \"%.40s\" cannot be a name (1 to 63 characters of UTF-8, no "
                      "comma, tab, quote or leading #)",
                      *placement, *socket);
}

void mukca_sampling_count_unwritten(mukca_recorder *r, const mukca_error *error)
{
    mukca_sampling *s = &r->session;
    if (error->status == MUKCA_MEMORY && s->unwritten++ == 0) s->first_unwritten = *error;
}

/* Add a sample to the file and the capture; `remark` describes anything unusual about it. */
static mukca_status store(mukca_recorder *r, const mukca_capture_sample *sample,
                          const char *placement, const char *socket,
                          char remark[MUKCA_CAPTURE_TEXT], mukca_error *error)
{
    mukca_sampling *s = &r->session;
    mukca_capture *c = &s->capture;
    const int socket_before = c->socket;
    if (mukca_capture_repeats(c, sample->q))
        return mukca_fail(
            error, MUKCA_NEGATIVE,
            "the joints read exactly as in sample %d: has the arm moved, and does its "
            "driver still update?",
            c->rows.n_rows);
    if (c->rows.n_rows == MUKCA_CAPTURE_MAX_ROWS)
        return mukca_fail(error, MUKCA_INPUT, "the session is full: begin another one");
    MUKCA_TRY(mukca_capture_select(c, placement, socket, error));
    mukca_status status = mukca_session_add(&s->file, placement, socket, sample, error);
    if (status == MUKCA_OK) return mukca_capture_keep(remark, c, sample->q, error);
    c->socket = socket_before;
    mukca_sampling_count_unwritten(r, error);
    return status;
}

/* Age of the last joint state at a request, for mukca_capture_take.  Lines wait in the pipes before
 * this program: if their times are those of a wall clock, they are compared with the request's.
 * Errors: MUKCA_NEGATIVE. */
static mukca_status age_at(double *age, const mukca_recorder *r,
                           const mukca_message_trigger *request, int64_t time, mukca_error *error)
{
    const mukca_stream *stream = &r->stream;
    const double longest_lag = 3600; /* s; beyond it the times are not of the same kind of clock */
    const int64_t sent = request->utime > 0 ? request->utime : time;
    const double lag = 1e-6 * (double)(sent - stream->last.time);
    *age = time ? fmax(1e-6 * (double)(time - stream->last.arrival), 0) : MUKCA_CAPTURE_IN_ORDER;
    if (!stream->lines || !time || !stream->last.time || lag < r->session.capture.settings.window ||
        lag > longest_lag)
        return MUKCA_OK;
    return mukca_fail(error, MUKCA_NEGATIVE,
                      "the last line is %.1f s older than the request: run the program before it "
                      "without buffering (stdbuf -oL), or synchronise the clocks",
                      lag);
}

/* Report joints beyond the limits of the URDF, once each: the wrong arm, joint or zero. */
static void report_limits(mukca_recorder *r, const double *q)
{
    for (int j = 0; j < r->chain->n_joints; j++) {
        const mukca_element *e = &r->chain->element[r->chain->joint_element[j]];
        const double beyond = mukca_rows_beyond(e, q[j]);
        if (beyond == 0 || r->session.beyond[j]) continue;
        r->session.beyond[j] = true;
        mukca_recorder_report(r,
                              "%s is %.2f %s beyond its limits in the URDF: check --urdf and --map",
                              e->name, beyond, e->type == MUKCA_PRISMATIC ? "m" : "rad");
    }
}

/* No sample is recorded for this time after a message of a second sender, us: longer than usual
 * averaging windows. */
static const int64_t doubt_us = 1000000;

static bool is_doubted(const mukca_recorder *r)
{
    const mukca_stream *stream = &r->stream;
    int64_t now = r->packet_time ? r->packet_time : mukca_lcm_link_clock(&r->link);
    return stream->sender.second_heard && now - stream->sender.second_heard < doubt_us &&
           now - stream->sender.second_heard > -doubt_us;
}

mukca_status mukca_sampling_sample(mukca_recorder *r, const mukca_message_trigger *request,
                                   int64_t time, mukca_error *answer)
{
    mukca_sampling *s = &r->session;
    mukca_capture_sample sample = {.time = 0};
    mukca_error error;
    char remark[MUKCA_CAPTURE_TEXT] = "";
    const char *placement = request->placement, *socket = request->socket;
    double age;
    mukca_status status = complete_labels(r, &placement, &socket, &error);
    if (!status && is_doubted(r))
        status = mukca_fail(&error, MUKCA_NEGATIVE, "two arms seem to send on this channel");
    if (status == MUKCA_OK) status = age_at(&age, r, request, time, &error);
    if (status == MUKCA_OK) status = mukca_capture_take(&sample, &s->capture, age, &error);
    if (status == MUKCA_OK) status = store(r, &sample, placement, socket, remark, &error);
    mukca_message_sample message = {.utime = (int64_t)llround(1e6 * sample.time),
                                    .id = request->id,
                                    .accepted = !status,
                                    .text = status ? error.text : remark,
                                    .placement = placement,
                                    .socket = socket,
                                    .row = status ? 0 : s->file.n_rows,
                                    .n = r->chain->n_joints};
    for (int j = 0; j < message.n; j++) message.joint[j] = mukca_chain_joint_name(r->chain, j);
    memcpy(message.position, sample.q, sizeof message.position);
    memcpy(message.spread, sample.spread, sizeof message.spread);
    mukca_recorder_publish(r, MUKCA_MESSAGE_SAMPLE, &message);
    if (status != MUKCA_OK) {
        s->refused++;
        return mukca_fail(answer, status, "not recorded: %s", error.text);
    }
    report_limits(r, sample.q);
    mukca_fail(answer, MUKCA_OK, "sample %d: placement %s, socket %s%s%s", message.row, placement,
               socket, remark[0] ? ": " : "", remark);
    if (mukca_capture_advise(&s->advice, &s->capture, &error) != MUKCA_OK) {
        mukca_recorder_report(r, "%s", error.text); /* the sample is on disk nevertheless */
        mukca_sampling_count_unwritten(r, &error);
    }
    return MUKCA_OK;
}

void mukca_sampling_trigger(mukca_recorder *r, const mukca_message_trigger *request, int64_t time)
{
    mukca_error answer;
    (void)mukca_sampling_sample(r, request, time, &answer);
    mukca_recorder_report(r, "%s", answer.text);
}

mukca_status mukca_sampling_delete(mukca_recorder *r, mukca_error *answer)
{
    mukca_sampling *s = &r->session;
    mukca_error error;
    const mukca_dataset *rows = &s->capture.rows;
    const int row = rows->n_rows;
    if (!s->file.open || !row)
        return mukca_fail(answer, MUKCA_NEGATIVE, "not deleted: %s",
                          s->file.open ? "there is no sample" : "no session is being recorded");
    const mukca_socket *where = &rows->sockets[rows->socket[row - 1]];
    const char *placement = rows->placements[where->placement].name;
    mukca_status status = mukca_session_delete(&s->file, placement, where->label, &error);
    if (status != MUKCA_OK) return mukca_fail(answer, status, "not deleted: %s", error.text);
    mukca_fail(answer, MUKCA_OK, "sample %d deleted (placement %s, socket %s)", row, placement,
               where->label);
    mukca_capture_drop(&s->capture);
    (void)mukca_capture_advise(&s->advice, &s->capture, &error);
    return MUKCA_OK;
}

mukca_status mukca_sampling_select(mukca_recorder *r, const char *placement, const char *socket,
                                   mukca_error *answer)
{
    mukca_sampling *s = &r->session;
    char name[MUKCA_NAME_SIZE];
    mukca_error error;
    if (!socket && placement) socket = s->capture.settings.labels[0];
    if (!socket) socket = mukca_capture_next_label(&s->capture);
    if (placement && !*placement) {
        new_placement(r, name);
        placement = name;
    }
    mukca_status status = complete_labels(r, &placement, &socket, &error);
    if (status == MUKCA_OK) status = mukca_capture_select(&s->capture, placement, socket, &error);
    if (status != MUKCA_OK) return mukca_fail(answer, status, "not changed: %s", error.text);
    return mukca_fail(answer, MUKCA_OK, "now placement %s, socket %s (%d samples)", placement,
                      socket, mukca_capture_count(&s->capture, s->capture.socket));
}
