/* LCM event logs.  Format of an event, big-endian: sync word, event number, time in us, length of
 * the channel, length of the data (28 bytes), then channel and data. */
#include "lcm/link.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io/output.h"
#include "lcm/wire.h"

enum {
    HEADER = 28,
    MAX_DATA = 1 << 26 /* larger events cannot be joint states or mukca's own */
};
static const unsigned char sync_word[4] = {0xED, 0xA1, 0xDA, 0x01};

mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error)
{
    *log = (mukca_lcm_log){.path = path};
    log->file = fopen(path, "rb");
    if (!log->file || fseeko(log->file, 0, SEEK_END) || (log->length = ftello(log->file)) < 0 ||
        log->length == INT64_MAX || fseeko(log->file, 0, SEEK_SET)) {
        int reason = errno;
        mukca_lcm_log_close(log);
        return mukca_fail(error, mukca_output_status(reason), "LCM log %s: %s", path,
                          reason ? strerror(reason) : "cannot be read");
    }
    return MUKCA_OK;
}

bool mukca_lcm_log_read(mukca_lcm_log *log, mukca_lcm_event *event)
{
    unsigned char head[HEADER] = {0};
    size_t have = 0;
    while (log->file) {
        have += fread(head + have, 1, sizeof head - have, log->file);
        if (have < sizeof head) {
            log->skipped += (int64_t)have;
            return false;
        }
        int64_t left = log->length - ftello(log->file);
        uint64_t n_channel = mukca_lcm_wire_get(head + 20, 4),
                 n_data = mukca_lcm_wire_get(head + 24, 4);
        bool event_here = memcmp(head, sync_word, 4) == 0 && n_channel > 0 &&
                          n_channel < sizeof event->channel && (int64_t)n_data <= left &&
                          (int64_t)n_channel <= left - (int64_t)n_data;
        if (!event_here) { /* advance to the next byte that may start a sync word */
            unsigned char *at = memchr(head + 1, sync_word[0], sizeof head - 1);
            size_t skip = at ? (size_t)(at - head) : sizeof head;
            have -= skip;
            memmove(head, head + skip, have);
            log->skipped += (int64_t)skip;
            continue;
        }
        have = 0;
        if (n_data > MAX_DATA) {
            if (fseeko(log->file, (off_t)(n_channel + n_data), SEEK_CUR)) return false;
            log->skipped += (int64_t)(HEADER + n_channel + n_data);
            continue;
        }
        if (n_data + 1 > log->capacity) {
            unsigned char *more = realloc(log->data, n_data + 1);
            if (!more) {
                log->exhausted = true;
                return false;
            }
            log->data = more;
            log->capacity = n_data + 1;
        }
        event->time = (int64_t)mukca_lcm_wire_get(head + 12, 8);
        event->data = log->data;
        event->size = n_data;
        memset(event->channel, 0, sizeof event->channel);
        return fread(event->channel, 1, n_channel, log->file) == n_channel &&
               fread(log->data, 1, n_data, log->file) == n_data;
    }
    return false;
}

void mukca_lcm_log_close(mukca_lcm_log *log)
{
    if (log->file) fclose(log->file);
    free(log->data);
    log->file = NULL;
    log->data = NULL;
}
