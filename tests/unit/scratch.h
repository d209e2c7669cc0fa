/* Files that a test writes: a folder of its own, removed at the end. */
#ifndef MUKCA_TESTS_SCRATCH_H
#define MUKCA_TESTS_SCRATCH_H

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include "close.h"

static char scratch_folder[64];

FIXTURE(scratch_setup)
{
    snprintf(scratch_folder, sizeof scratch_folder, "/tmp/mukca_test_XXXXXX");
    return mkdtemp(scratch_folder) ? 0 : 1;
}

static inline int scratch_remove(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir) return 1;
    for (struct dirent *e; (e = readdir(dir));) {
        char path[512];
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0) continue;
        snprintf(path, sizeof path, "%.200s/%.255s", folder, e->d_name);
        if (unlink(path) != 0) scratch_remove(path);
    }
    closedir(dir);
    return rmdir(folder);
}

FIXTURE(scratch_teardown)
{
    return scratch_remove(scratch_folder);
}

/* Path of a file of that name in the folder; eight are kept. */
static inline char *scratch_path(const char *name)
{
    static char path[8][256];
    static int next;
    char *p = path[next++ % 8];
    snprintf(p, sizeof path[0], "%s/%s", scratch_folder, name);
    return p;
}

/* Write bytes to a file of that name in the folder (made where the name has one); its path. */
static inline const char *scratch_bytes(const char *name, const char *bytes, size_t length)
{
    char *p = scratch_path(name), *slash = strrchr(p, '/');
    *slash = '\0';
    mkdir(p, 0777);
    *slash = '/';
    FILE *file = fopen(p, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
    return p;
}

static inline const char *scratch_file(const char *name, const char *text)
{
    return scratch_bytes(name, text, strlen(text));
}

/* A file of that name in the folder, open for writing; its path. */
static inline FILE *scratch_create(const char **path, const char *name)
{
    *path = scratch_file(name, "");
    FILE *file = fopen(*path, "w");
    assert_non_null(file);
    return file;
}

/* The whole of a file, ended by a zero byte; free it. */
static inline char *scratch_read(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    char *text = zeroed((size_t)size + 1, 1);
    assert_int_equal(fread(text, 1, (size_t)size, file), size);
    fclose(file);
    return text;
}

#endif
