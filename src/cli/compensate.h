/* What the compensate command's files share. */
#ifndef MUKCA_CLI_COMPENSATE_H
#define MUKCA_CLI_COMPENSATE_H

#include "arm/compensate.h"
#include "cli/cli.h"
#include "io/language.h"
#include "recalibrate/errors.h"

extern const char *const compensate_formats[]; /* table, then the languages; ended by NULL */

typedef struct {
    cli_common common;
    bool poses, position_only;
    int from, format; /* index into compensate_formats; -1: as `from` */
    double tolerance;
} compensate_options;

typedef struct {
    mukca_moments before, after;
    long count[MUKCA_REACH_COUNT], rows;
    /* of a program: targets of the kind that was not asked for, and those with missing numbers */
    long other, incomplete;
} compensate_tally;

/* One run: where the targets go, and what has been counted. */
typedef struct {
    cli_call *call;
    FILE *stream;
    const mukca_corrected *arm;
    const mukca_language *from, *to; /* NULL: tables */
    mukca_compensator compensator;
    compensate_tally tally;
    bool headed; /* the table's header is written */
} compensate_job;

/* A path begins: the targets of one file. */
void compensate_start(compensate_job *job, bool oriented);

/* The table's header, once. */
void compensate_print_header(compensate_job *job, bool timed);

/* A corrected target as a row of the table or a line of a program. */
void compensate_put(compensate_job *job, const double *q, const mukca_compensation *c);

/* Count a target of line `line` of `path`. */
void compensate_count(compensate_job *job, const mukca_compensation *c, const char *path, int line);

/* Correct the targets of the program at `path`. */
mukca_status compensate_program(compensate_job *job, const char *path);

#endif
