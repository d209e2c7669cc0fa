/* A folder for readers that take one: in memory where the system has such a place, removed at the
 * end. */
#ifndef MUKCA_FUZZ_MEMORY_FOLDER_H
#define MUKCA_FUZZ_MEMORY_FOLDER_H

#include <dirent.h>
#include <fcntl.h>

#include "memory_file.h"

static char memory_folder_path[64];

/* Remove the folder's files. */
static inline void memory_folder_clear(void)
{
    DIR *folder = opendir(memory_folder_path);
    if (!folder) abort();
    for (const struct dirent *e; (e = readdir(folder));)
        if (e->d_name[0] != '.' && unlinkat(dirfd(folder), e->d_name, 0)) abort();
    closedir(folder);
}

static inline void memory_folder_remove(void)
{
    memory_folder_clear();
    rmdir(memory_folder_path);
}

/* The folder, empty. */
static inline const char *memory_folder(void)
{
    if (!memory_folder_path[0]) {
        snprintf(memory_folder_path, sizeof memory_folder_path, "%s/mukca_fuzz_XXXXXX",
                 access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
        if (!mkdtemp(memory_folder_path) || atexit(memory_folder_remove)) abort();
    }
    memory_folder_clear();
    return memory_folder_path;
}

/* Write a file of the folder. */
static inline void memory_folder_write(const char *name, const uint8_t *bytes, size_t size)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", memory_folder_path, name);
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0 || write(file, bytes, size) != (ssize_t)size || close(file)) abort();
}

#endif
