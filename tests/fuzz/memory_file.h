/* Input as text or as a file in memory, and what holds of every refusal; with the C library. */
#ifndef MUKCA_FUZZ_MEMORY_FILE_H
#define MUKCA_FUZZ_MEMORY_FILE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "mukca/status.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

/* A refusal says why in one line. */
static inline void check_refusal(mukca_status status, const mukca_error *error)
{
    if (status && (!error->text[0] || strchr(error->text, '\n'))) abort();
}

/* The input as text, to be freed. */
static inline char *as_text(const uint8_t *bytes, size_t size)
{
    char *text = calloc(1, size + 1);
    if (!text) abort();
    return memcpy(text, bytes, size);
}

/* The input's file, for readers that take a path: up to four are open at a time. */
static inline const char *memory_file(const uint8_t *bytes, size_t size)
{
    static int file[4] = {-1, -1, -1, -1}, next;
    static char name[4][32];
    int k = next++ % 4;
    if (file[k] >= 0) close(file[k]);
    file[k] = (int)syscall(SYS_memfd_create, "fuzz", 0);
    if (file[k] < 0 || write(file[k], bytes, size) != (ssize_t)size) abort();
    snprintf(name[k], sizeof name[k], "/proc/self/fd/%d", file[k]);
    return name[k];
}

#endif
