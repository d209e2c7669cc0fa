/* Our own LCM messages to the wire and back: one visitor per type serves both directions. */
#include "lcm/message.h"

#include <stdio.h>
#include <string.h>

typedef struct {
    bool decoding, bad;
    unsigned char *out;      /* encoding */
    const unsigned char *in; /* decoding */
    size_t at, size;
} cursor;

static void bytes(cursor *c, uint64_t *value, size_t n)
{
    if (c->decoding && (c->bad || c->size - c->at < n)) {
        c->bad = true;
        *value = 0;
        return;
    }
    if (c->decoding) {
        *value = 0;
        for (size_t i = 0; i < n; i++) *value = *value << 8 | c->in[c->at + i];
    } else if (c->at <= c->size && c->size - c->at >= n) {
        for (size_t i = 0; i < n; i++)
            c->out[c->at + i] = (unsigned char)(*value >> 8 * (n - 1 - i));
    }
    c->at += n;
}

static void i64(cursor *c, int64_t *value)
{
    uint64_t u = (uint64_t)*value;
    bytes(c, &u, 8);
    if (c->decoding) *value = (int64_t)u;
}

static void i32(cursor *c, int *value)
{
    uint64_t u = (uint32_t)*value;
    bytes(c, &u, 4);
    if (c->decoding) *value = (int32_t)(uint32_t)u;
}

/* A count of array elements, 0 to `max`. */
static void count(cursor *c, int *n, int max)
{
    i32(c, n);
    if (*n < 0 || *n > max) {
        c->bad = true;
        if (c->decoding) *n = 0;
    }
}

static void flags(cursor *c, bool *value, int n)
{
    for (int i = 0; i < n; i++) {
        uint64_t u = c->decoding ? 0 : value[i];
        bytes(c, &u, 1);
        if (c->decoding) value[i] = u != 0;
    }
}

static void reals(cursor *c, double *value, int n)
{
    for (int i = 0; i < n; i++) {
        uint64_t u;
        memcpy(&u, &value[i], sizeof u);
        bytes(c, &u, 8);
        if (c->decoding) memcpy(&value[i], &u, sizeof u);
    }
}

static void text(cursor *c, const char **value)
{
    const char *given = c->decoding || !*value ? "" : *value;
    uint64_t length = strlen(given) + 1;
    bytes(c, &length, 4);
    if (c->decoding) {
        *value = "";
        if (c->bad || length < 1 || length > c->size - c->at || c->in[c->at + length - 1] != '\0') {
            c->bad = true;
            return;
        }
        *value = (const char *)c->in + c->at;
    } else if (c->at <= c->size && c->size - c->at >= length) {
        memcpy(c->out + c->at, given, length);
    }
    c->at += length;
}

static void texts(cursor *c, const char **value, int n)
{
    for (int i = 0; i < n; i++) text(c, &value[i]);
}

static void visit_trigger(cursor *c, void *message)
{
    mukca_message_trigger *m = message;
    i64(c, &m->utime);
    i64(c, &m->id);
    text(c, &m->placement);
    text(c, &m->socket);
}

static void visit_command(cursor *c, void *message)
{
    mukca_message_command *m = message;
    i64(c, &m->utime);
    i64(c, &m->id);
    text(c, &m->verb);
    count(c, &m->n, MUKCA_MESSAGE_ARGUMENTS);
    texts(c, m->argument, m->n);
}

static void visit_status(cursor *c, void *message)
{
    mukca_message_status *m = message;
    i64(c, &m->utime);
    text(c, &m->state);
    text(c, &m->text);
    text(c, &m->session);
    text(c, &m->placement);
    text(c, &m->socket);
    i32(c, &m->rows);
    i32(c, &m->rows_here);
    text(c, &m->channel);
    text(c, &m->type);
    text(c, &m->stream);
    reals(c, &m->rate_hz, 1);
    reals(c, &m->age_s, 1);
    i64(c, &m->received);
    i64(c, &m->refused);
    flags(c, &m->still, 1);
    reals(c, &m->spread_m, 1);
    reals(c, &m->expected_m, 1);
    flags(c, &m->more_rows_help, 1);
    count(c, &m->n, MUKCA_MAX_JOINTS);
    texts(c, m->joint, m->n);
    reals(c, m->position, m->n);
    reals(c, m->coverage, m->n);
}

static void visit_sample(cursor *c, void *message)
{
    mukca_message_sample *m = message;
    i64(c, &m->utime);
    i64(c, &m->id);
    flags(c, &m->accepted, 1);
    text(c, &m->text);
    text(c, &m->placement);
    text(c, &m->socket);
    i32(c, &m->row);
    count(c, &m->n, MUKCA_MAX_JOINTS);
    texts(c, m->joint, m->n);
    reals(c, m->position, m->n);
    reals(c, m->spread, m->n);
}

static void visit_result(cursor *c, void *message)
{
    mukca_message_result *m = message;
    i64(c, &m->utime);
    i64(c, &m->id);
    text(c, &m->verb);
    i32(c, &m->code);
    text(c, &m->text);
    text(c, &m->robot);
    text(c, &m->urdf_sha256);
    text(c, &m->base);
    text(c, &m->tip);
    text(c, &m->stream);
    count(c, &m->n, MUKCA_MESSAGE_ROWS);
    texts(c, m->joint, m->n);
    texts(c, m->parameter, m->n);
    texts(c, m->unit, m->n);
    reals(c, m->nominal, m->n);
    reals(c, m->calibrated, m->n);
    reals(c, m->offset, m->n);
    reals(c, m->sigma, m->n);
    flags(c, m->identifiable, m->n);
    text(c, &m->json);
}

static void visit_pose(cursor *c, void *message)
{
    mukca_message_pose *m = message;
    i64(c, &m->utime);
    reals(c, m->position, 3);
    reals(c, m->quaternion, 4);
}

static void (*const visitors[])(cursor *, void *) = {visit_trigger, visit_command, visit_status,
                                                     visit_sample,  visit_result,  visit_pose};

void mukca_message_channel(char channel[64], mukca_lcm_builtin kind, const char *prefix)
{
    static const char *const suffix[] = {"TRIGGER", "COMMAND", "STATUS",
                                         "SAMPLE",  "RESULT",  "POSE"};
    snprintf(channel, 64, "%.50s_%s", prefix ? prefix : "MUKCA", suffix[kind - MUKCA_LCM_TRIGGER]);
}

size_t mukca_message_encode(void *buffer, size_t size, mukca_lcm_builtin kind, const void *message,
                            const mukca_lcm_types *types)
{
    cursor c = {.out = buffer, .size = size};
    uint64_t fingerprint = types->type[kind].fingerprint;
    bytes(&c, &fingerprint, 8);
    /* The visitor only reads while encoding. */
    visitors[kind - MUKCA_LCM_TRIGGER](&c, (void *)(uintptr_t)message);
    return c.bad ? 0 : c.at;
}

mukca_status mukca_message_decode(void *message, mukca_lcm_builtin kind, const void *data,
                                  size_t size, const mukca_lcm_types *types, mukca_error *error)
{
    cursor c = {.decoding = true, .in = data, .size = size};
    uint64_t fingerprint;
    bytes(&c, &fingerprint, 8);
    if (c.bad || fingerprint != types->type[kind].fingerprint)
        return mukca_fail(error, MUKCA_INPUT, "not a %s message", types->type[kind].name);
    visitors[kind - MUKCA_LCM_TRIGGER](&c, message);
    if (c.bad || c.at != size)
        return mukca_fail(error, MUKCA_INPUT, "malformed %s message", types->type[kind].name);
    return MUKCA_OK;
}
