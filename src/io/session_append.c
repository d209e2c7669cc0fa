/* A session file that grows while it is recorded.
 *
 * Safe against a kill or a power cut at any moment: a row is one write at the end followed by
 * fsync; an undo changes one byte (the first of the row becomes #).  Text after the last newline
 * was never acknowledged. */
#include "io/session_append.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/list.h"
#include "base/text.h"
#include "io/dataset.h"
#include "io/output.h"

enum { LINE_SIZE = MUKCA_SESSION_LINE, MAX_SESSION = 1 << 27 };

static mukca_status fail(const mukca_session *session, const char *what, mukca_error *error)
{
    return mukca_fail(error, mukca_output_status(errno), "%s: %s: %s", session->path, what,
                      strerror(errno));
}

static mukca_status fail_write(const mukca_session *session, const char *what, mukca_error *error)
{
    return mukca_fail(error, MUKCA_MEMORY, "%s: %s: %s%s", session->path, what, strerror(errno),
                      errno == ENOSPC ? "; free some space" : "");
}

bool mukca_session_label_ok(const char *label)
{
    size_t n = strlen(label);
    if (n < 1 || n >= MUKCA_NAME_SIZE || label[0] == '#' || label[0] == ' ') return false;
    for (const char *c = label; *c; c++)
        if (strchr("\t\n,;\"", *c)) return false;
    return label[n - 1] != ' ' && mukca_utf8_valid(label);
}

/* ---- writing ---- */

/* Truncate the file after the acknowledged rows. */
static bool cut(mukca_session *session)
{
    if (session->uncut && ftruncate(session->fd, session->length)) return false;
    session->uncut = false;
    return true;
}

/* Write the acknowledged rows again to a path that is gone; false: it failed. */
static bool restore(const mukca_session *session)
{
    char bytes[LINE_SIZE];
    mukca_output output;
    if (mukca_output_open(&output, session->path, false, NULL) != MUKCA_OK) return false;
    off_t at = 0;
    for (ssize_t n; (n = pread(session->fd, bytes, sizeof bytes, at)) > 0; at += n)
        fwrite(bytes, 1, (size_t)n, output.stream); /* mukca_output_finish detects failures */
    const bool whole = at >= session->length;
    return !mukca_output_finish(&output, whole ? MUKCA_OK : MUKCA_MEMORY, NULL);
}

/* Check that the path still names the open file, with the acknowledged rows: what is written to a
 * file that an editor has replaced is lost. */
static mukca_status check_path(const mukca_session *session, mukca_error *error)
{
    struct stat named, opened;
    const bool gone = stat(session->path, &named) != 0;
    if (!gone && fstat(session->fd, &opened) == 0 && named.st_dev == opened.st_dev &&
        named.st_ino == opened.st_ino &&
        (session->uncut ? opened.st_size >= session->length : opened.st_size == session->length))
        return MUKCA_OK;
    const char *what = !gone              ? "changed"
                       : restore(session) ? "deleted or moved, and written again,"
                                          : "deleted or moved";
    return mukca_fail(error, MUKCA_MEMORY,
                      "%s was %s during the recording; finish, check the file, then resume it",
                      session->path, what);
}

/* Append text and sync it; on failure the file is restored. */
static mukca_status commit(mukca_session *session, const char *text, size_t length,
                           mukca_error *error)
{
    int fd = session->fd;
    size_t done = 0;
    MUKCA_TRY(check_path(session, error));
    if (!cut(session)) return fail_write(session, "not recorded", error);
    session->uncut = true;
    while (done < length) {
        ssize_t n = pwrite(fd, text + done, length - done, session->length + (off_t)done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        done += (size_t)n;
    }
    if (done == length && fsync(fd) == 0) {
        session->length += (int64_t)length;
        session->uncut = false;
        return MUKCA_OK;
    }
    mukca_status status = fail_write(session, "not recorded", error);
    (void)cut(session); /* if this fails, before the next row */
    return status;
}

/* Put the row of a sample, NULL: of the columns' names. */
static void put_row(mukca_text *line, const mukca_session *session, const char *placement,
                    const char *socket, const mukca_capture_sample *sample)
{
    static const mukca_capture_sample none;
    const mukca_capture_sample *values = sample ? sample : &none;
    const struct {
        const char *suffix;
        const double *values; /* NULL: absent */
    } columns[] = {{"", values->q},
                   {MUKCA_COLUMNS_SPREAD, values->spread},
                   {".effort", session->has_effort ? values->effort : NULL},
                   {".command", session->has_command ? values->command : NULL}};
    const char s = session->separator;
    mukca_text_put(line, sample ? "%s%c%s%c%.6f" : "%s%c%s%ctime_s", placement, s, socket, s,
                   values->time);
    for (int k = 0; k < 4; k++)
        for (int j = 0; columns[k].values && j < session->chain->n_joints; j++)
            if (!sample)
                mukca_text_put(line, "%c%s%s", s, mukca_chain_joint_name(session->chain, j),
                               columns[k].suffix);
            else
                mukca_text_put(line, isfinite(columns[k].values[j]) ? "%c%.17g" : "%cnan", s,
                               columns[k].values[j]);
    mukca_text_put(line, "\n");
}

mukca_status mukca_session_delete(mukca_session *session, const char *placement, const char *socket,
                                  mukca_error *error)
{
    if (session->n_rows < 1)
        return mukca_fail(error, MUKCA_INPUT, "%s: no row to delete", session->path);
    const int64_t at = session->row_at[session->n_rows - 1];
    MUKCA_TRY(check_path(session, error));
    if (pwrite(session->fd, "#", 1, at) != 1 || fsync(session->fd)) {
        const mukca_status status = fail_write(session, "not deleted", error);
        (void)!pwrite(session->fd, placement, 1, at); /* the first byte of the row */
        return status;
    }
    char buffer[LINE_SIZE];
    mukca_text line = MUKCA_TEXT(buffer);
    mukca_text_put(&line,
                   "# undone: row %d, placement %s, socket %s (the line that now begins with #)\n",
                   session->n_rows--, placement, socket);
    (void)commit(session, line.at, line.used, NULL); /* undone without this, too */
    return MUKCA_OK;
}

/* ---- header ---- */

/* "# key: value" lines whose values must be equal on resume. */
static const struct {
    const char *key, *refusal;
} origins[] = {
    {"# urdf_sha256: ", "recorded with another URDF; use that one: SHA-256"},
    {"# stream: ", "do not mix streams; recorded with --stream"},
};
enum { ORIGINS = sizeof origins / sizeof *origins };

static const char *origin(const mukca_session_task *task, int k)
{
    return k ? task->stream : task->chain->urdf_sha256;
}

static const char first_line[] = "# mukca session\n";

static void put_header(mukca_session *session, const mukca_session_task *task)
{
    mukca_text line = MUKCA_TEXT(session->header);
    mukca_text_put(&line, "%s# robot: %s\n# base: %s\n# tip: %s\n", first_line, task->chain->robot,
                   task->chain->base, task->chain->tip);
    for (int k = 0; k < ORIGINS; k++)
        mukca_text_put(&line, "%s%s\n", origins[k].key, origin(task, k));
    mukca_text_put(&line, "# channel: %s (%s)\n", task->channel, task->type);
    mukca_text_put(
        &line,
        "# a row is the mean of a still window; .spread is the standard deviation within it\n");
    put_row(&line, session, "placement", "socket", NULL);
}

/* Open an existing file and lock it. */
static mukca_status open_file(mukca_session *session, mukca_error *error)
{
    struct stat st;
    int fd = open(session->path, O_RDWR | O_CLOEXEC);
    session->fd = fd;
    if (fd < 0) return fail(session, "cannot be written", error);
    if (fstat(fd, &st) || !S_ISREG(st.st_mode))
        return mukca_fail(error, MUKCA_INPUT, "%s: not a regular file", session->path);
    if (!mukca_output_lock(fd))
        return mukca_fail(error, MUKCA_INPUT, "%s: another mukca is recording it", session->path);
    session->length = st.st_size;
    return MUKCA_OK;
}

/* Write header and first row atomically to a new file, or over an old one, which stays if this
 * fails. */
static mukca_status create(mukca_session *session, const char *row, mukca_error *error)
{
    mukca_output output;
    MUKCA_TRY(mukca_output_open(&output, session->path, session->fd >= 0, error));
    fprintf(output.stream, "%s%s", session->header, row); /* mukca_output_close detects failures */
    MUKCA_TRY(mukca_output_close(&output, error));
    if (session->fd >= 0) close(session->fd);
    session->header[0] = '\0';
    return open_file(session, error);
}

mukca_status mukca_session_add(mukca_session *session, const char *placement, const char *socket,
                               const mukca_capture_sample *sample, mukca_error *error)
{
    char buffer[LINE_SIZE];
    mukca_text line = MUKCA_TEXT(buffer);
    int n = session->n_rows;
    int64_t *place = mukca_list_append(&session->row_at, &n, sizeof *place);
    if (!place) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    put_row(&line, session, placement, socket, sample);
    *place = session->header[0] ? (int64_t)strlen(session->header) : session->length;
    mukca_status status = session->header[0] ? create(session, line.at, error)
                                             : commit(session, line.at, line.used, error);
    if (status == MUKCA_OK) session->n_rows = n;
    return status;
}

/* ---- opening ---- */

static mukca_status check_comment(const mukca_session *session, const char *comment,
                                  const mukca_session_task *task, mukca_error *error)
{
    for (int k = 0; k < ORIGINS; k++) {
        const size_t n = strlen(origins[k].key);
        if (strncmp(comment, origins[k].key, n) == 0 && strcmp(comment + n, origin(task, k)) != 0)
            return mukca_fail(error, MUKCA_INPUT, "%s: %s %.16s", session->path, origins[k].refusal,
                              comment + n);
    }
    return MUKCA_OK;
}

/* Check the comments, look for the column line, and index the rows.  text, which is split into
 * lines, is empty or ends in a newline. */
static mukca_status scan(mukca_session *session, bool *has_columns, char *text,
                         const mukca_session_task *task, mukca_error *error)
{
    char buffer[LINE_SIZE];
    mukca_text columns = MUKCA_TEXT(buffer);
    put_row(&columns, session, "placement", "socket", NULL);
    columns.at[columns.used - 1] = '\0';
    *has_columns = false;
    for (char *at = text, *end; *at; at = end + 1) {
        end = strchr(at, '\n');
        if (!end) return mukca_fail(error, MUKCA_INPUT, "%s: not a text file", session->path);
        *end = '\0';
        if (end > at && end[-1] == '\r') end[-1] = '\0';
        if (at[0] == '#') {
            MUKCA_TRY(check_comment(session, at, task, error));
        } else if (at[0] && !*has_columns) {
            if (strcmp(at, columns.at) != 0)
                return mukca_fail(
                    error, MUKCA_INPUT,
                    "%s: other columns than those of this stream; begin another session",
                    session->path);
            *has_columns = true;
        } else if (at[0]) {
            int64_t *place = mukca_list_append(&session->row_at, &session->n_rows, sizeof *place);
            if (!place) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
            *place = at - text;
        }
    }
    return MUKCA_OK;
}

/* Read a file to be resumed: check its header, index its rows and remove the rest of an unfinished
 * one.  *has_columns false: it is empty, or truncated within the header. */
static mukca_status load(mukca_session *session, bool *has_columns, const mukca_session_task *task,
                         mukca_error *error)
{
    const int64_t length = session->length;
    if (length > MAX_SESSION)
        return mukca_fail(error, MUKCA_INPUT, "%s: too large for a session", session->path);
    char *text = malloc((size_t)length + 1);
    if (!text) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_status status = MUKCA_OK;
    if (pread(session->fd, text, (size_t)length, 0) != length) {
        status = fail(session, "cannot be read", error);
        goto out;
    }
    const size_t first = strlen(first_line);
    const bool ours =
        strncmp(text, first_line, (size_t)length < first ? (size_t)length : first) == 0;
    while (session->length > 0 && text[session->length - 1] != '\n') session->length--;
    text[session->length] = '\0';
    status = scan(session, has_columns, text, task, error);
    if (status != MUKCA_OK) goto out;
    if (!*has_columns && !ours)
        status = mukca_fail(error, MUKCA_INPUT, "%s: no header of a session", session->path);
    else if (*has_columns && session->length < length && ftruncate(session->fd, session->length))
        status = fail(session, "cannot be mended", error);
    else if (*has_columns && session->length < length)
        mukca_note_format(task->notes, "%s: %lld bytes of an unfinished row removed", session->path,
                          (long long)(length - session->length));
out:
    free(text);
    return status;
}

mukca_status mukca_session_open(mukca_session *session, const mukca_session_task *task,
                                mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    bool has_columns = false;
    *session = (mukca_session){.open = true,
                               .fd = -1,
                               .separator = mukca_dataset_separator(task->path),
                               .chain = task->chain,
                               .has_effort = task->has_effort,
                               .has_command = task->has_command};
    if (snprintf(session->path, sizeof session->path, "%s", task->path) >=
        (int)sizeof session->path)
        status = mukca_fail(error, MUKCA_INPUT, "%.100s...: the path is too long", task->path);
    else if (access(task->path, F_OK) == 0) {
        if (!task->resume && !task->force)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s: exists already; --resume continues it, --force overwrites it",
                              task->path);
        status = open_file(session, error); /* checks that no other program records it */
        if (status == MUKCA_OK && task->resume) status = load(session, &has_columns, task, error);
    }
    if (status == MUKCA_OK && !has_columns) { /* the first sample creates or overwrites it */
        put_header(session, task);
        status = mukca_output_check(session->path, true, error);
    }
    if (status != MUKCA_OK) mukca_session_close(session);
    return status;
}

void mukca_session_close(mukca_session *session)
{
    if (session->open && session->fd >= 0) close(session->fd);
    free(session->row_at);
    memset(session, 0, sizeof *session);
}
