/* Calibrated poses of `mukca serve --publish-pose`: one per joint state, without allocation. */
#include <math.h>
#include <string.h>

#include "cli/serve.h"

mukca_status serve_load_model(server *s, mukca_error *error)
{
    char path[SERVE_PATH];
    s->pose.ready = false;
    if (!s->memory.model[0]) return MUKCA_OK;
    if (strcmp(s->memory.model_stream, recorder_stream_name(&s->engine)) != 0)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s was calibrated on a %s stream, and this one is %s: its offsets would "
                          "count twice or not at all",
                          s->memory.model, s->memory.model_stream,
                          recorder_stream_name(&s->engine));
    serve_path(path, s, s->memory.model, "");
    mukca_status status =
        mukca_offsets_read(&s->pose.offsets, &s->model.chain, path, false, NULL, NULL, error);
    if (status) return status;
    mukca_geometry_set(&s->pose.geometry, &s->model.chain, s->pose.offsets.theta);
    s->pose.ready = true;
    return MUKCA_OK;
}

static const double bucket_ratio = 1.02, bucket_first = 1e-7;

static void count_latency(serve_pose *pose, double seconds)
{
    int i = seconds > bucket_first ? (int)(log(seconds / bucket_first) / log(bucket_ratio)) + 1 : 0;
    pose->histogram[i < SERVE_BUCKETS ? i : SERVE_BUCKETS - 1]++;
}

double serve_latency(const serve_pose *pose, double p)
{
    int64_t sum = 0;
    for (int i = 0; i < SERVE_BUCKETS && pose->sent; i++)
        if ((double)(sum += pose->histogram[i]) >= p * (double)pose->sent)
            return bucket_first * pow(bucket_ratio, i);
    return (double)NAN;
}

void serve_send_pose(void *context, int64_t time_us, const double *q)
{
    server *s = context;
    serve_pose *pose = &s->pose;
    mukca_displacement displacement;
    mukca_frame tip;
    mukca_message_pose message = {.utime = time_us};
    /* Without a time: drift is known for a session, not for the days that a daemon runs. */
    const mukca_row_reading reading = {
        .q = q,
        .command = s->engine.joints.has[MUKCA_LCM_ROLE_COMMAND] ? s->engine.command : NULL,
        .time = (double)NAN,
        .placement = -1};
    const mukca_joint_state *state = mukca_row_state_next(&pose->states, &reading);
    if (!pose->ready) return;
    bool effects = pose->offsets.n_effects > 0;
    if (effects)
        mukca_effects_displacement(&displacement, pose->offsets.effects, pose->offsets.n_effects,
                                   &s->model.chain, &pose->geometry, q, state);
    mukca_fk_pose(&tip, &pose->geometry, q, effects ? &displacement : NULL);
    memcpy(message.position, tip.p, sizeof message.position);
    mukca_rotation_to_quaternion(message.quaternion, tip.R);
    size_t size =
        mukca_message_encode(pose->buffer, sizeof pose->buffer, MUKCA_MESSAGE_POSE, &message);
    mukca_error error;
    if (mukca_lcm_link_publish(s->engine.link, pose->channel, pose->buffer, size, &error)) return;
    pose->sent++;
    count_latency(pose,
                  1e-6 * (double)(mukca_lcm_link_clock(s->engine.link) - s->engine.packet_time));
}
