/* mukca report: calibrate, diagnose, and show it all on one page. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sha2.h>

#include "cli/calibrate.h"
#include "fit/nlopt_adapter.h"
#include "io/output.h"
#include "report/report.h"

typedef struct {
    cli_common common;
    const char *plots;
    int format;
    double repeatability;
    bool free_base, free_tool;
} report_options;

static const report_options defaults = {.repeatability = 1e-4};

static const char *const formats[] = {"png", "pdf", "svg", NULL};

static const cli_option options[] = {
    CLI_TEST_OPTION,
    CLI_OUTPUT_OPTION("write the page there (default: standard output)"),
    {"plots", 0, CLI_TEXT, "FOLDER", "also write each figure there as a file", NULL,
     offsetof(report_options, plots)},
    {"format", 0, CLI_CHOICE, "FORMAT", "format of these files (default: png)", formats,
     offsetof(report_options, format)},
    {"repeatability", 0, CLI_NUMBER, "M",
     "repeatability of the data sheet, a line in the convergence plot, m (default: 1e-4; 0: none)",
     NULL, offsetof(report_options, repeatability)},
    {"free-base", 0, CLI_FLAG, NULL, "pose logs: fit the frame of the tracker", NULL,
     offsetof(report_options, free_base)},
    {"free-tool", 0, CLI_FLAG, NULL, "pose logs: fit the offset of the target", NULL,
     offsetof(report_options, free_tool)},
    CLI_OFFSETS_OPTION,
    CLI_MODEL_OPTIONS,
    CLI_DISTANCE_OPTIONS,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

enum { MAX_STEPS = 500 };

/* All that a run holds beside the session. */
typedef struct {
    cli_call *call;
    cli_session *session;
    mukca_fit fit;
    mukca_offsets offsets;
    mukca_diagnosis diagnosis;
    mukca_next_poses next;
    mukca_pool pool;
    mukca_score *scores; /* scratch of `watch` */
    mukca_report_step steps[MAX_STEPS];
    mukca_report page;
    char *command, when[32];
} report_work;

/* Called at each iteration of the fit. */
static void watch(void *context, const double *theta, const mukca_cost_value *value,
                  int evaluations)
{
    report_work *r = context;
    (void)value;
    (void)evaluations;
    const mukca_model model = {.chain = &r->fit.chain, .theta = theta};
    mukca_score train = {0}, test = {.std = NAN, .distance_error = NAN};
    if (r->page.n_steps >= MAX_STEPS) return;
    mukca_evaluate(r->scores, &train, &model, &r->session->data);
    if (r->session->test.n_rows > 0) mukca_evaluate(r->scores, &test, &model, &r->session->test);
    r->steps[r->page.n_steps++] = (mukca_report_step){.train_consistency = train.std,
                                                      .train_distortion = train.distance_error,
                                                      .test_consistency = test.std,
                                                      .test_distortion = test.distance_error};
}

/* Fit, or take the table of --offsets. */
static mukca_status calibrate(report_work *r)
{
    cli_call *call = r->call;
    const report_options *o = call->options;
    if (call->common->offsets) {
        r->offsets = r->session->model.offsets;
        r->page.fitted = &r->session->model.chain;
        return MUKCA_OK;
    }
    r->scores = MUKCA_TAKE(&r->pool, mukca_score,
                           r->session->data.n_placements + r->session->test.n_placements + 2);
    if (!r->scores) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    const mukca_fit_options fit_options = {
        .free_base = o->free_base,
        .free_tool = o->free_tool,
        .solver = mukca_solver_table[0],
        .limits = {.stop = cli_stop, .progress = watch, .context = r}};
    const mukca_status status = mukca_fit_run(&r->fit, &r->session->model.chain, &r->session->data,
                                              &fit_options, &call->error);
    if (status != MUKCA_OK) return status;
    calibrate_fill_offsets(&r->offsets, &r->fit);
    r->page.fit = &r->fit;
    r->page.fitted = &r->fit.chain;
    r->page.solver = mukca_solver_table[0]->name;
    return MUKCA_OK;
}

static mukca_status diagnose(report_work *r)
{
    const report_options *o = r->call->options;
    const mukca_dataset *test = r->session->test.n_rows > 0 ? &r->session->test : NULL;
    const mukca_diagnose_options diagnose_options = {.test = test,
                                                     .free_base = o->free_base,
                                                     .free_tool = o->free_tool,
                                                     .applied = true,
                                                     .confounding = true,
                                                     .progress = cli_show_progress,
                                                     .progress_context = r->call};
    mukca_status status = mukca_diagnose(&r->diagnosis, &r->session->model.chain, &r->session->data,
                                         &diagnose_options, &r->call->error);
    if (status != MUKCA_OK) return status;
    r->page.diagnosed = (mukca_diagnosed){.diagnosis = &r->diagnosis,
                                          .chain = &r->session->model.chain,
                                          .data = &r->session->data,
                                          .test = test,
                                          .next = &r->next,
                                          .saved = true};
    return mukca_next_poses_choose(&r->next, &r->diagnosis, &r->session->model.chain,
                                   &r->session->data, cli_stop, &r->call->error);
}

/* Paths and hashes of all that was read; folders stand for the files in them. */
static mukca_status provenance(report_work *r)
{
    const mukca_dataset *sets[2] = {&r->session->data, &r->session->test};
    mukca_report_file *files = MUKCA_TAKE(&r->pool, mukca_report_file,
                                          r->session->data.n_files + r->session->test.n_files + 2);
    int n = 0;
    if (!files) return mukca_fail(&r->call->error, MUKCA_MEMORY, "out of memory");
    files[n++] = (mukca_report_file){r->call->common->urdf, r->session->model.chain.urdf_sha256};
    for (int k = 0; k < 2; k++)
        for (int f = 0; f < sets[k]->n_files; f++) {
            char *hash = MUKCA_TAKE(&r->pool, char, SHA256_DIGEST_STRING_LENGTH);
            if (!hash) return mukca_fail(&r->call->error, MUKCA_MEMORY, "out of memory");
            if (!SHA256File(sets[k]->files[f], hash)) strcpy(hash, "file no longer exists");
            files[n++] = (mukca_report_file){sets[k]->files[f], hash};
        }
    r->page.files = files;
    r->page.n_files = n;
    return MUKCA_OK;
}

static mukca_status write_page(report_work *r)
{
    const report_options *o = r->call->options;
    mukca_output output = {0};
    mukca_status status = MUKCA_OK;
    if (o->plots && mkdir(o->plots, 0777) != 0 && errno != EEXIST)
        return mukca_fail(&r->call->error, MUKCA_INPUT, "--plots %s: %s", o->plots,
                          strerror(errno));
    if (o->plots)
        status =
            mukca_report_write_figures(o->plots, formats[o->format], &r->page, &r->call->error);
    if (status == MUKCA_OK) status = cli_output_open(r->call, &output);
    if (status == MUKCA_OK) status = mukca_report_write(output.stream, &r->page, &r->call->error);
    if (status == MUKCA_OK) status = mukca_output_close(&output, &r->call->error);
    mukca_output_abort(&output);
    return status;
}

static mukca_status check(cli_call *call)
{
    const report_options *o = call->options;
    if (!call->common->output && isatty(STDOUT_FILENO))
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "-o FILE is needed: the page is HTML, not for the terminal");
    if (!(o->repeatability >= 0))
        return mukca_fail(&call->error, MUKCA_USAGE, "--repeatability %g: must not be negative",
                          o->repeatability);
    if (call->common->offsets && (o->free_base || o->free_tool))
        return mukca_fail(
            &call->error, MUKCA_USAGE,
            "--offsets contains its own frames; leave out --free-base and --free-tool");
    return MUKCA_OK;
}

static mukca_status prepare(report_work *r)
{
    const report_options *o = r->call->options;
    mukca_report *p = &r->page;
    p->chain = &r->session->model.chain;
    p->offsets = &r->offsets;
    p->train = &r->session->data;
    p->test = &r->session->test;
    p->repeatability = o->repeatability;
    p->steps = r->steps;
    p->progress = cli_show_progress;
    p->progress_context = r->call;
    mukca_status status = calibrate(r);
    if (status == MUKCA_OK) status = diagnose(r);
    if (status == MUKCA_OK) status = mukca_report_prepare(p, &r->call->error);
    if (status == MUKCA_OK) status = provenance(r);
    return status;
}

/* One option as on the command line, unless it has its default. */
static void put_option(FILE *line, const cli_option *o, const char *value, const char *initial)
{
    if (o->letter == 'q' || o->letter == 'v') return;
    if (o->kind == CLI_FLAG && *(const bool *)value)
        fprintf(line, " --%s", o->name);
    else if (o->kind == CLI_TEXT && *(const char *const *)value)
        fprintf(line, " --%s %s", o->name, *(const char *const *)value);
    else if (o->kind == CLI_CHOICE && *(const int *)value)
        fprintf(line, " --%s %s", o->name, o->choices[*(const int *)value]);
    else if ((o->kind == CLI_NUMBER || o->kind == CLI_POSITIVE) &&
             *(const double *)value != *(const double *)initial)
        fprintf(line, " --%s %g", o->name, *(const double *)value);
    else if (o->kind == CLI_VECTOR && memcmp(value, initial, 3 * sizeof(double)) != 0)
        fprintf(line, " --%s %g,%g,%g", o->name, ((const double *)value)[0],
                ((const double *)value)[1], ((const double *)value)[2]);
}

/* The command line that makes this page again. */
static mukca_status put_command(report_work *r)
{
    const cli_call *call = r->call;
    size_t size;
    FILE *line = open_memstream(&r->command, &size);
    if (!line) return mukca_fail(&r->call->error, MUKCA_MEMORY, "out of memory");
    fputs("mukca report", line);
    for (const cli_option *o = options; o->name; o++)
        put_option(line, o, (const char *)call->options + o->offset,
                   (const char *)&defaults + o->offset);
    for (int i = 0; i < call->arguments.n; i++) fprintf(line, " %s", call->arguments.items[i]);
    for (int i = 0; i < call->common->test.n; i++)
        fprintf(line, "%s %s", i ? "" : " --test", call->common->test.items[i]);
    if (fclose(line) != 0) return mukca_fail(&r->call->error, MUKCA_MEMORY, "out of memory");
    mukca_offsets_time(r->when);
    r->page.command = r->command;
    r->page.when = r->when;
    return MUKCA_OK;
}

static void release(void *work)
{
    report_work *r = work;
    free(r->command);
    mukca_report_free(&r->page);
    mukca_next_poses_free(&r->next);
    mukca_diagnosis_free(&r->diagnosis);
    mukca_fit_free(&r->fit);
    mukca_pool_free(&r->pool);
}

static mukca_status run(cli_call *call)
{
    report_work *r = call->work;
    r->call = call;
    r->session = call->session;
    cli_catch_interrupts();
    mukca_status status = check(call);
    if (status == MUKCA_OK) status = cli_load(call);
    if (status == MUKCA_OK) status = cli_check_effects(call, &r->session->model);
    if (status == MUKCA_OK) status = prepare(r);
    if (status == MUKCA_OK) status = put_command(r);
    if (status == MUKCA_OK) status = write_page(r);
    if (status == MUKCA_OK && call->common->output)
        cli_answer(call, "report: %s\n", call->common->output);
    return status;
}

const cli_command cli_command_report = {
    .name = "report",
    .group = CLI_UNDERSTAND,
    .summary = "write all evidence as one self-contained HTML page",
    .synopsis = "DATA...",
    .min_arguments = 1,
    .max_arguments = -1,
    .description =
        "Calibrates (or takes --offsets), diagnoses, and writes one page without scripts and "
        "requests. It opens with the verdict, what to do and the next postures. Then follow the "
        "held-out errors, the arm with its placements and residual vectors, the causes and what is "
        "confounded with them, errors by placement, joint and sample, detection limits, recording "
        "faults, offsets with standard errors, and provenance. gnuplot draws the figures.",
    .example =
        "mukca report --urdf data/demo/arm.urdf data/demo/train.tsv --test data/demo/test.tsv -o "
        "build/demo/report.html --force",
    .options = options,
    .options_size = sizeof(report_options),
    .defaults = &defaults,
    .run = run,
    .work_size = sizeof(report_work),
    .release = release,
};
