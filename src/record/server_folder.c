/* The server's folder: lock, separate folders for sessions and results, removal of temporary files.
 *
 *   DIR/state.tsv      state that survives a restart
 *   DIR/in_use.tsv     offsets table of the poses
 *   DIR/lock           locked while a server runs; contains its process number
 *   DIR/sessions/      NAME.tsv
 *   DIR/results/       NAME.offsets.tsv and other results of jobs
 *
 * Session names come from the network and must not collide with other files. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/output.h"
#include "record/server.h"

static mukca_status fail(const char *path, mukca_error *error)
{
    return mukca_fail(error, mukca_output_status(errno), "--state %.200s: %s", path,
                      strerror(errno));
}

/* Create the folder `path` if it does not exist. */
static mukca_status make_folder(const char *path, mukca_error *error)
{
    if (mkdir(path, 0777) == 0 ? !mukca_output_sync_folder(path) : errno != EEXIST)
        return fail(path, error);
    if (access(path, R_OK | W_OK | X_OK))
        return mukca_fail(error, MUKCA_INPUT,
                          "--state %.200s: must be a folder that can be written", path);
    return MUKCA_OK;
}

/* Lock the folder until the server is closed. */
static mukca_status lock(mukca_server *s, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH], holder[32] = "";
    snprintf(path, sizeof path, "%.800s/lock", s->options->folder);
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0) return fail(path, error);
    s->lock = fd + 1;
    if (!mukca_output_lock(fd)) {
        ssize_t n = pread(fd, holder, sizeof holder - 1, 0);
        long process = n > 0 ? strtol(holder, NULL, 10) : 0;
        return mukca_fail(error, MUKCA_INPUT,
                          "--state %.150s: in use by another mukca serve, process %ld; stop it, or "
                          "name another folder",
                          s->options->folder, process);
    }
    int n = snprintf(holder, sizeof holder, "%ld\n", (long)getpid());
    if (ftruncate(fd, 0) || pwrite(fd, holder, (size_t)n, 0) != n) return fail(path, error);
    return MUKCA_OK;
}

static bool ends_with(const char *name, const char *ending)
{
    const size_t length = strlen(name), end = strlen(ending);
    return length > end && strcmp(name + length - end, ending) == 0;
}

/* Remove the temporary files of killed writers in DIR/folder. */
static mukca_status tidy(const char *path, mukca_error *error)
{
    DIR *entries = opendir(path);
    if (!entries) return fail(path, error);
    for (const struct dirent *e; (e = readdir(entries));)
        if (e->d_name[0] == '.' && ends_with(e->d_name, ".tmp"))
            (void)!unlinkat(dirfd(entries), e->d_name, 0); /* a leftover file does no harm */
    closedir(entries);
    return MUKCA_OK;
}

mukca_status mukca_server_open_folder(mukca_server *s, mukca_error *error)
{
    static const char *const folders[] = {"", MUKCA_SERVER_SESSIONS, MUKCA_SERVER_RESULTS};
    mukca_status status = make_folder(s->options->folder, error);
    if (status == MUKCA_OK) status = lock(s, error);
    for (int i = 0; i < 3 && status == MUKCA_OK; i++) {
        char path[MUKCA_SERVER_PATH];
        snprintf(path, sizeof path, "%.800s/%s", s->options->folder, folders[i]);
        status = make_folder(path, error);
        if (status == MUKCA_OK) status = tidy(path, error);
    }
    return status;
}
