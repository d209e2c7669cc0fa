/* LCM event logs (the format of lcm-logger), read with bounded lengths. */
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
    int64_t length;  /* bytes of the file */
    int64_t skipped; /* bytes outside events, or of events that are too long */
    bool exhausted;  /* memory for an event was exhausted */
    unsigned char *data;
    size_t capacity;
} mukca_lcm_log;

/* Open a log; `path` must outlive it.  Errors: MUKCA_INPUT (cannot be opened). */
mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error);

/* Read the next event; false at the end.  Skips damaged parts up to the next sync word. */
bool mukca_lcm_log_read(mukca_lcm_log *log, mukca_lcm_event *event);

/* Harmless on a closed log. */
void mukca_lcm_log_close(mukca_lcm_log *log);

#endif
