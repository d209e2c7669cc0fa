/* Run gnuplot and make its SVG part of a page: ids unique, no prologue, a text alternative. */
#include "report/plot.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report/html.h"

extern char **environ;

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

/* All of a stream as text that ends in 0; NULL out of memory. */
static char *slurp(FILE *in)
{
    char *text = NULL, block[4096];
    size_t size = 0, n;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    rewind(in);
    while ((n = fread(block, 1, sizeof block, in)) > 0) fwrite(block, 1, n, out);
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

/* Run gnuplot on terminal line + script; what it prints goes to `output`, complaints to
 * `complaints`. */
static mukca_status run(FILE *output, FILE *complaints, FILE *script, mukca_error *error)
{
    char *const argv[] = {(char[]){"gnuplot"}, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status = 0;
    if (fflush(script) != 0 || lseek(fileno(script), 0, SEEK_SET) != 0)
        return mukca_fail(error, MUKCA_INPUT, "cannot write a script for gnuplot: %s",
                          strerror(errno));
    if (posix_spawn_file_actions_init(&actions) != 0)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    posix_spawn_file_actions_adddup2(&actions, fileno(script), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(complaints), STDERR_FILENO);
    const int failure = posix_spawnp(&pid, "gnuplot", &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        return mukca_fail(error, MUKCA_INPUT,
                          "cannot run gnuplot, which draws the figures: %s; install the package "
                          "gnuplot-nox",
                          strerror(failure));
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
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return MUKCA_OK;
    char *said = slurp(complaints);
    mukca_fail(error, MUKCA_INPUT, "gnuplot failed on a figure: %.180s", said ? said : "");
    free(said);
    for (char *c = error ? error->text : NULL; c && *c; c++)
        if ((unsigned char)*c < ' ') *c = ' ';
    return MUKCA_INPUT;
}

/* gnuplot's output for `terminal` as text; the caller frees it. */
static mukca_status render(char **text, const char *terminal, const char *path, const char *script,
                           mukca_error *error)
{
    FILE *in = tmpfile(), *out = tmpfile(), *complaints = tmpfile();
    mukca_status status;
    *text = NULL;
    if (!in || !out || !complaints) {
        status =
            mukca_fail(error, MUKCA_INPUT, "cannot make a temporary file: %s", strerror(errno));
        goto out;
    }
    fprintf(in, "set encoding utf8\nset terminal %s\n", terminal);
    if (path) {
        fputs("set output ", in);
        mukca_plot_quote(in, path);
    }
    fprintf(in, "\n%s\n", script);
    status = run(out, complaints, in, error);
    if (status == MUKCA_OK && !(*text = slurp(out)))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
out:
    if (in) fclose(in);
    if (out) fclose(out);
    if (complaints) fclose(complaints);
    return status;
}

static const char *starts(const char *text, const char *with)
{
    const size_t n = strlen(with);
    return strncmp(text, with, n) == 0 ? text + n : NULL;
}

/* The elements within gnuplot's <svg>, with ids prefixed and empty groups left out. */
static void put_body(FILE *out, const char *body, const char *id)
{
    static const char *const references[] = {" id='", " id=\"", "href='#", "href=\"#", "url(#"};
    const char *end = strstr(body, "</svg>");
    while (*body && body != end) {
        const char *rest, *close;
        /* gnuplot's own title is the file's name, its ids are the same in every figure */
        if ((rest = starts(body, "<title>Gnuplot")) || (rest = starts(body, "<desc>"))) {
            close = strchr(rest, '\n');
            body = close ? close : rest;
            continue;
        }
        if ((rest = starts(body, "<g ")) && (close = strchr(rest, '>')) &&
            (rest = starts(close + 1, "\n</g>\n"))) {
            body = rest;
            continue;
        }
        if ((rest = starts(body, " id=\"gnuplot_")) && (close = strchr(rest, '"'))) {
            body = close + 1;
            continue;
        }
        if ((rest = starts(body, "xlink:href"))) body += strlen("xlink:");
        size_t k = 0;
        for (; k < sizeof references / sizeof *references; k++)
            if ((rest = starts(body, references[k]))) break;
        if (k < sizeof references / sizeof *references) {
            fputs(references[k], out);
            fprintf(out, "%s-", id);
            body = rest;
        } else {
            fputc(*body++, out);
        }
    }
}

mukca_status mukca_plot_svg(FILE *out, const mukca_figure *figure, const char *script,
                            mukca_error *error)
{
    char terminal[160], *text;
    snprintf(terminal, sizeof terminal,
             "svg size %d,%d dynamic noenhanced linewidth 1.2 font 'sans-serif,13'", figure->width,
             figure->height);
    mukca_status status = render(&text, terminal, NULL, script, error);
    if (!text) return status;
    const char *svg = strstr(text, "<svg"), *body = svg ? strchr(svg, '>') : NULL;
    if (body) {
        fprintf(out,
                "<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-labelledby=\"%s-t "
                "%s-d\">\n<title id=\"%s-t\">",
                figure->width, figure->height, figure->id, figure->id, figure->id);
        mukca_html_escape(out, figure->title);
        fprintf(out, "</title>\n<desc id=\"%s-d\">", figure->id);
        mukca_html_escape(out, figure->description);
        fputs("</desc>", out);
        put_body(out, body + 1, figure->id);
        fputs("</svg>\n", out);
    } else {
        status = mukca_fail(error, MUKCA_INPUT, "gnuplot drew nothing; is its svg terminal there?");
    }
    free(text);
    return status;
}

mukca_status mukca_plot_file(const char *path, const char *format, const mukca_figure *figure,
                             const char *script, mukca_error *error)
{
    char terminal[160], *text;
    if (strcmp(format, "pdf") == 0)
        snprintf(terminal, sizeof terminal,
                 "pdfcairo size %g,%g noenhanced linewidth 1.2 font 'sans,10'",
                 figure->width / 96.0, figure->height / 96.0);
    else if (strcmp(format, "png") == 0)
        snprintf(terminal, sizeof terminal,
                 "pngcairo size %d,%d noenhanced linewidth 2.4 font 'sans,20'", 2 * figure->width,
                 2 * figure->height);
    else
        snprintf(
            terminal, sizeof terminal,
            "svg size %d,%d noenhanced linewidth 1.2 background '#ffffff' font 'sans-serif,13'",
            figure->width, figure->height);
    mukca_status status = render(&text, terminal, path, script, error);
    if (status == MUKCA_INTERRUPTED) unlink(path); /* half of a figure */
    free(text);
    return status;
}
