/* Requests over LCM.  Messages of a log have no sender and are not limited. */
#include <math.h>

#include "record/recorder.h"

/* Our choice: above the rate of people and of programs that wait for replies, below that of a
 * disk. */
static const double requests_per_s = 50, first_requests = 40, most_requests = 100;

/* Tolerated clock difference between signer and receiver, us: clocks set by hand agree within
 * seconds.  A recorded request cannot be replayed, which permits a wide tolerance. */
static const int64_t fresh_us = 10000000;

bool mukca_requests_may(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    if (!packet->sender) return true;
    mukca_requests_sender *s = &r->requests.sender[0]; /* its entry, else the oldest */
    for (int i = 0; i < MUKCA_REQUESTS_SENDERS; i++) {
        if (r->requests.sender[i].id == packet->sender) {
            s = &r->requests.sender[i];
            break;
        }
        if (r->requests.sender[i].time < s->time) s = &r->requests.sender[i];
    }
    if (s->id != packet->sender)
        *s = (mukca_requests_sender){packet->sender, packet->time, first_requests};
    double elapsed = 1e-6 * (double)(packet->time - s->time);
    if (elapsed > 0) s->requests += requests_per_s * elapsed;
    if (s->requests > most_requests) s->requests = most_requests;
    s->time = packet->time;
    if (s->requests < 1) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_RATE,
                              "%s: more than %g requests a second of one sender: ignored",
                              packet->channel, requests_per_s);
        return false;
    }
    s->requests -= 1;
    return true;
}

mukca_status mukca_requests_check_signature(mukca_recorder *r, const mukca_lcm_packet *packet,
                                            int64_t utime, mukca_error *error)
{
    if (!r->options->key) return MUKCA_OK;
    if (!mukca_lcm_signature_check(&r->requests.key, packet))
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not signed with the key that is required here: send it with --key FILE");
    int64_t ahead = utime - packet->time;
    if (ahead > fresh_us || ahead < -fresh_us)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "signed %.0f s %s: synchronise the clocks of both machines",
                          1e-6 * fabs((double)ahead), ahead > 0 ? "in the future" : "ago");
    if (utime <= r->requests.last_signed)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not newer than the last signed request, or sent twice: send another");
    r->requests.last_signed = utime;
    return MUKCA_OK;
}

void mukca_requests_trigger(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_message_trigger trigger;
    mukca_error error;
    if (mukca_message_decode(&trigger, MUKCA_MESSAGE_TRIGGER, packet->data, packet->size, &error)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s: ignored", packet->channel,
                              error.text);
        return;
    }
    if (!mukca_requests_may(r, packet)) return;
    mukca_status status = mukca_requests_check_signature(r, packet, trigger.utime, &error);
    if (status == MUKCA_OK && r->hooks.trigger)
        status = r->hooks.trigger(r->hooks.context, packet, &error);
    if (status != MUKCA_OK) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s", packet->channel, error.text);
        const mukca_message_sample answer = {.id = trigger.id, .text = error.text};
        r->session.refused++;
        mukca_recorder_publish(r, MUKCA_MESSAGE_SAMPLE, &answer);
        return;
    }
    const mukca_sample_request request = {.id = trigger.id,
                                          .time = packet->time,
                                          .sent = trigger.utime,
                                          .placement = trigger.placement,
                                          .socket = trigger.socket};
    mukca_sampling_trigger(r, &request);
}
