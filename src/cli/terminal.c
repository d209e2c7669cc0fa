/* Terminal output: text that is wrapped, keyed, bold; the answer on standard output; notes,
 * progress and errors on standard error.  Also interrupts. */
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"
#include "cli/cli.h"

enum { KEY = 8, WIDTH = 79 }; /* columns */

static bool fancy(FILE *stream)
{
    const char *no = getenv("NO_COLOR"), *term = getenv("TERM");
    if (no && *no) return false;
    return isatty(fileno(stream)) && term && strcmp(term, "dumb") != 0;
}

const char *cli_bold(FILE *stream)
{
    return fancy(stream) ? "\033[1m" : "";
}

const char *cli_plain(FILE *stream)
{
    return fancy(stream) ? "\033[0m" : "";
}

/* Length of the first word, with the unit or other short word that follows a number. */
static size_t find_word(const char *text, const char *end)
{
    size_t word = 0, unit = 1;
    while (text + word < end && text[word] != ' ') word++;
    if (!word || !strchr("0123456789", text[word - 1])) return word;
    while (text + word + unit < end && text[word + unit] != ' ') unit++;
    return text + word < end && unit < 7 ? word + unit : word;
}

void cli_print_words(FILE *stream, int indent, int column, const char *text, size_t length)
{
    const char *end = text + length;
    bool first = true;
    while (text < end) {
        while (text < end && *text == ' ') text++;
        const size_t word = find_word(text, end);
        if (!word) break;
        if (!first && column + 1 + (int)word > WIDTH) {
            fprintf(stream, "\n%*s", indent, "");
            column = indent;
            first = true;
        }
        column += fprintf(stream, "%s%.*s", first ? "" : " ", (int)word, text);
        first = false;
        text += word;
    }
    fputc('\n', stream);
}

void cli_print_wrapped(FILE *stream, const char *text)
{
    while (*text) {
        size_t length = strcspn(text, "\n");
        if (length == 0)
            fputc('\n', stream);
        else if (*text == ' ')
            fprintf(stream, "%.*s\n", (int)length, text);
        else
            cli_print_words(stream, 0, 0, text, length);
        text += length + (text[length] == '\n');
    }
}

void cli_print_keyed(FILE *stream, const char *key, const char *text)
{
    if (key && *text) fprintf(stream, "%s%-*s%s", cli_bold(stream), KEY, key, cli_plain(stream));
    if (key && *text)
        cli_print_words(stream, KEY, KEY, text, strlen(text));
    else
        cli_print_wrapped(stream, text);
}

void cli_describe_data(char text[80], const mukca_dataset *data)
{
    mukca_text to = {.at = text, .size = 80};
    text[0] = '\0';
    mukca_text_put(&to, "%d %s%s", data->n_rows, data->n_sockets ? "sample" : "measured pose",
                   data->n_rows == 1 ? "" : "s");
    if (data->n_placements)
        mukca_text_put(&to, ", %d placement%s", data->n_placements,
                       data->n_placements == 1 ? "" : "s");
}

void cli_print_head(FILE *stream, const char *robot, const mukca_dataset *data,
                    const mukca_dataset *test)
{
    char texts[2][80] = {""};
    const bool tested = test && test->n_rows > 0;
    if (!stream) return;
    cli_describe_data(texts[0], data);
    if (tested) cli_describe_data(texts[1], test);
    fprintf(stream, "%s: %s%s%s\n", robot, texts[0], tested ? "; test: " : "", texts[1]);
}

void cli_print_acceptance(FILE *stream, const mukca_acceptance *a, const mukca_chain *chain)
{
    char tip[MUKCA_ACCEPTANCE_SENTENCE] = "", use[MUKCA_ACCEPTANCE_SENTENCE] = "";
    const bool factory = chain->kinematics_sha256[0] != '\0';
    if (!stream) return;
    if (a->accepted) mukca_acceptance_put_tip(&(mukca_text)MUKCA_TEXT(tip), a, factory);
    mukca_acceptance_put_use(&(mukca_text)MUKCA_TEXT(use), a, factory);
    cli_print_keyed(stream, "Use", use);
    cli_print_keyed(stream, "Tip", tip);
}

/* ---- streams ---- */

double cli_elapsed(const cli_call *call)
{
    return mukca_clock_seconds() - call->started;
}

static void clear_progress(cli_call *call)
{
    if (call->showing) fputs("\r\033[K", stderr);
    call->showing = false;
}

void cli_print(FILE *stream, const char *format, ...)
{
    char text[4096];
    if (!stream) return;
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    mukca_utf8_mend(text); /* of file names, or of tables */
    fputs(text, stream);
}

FILE *cli_log_stream(cli_call *call)
{
    if (call->common && call->common->quiet) return NULL;
    clear_progress(call);
    return stderr;
}

static void note(void *call, const char *text)
{
    cli_log(call, "mukca: note: %s\n", text);
}

mukca_notes cli_notes(cli_call *call)
{
    return (mukca_notes){note, call};
}

bool cli_show_progress(void *context, double fraction, const char *doing)
{
    cli_call *call = context;
    const double t = cli_elapsed(call);
    if (call->common->quiet || t < 2 || t - call->progressed < 0.1 || !isatty(STDERR_FILENO))
        return !cli_interrupted();
    const int filled = fraction < 0 ? 0 : fraction > 1 ? 30 : (int)(30 * fraction);
    fprintf(stderr, "\r%-28.28s [%.*s%*s] %3.0f %%\033[K", doing, filled,
            "##############################", 30 - filled, "", 100 * fraction);
    fflush(stderr);
    call->progressed = t;
    call->showing = true;
    return !cli_interrupted();
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

/* ---- interrupts ---- */

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
