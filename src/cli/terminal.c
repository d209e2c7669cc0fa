/* Terminal output: the answer on standard output; notes, progress and errors on standard error.
 * Also interrupts. */
#include <signal.h>
#include <stdarg.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"
#include "cli/cli.h"

double cli_elapsed(const cli_call *call)
{
    return mukca_clock_seconds() - call->started;
}

static void clear_progress(cli_call *call)
{
    if (call->showing) fputs("\r\033[K", stderr);
    call->showing = false;
}

/* vfprintf without control characters: of file names, or of tables. */
static void print(FILE *stream, const char *format, va_list args)
{
    char text[4096];
    vsnprintf(text, sizeof text, format, args);
    mukca_utf8_mend(text);
    fputs(text, stream);
}

void cli_log(cli_call *call, const char *format, ...)
{
    if (call->common && call->common->quiet) return;
    clear_progress(call);
    va_list args;
    va_start(args, format);
    print(stderr, format, args);
    va_end(args);
}

static void note(void *call, const char *text)
{
    cli_log(call, "mukca: note: %s\n", text);
}

mukca_notes cli_notes(cli_call *call)
{
    return (mukca_notes){note, call};
}

void cli_progress(cli_call *call, const char *what, double done, double total)
{
    double t = cli_elapsed(call);
    if (call->common->quiet || t < 2 || t - call->progressed < 0.1 || !isatty(STDERR_FILENO))
        return;
    double fraction = total > 0 ? done / total : 0;
    int filled = fraction < 0 ? 0 : fraction > 1 ? 30 : (int)(30 * fraction);
    fprintf(stderr, "\r%-28.28s [%.*s%*s] %3.0f %%\033[K", what, filled,
            "##############################", 30 - filled, "", 100 * fraction);
    fflush(stderr);
    call->progressed = t;
    call->showing = true;
}

FILE *cli_answer_stream(cli_call *call)
{
    const cli_common *c = call->common;
    if (c->quiet) return NULL;
    clear_progress(call);
    const bool taken = call->printed || (c->json && strcmp(c->json, "-") == 0) ||
                       (c->output && strcmp(c->output, "-") == 0);
    return taken ? stderr : stdout;
}

void cli_answer(cli_call *call, const char *format, ...)
{
    FILE *stream = cli_answer_stream(call);
    if (!stream) return;
    va_list args;
    va_start(args, format);
    print(stream, format, args);
    va_end(args);
}

void cli_say(cli_call *call, const char *key, const char *format, ...)
{
    char text[1024];
    FILE *stream = cli_answer_stream(call);
    va_list args;
    if (!stream) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    mukca_utf8_mend(text);
    cli_print_keyed(stream, key, text);
}

/* A signal handler has no other access to state. */
static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    interrupted = number;
    alarm(1); /* also ends a read begun after the last check of `interrupted` */
}

static void on_alarm(int number)
{
    (void)number;
}

void cli_catch_interrupts(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    action.sa_flags = (int)SA_RESETHAND; /* no SA_RESTART: blocking reads return */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    action.sa_handler = on_alarm;
    sigaction(SIGALRM, &action, NULL);
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is then a write error, reported in one line */
    signal(SIGXFSZ, SIG_IGN); /* likewise a file beyond the shell's limit */
}

bool cli_interrupted(void)
{
    return interrupted != 0;
}

bool cli_stop(void *context)
{
    (void)context;
    return cli_interrupted();
}

bool cli_show_progress(void *call, double fraction, const char *doing)
{
    cli_progress(call, doing, fraction, 1);
    return !cli_interrupted();
}
