/* The server's calibrated poses: one per joint state, without allocation. */
#include <math.h>
#include <string.h>

#include "record/server.h"

void mukca_server_send_pose(void *context, int64_t time_us, const double *q)
{
    mukca_server *s = context;
    mukca_server_pose *pose = &s->pose;
    mukca_displacement displacement;
    mukca_frame tip;
    mukca_message_pose message = {.utime = time_us};
    /* Without a time: drift is identified within a session and does not extrapolate over days. */
    const mukca_row_reading reading = {
        .q = q,
        .command = s->recorder.stream.last.joints.has[MUKCA_LCM_ROLE_COMMAND]
                       ? s->recorder.stream.last.command
                       : NULL,
        .time = (double)NAN,
        .placement = -1};
    const mukca_joint_state *state = mukca_row_state_next(&pose->states, &reading);
    if (!pose->ready) return;
    bool effects = pose->offsets.n_effects > 0;
    if (effects)
        mukca_effects_displacement(&displacement, pose->offsets.effects, pose->offsets.n_effects,
                                   s->recorder.chain, &pose->geometry, q, state);
    mukca_fk_pose(&tip, &pose->geometry, q, effects ? &displacement : NULL);
    memcpy(message.position, tip.p, sizeof message.position);
    mukca_rotation_to_quaternion(message.quaternion, tip.R);
    if (!mukca_recorder_publish(&s->recorder, MUKCA_MESSAGE_POSE, &message)) return;
    const double latency =
        1e-6 * (double)(mukca_lcm_link_clock(s->recorder.link) - s->recorder.packet_time);
    pose->sent++;
    pose->latency += latency;
    pose->longest_latency = fmax(pose->longest_latency, latency);
}
