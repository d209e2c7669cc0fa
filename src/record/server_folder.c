/* The server's folder, its state on disk, and notifications of the service manager.
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
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/file.h"
#include "io/output.h"
#include "record/server.h"

void mukca_server_path(char path[MUKCA_SERVER_PATH], const mukca_server *s, const char *folder,
                       const char *name, const char *ending)
{
    snprintf(path, MUKCA_SERVER_PATH, "%.700s/%s%s%.255s%s", s->options->folder, folder,
             *folder ? "/" : "", name, ending);
}

bool mukca_server_name_ok(const char *name)
{
    const size_t n =
        strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.");
    return n > 0 && n <= 40 && !name[n] && name[0] != '.' && name[0] != '-';
}

bool mukca_server_session_of(char session[MUKCA_NAME_SIZE], const char *result)
{
    const size_t n = strlen(result), ending = strlen(".offsets.tsv"); /* as long as .effects.tsv */
    const char *end = n > ending ? result + n - ending : "";
    session[0] = '\0';
    if (strcmp(end, ".offsets.tsv") != 0 && strcmp(end, ".effects.tsv") != 0) return false;
    snprintf(session, MUKCA_NAME_SIZE, "%.*s", (int)(n - ending), result);
    return n - ending < MUKCA_NAME_SIZE && mukca_server_name_ok(session);
}

static bool is_result(const char *value)
{
    char session[MUKCA_NAME_SIZE];
    return mukca_server_session_of(session, value);
}

static const struct {
    const char *key;
    size_t offset, size;
    bool (*ok)(const char *value);
} fields[] = {
#define FIELD(name, size, ok) {#name, offsetof(mukca_server_state, name), size, ok},
    MUKCA_SERVER_STATE_LIST(FIELD)
#undef FIELD
};
enum { FIELDS = sizeof fields / sizeof fields[0] };

/* Set a field; keys of a later version are ignored. */
static bool set_field(mukca_server_state *state, const char *key, const char *value)
{
    for (int i = 0; i < FIELDS; i++) {
        if (strcmp(key, fields[i].key) != 0) continue;
        if (strlen(value) >= fields[i].size) return false;
        if (*value && fields[i].ok && !fields[i].ok(value)) return false;
        char *field = (char *)state + fields[i].offset;
        memset(field, 0, fields[i].size); /* states are compared bytewise */
        snprintf(field, fields[i].size, "%s", value);
    }
    return true;
}

mukca_status mukca_server_load_state(mukca_server *s, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH], line[512];
    mukca_status status = MUKCA_OK;
    memset(&s->state, 0, sizeof s->state);
    mukca_server_path(path, s, "", "state", ".tsv");
    FILE *file = fopen(path, "r");
    if (!file && errno != ENOENT) return mukca_file_fail(error, path);
    for (int n = 1; !status && file && fgets(line, sizeof line, file); n++) {
        char *value = strchr(line, '\t');
        line[strcspn(line, "\n")] = '\0';
        if (!value) continue;
        *value++ = '\0';
        if (!set_field(&s->state, line, value))
            status = mukca_fail(error, MUKCA_INPUT,
                                "%s:%d: %.20s is damaged; correct or remove the line",
                                mukca_file_shown(path), n, line);
    }
    if (file && !mukca_file_close(file, NULL)) return mukca_file_fail(error, path);
    if (status == MUKCA_OK) s->saved = s->state;
    return status;
}

mukca_status mukca_server_save_state(mukca_server *s, mukca_error *error)
{
    char path[MUKCA_SERVER_PATH];
    mukca_output output;
    if (memcmp(&s->state, &s->saved, sizeof s->state) == 0) return MUKCA_OK;
    mukca_server_path(path, s, "", "state", ".tsv");
    MUKCA_TRY(mukca_output_open(&output, path, true, error));
    for (int i = 0; i < FIELDS; i++)
        fprintf(output.stream, "%s\t%s\n", fields[i].key,
                (const char *)&s->state + fields[i].offset);
    mukca_status status = mukca_output_close(&output, error);
    if (status == MUKCA_OK)
        s->saved = s->state;
    else
        memset(&s->saved, 0xff, sizeof s->saved); /* content unknown: write it again */
    return status;
}

/* Send one datagram of the protocol of sd_notify(3). */
void mukca_server_notify(const char *text)
{
    const char *name = getenv("NOTIFY_SOCKET");
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (!name || (name[0] != '/' && name[0] != '@') || strlen(name) >= sizeof address.sun_path)
        return;
    memcpy(address.sun_path, name, strlen(name) + 1);
    if (name[0] == '@') address.sun_path[0] = '\0';
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return;
    socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(name));
    /* fails if no manager is listening */
    (void)!sendto(fd, text, strlen(text), MSG_NOSIGNAL, (const struct sockaddr *)&address, size);
    close(fd);
}

/* ---- the folder ---- */

static mukca_status fail(const char *path, mukca_error *error)
{
    return mukca_fail(error, mukca_output_status(errno), "--state %.200s: %s", path,
                      strerror(errno));
}

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
    mukca_server_path(path, s, "", "lock", "");
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0) return fail(path, error);
    s->lock = fd;
    s->locked = true;
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

/* Remove the temporary files of killed writers in DIR/folder. */
static mukca_status tidy(const char *path, mukca_error *error)
{
    DIR *entries = opendir(path);
    if (!entries) return fail(path, error);
    for (const struct dirent *e; (e = readdir(entries));) {
        const char *ending = strrchr(e->d_name, '.');
        if (e->d_name[0] == '.' && ending > e->d_name && strcmp(ending, ".tmp") == 0)
            (void)!unlinkat(dirfd(entries), e->d_name, 0); /* a leftover file does no harm */
    }
    closedir(entries);
    return MUKCA_OK;
}

mukca_status mukca_server_open_folder(mukca_server *s, mukca_error *error)
{
    static const char *const folders[] = {"", MUKCA_SERVER_SESSIONS, MUKCA_SERVER_RESULTS};
    MUKCA_TRY(make_folder(s->options->folder, error));
    MUKCA_TRY(lock(s, error));
    for (int i = 0; i < 3; i++) {
        char path[MUKCA_SERVER_PATH];
        mukca_server_path(path, s, "", folders[i], "");
        MUKCA_TRY(make_folder(path, error));
        MUKCA_TRY(tidy(path, error));
    }
    return MUKCA_OK;
}
