/* Admission of senders: a rate limit for the requests of each sender, and one sender of joint
 * states at a time.  Messages of a log have no sender and are not limited. */
#include <math.h>
#include <string.h>

#include "record/recorder.h"

/* Our choice: above the rate of people and of programs that wait for replies, below that of a
 * disk. */
static const double requests_per_s = 50, first_requests = 40, most_requests = 100;

/* A restarted driver has a new port and is accepted after this silence, us. */
static const int64_t handover_us = 500000;

/* Tolerated clock difference between signer and receiver, us: clocks set by hand agree within
 * seconds.  A recorded request cannot be replayed, which permits a wide tolerance. */
static const int64_t fresh_us = 10000000;

/* No sample is recorded for this time after a message of a second sender, us: longer than usual
 * averaging windows. */
static const int64_t doubt_us = 1000000;

bool mukca_recorder_may_request(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    if (!packet->sender) return true;
    mukca_recorder_sender *s = &r->sender[0]; /* its entry, else the oldest */
    for (int i = 0; i < MUKCA_RECORDER_MAX_SENDERS; i++) {
        if (r->sender[i].id == packet->sender) {
            s = &r->sender[i];
            break;
        }
        if (r->sender[i].time < s->time) s = &r->sender[i];
    }
    if (s->id != packet->sender)
        *s = (mukca_recorder_sender){packet->sender, packet->time, first_requests};
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

mukca_status mukca_recorder_check_signature(mukca_recorder *r, const mukca_lcm_packet *packet,
                                            int64_t utime, mukca_error *error)
{
    if (!r->options->key) return MUKCA_OK;
    if (!mukca_lcm_signature_check(&r->key, packet))
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not signed with the key that is required here: send it with --key FILE");
    int64_t ahead = utime - packet->time;
    if (ahead > fresh_us || ahead < -fresh_us)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "signed %.0f s %s: synchronise the clocks of both machines",
                          1e-6 * fabs((double)ahead), ahead > 0 ? "in the future" : "ago");
    if (utime <= r->last_signed)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not newer than the last signed request, or sent twice: send another");
    r->last_signed = utime;
    return MUKCA_OK;
}

bool mukca_recorder_one_sender(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    int64_t silence = packet->time - r->arm_heard;
    if (!packet->sender || !r->arm || r->arm == packet->sender || silence > handover_us ||
        silence < -handover_us) {
        r->arm = packet->sender;
        r->arm_heard = packet->time;
        return true;
    }
    r->second_heard = packet->time;
    mukca_recorder_refuse(
        r, MUKCA_RECORDER_TWO_SENDERS, "%s",
        "two arms seem to send on this channel: stop one of them, or name another "
        "--channel");
    return false;
}

bool mukca_recorder_doubted(const mukca_recorder *r)
{
    int64_t now = r->packet_time ? r->packet_time : mukca_lcm_link_clock(r->link);
    return r->second_heard && now - r->second_heard < doubt_us && now - r->second_heard > -doubt_us;
}
