/* LCM event logs (the format of lcm-logger), read and written with bounded lengths. */
#ifndef MUKCA_LCM_LOG_H
#define MUKCA_LCM_LOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "mukca/status.h"

typedef struct {
    int64_t time; /* us since 1970, time of logging */
    char channel[64];
    const void *data; /* valid until the next read */
    size_t size;
} mukca_lcm_event;

/* Zeroed: closed. */
typedef struct {
    FILE *file;
    const char *path;
    int64_t length;  /* reading: bytes of the file */
    int64_t number;  /* writing: number of the next event */
    int64_t skipped; /* reading: bytes outside events, or of events that are too long */
    bool exhausted;  /* memory for an event was exhausted */
    unsigned char *data;
    size_t capacity;
} mukca_lcm_log;

/* Open a log; `path` must outlive it.  Errors: MUKCA_INPUT (cannot be opened; not a log; create:
 * exists, without `force`). */
mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error);
mukca_status mukca_lcm_log_create(mukca_lcm_log *log, const char *path, bool force,
                                  mukca_error *error);

/* Read the next event; false at the end.  Skips damaged parts up to the next sync word. */
bool mukca_lcm_log_read(mukca_lcm_log *log, mukca_lcm_event *event);

/* Append an event, buffered (see mukca_lcm_log_flush).  Errors: MUKCA_MEMORY (disk full and the
 * like). */
mukca_status mukca_lcm_log_write(mukca_lcm_log *log, const char *channel, int64_t time,
                                 const void *data, size_t size, mukca_error *error);
mukca_status mukca_lcm_log_flush(mukca_lcm_log *log, mukca_error *error);

/* Sync the file and close it.  Errors: MUKCA_MEMORY. */
mukca_status mukca_lcm_log_finish(mukca_lcm_log *log, mukca_error *error);

/* Harmless on a closed log. */
void mukca_lcm_log_close(mukca_lcm_log *log);

#endif
