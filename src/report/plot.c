/* Run gnuplot and make its SVG part of a page: ids unique, no prologue, a text alternative. */
#include "report/plot.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report/html.h"

extern char **environ;

/* ---- the script ---- */

mukca_status mukca_plot_open(mukca_plot *plot, mukca_error *error)
{
    *plot = (mukca_plot){.width = 0};
    plot->script = open_memstream(&plot->text, &plot->sizes[0]);
    plot->description = open_memstream(&plot->words, &plot->sizes[1]);
    if (plot->script && plot->description) return MUKCA_OK;
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
}

void mukca_plot_free(mukca_plot *plot)
{
    if (plot->script) fclose(plot->script);
    if (plot->description) fclose(plot->description);
    free(plot->text);
    free(plot->words);
}

void mukca_plot_begin(mukca_plot *plot, const char *id, const char *title, int width, int height)
{
    snprintf(plot->id, sizeof plot->id, "%s", id);
    snprintf(plot->title, sizeof plot->title, "%s", title);
    plot->width = width;
    plot->height = height;
    fputs(
        "set border 3 linewidth 0.8\n"
        "set tics nomirror out scale 0.6\n"
        "set grid linecolor 'gray' linewidth 0.4 dashtype 3\n"
        "set key above left horizontal Left reverse samplen 2\n",
        plot->script);
}

void mukca_plot_quote(FILE *script, const char *text)
{
    /* Nothing is special within single quotes but the quote. */
    fputc('\'', script);
    for (; *text; text++) {
        if (*text == '\'') fputc('\'', script);
        if ((unsigned char)*text >= ' ') fputc(*text, script);
    }
    fputc('\'', script);
}

void mukca_plot_label(mukca_plot *plot, const char *text, const char *format, ...)
{
    va_list values;
    fputs("set label ", plot->script);
    mukca_plot_quote(plot->script, text);
    fputc(' ', plot->script);
    va_start(values, format);
    vfprintf(plot->script, format, values);
    va_end(values);
    fputc('\n', plot->script);
}

/* ---- gnuplot ---- */

/* All of a stream as text that ends in 0; NULL where it cannot be had. */
static char *slurp(FILE *in)
{
    const long size = fseek(in, 0, SEEK_END) == 0 ? ftell(in) : 0;
    char *text = calloc((size_t)size + 1, 1);
    rewind(in);
    if (text) text[fread(text, 1, (size_t)size, in)] = '\0';
    return text;
}

/* Wait for gnuplot; MUKCA_NEGATIVE where it complained. */
static mukca_status wait_for(pid_t pid, mukca_error *error)
{
    int status = 0;
    bool interrupted = false;
    while (waitpid(pid, &status, 0) < 0) {
        if (errno != EINTR)
            return mukca_fail(error, MUKCA_INPUT, "lost gnuplot: %s", strerror(errno));
        interrupted = true; /* a signal to us alone: gnuplot does not know of it */
        kill(pid, SIGTERM);
    }
    /* a signal to the whole process group may end gnuplot before it interrupts the wait */
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGINT || WTERMSIG(status) == SIGTERM))
        interrupted = true;
    if (interrupted)
        return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; the page was not written");
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? MUKCA_OK : MUKCA_NEGATIVE;
}

/* Run gnuplot on streams[0]; its output goes to streams[1], its complaints to streams[2]. */
static mukca_status run(FILE *const streams[3], mukca_error *error)
{
    char *const arguments[] = {(char[]){"gnuplot"}, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    if (fflush(streams[0]) != 0 || lseek(fileno(streams[0]), 0, SEEK_SET) != 0)
        return mukca_fail(error, MUKCA_INPUT, "cannot write a script for gnuplot: %s",
                          strerror(errno));
    if (posix_spawn_file_actions_init(&actions) != 0)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    for (int k = 0; k < 3; k++)
        posix_spawn_file_actions_adddup2(&actions, fileno(streams[k]), STDIN_FILENO + k);
    const int failure = posix_spawnp(&pid, "gnuplot", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        return mukca_fail(error, MUKCA_INPUT,
                          "cannot run gnuplot, which draws the figures: %s; install the package "
                          "gnuplot-nox",
                          strerror(failure));
    const mukca_status status = wait_for(pid, error);
    if (status != MUKCA_NEGATIVE) return status;
    char complaint[181] = "";
    rewind(streams[2]);
    complaint[fread(complaint, 1, sizeof complaint - 1, streams[2])] = '\0';
    for (char *c = complaint; *c; c++)
        if ((unsigned char)*c < ' ') *c = ' ';
    return mukca_fail(error, MUKCA_INPUT, "gnuplot failed on a figure: %s", complaint);
}

/* gnuplot's output for `terminal` as text, which the caller frees; or into the file `path`. */
static mukca_status render(char **text, const char *terminal, const char *path, mukca_plot *plot,
                           mukca_error *error)
{
    FILE *streams[3] = {tmpfile(), tmpfile(), tmpfile()};
    mukca_status status;
    if (fflush(plot->script) != 0 || fflush(plot->description) != 0) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
        goto out;
    }
    if (!streams[0] || !streams[1] || !streams[2]) {
        status =
            mukca_fail(error, MUKCA_INPUT, "cannot make a temporary file: %s", strerror(errno));
        goto out;
    }
    fprintf(streams[0], "set encoding utf8\nset terminal %s noenhanced\n", terminal);
    if (path) {
        fputs("set output ", streams[0]);
        mukca_plot_quote(streams[0], path);
    }
    fprintf(streams[0], "\n%s\n", plot->text);
    status = run(streams, error);
    if (status == MUKCA_OK && text && !(*text = slurp(streams[1])))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
out:
    for (int k = 0; k < 3; k++)
        if (streams[k]) fclose(streams[k]);
    return status;
}

mukca_status mukca_plot_file(const char *path, const char *format, mukca_plot *plot,
                             mukca_error *error)
{
    const int width = plot->width, height = plot->height;
    char terminal[160];
    if (strcmp(format, "pdf") == 0) /* inches of 96 px */
        snprintf(terminal, sizeof terminal, "pdfcairo size %g,%g linewidth 1.2 font 'sans,10'",
                 width / 96.0, height / 96.0);
    else if (strcmp(format, "png") == 0)
        snprintf(terminal, sizeof terminal, "pngcairo size %d,%d linewidth 2.4 font 'sans,20'",
                 2 * width, 2 * height);
    else
        snprintf(terminal, sizeof terminal,
                 "svg size %d,%d linewidth 1.2 background '#ffffff' font 'sans-serif,13'", width,
                 height);
    const mukca_status status = render(NULL, terminal, path, plot, error);
    if (status == MUKCA_INTERRUPTED) unlink(path); /* half of a figure */
    return status;
}

/* ---- SVG for the page ---- */

/* What changes in gnuplot's SVG: each `from` becomes `to` and, where `prefix`, the figure's id; the
 * text up to the end of `until` (NULL: nothing) goes. */
static const struct {
    const char *from, *until, *to;
    bool prefix;
} edits[] = {
    {"<title>Gnuplot", "\n", "", false}, /* its title is the file's name */
    {"<desc>", "\n", "", false},
    {" id=\"gnuplot_", "\"", "", false},
    {"xlink:href='#", NULL, "href='#", true},
    {"xlink:href=\"#", NULL, "href=\"#", true},
    {" id='", NULL, " id='", true},
    {" id=\"", NULL, " id=\"", true},
    {"url(#", NULL, "url(#", true},
};

/* The elements within gnuplot's <svg>; its ids are the same in every figure. */
static void put_body(FILE *out, const char *body, const char *id)
{
    enum { EDITS = sizeof edits / sizeof *edits };
    const char *end = strstr(body, "</svg>");
    while (*body && body != end) {
        const char *tag = strncmp(body, "<g ", 3) == 0 ? strchr(body, '>') : NULL;
        if (tag && strncmp(tag, ">\n</g>\n", 7) == 0) { /* an empty group */
            body = tag + 7;
            continue;
        }
        size_t k = 0;
        while (k < EDITS && strncmp(body, edits[k].from, strlen(edits[k].from)) != 0) k++;
        if (k == EDITS) {
            fputc(*body++, out);
            continue;
        }
        fprintf(out, "%s%s%s", edits[k].to, edits[k].prefix ? id : "", edits[k].prefix ? "-" : "");
        body += strlen(edits[k].from);
        const char *close = edits[k].until ? strstr(body, edits[k].until) : NULL;
        if (close) body = close + strlen(edits[k].until);
    }
}

mukca_status mukca_plot_svg(FILE *out, mukca_plot *plot, mukca_error *error)
{
    char terminal[160], *text = NULL;
    snprintf(terminal, sizeof terminal, "svg size %d,%d dynamic linewidth 1.2 font 'sans-serif,13'",
             plot->width, plot->height);
    mukca_status status = render(&text, terminal, NULL, plot, error);
    if (status != MUKCA_OK) return status;
    const char *svg = text ? strstr(text, "<svg") : NULL, *body = svg ? strchr(svg, '>') : NULL;
    if (body) {
        fprintf(out,
                "<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-labelledby=\"%s-t "
                "%s-d\">\n<title id=\"%s-t\">",
                plot->width, plot->height, plot->id, plot->id, plot->id);
        mukca_html_escape(out, plot->title);
        fprintf(out, "</title>\n<desc id=\"%s-d\">", plot->id);
        mukca_html_escape(out, plot->words);
        fputs("</desc>", out);
        put_body(out, body + 1, plot->id);
        fputs("</svg>\n", out);
    } else {
        status = mukca_fail(error, MUKCA_INPUT, "gnuplot drew nothing; is its svg terminal there?");
    }
    free(text);
    return status;
}
