/* mukca compensate: joint targets in, corrected joint targets out; programs whole, or each line
 * listed that was not understood. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arm/compensate.h"
#include "base/file.h"
#include "cli/cli.h"
#include "io/language.h"

static const char *const formats[] = {"table",
#define FORMAT_NAME(name, description) #name,
                                      MUKCA_LANGUAGE_LIST(FORMAT_NAME)
#undef FORMAT_NAME
                                          NULL};

typedef struct {
    cli_common common;
    bool position_only;
    int from; /* index into formats */
} compensate_options;

/* Errors of the tip, m. */
typedef struct {
    double sum, max;
} tip_errors;

typedef struct {
    tip_errors before, after;
    long count[MUKCA_REACH_COUNT], rows;
    long refused; /* lines for which no program is written */
} tally;

/* One run: output and counters. */
typedef struct {
    cli_call *call;
    FILE *stream;
    mukca_corrected arm;
    const mukca_language *from; /* NULL: tables */
    mukca_compensator compensator;
    tally tally;
    mukca_rows rows;
    bool headed; /* the table's header has been written */
} compensate_work;

static const cli_option options[] = {
    CLI_OPTION(compensate_options, from, "from", CLI_CHOICE, "FORMAT",
               "correct tables (default) or programs in this language", .choices = formats),
    CLI_OPTION(compensate_options, position_only, "position-only", CLI_FLAG, NULL,
               "ignore the orientation (always with fewer than six joints)"),
    CLI_OUTPUT_OPTION("write the corrected targets there (default: standard output)"),
    {.name = NULL}};

/* ---- tables ---- */

/* Print the table's header, once. */
static void print_header(compensate_work *w, bool timed)
{
    const mukca_chain *chain = &w->arm.chain;
    if (w->headed) return;
    w->headed = true;
    cli_print_verdict(w->call, w->stream);
    if (timed) fputs("time_s\t", w->stream);
    for (int j = 0; j < chain->n_joints; j++)
        fprintf(w->stream, "%s\t", mukca_chain_joint_name(chain, j));
    fputs("error_before_m\terror_m\terror_rad\tstatus\n", w->stream);
}

/* List line `number` of `path`, which a program cannot hold, and why. */
static void refuse(compensate_work *w, const char *path, int number, const char *why)
{
    mukca_error error; /* for its rules about foreign text */
    mukca_fail(&error, MUKCA_INPUT, "%s:%d: %s", mukca_file_shown(path), number, why);
    fprintf(stderr, "mukca: %s\n", error.text);
    w->tally.refused++;
}

static void add(tip_errors *errors, double x)
{
    errors->sum += x;
    if (!(x <= errors->max)) errors->max = x;
}

/* Count a target; false: a program cannot hold it (listed). */
static bool count(compensate_work *w, const mukca_compensation *c, const char *path, int number)
{
    tally *t = &w->tally;
    t->rows++;
    t->count[c->reach]++;
    add(&t->before, c->position_before);
    add(&t->after, c->position_error);
    if (!w->from || c->reach == MUKCA_REACH_OK) return true; /* tables have a status column */
    refuse(w, path, number, mukca_reach_sentence[c->reach]);
    return false;
}

static mukca_status correct_table(compensate_work *w, const char *path)
{
    cli_call *call = w->call;
    mukca_rows *rows = &w->rows;
    mukca_row row;
    mukca_rows_options header = {.kind = MUKCA_EITHER, .unchecked = true, .notes = cli_notes(call)};
    MUKCA_TRY(cli_read_format(call, &header.format));
    MUKCA_TRY(mukca_rows_open(rows, path, &w->arm.chain, &header, &call->error));
    if (mukca_table_find(&rows->table, "error_before_m") >= 0)
        mukca_table_fail(
            &rows->table, -1,
            "these targets were corrected by mukca compensate; give the intended ones");
    const bool timed = rows->column.number[MUKCA_COLUMN_TIME][0] >= 0;
    print_header(w, timed);
    while (!ferror(w->stream) && !cli_interrupted() && mukca_rows_next(rows, &row)) {
        const mukca_row_reading reading = mukca_row_read(&row, rows);
        double q[MUKCA_MAX_JOINTS];
        memcpy(q, row.q, sizeof q);
        const mukca_compensation c = mukca_compensate_joints(q, &w->compensator, &reading);
        count(w, &c, path, rows->table.line);
        if (timed) fprintf(w->stream, "%.17g\t", row.time[0]);
        for (int j = 0; j < w->arm.chain.n_joints; j++) fprintf(w->stream, "%.17g\t", q[j]);
        fprintf(w->stream, "%.9g\t%.9g\t%.9g\t%s\n", c.position_before, c.position_error,
                c.rotation_error, mukca_reach_text[c.reach]);
    }
    const mukca_status status = mukca_rows_close(rows);
    return status == MUKCA_OK && cli_interrupted() ? MUKCA_INTERRUPTED : status;
}

/* ---- programs ---- */

static void correct_line(compensate_work *w, const char *line, const char *path, int number)
{
    const mukca_chain *chain = &w->arm.chain;
    const mukca_row_reading reading = {
        .time = (double)NAN, .placement = -1, .number = (int)w->tally.rows + 1};
    char text[160];
    mukca_program_target t;
    const mukca_program_line kind = mukca_language_read(&t, w->from, chain, line);
    if (kind == MUKCA_LINE_UNKNOWN) {
        const char *words = line + strspn(line, " \t");
        snprintf(text, sizeof text, "not understood: %.*s", (int)strcspn(words, "\r"), words);
        refuse(w, path, number, text);
    }
    if (kind == MUKCA_LINE_OTHER) fputs(line, w->stream);
    if (kind != MUKCA_LINE_TARGET) return;
    double q[MUKCA_MAX_JOINTS];
    memcpy(q, t.q, sizeof q);
    for (int j = 0; j < chain->n_joints; j++)
        if (!mukca_rows_plausible(&chain->element[chain->joint_element[j]], q[j])) {
            snprintf(text, sizeof text, "joint '%s' is %g rad, more than two turns; check --from",
                     mukca_chain_joint_name(chain, j), q[j]);
            refuse(w, path, number, text);
            return;
        }
    const mukca_compensation c = mukca_compensate_joints(q, &w->compensator, &reading);
    if (count(w, &c, path, number)) mukca_language_replace(w->stream, w->from, chain, line, &t, q);
}

/* Correct the program at `path`; lines that are not understood are listed. */
static mukca_status correct_program(compensate_work *w, const char *path)
{
    cli_call *call = w->call;
    const compensate_options *o = call->options;
    const long before = w->tally.rows;
    char *text;
    int number = 0;
    MUKCA_TRY(mukca_file_read(&text, path, &call->error));
    for (char *line = text; *line && !ferror(w->stream) && !cli_interrupted();) {
        char *end = line + strcspn(line, "\n");
        const bool ended = *end == '\n';
        *end = '\0';
        correct_line(w, line, path, ++number);
        if (ended) fputc('\n', w->stream);
        line = end + ended;
    }
    free(text);
    if (cli_interrupted()) return MUKCA_INTERRUPTED;
    if (w->tally.rows > before || w->tally.refused > 0) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT, "%s: no target in %s; check --from and --tip",
                    mukca_file_shown(path), formats[o->from]);
}

/* ---- the command ---- */

/* Mean over the rows, m. */
static double mean(const tally *t, const tip_errors *errors)
{
    return t->rows ? errors->sum / (double)t->rows : 0;
}

static mukca_status print(cli_call *call)
{
    const tally *t = &((const compensate_work *)call->work)->tally;
    if (t->rows == 0) return MUKCA_OK;
    cli_answer(call, "%ld row%s: error %.4f mm (mean), %.4f mm (max) -> %.4f mm, %.4f mm\n",
               t->rows, t->rows == 1 ? "" : "s", 1e3 * mean(t, &t->before), 1e3 * t->before.max,
               1e3 * mean(t, &t->after), 1e3 * t->after.max);
    for (int r = 1; r < MUKCA_REACH_COUNT; r++)
        if (t->count[r] > 0)
            cli_answer(call, "%ld row%s '%s': %s\n", t->count[r], t->count[r] == 1 ? "" : "s",
                       mukca_reach_text[r], mukca_reach_sentence[r]);
    return MUKCA_OK;
}

static json_t *as_json(const cli_call *call)
{
    const tally *t = &((const compensate_work *)call->work)->tally;
    json_t *counts = json_object();
    for (int r = 0; r < MUKCA_REACH_COUNT; r++)
        json_object_set_new(counts, mukca_reach_text[r], json_integer((json_int_t)t->count[r]));
    return cli_json(
        FIELD(t, rows),
        KEY("before", cli_json(KEY("mean_m", mean(t, &t->before)), KEY("max_m", t->before.max))),
        KEY("after", cli_json(KEY("mean_m", mean(t, &t->after)), KEY("max_m", t->after.max))),
        KEY("status", counts), KEY("elapsed_s", cli_elapsed(call)));
}

/* Check that targets of the language have an axis for each joint. */
static mukca_status check_axes(cli_call *call, int format)
{
    const int n = call->session->model.chain.n_joints;
    const int most = format ? mukca_language_axes(mukca_languages[format - 1]) : n;
    if (n <= most) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT,
                    "a target in %s has at most %d axes, and the chain has %d; check --tip",
                    formats[format], most, n);
}

static mukca_status correct_all(cli_call *call, FILE *stream)
{
    const compensate_options *o = call->options;
    compensate_work *w = call->work;
    const cli_list input = cli_inputs(call);
    w->stream = stream;
    for (int i = 0; i < input.n; i++) {
        mukca_compensator_start(&w->compensator, &w->arm, o->position_only);
        MUKCA_TRY((w->from ? correct_program : correct_table)(w, input.items[i]));
    }
    return MUKCA_OK;
}

/* Write a program when all of it is known to be right: if no line was refused. */
static mukca_status correct_whole(cli_call *call, FILE *stream)
{
    const tally *t = &((const compensate_work *)call->work)->tally;
    char *text = NULL;
    size_t size;
    FILE *memory = open_memstream(&text, &size);
    mukca_status status = memory ? correct_all(call, memory) : MUKCA_MEMORY;
    const bool whole = memory && mukca_file_close(memory, &text);
    if ((status == MUKCA_OK && !whole) || !memory)
        status = cli_fail(call, MUKCA_MEMORY, "not enough memory for the program");
    else if (status == MUKCA_OK && t->refused > 0)
        status = cli_fail(call, MUKCA_INPUT,
                          "nothing written, for the %ld line%s above; a program is corrected only "
                          "if each motion in it is to joint values in numbers",
                          t->refused, t->refused == 1 ? "" : "s");
    if (status == MUKCA_OK) fputs(text, stream);
    free(text);
    return status;
}

static mukca_status run(cli_call *call)
{
    const compensate_options *o = call->options;
    const cli_common *c = call->common;
    const cli_model *model = &call->session->model;
    compensate_work *w = call->work;
    MUKCA_TRY(check_axes(call, o->from));
    w->call = call;
    w->from = o->from ? mukca_languages[o->from - 1] : NULL;
    w->arm.chain = model->chain;
    w->arm.geometry = model->geometry;
    w->arm.n_effects = model->offsets.n_effects;
    memcpy(w->arm.effects, model->offsets.effects, sizeof w->arm.effects);
    if (!c->arm.offsets)
        cli_note(call, "no --offsets: targets are those of the nominal model; no correction");
    mukca_offsets_note_history(&model->offsets, &w->arm.chain,
                               "applied to the rows as to a recording that begins with the first, "
                               "not to the arm in use",
                               cli_notes(call));
    cli_writer *const correct = w->from ? correct_whole : correct_all;
    if (c->json && strcmp(c->json, "-") == 0 && !c->output)
        return cli_write(call, "/dev/null", correct);
    return cli_write_table(call, correct);
}

#define FORMAT_LINE(name, description) "  " #name ": " description "\n"

const cli_command cli_command_compensate = {
    .name = "compensate",
    .group = CLI_USE,
    .summary = "correct joint targets for the identified errors",
    .synopsis = "[FILE...]",
    .description =
        "For controllers whose model cannot be changed. Reads rows of joint targets and writes corrected joint targets: with these the arm of --offsets, effects included, reaches the pose that the nominal model predicts for the given targets. Damped least squares with the smallest change of the joints, within their limits; along a path the corrections are continuous. For a target out of reach the row holds the nearest solution and its status the reason.\n\n"
        "--from corrects programs; joints from the seventh on are external axes:\n" MUKCA_LANGUAGE_LIST(FORMAT_LINE)
        "A program is corrected only as a whole: each line is a comment, a motion to joint values in numbers (MoveAbsJ, PTP, SPTP, movej, movel, movep, servoj), a target alone, or one of a few statements without motion. Otherwise all other lines are listed, nothing is written, and the exit code is 3; likewise if a target is out of reach.",
    .example =
        "  echo 0.1,0.2,0.3,-1.5,0.2,1.1,0.4 | mukca compensate \\\n"
        "      --urdf data/demo/arm.urdf --offsets build/demo/offsets.tsv",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_JSON | CLI_WITH_COLUMNS,
    .options = options,
    .options_size = sizeof(compensate_options),
    .reads = CLI_READS_MODEL,
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(compensate_work),
};
