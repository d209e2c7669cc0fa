/* LCM event logs.  Format of an event, big-endian: sync word, event number, time in us, length of
 * the channel, length of the data (28 bytes), then channel and data. */
#include "lcm/log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

mukca_status mukca_lcm_log_create(mukca_lcm_log *log, const char *path, bool force,
                                  mukca_error *error)
{
    *log = (mukca_lcm_log){.path = path};
    int fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC | (force ? O_TRUNC : O_EXCL), 0666);
    if (fd >= 0) log->file = fdopen(fd, "wb");
    if (log->file) return MUKCA_OK;
    int reason = errno;
    if (fd >= 0) close(fd);
    return mukca_fail(error, mukca_output_status(reason), "LCM log %s: %s%s", path,
                      strerror(reason), reason == EEXIST ? " (--force overwrites)" : "");
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

static mukca_status write_error(const mukca_lcm_log *log, mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "LCM log %s: %s: recording of the raw stream ends here",
                      log->path, strerror(errno));
}

mukca_status mukca_lcm_log_write(mukca_lcm_log *log, const char *channel, int64_t time,
                                 const void *data, size_t size, mukca_error *error)
{
    unsigned char head[HEADER];
    size_t n_channel = strlen(channel);
    memcpy(head, sync_word, 4);
    mukca_lcm_wire_put(head + 4, (uint64_t)log->number++, 8);
    mukca_lcm_wire_put(head + 12, (uint64_t)time, 8);
    mukca_lcm_wire_put(head + 20, n_channel, 4);
    mukca_lcm_wire_put(head + 24, size, 4);
    if (fwrite(head, 1, sizeof head, log->file) != sizeof head ||
        fwrite(channel, 1, n_channel, log->file) != n_channel ||
        fwrite(data, 1, size, log->file) != size)
        return write_error(log, error);
    return MUKCA_OK;
}

mukca_status mukca_lcm_log_flush(mukca_lcm_log *log, mukca_error *error)
{
    return fflush(log->file) ? write_error(log, error) : MUKCA_OK;
}

mukca_status mukca_lcm_log_finish(mukca_lcm_log *log, mukca_error *error)
{
    mukca_status status = mukca_lcm_log_flush(log, error);
    if (status == MUKCA_OK && fsync(fileno(log->file)) && errno != EINVAL) /* pipes have no fsync */
        status = write_error(log, error);
    mukca_lcm_log_close(log);
    return status;
}

void mukca_lcm_log_close(mukca_lcm_log *log)
{
    if (log->file) fclose(log->file);
    free(log->data);
    log->file = NULL;
    log->data = NULL;
}
