/* mukca's own LCM messages: one table of fields per type drives encoding and decoding. */
#include "lcm/message.h"

#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "lcm/wire.h"

typedef enum { INT64, INT32, REAL, FLAG, TEXT, COUNT } field_kind;
static const size_t wire_size[] = {8, 4, 8, 1, 4, 4}; /* of a text: size of its length */
static const size_t member_size[] = {sizeof(int64_t), sizeof(int),    sizeof(double),
                                     sizeof(bool),    sizeof(char *), sizeof(int)};

enum { N = -1 }; /* number of elements from the preceding COUNT */

typedef struct {
    field_kind kind;
    int count; /* elements, or N; for a COUNT its largest value */
    size_t offset;
} field;

/* Fields in the order of data/lcm. */
#define FIELD(message, kind, member, count)                    \
    {                                                          \
        kind, count, offsetof(mukca_message_##message, member) \
    }
static const field trigger_fields[] = {
    FIELD(trigger, INT64, utime, 1), FIELD(trigger, INT64, id, 1),
    FIELD(trigger, TEXT, placement, 1), FIELD(trigger, TEXT, socket, 1)};
static const field command_fields[] = {
    FIELD(command, INT64, utime, 1), FIELD(command, INT64, id, 1), FIELD(command, TEXT, verb, 1),
    FIELD(command, COUNT, n, MUKCA_MESSAGE_ARGUMENTS), FIELD(command, TEXT, argument, N)};
static const field status_fields[] = {
    FIELD(status, INT64, utime, 1),         FIELD(status, TEXT, state, 1),
    FIELD(status, TEXT, text, 1),           FIELD(status, TEXT, session, 1),
    FIELD(status, TEXT, placement, 1),      FIELD(status, TEXT, socket, 1),
    FIELD(status, INT32, rows, 1),          FIELD(status, INT32, rows_here, 1),
    FIELD(status, TEXT, channel, 1),        FIELD(status, TEXT, type, 1),
    FIELD(status, TEXT, stream, 1),         FIELD(status, REAL, rate_hz, 1),
    FIELD(status, REAL, age_s, 1),          FIELD(status, INT64, received, 1),
    FIELD(status, INT64, refused, 1),       FIELD(status, FLAG, still, 1),
    FIELD(status, REAL, spread_m, 1),       FIELD(status, REAL, expected_m, 1),
    FIELD(status, FLAG, more_rows_help, 1), FIELD(status, COUNT, n, MUKCA_MAX_JOINTS),
    FIELD(status, TEXT, joint, N),          FIELD(status, REAL, position, N),
    FIELD(status, REAL, coverage, N)};
static const field sample_fields[] = {
    FIELD(sample, INT64, utime, 1),    FIELD(sample, INT64, id, 1),
    FIELD(sample, FLAG, accepted, 1),  FIELD(sample, TEXT, text, 1),
    FIELD(sample, TEXT, placement, 1), FIELD(sample, TEXT, socket, 1),
    FIELD(sample, INT32, row, 1),      FIELD(sample, COUNT, n, MUKCA_MAX_JOINTS),
    FIELD(sample, TEXT, joint, N),     FIELD(sample, REAL, position, N),
    FIELD(sample, REAL, spread, N)};
static const field result_fields[] = {FIELD(result, INT64, utime, 1),
                                      FIELD(result, INT64, id, 1),
                                      FIELD(result, TEXT, verb, 1),
                                      FIELD(result, INT32, code, 1),
                                      FIELD(result, TEXT, text, 1),
                                      FIELD(result, TEXT, robot, 1),
                                      FIELD(result, TEXT, urdf_sha256, 1),
                                      FIELD(result, TEXT, base, 1),
                                      FIELD(result, TEXT, tip, 1),
                                      FIELD(result, TEXT, stream, 1),
                                      FIELD(result, COUNT, n, MUKCA_MESSAGE_ROWS),
                                      FIELD(result, TEXT, joint, N),
                                      FIELD(result, TEXT, parameter, N),
                                      FIELD(result, TEXT, unit, N),
                                      FIELD(result, REAL, nominal, N),
                                      FIELD(result, REAL, calibrated, N),
                                      FIELD(result, REAL, offset, N),
                                      FIELD(result, REAL, sigma, N),
                                      FIELD(result, FLAG, identifiable, N),
                                      FIELD(result, TEXT, json, 1)};
static const field pose_fields[] = {FIELD(pose, INT64, utime, 1), FIELD(pose, REAL, position, 3),
                                    FIELD(pose, REAL, quaternion, 4)};

static const struct {
    const char *channel, *name;
    uint64_t fingerprint;
    const field *fields;
    size_t n_fields;
} kinds[] = {
#define KIND(channel, name, fingerprint)                   \
    {#channel, "mukca." #name, fingerprint, name##_fields, \
     sizeof name##_fields / sizeof name##_fields[0]},
    MUKCA_MESSAGE_LIST(KIND)
#undef KIND
};

void mukca_message_channel(char channel[64], mukca_message_kind kind, const char *prefix)
{
    snprintf(channel, 64, "%.50s_%s", prefix ? prefix : "MUKCA", kinds[kind].channel);
}

const char *mukca_message_identify(const void *data, size_t size)
{
    for (int k = 0; k < MUKCA_MESSAGES && size >= 8; k++)
        if (mukca_lcm_wire_get(data, 8) == kinds[k].fingerprint) return kinds[k].name;
    return NULL;
}

/* Number of elements of a field after the count `n`; -1: a COUNT out of range. */
static int elements(const field *f, const void *member, int *n)
{
    if (f->kind == COUNT) {
        memcpy(n, member, sizeof *n);
        return *n < 0 || *n > f->count ? -1 : 1;
    }
    return f->count == N ? *n : f->count;
}

/* ---- encode ---- */

typedef struct {
    unsigned char *at;
    size_t size, used; /* nothing is written once `used` exceeds `size` */
} writer;

static void put(writer *w, const void *bytes, uint64_t number, size_t n)
{
    if (w->used <= w->size && n <= w->size - w->used) {
        if (bytes)
            memcpy(w->at + w->used, bytes, n);
        else
            mukca_lcm_wire_put(w->at + w->used, number, (int)n);
    }
    w->used += n;
}

static void put_element(writer *w, field_kind kind, const char *member)
{
    const char *text = NULL;
    uint64_t number = 0;
    int small = 0;
    bool flag = false;
    switch (kind) {
        case TEXT:
            memcpy(&text, member, sizeof text);
            if (!text) text = "";
            put(w, NULL, strlen(text) + 1, 4);
            put(w, text, 0, strlen(text) + 1);
            if (w->used <= w->size) mukca_utf8_mend((char *)w->at + w->used - strlen(text) - 1);
            return;
        case FLAG:
            memcpy(&flag, member, sizeof flag);
            number = flag;
            break;
        case INT32:
        case COUNT:
            memcpy(&small, member, sizeof small);
            number = (uint32_t)small;
            break;
        case INT64:
        case REAL:
            memcpy(&number, member, sizeof number);
            break;
    }
    put(w, NULL, number, wire_size[kind]);
}

size_t mukca_message_encode(void *buffer, size_t size, mukca_message_kind kind, const void *message)
{
    writer w = {.at = buffer, .size = size};
    int n = 0;
    put(&w, NULL, kinds[kind].fingerprint, 8);
    for (size_t i = 0; i < kinds[kind].n_fields; i++) {
        const field *f = &kinds[kind].fields[i];
        const char *member = (const char *)message + f->offset;
        int count = elements(f, member, &n);
        if (count < 0) return 0;
        for (int k = 0; k < count; k++)
            put_element(&w, f->kind, member + (size_t)k * member_size[f->kind]);
    }
    return w.used;
}

/* ---- decode ---- */

/* Whether a text has no characters that control a terminal. */
static bool is_printable(const char *text)
{
    for (const char *c = text; *c; c++)
        if (((unsigned char)*c < 0x20 && *c != '\t' && *c != '\n') || *c == 0x7f) return false;
    return true;
}

static bool decode_element(mukca_lcm_wire *wire, field_kind kind, char *member)
{
    if (kind == TEXT) {
        const char *text = mukca_lcm_wire_text(wire);
        memcpy(member, &text, sizeof text);
        return text && is_printable(text);
    }
    const unsigned char *at = mukca_lcm_wire_bytes(wire, wire_size[kind]);
    if (!at) return false;
    uint64_t number = mukca_lcm_wire_get(at, (int)wire_size[kind]);
    int small = (int)(uint32_t)number;
    bool flag = number != 0;
    const void *value = kind == FLAG                     ? (const void *)&flag
                        : kind == INT32 || kind == COUNT ? (const void *)&small
                                                         : (const void *)&number;
    memcpy(member, value, member_size[kind]);
    return true;
}

mukca_status mukca_message_decode(void *message, mukca_message_kind kind, const void *data,
                                  size_t size, mukca_error *error)
{
    mukca_lcm_wire wire = {.at = data, .left = size};
    const unsigned char *head = mukca_lcm_wire_bytes(&wire, 8);
    if (!head || mukca_lcm_wire_get(head, 8) != kinds[kind].fingerprint)
        return mukca_fail(error, MUKCA_INPUT, "not a %s message", kinds[kind].name);
    bool good = true;
    int n = 0;
    for (size_t i = 0; i < kinds[kind].n_fields && good; i++) {
        const field *f = &kinds[kind].fields[i];
        char *member = (char *)message + f->offset;
        int count = f->kind == COUNT ? 1 : elements(f, member, &n);
        for (int k = 0; k < count && good; k++)
            good = decode_element(&wire, f->kind, member + (size_t)k * member_size[f->kind]);
        if (good && f->kind == COUNT) good = elements(f, member, &n) == 1;
    }
    const bool request = kind == MUKCA_MESSAGE_TRIGGER || kind == MUKCA_MESSAGE_COMMAND;
    if (request && wire.left == MUKCA_LCM_SIGNATURE) wire.left = 0;
    if (!good || wire.left)
        return mukca_fail(error, MUKCA_INPUT, "malformed %s message", kinds[kind].name);
    return MUKCA_OK;
}
