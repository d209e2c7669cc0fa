/* The command framework: tables of commands and options that drive parsing, help, man page and
 * completion, and functions shared by commands.
 *
 * A command is one file src/cli/<name>.c that defines `const cli_command cli_command_<name>`, and
 * one line in CLI_COMMAND_LIST (commands.c).
 */
#ifndef MUKCA_CLI_H
#define MUKCA_CLI_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/pool.h"
#include "base/text.h"
#include "cli/options.h"
#include "fit/evaluate.h"
#include "infer/gaussians.h"
#include "io/kinematics.h"
#include "io/offsets.h"
#include "io/output.h"
#include "io/rows.h"
#include "io/summary.h"
#include "model/dataset.h"
#include "mukca/chain.h"
#include "mukca/effect.h"
#include "mukca/status.h"
#include "report/page.h"

/* Groups of commands in the order of the work, with their titles in help. */
#define CLI_GROUP_LIST(X)                                          \
    X(MEASURE, "Measure: record or simulate the arm")              \
    X(CALIBRATE, "Calibrate: fit the model to the arm")            \
    X(UNDERSTAND, "Understand: the causes of the remaining error") \
    X(USE, "Use: carry the result to where it is needed")

typedef enum {
#define CLI_GROUP_ENUM(name, title) CLI_##name,
    CLI_GROUP_LIST(CLI_GROUP_ENUM)
#undef CLI_GROUP_ENUM
} cli_group;

typedef struct cli_call cli_call;

/* A step of a command.  Returns the exit code; on errors, call->error is the line to print (empty:
 * none). */
typedef mukca_status cli_step(cli_call *call);

/* Write a file, or standard output, that is open. */
typedef mukca_status cli_writer(cli_call *call, FILE *stream);

/* What is read into call->session before `run`. */
typedef enum {
    CLI_READS_NOTHING,
    CLI_READS_MODEL,    /* the arm of the common options, --traits */
    CLI_READS_DATA,     /* also DATA, if there are arguments, and --test */
    CLI_READS_CONDENSED /* likewise, DATA condensed to the capacity of a diagnosis */
} cli_reads;

typedef struct {
    const char *name;
    cli_group group;
    const char *summary;       /* one line without a full stop */
    const char *synopsis;      /* positional arguments, "DATA...", "[FILE...]", "A B"; "": none */
    const char *description;   /* paragraphs separated by empty lines; wrapped by help */
    const char *example;       /* valid commands, indented; a test runs each */
    unsigned with;             /* common options: CLI_WITH_... */
    const cli_option *options; /* its own; NULL: none */
    size_t options_size;       /* of the options struct, first member cli_common */
    const void *defaults;      /* an options struct, or NULL: zeroed */
    bool targets;              /* pose logs may have several targets */
    bool grows;                /* -o may exist */
    bool any_table;            /* an offsets table is read whatever its verdict */
    /* The steps of its run, in this order, until one fails; NULL: nothing to do. */
    cli_step *check; /* of the options, before anything is read */
    cli_reads reads;
    cli_step *run;                         /* its work, and the files that have own options */
    cli_writer *table;                     /* -o, else standard output unless --json is given */
    json_t *(*json)(const cli_call *call); /* --json, without its schema */
    cli_step *print;                       /* the answer; returns the exit code */
    size_t work_size;                      /* of call->work, or 0 */
    void (*release)(void *work);           /* frees what its members own outside of the pool */
} cli_command;

typedef struct {
    mukca_chain chain;
    mukca_chain urdf; /* the chain with the URDF's origins, before --kinematics */
    mukca_kinematics kinematics;
    mukca_offsets offsets;   /* of --offsets; default: nominal theta, no effects */
    mukca_geometry geometry; /* of offsets.theta */
} cli_model;

/* Inputs of a command. */
typedef struct {
    cli_model model;
    mukca_traits traits;      /* --traits */
    mukca_dataset data, test; /* DATA..., --test */
} cli_session;

struct cli_call {
    const cli_command *command;
    void *options;                     /* the command's options struct */
    cli_common *common;                /* its first member */
    int argc;                          /* arguments after the command's name */
    char **argv;                       /* [argc] */
    cli_list arguments;                /* positionals */
    cli_given given[CLI_MOST_OPTIONS]; /* [n_given] each option once */
    int n_given;
    cli_session *session; /* zeroed, filled as the command reads */
    void *work;           /* zeroed memory of the command */
    mukca_pool pool;      /* of all these, and for the command's arrays */
    mukca_error error;
    double started, progressed; /* s, monotonic: the start, the last progress line */
    bool showing;               /* a progress line is on the screen */
    bool printed;               /* standard output is the table, without -o */
};

/* mukca_fail for the line to print. */
#define cli_fail(call, ...) mukca_fail(&(call)->error, __VA_ARGS__)

/* All commands, terminated by NULL. */
extern const cli_command *const cli_commands[];

/* The command's options after `option` (NULL: from the first on), its own before the common ones;
 * NULL after the last. */
const cli_option *cli_next_option(const cli_command *command, const cli_option *option);

/* The member of call->options that has the option's value, of the type of its kind. */
void *cli_option_member(const cli_call *call, const cli_option *option);

/* ---- parsing and help (parse.c, options.c, commands.c) ---- */

/* Fill call->options and call->arguments from argv[argc]; `*help`: -h or --help was given.  Errors:
 * MUKCA_USAGE, MUKCA_MEMORY. */
mukca_status cli_parse(cli_call *call, bool *help, int argc, char **argv);
void cli_call_free(cli_call *call);

/* Read comma-separated numbers.  Returns how many, -1: an invalid one, or more than `most`. */
int cli_read_list(double *values, int most, const char *text);

const cli_command *cli_find_command(const char *name); /* NULL: none */

/* Error for a `name` that is no effect, with a suggestion: MUKCA_USAGE. */
mukca_status cli_fail_effect(mukca_error *error, const char *option, const char *name);

/* Run the steps of the parsed command. */
mukca_status cli_run(cli_call *call);

/* ---- terminal output (terminal.c) ---- */

/* Print `text` wrapped to 79 columns; empty lines separate paragraphs, lines that begin with a
 * space are printed unchanged. */
void cli_print_wrapped(FILE *stream, const char *text);

/* "Cause   text": a bold key of 8 columns, then the wrapped text; key NULL: without; nothing for an
 * empty text. */
void cli_print_keyed(FILE *stream, const char *key, const char *text);

/* "panda: 180 samples, 3 placements; test: 60 samples, 1 placement"; `test` may be NULL or empty.
 */
void cli_print_head(FILE *stream, const char *robot, const mukca_dataset *data,
                    const mukca_dataset *test);

/* Print the words of text[length], wrapped, from `column` on, with a line feed. */
void cli_print_words(FILE *stream, int indent, int column, const char *text, size_t length);

/* Stream of the readable answer: standard output, or standard error if standard output is
 * machine-readable (--json -, -o -, or a table of cli_write_table).  NULL with -q.  Call it
 * for each piece of output: it clears a progress line. */
FILE *cli_answer_stream(cli_call *call);

/* Standard error; NULL with -q. */
FILE *cli_log_stream(cli_call *call);

/* printf without control characters; nothing if the stream is NULL. */
void cli_print(FILE *stream, const char *format, ...) __attribute__((format(printf, 2, 3)));
#define cli_answer(call, ...) cli_print(cli_answer_stream(call), __VA_ARGS__)
#define cli_log(call, ...) cli_print(cli_log_stream(call), __VA_ARGS__)

/* cli_answer as cli_print_keyed. */
void cli_say(cli_call *call, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Receiver of notes, and a note to it; silent with -q. */
mukca_notes cli_notes(cli_call *call);
#define cli_note(call, ...) mukca_note_format(cli_notes(call), __VA_ARGS__)

double cli_elapsed(const cli_call *call);

/* Escape sequences for headings, "" if the stream is no terminal or NO_COLOR is set. */
const char *cli_bold(FILE *stream);
const char *cli_plain(FILE *stream);

/* Catch SIGINT and SIGTERM (a second one kills); true after the first: return MUKCA_INTERRUPTED. */
void cli_catch_interrupts(void);
bool cli_interrupted(void);

/* Callbacks for long functions of the library.  The second shows progress on a terminal, from 2 s
 * of run time on, and returns false after an interrupt. */
bool cli_stop(void *context);
bool cli_show_progress(void *call, double fraction, const char *doing);

/* ---- JSON objects from C values (json.c) ---- */

/* A JSON object: cli_json(KEY("name", text), KEY("error_m", number), ...).  The type of a value is
 * that of C: texts (NULL: null), flags, integers, numbers (null for NaN and infinity), json_t *
 * (stolen; NULL: null).  A comparison is an int: write (bool)(a > b). */
typedef struct {
    const char *key;
    json_t *value;
} cli_json_member;
#define KEY(name, value)                        \
    {                                           \
        name, _Generic((value),               \
            bool: cli_json_flag,           \
            unsigned char: cli_json_flag,  \
            int: json_integer,             \
            long: json_integer,            \
            double: cli_json_real,         \
            char *: cli_json_text,         \
            const char *: cli_json_text,   \
            json_t *: cli_json_value)(value) \
    }
#define FIELD(from, member) KEY(#member, (from)->member) /* FIELD(plan, rows_to_name) */
#define cli_json(...) cli_json_object((const cli_json_member[]){__VA_ARGS__, {NULL, NULL}})
#define cli_json_append(array, ...) json_array_append_new(array, cli_json(__VA_ARGS__))
json_t *cli_json_object(const cli_json_member *members); /* up to the key NULL */
json_t *cli_json_flag(bool value);
json_t *cli_json_real(double value);
json_t *cli_json_text(const char *text);
json_t *cli_json_value(json_t *value);
json_t *cli_json_positive(int value);               /* NULL unless above 0 */
json_t *cli_json_interval(double low, double high); /* NULL unless both are finite */
json_t *cli_json_estimate(const mukca_estimate *e); /* its interval; NULL: none */

/* Numbers; null for NaN and infinity. */
json_t *cli_json_reals(const double *values, int n);

/* A pose: position_m, and quaternion, w first. */
json_t *cli_json_frame(const mukca_frame *frame);

/* ---- inputs and outputs of commands (load.c, outputs.c, json.c) ---- */

/* Fill call->session.  Errors: those of the functions below. */
mukca_status cli_read(cli_call *call, cli_reads what);

/* Read an arm, for which --traits must be.  Errors: MUKCA_USAGE (no --urdf), MUKCA_INPUT,
 * MUKCA_MEMORY. */
mukca_status cli_load_model(cli_call *call, cli_model *model, const cli_arm *arm);

/* A comment line in an output if the table of --offsets was not accepted. */
void cli_print_verdict(const cli_call *call, FILE *stream);

/* Read an offsets table, subject to the options --accept-*.  `embedded` (may be
 * NULL) receives the chain in its comments, for which it is then read.  Errors: MUKCA_INPUT,
 * MUKCA_MEMORY. */
mukca_status cli_read_offsets(cli_call *call, mukca_offsets *offsets, mukca_chain *embedded,
                              const mukca_chain *chain, const char *path);

/* Format of input tables from --units, --map and --inverse-poses.  Errors: MUKCA_USAGE. */
mukca_status cli_read_format(cli_call *call, mukca_rows_format *format);

/* Read DATA paths, if any, for the model's chain; --distance, --distances and --payload apply. Free
 * with mukca_dataset_free. */
mukca_status cli_load_data(cli_call *call, mukca_dataset *data, const cli_model *model,
                           const cli_list *paths);

/* Refuse a socket, or measured poses, of which all samples, three or more, have identical angles,
 * or `postures`: are of one posture.  Errors: MUKCA_UNIDENTIFIABLE, MUKCA_MEMORY. */
mukca_status cli_check_moving(cli_call *call, const mukca_dataset *data, bool postures);

/* Evaluate the model with its offsets, in memory of the call's pool, and refuse data of another
 * arm: the predictions of a socket scatter by more than CLI_FOREIGN.  Errors: MUKCA_NEGATIVE,
 * MUKCA_MEMORY. */
mukca_status cli_check_scatter(mukca_evaluation *evaluation, cli_call *call, const char *path,
                               const cli_model *model, const mukca_dataset *data);

/* m per axis: twice that of an arm whose mean error is 15 mm, the largest of calibrated arms. */
#define CLI_FOREIGN 0.02

/* Error of the nominal model that indicates wrong units or columns, m: arms are built to 10 mm. */
#define CLI_FAR_OFF 0.1

/* "180 samples, 3 placements", "1000 measured poses". */
void cli_describe_data(char text[80], const mukca_dataset *data);

/* The positional arguments, or standard input if there are none, with a note at a terminal. */
cli_list cli_inputs(cli_call *call);

/* Check all outputs before any long work: each different from the others, no input (not even
 * --force overwrites a recording, which cannot be repeated), not existing without --force, folder
 * writable.  Errors: MUKCA_USAGE, MUKCA_INPUT, MUKCA_MEMORY. */
mukca_status cli_check_outputs(cli_call *call);

/* Write a file (NULL: none); and the table of a command: to -o, else to standard output. */
mukca_status cli_write(cli_call *call, const char *path, cli_writer *write);
mukca_status cli_write_table(cli_call *call, cli_writer *write);

/* Write a page with the command line and the time.  Errors: MUKCA_MEMORY. */
mukca_status cli_write_page(cli_call *call, FILE *stream, mukca_page page);

/* Write `members` (reference stolen) to --json, after the schema "mukca.COMMAND/1".  Errors:
 * MUKCA_INPUT, MUKCA_MEMORY (also after any allocation that failed). */
mukca_status cli_write_json(cli_call *call, json_t *members);

/* Monitor jansson's allocations, from before its first use. */
void cli_json_watch(void);

/* The rows of an offsets table as JSON objects (`parameters` in the output). */
json_t *cli_json_offsets(const mukca_offsets *offsets, const mukca_chain *chain);

/* Whether to use the table and, if so, the expected error of the tip: keyed lines. */
void cli_print_acceptance(FILE *stream, const mukca_acceptance *acceptance,
                          const mukca_chain *chain);

/* The verdict of an offsets table as a JSON object; null for NULL. */
json_t *cli_json_acceptance(const mukca_acceptance *acceptance);

#endif
