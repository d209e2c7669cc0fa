/* The poses and their offsets table.  Only the command `use` changes it, subject to conditions, by
 * a copy that later jobs do not overwrite.  It persists across restarts. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accept/accept.h"
#include "arm/tip_change.h"
#include "base/file.h"
#include "io/dataset.h"
#include "io/output.h"
#include "model/dataset_subset.h"
#include "record/server.h"

static mukca_status check_stream(const mukca_server *s, const char *model, const char *stream,
                                 mukca_error *error)
{
    const char *now = mukca_recorder_stream(&s->recorder);
    if (strcmp(stream, now) == 0) return MUKCA_OK;
    return mukca_fail(error, MUKCA_INPUT,
                      "%.80s was calibrated on a %s stream, and this one is %s: its offsets would "
                      "count twice or not at all",
                      model, stream, now);
}

/* Parse a table.  Its digest shows that its lines, the verdict among them, are those written; a
 * forged one must not move the tip by more than any calibration does. */
static mukca_status read_accepted(mukca_offsets *offsets, const mukca_server *s, const char *name,
                                  const char *text, mukca_error *error)
{
    mukca_offsets_origin origin = {.name = name};
    mukca_acceptance *a = &offsets->acceptance;
    MUKCA_TRY(mukca_offsets_parse(offsets, &origin, s->recorder.chain, text, error));
    if (!a->given || !a->intact)
        return mukca_fail(error, MUKCA_INPUT, "%s has no %s: calibrate again, then use the result",
                          name, a->given ? "digest" : "verdict");
    mukca_tip_change change;
    const mukca_tip_change_task task = {.chain = s->recorder.chain, .to = offsets};
    MUKCA_TRY(mukca_tip_change_find(&change, &task, error));
    if (!(change.m <= MUKCA_MOST_TIP_CHANGE))
        mukca_acceptance_refuse(a, "moves the tip by %.0f mm, more than any calibration",
                                1e3 * change.m);
    if (a->accepted) return MUKCA_OK;
    return mukca_fail(error, MUKCA_INPUT, "%.60s did not pass: %.150s", name, a->reason);
}

mukca_status mukca_server_load_model(mukca_server *s, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH], *text = NULL;
    const mukca_server_state *state = &s->state;
    s->pose.ready = false;
    if (!state->model[0]) return MUKCA_OK;
    mukca_server_path(path, s, "", "in_use", ".tsv");
    mukca_status status = check_stream(s, state->model, state->model_stream, error);
    if (status == MUKCA_OK) status = mukca_file_read(&text, path, error);
    if (status == MUKCA_OK) status = read_accepted(&s->pose.offsets, s, state->model, text, error);
    free(text);
    if (status != MUKCA_OK) return status;
    mukca_geometry_set(&s->pose.geometry, s->recorder.chain, s->pose.offsets.theta);
    s->pose.ready = true;
    return MUKCA_OK;
}

mukca_status mukca_server_keep_result(mukca_server *s, mukca_error *error)
{
    mukca_server_state *state = &s->state;
    const mukca_offsets_options options = {.accept = MUKCA_ACCEPT_FAILED};
    MUKCA_TRY(
        mukca_offsets_read(&s->candidate, s->recorder.chain, s->job.offsets, &options, error));
    snprintf(state->candidate, sizeof state->candidate, "%s", strrchr(s->job.offsets, '/') + 1);
    snprintf(state->candidate_stream, sizeof state->candidate_stream, "%s",
             mukca_recorder_stream(&s->recorder));
    return mukca_server_save_state(s, error);
}

/* error[n_rows]; false: out of memory. */
static bool find_errors(double *error, const mukca_chain *chain, const mukca_offsets *table,
                        const mukca_dataset *data)
{
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    const mukca_model model = {
        .chain = chain, .theta = table->theta, .effects = effects, .n_effects = table->n_effects};
    mukca_offsets_place_effects(effects, table, data);
    return mukca_evaluate_rows(error, &model, data);
}

static mukca_status find_difference(mukca_difference *d, mukca_server *s, const mukca_dataset *data,
                                    mukca_error *error)
{
    const int n = data->n_rows;
    double *errors = calloc(2 * ((size_t)n + 1), sizeof *errors);
    const bool found = errors && find_errors(errors, s->recorder.chain, &s->pose.offsets, data) &&
                       find_errors(errors + n, s->recorder.chain, &s->candidate, data);
    const mukca_status status = found ? mukca_difference_find(d, errors, errors + n, data, error)
                                      : mukca_fail(error, MUKCA_MEMORY, "out of memory");
    free(errors);
    return status;
}

/* Errors of s->candidate minus those of the table in use on the session of `table` (its file name);
 * no postures: the session cannot be read any more, or has one only. */
static mukca_status compare_tables(mukca_difference *d, mukca_server *s, const char *table,
                                   mukca_error *error)
{
    char name[MUKCA_NAME_SIZE], path[MUKCA_SERVER_PATH];
    const char *paths[1] = {path};
    const mukca_dataset_options options = {.partial = true};
    mukca_dataset data = {0};
    mukca_condensed condensed;
    *d = (mukca_difference){0};
    (void)mukca_server_session_of(name, table);
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, name, ".tsv");
    if (mukca_dataset_load(&data, s->recorder.chain, paths, 1, &options, error) != MUKCA_OK)
        return MUKCA_OK;
    mukca_status status = mukca_condense(&condensed, &data, MUKCA_MOST_SAMPLES, error);
    if (status == MUKCA_OK) status = find_difference(d, s, &data, error);
    if (!isfinite(d->sigma_m)) *d = (mukca_difference){0}; /* a single posture shows nothing */
    mukca_dataset_free(&data);
    return status;
}

/* Conditions relative to the table in use, on the samples of both sessions.  The new session counts
 * twice, as it shows the arm as it is: a change of the arm makes the two differences equal and
 * opposite.  --most-change does not protect a table in use that is worse on the new session and no
 * better on its own. */
static mukca_status check_change(mukca_server *s, mukca_error *error)
{
    mukca_difference new, old;
    const double most = s->options->most_change;
    if (!s->pose.ready) return MUKCA_OK;
    MUKCA_TRY(compare_tables(&new, s, s->state.candidate, error));
    MUKCA_TRY(compare_tables(&old, s, s->state.model, error));
    const double difference = 2 * new.mean_m + old.mean_m,
                 sigma = hypot(2 * new.sigma_m, old.sigma_m);
    mukca_tip_change change;
    const mukca_tip_change_task task = {
        .chain = s->recorder.chain, .from = &s->pose.offsets, .to = &s->candidate};
    MUKCA_TRY(mukca_tip_change_find(&change, &task, error));
    const bool worse = new.mean_m < -2 * new.sigma_m &&old.postures &&old.mean_m <= 2 * old.sigma_m;
    if (!(change.m <= most) && !worse)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "%s: moves the tip by %.1f mm against the table in use, at most %.1f mm "
                          "(--most-change)",
                          s->state.candidate, 1e3 * change.m, 1e3 * most);
    if (difference <= 2 * sigma) return MUKCA_OK;
    return mukca_fail(error, MUKCA_NEGATIVE,
                      "%s: error %+.3f mm (standard error %.3f mm) against the table in use on its "
                      "own session, %+.3f mm (%.3f mm) on that of the table in use; record more "
                      "samples",
                      s->state.candidate, 1e3 * new.mean_m, 1e3 * new.sigma_m, 1e3 * old.mean_m,
                      1e3 * old.sigma_m);
}

static mukca_status write_in_use(const mukca_server *s, const char *text, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH];
    mukca_output output = {0};
    mukca_server_path(path, s, "", "in_use", ".tsv");
    mukca_status status = mukca_output_open(&output, path, true, error);
    if (status == MUKCA_OK) fputs(text, output.stream);
    return mukca_output_finish(&output, status, error);
}

mukca_status mukca_server_use(mukca_server *s, const char *session, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH], name[MUKCA_NAME_SIZE], *text = NULL;
    mukca_server_state *state = &s->state;
    if (s->job.child) return mukca_fail(error, MUKCA_NEGATIVE, "a calculation is running: wait");
    if (!state->candidate[0])
        return mukca_fail(error, MUKCA_NEGATIVE, "there is no result: calibrate or diagnose first");
    (void)mukca_server_session_of(name, state->candidate);
    if (session && strcmp(session, name) != 0)
        return mukca_fail(error, MUKCA_NEGATIVE, "the last result is %s, not of session %.40s",
                          state->candidate, session);
    mukca_server_path(path, s, MUKCA_SERVER_RESULTS, state->candidate, "");
    mukca_status status = check_stream(s, state->candidate, state->candidate_stream, error);
    if (status == MUKCA_OK) status = mukca_file_read(&text, path, error);
    if (status == MUKCA_OK) status = read_accepted(&s->candidate, s, state->candidate, text, error);
    if (status == MUKCA_OK) status = check_change(s, error);
    if (status == MUKCA_OK) status = write_in_use(s, text, error);
    free(text);
    if (status != MUKCA_OK) return status;
    snprintf(state->model, sizeof state->model, "%s", state->candidate);
    snprintf(state->model_stream, sizeof state->model_stream, "%s", state->candidate_stream);
    status = mukca_server_load_model(s, error);
    if (status == MUKCA_OK) status = mukca_server_save_state(s, error);
    char verdict[MUKCA_ACCEPTANCE_SENTENCE] = "";
    mukca_acceptance_put_brief(&(mukca_text)MUKCA_TEXT(verdict), &s->pose.offsets.acceptance);
    if (status == MUKCA_OK) mukca_fail(error, MUKCA_OK, "in use: %.60s; %s", state->model, verdict);
    return status;
}

/* ---- poses: one per joint state, without allocation ---- */

void mukca_server_send_pose(void *context, int64_t time_us, const double *q)
{
    mukca_server *s = context;
    mukca_server_pose *pose = &s->pose;
    mukca_frame tip;
    mukca_message_pose message = {.utime = time_us};
    /* Without a time: drift is identified within a session and does not extrapolate over days. */
    const mukca_row_reading reading = {
        .q = q,
        .command = s->recorder.stream.last.joints.has[MUKCA_LCM_ROLE_COMMAND]
                       ? s->recorder.stream.last.reading.command
                       : NULL,
        .time = (double)NAN,
        .placement = -1};
    const mukca_joint_state *state = mukca_row_state_next(&pose->states, &reading);
    if (!pose->ready) return;
    mukca_tip_pose(&tip, pose->offsets.effects, pose->offsets.n_effects, s->recorder.chain,
                   &pose->geometry, state);
    memcpy(message.position, tip.p, sizeof message.position);
    mukca_rotation_to_quaternion(message.quaternion, tip.R);
    pose->sent += mukca_recorder_publish(&s->recorder, MUKCA_MESSAGE_POSE, &message);
}
