/* Reports of a recording to the user, and its messages on LCM. */
#ifndef MUKCA_RECORD_MESSAGES_H
#define MUKCA_RECORD_MESSAGES_H

#include "record/state.h"

/* "raw", "corrected", NULL; and that of the options. */
extern const char *const mukca_recorder_streams[];
const char *mukca_recorder_stream(const mukca_recorder *r);

/* Send a message on its channel; false: it failed, which is reported. */
bool mukca_recorder_publish(mukca_recorder *r, mukca_message_kind kind, const void *message);

/* Report one line to the user and keep it for the status message: a mukca_note_fn, `r` is the
 * recorder; formatted. */
void mukca_recorder_note(void *r, const char *text);
#define mukca_recorder_report(r, ...) \
    mukca_note_format((mukca_notes){mukca_recorder_note, r}, __VA_ARGS__)

/* Whether trouble of this kind was reported in the last ten seconds. */
bool mukca_recorder_reported(const mukca_recorder *r, mukca_recorder_trouble kind);

/* Report trouble at a limited rate; mukca_recorder_refuse also counts an unusable message. */
void mukca_recorder_warn(mukca_recorder *r, mukca_recorder_trouble kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
#define mukca_recorder_refuse(r, kind, ...) \
    ((r)->stream.count.refused++, mukca_recorder_warn(r, kind, __VA_ARGS__))

/* Append "no joint state on X; heard instead: PANDA_STATUS (drake.lcmt_panda_status, 7 joints)";
 * `since` is printed after the channel. */
void mukca_recorder_describe_silence(mukca_text *text, const mukca_recorder *r, const char *since);

/* Type of the joint states; "": none. */
const char *mukca_stream_type(const mukca_recorder *r);

double mukca_stream_age(const mukca_recorder *r); /* s since the arrival of the last joint state */

/* State of the stream: "no_stream", "moving" or "still"; and send it, or another `state` unless
 * NULL, as a status message. */
const char *mukca_sampling_state(const mukca_recorder *r);
void mukca_sampling_publish_status(mukca_recorder *r, const char *state);

#endif
