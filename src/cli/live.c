/* Live recording: options for the commands that use the session; standard error, written by a
 * thread that copies a pipe. */
#include "cli/live.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
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

static void write_all(const char *at, size_t n)
{
    while (n) {
        const ssize_t done = write(STDERR_FILENO, at, n);
        if (done < 0 && errno != EINTR) return; /* nobody reads */
        if (done > 0) at += done, n -= (size_t)done;
    }
}

static void *run(void *relay)
{
    const cli_relay *r = relay;
    char text[4096];
    for (ssize_t n; (n = read(r->ends[0], text, sizeof text)) > 0;) write_all(text, (size_t)n);
    return NULL;
}

void cli_relay_open(cli_relay *r)
{
    sigset_t all, before;
    if (pipe(r->ends)) return;
    for (int i = 0; i < 2; i++) fcntl(r->ends[i], F_SETFD, FD_CLOEXEC);
    fcntl(r->ends[1], F_SETFL, O_NONBLOCK);
    sigfillset(&all);
    const int own[] = {SIGSYS, SIGSEGV, SIGBUS, SIGFPE,
                       SIGILL}; /* of the thread that causes them */
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) sigdelset(&all, own[i]);
    pthread_sigmask(SIG_SETMASK, &all, &before); /* the main thread handles signals */
    r->running = pthread_create(&r->thread, NULL, run, r) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (r->running) return;
    close(r->ends[0]);
    close(r->ends[1]);
}

void cli_relay_close(cli_relay *r)
{
    if (!r->running) return;
    r->running = false;
    close(r->ends[1]);
    pthread_join(r->thread, NULL);
    close(r->ends[0]);
}

/* False: the pipe is full. */
static bool put(const cli_relay *r, const char *text)
{
    const size_t n = strlen(text);
    if (r->running) return write(r->ends[1], text, n) == (ssize_t)n;
    write_all(text, n);
    return true;
}

void cli_relay_write(cli_relay *r, const char *text)
{
    char line[80];
    snprintf(line, sizeof line, "%ld lines are not shown: the terminal was stopped\n", r->lost);
    if (r->lost && put(r, line)) r->lost = 0;
    r->lost += r->lost || !put(r, text);
}

bool cli_relay_idle(const cli_relay *r)
{
    int waiting = 0;
    return !r->running || (ioctl(r->ends[0], FIONREAD, &waiting) == 0 && waiting == 0);
}
