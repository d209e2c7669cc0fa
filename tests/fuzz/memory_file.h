/* A file in memory for readers that take a path: its name is good until the next one is made. */
#ifndef MUKCA_FUZZ_MEMORY_FILE_H
#define MUKCA_FUZZ_MEMORY_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

/* Up to four files are open at a time. */
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
