/* Output of corrected targets as rows of a table or lines of a program, and their counters. */
#include <stdio.h>

#include "base/file.h"
#include "cli/compensate.h"

const char *const compensate_formats[] = {"table",
#define FORMAT_NAME(name, description) #name,
                                          MUKCA_LANGUAGE_LIST(FORMAT_NAME)
#undef FORMAT_NAME
                                              NULL};

void compensate_print_header(compensate_job *b, bool timed)
{
    const mukca_chain *chain = &b->arm.chain;
    if (b->to || b->headed) return;
    b->headed = true;
    cli_print_verdict(b->call, b->stream);
    if (timed) fputs("time_s\t", b->stream);
    for (int j = 0; j < chain->n_joints; j++)
        fprintf(b->stream, "%s\t", mukca_chain_joint_name(chain, j));
    fputs("error_before_m\terror_m\terror_rad\tstatus\n", b->stream);
}

void compensate_refuse(compensate_job *b, const char *path, int number, const char *why)
{
    mukca_error error; /* for its rules about foreign text */
    mukca_fail(&error, MUKCA_INPUT, "%s:%d: %s", mukca_file_shown(path), number, why);
    fprintf(stderr, "mukca: %s\n", error.text);
    b->tally.refused++;
}

bool compensate_count(compensate_job *b, const mukca_compensation *c, const char *path, int number)
{
    compensate_tally *t = &b->tally;
    t->rows++;
    t->count[c->reach]++;
    mukca_moments_add(&t->before, c->position_before);
    mukca_moments_add(&t->after, c->position_error);
    if (!b->to || c->reach == MUKCA_REACH_OK) return true; /* tables have a status column */
    compensate_refuse(b, path, number, mukca_reach_sentence[c->reach]);
    return false;
}

void compensate_put(compensate_job *b, const double *q, const mukca_compensation *c,
                    const char *path, int number)
{
    if (!compensate_count(b, c, path, number)) return;
    if (b->to) {
        mukca_language_print(b->stream, b->to, &b->arm.chain, q);
        fputc('\n', b->stream);
        return;
    }
    for (int j = 0; j < b->arm.chain.n_joints; j++) fprintf(b->stream, "%.17g\t", q[j]);
    fprintf(b->stream, "%.9g\t%.9g\t%.9g\t%s\n", c->position_before, c->position_error,
            c->rotation_error, mukca_reach_text[c->reach]);
}

void compensate_start(compensate_job *b, bool oriented)
{
    const compensate_options *o = b->call->options;
    mukca_compensator_start(&b->compensator, &b->arm, o->position_only || !oriented, o->tolerance);
}
