/* mukca report: diagnose an arm, or pool a fleet, and write one page. */
#include <unistd.h>

#include "base/file.h"
#include "cli/diagnose.h"
#include "report/report.h"

typedef struct {
    cli_common common;
    bool fleet;
} report_options;

static const cli_option options[] = {
    CLI_OPTION(
        report_options, fleet, "fleet", CLI_FLAG, NULL,
        "DATA are summaries of the arms of one model (diagnose --summary): the page of a fleet",
        .excludes = "urdf kinematics inertials offsets distances payload test free-base free-tool"),
    CLI_OUTPUT_OPTION("write the page there (default: standard output)"),
    {.name = NULL}};

typedef struct {
    cli_diagnosis analysis;
    mukca_report page;
    mukca_fleet fleet;
} report_work;

/* Use the table of --offsets, else that of the diagnosis, else (nothing was fitted) none. */
static mukca_status take_offsets(cli_call *call)
{
    report_work *w = call->work;
    w->analysis.offsets = call->session->model.offsets;
    if (call->common->arm.offsets || !w->analysis.diagnosis.applied.fitted) return MUKCA_OK;
    w->page.fitted = &w->analysis.chain;
    return cli_diagnosis_make_offsets(call, &w->analysis);
}

static mukca_status write_page(cli_call *call, FILE *stream)
{
    const report_options *o = call->options;
    const report_work *w = call->work;
    return cli_write_page(call, stream,
                          o->fleet ? mukca_fleet_page(&w->fleet) : mukca_report_page(&w->page));
}

static mukca_status check(cli_call *call)
{
    const cli_common *c = call->common;
    if (!c->output && isatty(STDOUT_FILENO))
        return cli_fail(call, MUKCA_USAGE,
                        "-o FILE is needed: the page is HTML, not for the terminal");
    if (c->arm.offsets && (c->free_base || c->free_tool))
        return cli_fail(
            call, MUKCA_USAGE,
            "--offsets contains its own frames; do not give --free-base or --free-tool with it");
    return MUKCA_OK;
}

static void release(void *work)
{
    report_work *w = work;
    mukca_fleet_free(&w->fleet);
    cli_diagnosis_free(&w->analysis);
}

static mukca_status prepare_arm(cli_call *call)
{
    const cli_session *s = call->session;
    report_work *w = call->work;
    w->page = (mukca_report){.pool = &call->pool,
                             .chain = &s->model.chain,
                             .fitted = &s->model.chain,
                             .offsets = &w->analysis.offsets,
                             .train = &s->data,
                             .test = &s->test};
    MUKCA_TRY(cli_read(call, CLI_READS_CONDENSED));
    MUKCA_TRY(cli_diagnosis_run(call, &w->analysis));
    MUKCA_TRY(take_offsets(call));
    w->page.diagnosed = w->analysis.result;
    w->page.diagnosed.saved = true;
    w->page.free_base = w->analysis.options.free_base;
    w->page.free_tool = w->analysis.options.free_tool;
    return mukca_report_prepare(&w->page, &call->error);
}

static mukca_status run(cli_call *call)
{
    const report_options *o = call->options;
    report_work *w = call->work;
    if (!o->fleet) return prepare_arm(call);
    MUKCA_TRY(cli_fleet_read(call, &w->fleet));
    return mukca_fleet_pool(&w->fleet, &call->error);
}

static mukca_status print(cli_call *call)
{
    const report_options *o = call->options;
    const report_work *w = call->work;
    if (call->common->output) cli_answer(call, "report: %s\n", call->common->output);
    if (o->fleet) return MUKCA_OK;
    if (w->analysis.diagnosis.verdict == MUKCA_VERDICT_UNTESTABLE)
        return cli_fail(call, MUKCA_NEGATIVE, "nothing can be tested: %s",
                        w->analysis.diagnosis.why);
    if (!w->analysis.offsets.acceptance.accepted)
        return cli_fail(call, MUKCA_NEGATIVE, "the result is not accepted; the page says why");
    return MUKCA_OK;
}

const cli_command cli_command_report = {
    .name = "report",
    .group = CLI_UNDERSTAND,
    .summary = "write all evidence as one self-contained HTML page",
    .synopsis = "DATA...",
    .targets = true,
    .description =
        "Diagnoses, and writes one page without requests, with the result of the diagnosis (the "
        "table of mukca diagnose -o) or that of --offsets. It opens with the expected error of the "
        "tip, whether to use the result, the verdict and what to do. Then follow the errors step "
        "by step, the causes, a view of the arm with the findings, errors by placement and joint, "
        "detection limits, recording faults, and parameters with standard errors.\n\n"
        "--fleet writes the page of many arms of one model from their summaries, the arguments of "
        "mukca fleet: arms that depart, what the arms share, each elastic coefficient with the "
        "arms side by side, and the most probable ripple order of each joint.",
    .example =
        "  mukca report --urdf data/demo/arm.urdf data/demo/train.tsv \\\n"
        "      --test data/demo/test.tsv -o build/demo/report.html --force",
    .with = CLI_WITH_DATA | CLI_WITH_SD | CLI_WITH_OFFSETS | CLI_WITH_TEST | CLI_WITH_FRAMES |
            CLI_WITH_THREADS,
    .options = options,
    .options_size = sizeof(report_options),
    .any_table = true,
    .check = check,
    .run = run,
    .table = write_page,
    .print = print,
    .work_size = sizeof(report_work),
    .release = release,
};
