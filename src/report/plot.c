/* Figures by gnuplot, and the conversion of its SVG for a page: unique ids, no prologue, a text
 * alternative. */
#include "report/plot.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/output.h"
#include "report/html.h"

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

/* Quote a text: within single quotes only the quote itself, and `more`, need doubling. */
static void quote(FILE *script, const char *text, char more)
{
    fputc('\'', script);
    for (; *text; text++) {
        if (*text == '\'' || *text == more) fputc(*text, script);
        if ((unsigned char)*text >= ' ') fputc(*text, script);
    }
    fputc('\'', script);
}

void mukca_plot_tic(FILE *script, const char *text)
{
    quote(script, text, '%'); /* gnuplot treats the text of a tic as a format */
}

void mukca_plot_label(mukca_plot *plot, const char *text, const char *format, ...)
{
    va_list values;
    fputs("set label ", plot->script);
    quote(plot->script, text, '\'');
    fputc(' ', plot->script);
    va_start(values, format);
    vfprintf(plot->script, format, values);
    va_end(values);
    fputc('\n', plot->script);
}

/* ---- gnuplot ---- */

static const char interrupted_text[] = "interrupted; the page was not written";

/* Output of gnuplot. */
typedef struct {
    char *bytes; /* zero-terminated */
    size_t size;
} drawing;

/* Read gnuplot's output to the end; an interrupt aborts it.  Errors: MUKCA_MEMORY, MUKCA_INPUT,
 * MUKCA_INTERRUPTED. */
static mukca_status read_all(drawing *drawn, FILE *in, mukca_error *error)
{
    size_t capacity = 0, n = 1;
    while (n > 0) {
        if (drawn->size == capacity) {
            capacity = capacity ? 2 * capacity : 1 << 16;
            char *grown = realloc(drawn->bytes, capacity + 1);
            if (!grown) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
            drawn->bytes = grown;
        }
        n = fread(drawn->bytes + drawn->size, 1, capacity - drawn->size, in);
        drawn->size += n;
        drawn->bytes[drawn->size] = '\0';
    }
    if (!ferror(in)) return MUKCA_OK;
    if (errno == EINTR) return mukca_fail(error, MUKCA_INTERRUPTED, "%s", interrupted_text);
    return mukca_fail(error, MUKCA_INPUT, "cannot read from gnuplot: %s", strerror(errno));
}

/* Run gnuplot on a script; MUKCA_NEGATIVE: it reported an error.  Its output is read through a
 * pipe, independent of disk space. */
static mukca_status run(drawing *drawn, FILE *script, FILE *complaints, mukca_error *error)
{
    char command[80], line[32];
    if (fflush(script) != 0 || ferror(script) || lseek(fileno(script), 0, SEEK_SET) != 0)
        return mukca_fail(error, MUKCA_MEMORY, "cannot write a script for gnuplot: %s",
                          strerror(errno));
    snprintf(command, sizeof command, "echo $$; exec gnuplot <&%d 2>&%d", fileno(script),
             fileno(complaints));
    FILE *in = popen(command, "r"); /* NOLINT(cert-env33-c): no text of others */
    if (!in) return mukca_fail(error, MUKCA_MEMORY, "cannot run a shell: %s", strerror(errno));
    /* of the shell, then of gnuplot */
    const long pid = fgets(line, sizeof line, in) ? strtol(line, NULL, 10) : 0;
    mukca_status status = MUKCA_INTERRUPTED;
    if (pid > 0)
        status = read_all(drawn, in, error);
    else
        mukca_fail(error, status, "%s", interrupted_text);
    if (status != MUKCA_OK && pid > 0) kill((pid_t)pid, SIGTERM);
    const int ended = pclose(in);
    if (status != MUKCA_OK) return status;
    /* a signal to the process group may end gnuplot before it interrupts the read */
    if (WIFSIGNALED(ended) && (WTERMSIG(ended) == SIGINT || WTERMSIG(ended) == SIGTERM))
        return mukca_fail(error, MUKCA_INTERRUPTED, "%s", interrupted_text);
    if (WIFEXITED(ended) && WEXITSTATUS(ended) == 127) /* of the shell: not found */
        return mukca_fail(error, MUKCA_INPUT,
                          "cannot run gnuplot, which draws the figures; install the package "
                          "gnuplot-nox");
    return WIFEXITED(ended) && WEXITSTATUS(ended) == 0 ? MUKCA_OK : MUKCA_NEGATIVE;
}

/* Draw the figure for `terminal`; the caller frees drawn->bytes. */
static mukca_status render(drawing *drawn, const char *terminal, mukca_plot *plot,
                           mukca_error *error)
{
    FILE *script = tmpfile(), *complaints = tmpfile();
    mukca_status status;
    *drawn = (drawing){.size = 0};
    if (fflush(plot->script) != 0 || fflush(plot->description) != 0 || ferror(plot->script) ||
        ferror(plot->description)) {
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for the figures");
        goto out;
    }
    if (!script || !complaints) {
        status = mukca_fail(error, mukca_output_status(errno), "cannot make a temporary file: %s",
                            strerror(errno));
        goto out;
    }
    fprintf(script, "set encoding utf8\nset terminal %s noenhanced\n\n%s\n", terminal, plot->text);
    status = run(drawn, script, complaints, error);
    if (status == MUKCA_NEGATIVE || (status == MUKCA_OK && !drawn->size)) {
        char complaint[181] = "";
        rewind(complaints);
        complaint[fread(complaint, 1, sizeof complaint - 1, complaints)] = '\0';
        for (char *c = complaint; *c; c++)
            if ((unsigned char)*c < ' ') *c = ' ';
        status = mukca_fail(error, MUKCA_INPUT, "gnuplot failed on a figure: %s", complaint);
    }
out:
    if (script) fclose(script);
    if (complaints) fclose(complaints);
    return status;
}

mukca_status mukca_plot_file(const char *path, const char *format, mukca_plot *plot,
                             mukca_error *error)
{
    const int width = plot->width, height = plot->height;
    char terminal[160];
    if (strcmp(format, "pdf") == 0) /* inches; 96 px per inch */
        snprintf(terminal, sizeof terminal, "pdfcairo size %g,%g linewidth 1.2 font 'sans,10'",
                 width / 96.0, height / 96.0);
    else if (strcmp(format, "png") == 0)
        snprintf(terminal, sizeof terminal, "pngcairo size %d,%d linewidth 2.4 font 'sans,20'",
                 2 * width, 2 * height);
    else
        snprintf(terminal, sizeof terminal,
                 "svg size %d,%d linewidth 1.2 background '#ffffff' font 'sans-serif,13'", width,
                 height);
    drawing drawn;
    mukca_output output = {0};
    mukca_status status = render(&drawn, terminal, plot, error);
    if (status == MUKCA_OK) status = mukca_output_open(&output, path, true, error);
    if (status == MUKCA_OK) fwrite(drawn.bytes, 1, drawn.size, output.stream);
    free(drawn.bytes);
    return mukca_output_finish(&output, status, error);
}

/* ---- SVG for the page ---- */

/* Replacements in gnuplot's SVG: each `from` becomes `to`, followed with `prefix` by the figure's
 * id; the text up to the end of `until` (NULL: none) is removed. */
static const struct {
    const char *from, *until, *to;
    bool prefix;
} edits[] = {
    {"<title>Gnuplot", "\n", "", false}, /* its title is the file name */
    {"<desc>", "\n", "", false},
    {" id=\"gnuplot_", "\"", "", false},
    {"xlink:href='#", NULL, "href='#", true},
    {"xlink:href=\"#", NULL, "href=\"#", true},
    {" id='", NULL, " id='", true},
    {" id=\"", NULL, " id=\"", true},
    {"url(#", NULL, "url(#", true},
};

/* Write the content of gnuplot's <svg> with unique ids; gnuplot uses the same ones in every
 * figure. */
static void put_body(FILE *out, const char *body, const char *id)
{
    enum { EDITS = sizeof edits / sizeof *edits };
    const char *end = strstr(body, "</svg>");
    while (*body && body != end) {
        const char *tag = strncmp(body, "<g ", 3) == 0 ? strchr(body, '>') : NULL;
        if (tag && strncmp(tag, ">\n</g>\n", 7) == 0) { /* skip an empty group */
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
    char terminal[160];
    drawing drawn;
    snprintf(terminal, sizeof terminal, "svg size %d,%d dynamic linewidth 1.2 font 'sans-serif,13'",
             plot->width, plot->height);
    mukca_status status = render(&drawn, terminal, plot, error);
    const char *svg = status == MUKCA_OK && drawn.bytes ? strstr(drawn.bytes, "<svg") : NULL;
    const char *body = svg ? strchr(svg, '>') : NULL;
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
    } else if (status == MUKCA_OK) {
        status = mukca_fail(error, MUKCA_INPUT, "gnuplot drew nothing; is its svg terminal there?");
    }
    free(drawn.bytes);
    return status;
}
