/* Atomic output: files appear complete or not at all. */
#include "io/output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Length of the folder part of a path, including the slash; 0: none. */
static int folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path + 1) : 0;
}

mukca_status mukca_output_status(int reason)
{
    return reason == ENOMEM || reason == ENOSPC || reason == EDQUOT || reason == EIO ||
                   reason == EFBIG
               ? MUKCA_MEMORY
               : MUKCA_INPUT;
}

static mukca_status fail_errno(mukca_error *error, mukca_status status, const char *path)
{
    const char *hint = errno == EACCES || errno == EROFS || errno == EPERM
                           ? "; choose a folder that you may write to"
                       : errno == ENOENT ? "; make its folder first"
                       : errno == ENOSPC ? "; free some space"
                                         : "";
    return mukca_fail(error, status, "%s: cannot write: %s%s", path, strerror(errno), hint);
}

static mukca_status fail_exists(mukca_error *error, const char *path)
{
    return mukca_fail(error, MUKCA_INPUT, "%s: exists already; --force overwrites it", path);
}

/* Close the stream and remove the temporary file; harmless on a closed output. */
static void give_up(mukca_output *output)
{
    if (output->stream && output->stream != stdout) fclose(output->stream);
    if (output->stream && output->temporary[0]) unlink(output->temporary);
    output->stream = NULL;
}

/* Set the output's path and temporary name. */
static mukca_status resolve(mukca_output *output, const char *path, bool force, mukca_error *error)
{
    struct stat info;
    char whole[PATH_MAX];
    bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return mukca_fail(error, MUKCA_INPUT, "%s: is a folder; give the name of a file", path);
    const char *target = exists && realpath(path, whole) ? whole : path;
    if (snprintf(output->path, sizeof output->path, "%s", target) >= (int)sizeof output->path)
        return mukca_fail(error, MUKCA_INPUT, "%.60s...: the file's name is too long", path);
    if (exists && !S_ISREG(info.st_mode)) return MUKCA_OK;
    if (exists && !force) return fail_exists(error, path);
    int folder = folder_length(output->path); /* the rest adds at most 26 characters to the path */
    snprintf(output->temporary, sizeof output->temporary, "%.*s.%.80s.%ld.tmp", folder,
             output->path, output->path + folder, (long)getpid());
    return MUKCA_OK;
}

/* Resolve `.`, `..` and links in the path; unchanged if its folder does not exist. */
static void normalise(char whole[PATH_MAX + NAME_MAX + 2], const char *path)
{
    char folder[PATH_MAX];
    const int length = folder_length(path);
    if (realpath(path, whole)) return;
    snprintf(folder, sizeof folder, "%.*s", length ? length : 1, length ? path : ".");
    if (realpath(folder, whole))
        snprintf(whole + strlen(whole), NAME_MAX + 2, "/%.*s", (int)NAME_MAX, path + length);
    else
        snprintf(whole, PATH_MAX, "%s", path);
}

bool mukca_output_same(const char *a, const char *b)
{
    char one[PATH_MAX + NAME_MAX + 2], other[PATH_MAX + NAME_MAX + 2];
    struct stat info;
    if (!a || !b) return false;
    if (stat(a, &info) == 0 && !S_ISREG(info.st_mode)) return false; /* allowed for devices */
    if (strcmp(a, "-") == 0 || strcmp(b, "-") == 0) return strcmp(a, b) == 0;
    normalise(one, a);
    normalise(other, b);
    return strcmp(one, other) == 0;
}

mukca_status mukca_output_check(const char *path, bool force, mukca_error *error)
{
    if (strcmp(path, "-") == 0) return MUKCA_OK;
    mukca_output output;
    struct stat info;
    if (stat(path, &info) == 0 && S_ISFIFO(info.st_mode)) /* closing a FIFO would end its reader */
        return access(path, W_OK) == 0 ? MUKCA_OK : fail_errno(error, MUKCA_INPUT, path);
    mukca_status status = mukca_output_open(&output, path, force, error);
    give_up(&output);
    return status;
}

mukca_status mukca_output_open(mukca_output *output, const char *path, bool force,
                               mukca_error *error)
{
    memset(output, 0, sizeof *output);
    if (strcmp(path, "-") == 0) {
        snprintf(output->path, sizeof output->path, "standard output");
        output->stream = stdout;
        return MUKCA_OK;
    }
    mukca_status status = resolve(output, path, force, error);
    output->force = force;
    if (status != MUKCA_OK) return status;
    int flags = output->temporary[0] ? O_CREAT | O_EXCL : 0;
    const char *name = output->temporary[0] ? output->temporary : output->path;
    if (output->temporary[0]) unlink(name); /* left by a killed process of the same number */
    int file = open(name, O_WRONLY | O_CLOEXEC | flags, 0666);
    struct stat info;
    if (file >= 0 && output->temporary[0] && stat(output->path, &info) == 0)
        (void)!fchmod(file, info.st_mode & 0777);
    output->stream = file < 0 ? NULL : fdopen(file, "w");
    if (!output->stream) {
        status = fail_errno(error, mukca_output_status(errno), path);
        if (file >= 0) close(file);
        if (file >= 0 && output->temporary[0]) unlink(output->temporary);
    }
    return status;
}

bool mukca_output_sync_folder(const char *path)
{
    char folder[PATH_MAX];
    const int length = folder_length(path);
    snprintf(folder, sizeof folder, "%.*s", length ? length : 1, length ? path : ".");
    int file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return false;
    const bool good = fsync(file) == 0 || errno == EINVAL; /* some file systems lack fsync */
    const int reason = errno;
    close(file);
    errno = reason;
    return good;
}

bool mukca_output_lock(int file)
{
    const struct timespec pause = {.tv_nsec = 10000000};
    for (int tries = 100; flock(file, LOCK_EX | LOCK_NB); tries--)
        if (tries == 0 || errno != EWOULDBLOCK || nanosleep(&pause, NULL)) return false;
    return true;
}

bool mukca_output_flush(FILE *stream)
{
    errno = EIO;
    if (fflush(stream) != 0) return false;
    if (!ferror(stream)) return true;
    /* the errno of an earlier failed write is lost: provoke it again */
    if (fputc('\n', stream) != EOF) (void)fflush(stream);
    return false;
}

mukca_status mukca_output_close(mukca_output *output, mukca_error *error)
{
    FILE *stream = output->stream;
    bool regular = output->temporary[0] != '\0';
    bool good = mukca_output_flush(stream);
    if (good && regular) good = fsync(fileno(stream)) == 0;
    int reason = errno;
    if (good && regular) {
        /* detect a file created meanwhile by another process; some file systems have no links */
        const bool linked = !output->force && link(output->temporary, output->path) == 0;
        if (!linked && !output->force && access(output->path, F_OK) == 0) {
            give_up(output);
            return fail_exists(error, output->path);
        }
        good =
            linked ? unlink(output->temporary) == 0 : rename(output->temporary, output->path) == 0;
        if (good) output->temporary[0] = '\0';
        good = good && mukca_output_sync_folder(output->path);
        reason = errno;
        if (linked && !good) unlink(output->path);
    }
    give_up(output);
    if (good) return MUKCA_OK;
    errno = reason;
    return fail_errno(error, MUKCA_MEMORY, output->path);
}

mukca_status mukca_output_finish(mukca_output *output, mukca_status status, mukca_error *error)
{
    if (status == MUKCA_OK && output->stream) return mukca_output_close(output, error);
    give_up(output);
    return status;
}
