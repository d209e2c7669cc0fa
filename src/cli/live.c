/* Live recording: options for the commands that use the session; standard error that never
 * blocks. */
#include "cli/live.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void cli_live_arguments(const char *words[MUKCA_SERVER_ARGUMENTS], const cli_call *call)
{
    const unsigned sets =
        CLI_WITH_MODEL | CLI_WITH_DISTANCE | CLI_WITH_DISTANCES | CLI_WITH_SD | CLI_WITH_TRAITS;
    int n = 0;
    for (const cli_given *g = call->given; g < call->given + call->n_given; g++)
        for (int i = 0; g->option->set & sets && i < g->n_words; i++) words[n++] = g->words[i];
    words[n] = NULL;
}

/* ---- standard error ---- */

void cli_relay_open(cli_relay *r)
{
    struct stat info;
    /* opened anew: O_NONBLOCK of the inherited one would be the shell's, too; files never block */
    if (fstat(STDERR_FILENO, &info) == 0 && (S_ISCHR(info.st_mode) || S_ISFIFO(info.st_mode)))
        r->file = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (r->file < 0) r->file = 0;
}

void cli_relay_close(cli_relay *r)
{
    if (r->file) close(r->file);
    r->file = 0;
}

/* Write as much as is taken. */
static void flush(cli_relay *r)
{
    while (r->used) {
        ssize_t n = write(r->file ? r->file : STDERR_FILENO, r->waiting, r->used);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && errno == EAGAIN) return;
        if (n < 0) n = (ssize_t)r->used; /* nobody reads */
        r->used -= (size_t)n;
        memmove(r->waiting, r->waiting + n, r->used);
    }
}

static bool append(cli_relay *r, const char *text)
{
    const size_t n = strlen(text);
    if (n > sizeof r->waiting - r->used) return false;
    memcpy(r->waiting + r->used, text, n);
    r->used += n;
    return true;
}

void cli_relay_write(cli_relay *r, const char *text)
{
    char line[80];
    snprintf(line, sizeof line, "%ld lines are not shown: the terminal was stopped\n", r->lost);
    flush(r);
    if (r->lost && append(r, line)) r->lost = 0;
    r->lost += r->lost || !append(r, text);
    flush(r);
}

bool cli_relay_idle(cli_relay *r)
{
    flush(r);
    return !r->used;
}
