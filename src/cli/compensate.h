/* Declarations shared by the files of the compensate command. */
#ifndef MUKCA_CLI_COMPENSATE_H
#define MUKCA_CLI_COMPENSATE_H

#include "arm/compensate.h"
#include "cli/cli.h"
#include "io/language.h"
#include "io/rows.h"

extern const char
    *const cli_compensate_formats[]; /* table, then the languages; terminated by NULL */

typedef struct {
    cli_common common;
    bool poses, position_only;
    int from; /* index into cli_compensate_formats */
    double tolerance;
} cli_compensate_options;

/* Errors of the tip, m. */
typedef struct {
    double sum, max;
} cli_compensate_errors;

typedef struct {
    cli_compensate_errors before, after;
    long count[MUKCA_REACH_COUNT], rows;
    long refused; /* lines for which no program is written */
} cli_compensate_tally;

/* One run: output and counters. */
typedef struct {
    cli_call *call;
    FILE *stream;
    mukca_corrected arm;
    const mukca_language *from; /* NULL: tables */
    mukca_compensator compensator;
    cli_compensate_tally tally;
    mukca_rows rows;
    bool headed; /* the table's header has been written */
} cli_compensate_job;

/* Begin a path: the targets of one file. */
void cli_compensate_start(cli_compensate_job *job, bool oriented);

/* Print the table's header, once. */
void cli_compensate_print_header(cli_compensate_job *job, bool timed);

/* List line `number` of `path`, which a program cannot hold, and why. */
void cli_compensate_refuse(cli_compensate_job *job, const char *path, int number, const char *why);

/* Count a target; false: a program cannot hold it (listed). */
bool cli_compensate_count(cli_compensate_job *job, const mukca_compensation *c, const char *path,
                          int number);

/* Count a corrected target, and print it as a row of the table. */
void cli_compensate_put(cli_compensate_job *job, const double *q, const mukca_compensation *c,
                        const char *path, int number);

/* Correct the program at `path`; lines that are not understood are listed. */
mukca_status cli_compensate_program(cli_compensate_job *job, const char *path);

#endif
