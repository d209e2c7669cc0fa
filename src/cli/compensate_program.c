/* Output of corrected targets as rows of a table, with their counters; and the correction of
 * programs: whole, or each line listed that was not understood. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "cli/compensate.h"

const char *const cli_compensate_formats[] = {"table",
#define FORMAT_NAME(name, description) #name,
                                              MUKCA_LANGUAGE_LIST(FORMAT_NAME)
#undef FORMAT_NAME
                                                  NULL};

void cli_compensate_print_header(cli_compensate_job *b, bool timed)
{
    const mukca_chain *chain = &b->arm.chain;
    if (b->headed) return;
    b->headed = true;
    cli_print_verdict(b->call, b->stream);
    if (timed) fputs("time_s\t", b->stream);
    for (int j = 0; j < chain->n_joints; j++)
        fprintf(b->stream, "%s\t", mukca_chain_joint_name(chain, j));
    fputs("error_before_m\terror_m\terror_rad\tstatus\n", b->stream);
}

void cli_compensate_refuse(cli_compensate_job *b, const char *path, int number, const char *why)
{
    mukca_error error; /* for its rules about foreign text */
    mukca_fail(&error, MUKCA_INPUT, "%s:%d: %s", mukca_file_shown(path), number, why);
    fprintf(stderr, "mukca: %s\n", error.text);
    b->tally.refused++;
}

static void add(cli_compensate_errors *errors, double x)
{
    errors->sum += x;
    if (!(x <= errors->max)) errors->max = x;
}

bool cli_compensate_count(cli_compensate_job *b, const mukca_compensation *c, const char *path,
                          int number)
{
    cli_compensate_tally *t = &b->tally;
    t->rows++;
    t->count[c->reach]++;
    add(&t->before, c->position_before);
    add(&t->after, c->position_error);
    if (!b->from || c->reach == MUKCA_REACH_OK) return true; /* tables have a status column */
    cli_compensate_refuse(b, path, number, mukca_reach_sentence[c->reach]);
    return false;
}

void cli_compensate_put(cli_compensate_job *b, const double *q, const mukca_compensation *c,
                        const char *path, int number)
{
    cli_compensate_count(b, c, path, number);
    for (int j = 0; j < b->arm.chain.n_joints; j++) fprintf(b->stream, "%.17g\t", q[j]);
    fprintf(b->stream, "%.9g\t%.9g\t%.9g\t%s\n", c->position_before, c->position_error,
            c->rotation_error, mukca_reach_text[c->reach]);
}

void cli_compensate_start(cli_compensate_job *b, bool oriented)
{
    const cli_compensate_options *o = b->call->options;
    mukca_compensator_start(&b->compensator, &b->arm, o->position_only || !oriented, o->tolerance);
}

/* ---- programs ---- */

static mukca_status correct_line(cli_compensate_job *b, const char *line, const char *path,
                                 int number)
{
    const mukca_chain *chain = &b->arm.chain;
    const mukca_row_reading reading = {
        .time = (double)NAN, .placement = -1, .number = (int)b->tally.rows + 1};
    char text[160];
    mukca_program_target t;
    const mukca_line_kind kind = mukca_language_read(&t, b->from, chain, line);
    if (kind == MUKCA_LINE_UNKNOWN) {
        const char *words = line + strspn(line, " \t");
        snprintf(text, sizeof text, "not understood: %.*s", (int)strcspn(words, "\r"), words);
        cli_compensate_refuse(b, path, number, text);
    }
    if (kind == MUKCA_LINE_OTHER) fputs(line, b->stream);
    if (kind != MUKCA_LINE_TARGET) return MUKCA_OK;
    double q[MUKCA_MAX_JOINTS];
    memcpy(q, t.q, sizeof q);
    for (int j = 0; j < chain->n_joints; j++)
        if (fabs(q[j]) > 4 * M_PI) /* as in tables */
            return mukca_fail(&b->call->error, MUKCA_INPUT,
                              "%s:%d: joint '%s' is %g rad, more than two turns; check --from",
                              mukca_file_shown(path), number, mukca_chain_joint_name(chain, j),
                              q[j]);
    const mukca_compensation c = mukca_compensate_joints(q, &b->compensator, &reading);
    if (cli_compensate_count(b, &c, path, number))
        mukca_language_replace(b->stream, b->from, chain, line, &t, q);
    return MUKCA_OK;
}

mukca_status cli_compensate_program(cli_compensate_job *b, const char *path)
{
    cli_call *call = b->call;
    const cli_compensate_options *o = call->options;
    const long before = b->tally.rows;
    char *text;
    int number = 0;
    mukca_status status = mukca_file_read(&text, path, &call->error);
    if (status != MUKCA_OK) return status;
    cli_compensate_start(b, true);
    for (char *line = text; status == MUKCA_OK && *line && !ferror(b->stream);) {
        char *end = line + strcspn(line, "\n");
        const bool ended = *end == '\n';
        *end = '\0';
        status = cli_interrupted() ? MUKCA_INTERRUPTED : correct_line(b, line, path, ++number);
        if (ended) fputc('\n', b->stream);
        line = end + ended;
    }
    free(text);
    if (status != MUKCA_OK) return status;
    if (b->tally.rows > before || b->tally.refused > 0) return MUKCA_OK;
    return mukca_fail(&call->error, MUKCA_INPUT, "%s: no target in %s; check --from and --tip",
                      mukca_file_shown(path), cli_compensate_formats[o->from]);
}
