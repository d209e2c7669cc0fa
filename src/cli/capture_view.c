/* The terminal of `mukca capture`: single keys, and a view that is redrawn in place. */
#include "cli/capture_view.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/text.h"

void cli_capture_enter(cli_capture_view *v, int terminal)
{
    v->terminal = terminal;
    if (tcgetattr(terminal, &v->saved)) return;
    struct termios raw = v->saved;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO); /* ISIG stays set: ^C ends the session cleanly */
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    raw.c_cc[VSUSP] = raw.c_cc[VQUIT] = _POSIX_VDISABLE; /* would leave the terminal in raw mode */
    v->raw = tcsetattr(terminal, TCSAFLUSH, &raw) == 0;
}

void cli_capture_leave(cli_capture_view *v)
{
    if (v->raw) tcsetattr(v->terminal, TCSAFLUSH, &v->saved);
    v->raw = false;
}

/* Remove the view from the screen. */
static void erase(mukca_text *screen, cli_capture_view *v)
{
    if (v->drawn) mukca_text_put(screen, "\033[%dA\033[J", v->drawn);
    v->drawn = 0;
}

void cli_capture_print(cli_capture_view *v, const char *line)
{
    char text[PIPE_BUF];
    mukca_text screen = MUKCA_TEXT(text);
    erase(&screen, v);
    mukca_text_put(&screen, "%s\n", line);
    cli_relay_write(&v->relay, text);
}

/* The view while it is drawn. */
typedef struct {
    mukca_text text;
    int width, lines;
} screen;

/* One line of the view, truncated to the width of the terminal. */
__attribute__((format(printf, 2, 3))) static void draw(screen *s, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    mukca_text_put(&s->text, "%.*s\n", s->width - 1, text);
    s->lines++;
}

/* Samples by placement and socket, the latest first. */
static void draw_counts(screen *s, const mukca_capture *c)
{
    char line[512] = "";
    mukca_text text = MUKCA_TEXT(line);
    int placement = -1;
    for (int k = c->rows.n_sockets - 1; k >= 0; k--) {
        int n = mukca_capture_count(c, k), p = c->rows.sockets[k].placement;
        if (!n && k != c->socket) continue;
        if (p != placement)
            mukca_text_put(&text, "%s%.40s:", text.used ? " | " : "", c->rows.placements[p].name);
        placement = p;
        mukca_text_put(&text, " %.16s=%d", c->rows.sockets[k].label, n);
    }
    draw(s, "samples      %s", line);
}

static void draw_accuracy(screen *s, const mukca_recorder *r)
{
    double rms, last;
    mukca_capture_spread(&rms, &last, &r->session.capture, r->session.capture.socket);
    if (isnan(rms))
        draw(s, "this socket  too few samples to judge");
    else
        draw(s, "this socket  consistency error %.2f mm; last sample %.2f mm from the others",
             1e3 * rms, 1e3 * last);
    if (isnan(r->session.advice.expected))
        draw(s, "accuracy     too few samples to predict");
    else
        draw(s, "accuracy     %.2f mm expected, %.2f mm with ten more samples here%s",
             1e3 * r->session.advice.expected, 1e3 * r->session.advice.expected_more,
             r->session.advice.more_rows_help ? "" : ": continue elsewhere");
}

static void draw_coverage(screen *s, const mukca_recorder *r)
{
    double coverage[MUKCA_MAX_JOINTS];
    char line[128] = "";
    mukca_text text = MUKCA_TEXT(line);
    mukca_capture_coverage(coverage, &r->session.capture);
    for (int j = 0; j < r->chain->n_joints; j++) mukca_text_put(&text, "%.0f ", 100 * coverage[j]);
    draw(s, "coverage     %s%% of the joint ranges, base to tip", line);
}

void cli_capture_draw(cli_capture_view *v, const mukca_recorder *r)
{
    const mukca_capture *c = &r->session.capture;
    struct winsize size = {.ws_col = 80};
    char text[PIPE_BUF];
    if (!cli_relay_idle(&v->relay)) return;
    double age = mukca_stream_age(r);
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) || size.ws_col < 20) size.ws_col = 80;
    screen s = {.text = MUKCA_TEXT(text), .width = size.ws_col};
    erase(&s.text, v);
    draw(&s, "stream       %s %.0f Hz, age %.3f s, %s: %s%s", r->stream.channel,
         age > 1 ? 0 : r->stream.count.rate, age < 1e6 ? age : 0, mukca_recorder_stream(r),
         mukca_sampling_state(r), c->guided ? ", guided by hand" : "");
    draw(&s, "now          placement %s, socket %s: %d samples here, %d in all",
         mukca_capture_placement(c), mukca_capture_socket(c), mukca_capture_count(c, c->socket),
         r->session.file.n_rows);
    draw_counts(&s, c);
    draw_accuracy(&s, r);
    draw_coverage(&s, r);
    if (v->raw)
        draw(&s, "keys         a add  d delete last  s other socket  n next placement  q finish");
    v->drawn = s.lines;
    cli_relay_write(&v->relay, text);
}
