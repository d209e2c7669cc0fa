/* LCM event logs (as lcm-logger writes them), read and written with capped lengths. */
#ifndef MUKCA_LCM_LOG_H
#define MUKCA_LCM_LOG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "mukca/status.h"

typedef struct {
    int64_t time; /* us since 1970, when it was logged */
    char channel[64];
    const void *data; /* valid until the next read */
    size_t size;
} mukca_lcm_event;

/* Zeroed: closed. */
typedef struct {
    FILE *file;
    char path[1024];
    int64_t length;  /* of the file, bytes; reading */
    int64_t number;  /* of the next event; writing */
    int64_t skipped; /* bytes that were no event, or too long for one; reading */
    bool exhausted;  /* out of memory for an event */
    unsigned char *data;
    size_t capacity;
} mukca_lcm_log;

/* Errors: MUKCA_INPUT (cannot be opened; is no log; exists, when writing without `force`). */
mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error);
mukca_status mukca_lcm_log_create(mukca_lcm_log *log, const char *path, bool force,
                                  mukca_error *error);

/* Next event; false at the end.  Skips to the next sync word where the file is damaged. */
bool mukca_lcm_log_read(mukca_lcm_log *log, mukca_lcm_event *event);

/* Errors: MUKCA_MEMORY (disk full and the like).  Buffered: see mukca_lcm_log_flush. */
mukca_status mukca_lcm_log_write(mukca_lcm_log *log, const char *channel, int64_t time,
                                 const void *data, size_t size, mukca_error *error);
mukca_status mukca_lcm_log_flush(mukca_lcm_log *log, mukca_error *error);

/* Put all of it on disk and close it.  Errors: MUKCA_MEMORY. */
mukca_status mukca_lcm_log_finish(mukca_lcm_log *log, mukca_error *error);

/* Harmless on a closed one. */
void mukca_lcm_log_close(mukca_lcm_log *log);

#endif
