/* mukca diagnose: identify and quantify the causes of the remaining error. */
#include "cli/diagnose.h"

#include <libgen.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/scores.h"
#include "diagnose/diagnose.h"
#include "fit/mismatch.h"

typedef struct {
    cli_common common;
    const char *without, *expect, *summary, *arm;
    bool traits_only;
} diagnose_options;

static const cli_option options[] = {
    CLI_OPTION(diagnose_options, without, "without", CLI_TEXT, "EFFECTS",
               "exclude these effects from the catalogue (comma-separated)"),
    CLI_OPTION(diagnose_options, expect, "expect", CLI_TEXT, "EFFECT",
               "exit code 1 unless this effect is among the causes"),
    CLI_OPTION(
        diagnose_options, summary, "summary", CLI_OUTPUT, "FILE",
        "write a summary of the data on effects shared by arms of this model (for mukca fleet)"),
    CLI_OPTION(diagnose_options, arm, "arm", CLI_TEXT, "NAME",
               "label of the arm in the summary (default: the name of the data's folder)",
               .needs = "summary"),
    CLI_OPTION(diagnose_options, traits_only, "traits-only", CLI_FLAG, NULL,
               "elastic coefficients: the means of --traits, nothing of this arm",
               .needs = "traits"),
    CLI_OUTPUT_OPTION("write the offsets table: geometry and causes"),
    {.name = NULL}};

static mukca_status disable(unsigned char *disabled, const char *list, mukca_error *error)
{
    char name[64];
    while (mukca_text_item(name, sizeof name, &list)) {
        const int kind = mukca_effect_find(name);
        if (kind < 0) return cli_fail_effect(error, "--without", name);
        disabled[kind] = 1;
    }
    return MUKCA_OK;
}

/* ---- shared with report ---- */

mukca_status cli_diagnosis_run(cli_call *call, cli_diagnosis *d)
{
    const cli_common *c = call->common;
    const cli_session *s = call->session;
    const mukca_chain *chain = &s->model.chain;
    mukca_error *error = &call->error;
    mukca_columns_note(cli_notes(call), chain, &s->data);
    const bool several = s->data.n_targets > 1 && !c->free_tool && !c->arm.offsets;
    if (several)
        cli_note(call, "several targets: each has its own position on the tool (--free-tool)");
    d->options.test = s->test.n_rows ? &s->test : NULL;
    d->options.free_base = c->free_base;
    d->options.free_tool = c->free_tool || several;
    d->options.applied = true;
    d->options.threads = c->threads;
    d->options.progress = cli_show_progress;
    d->options.progress_context = call;
    d->result = (mukca_diagnosed){.diagnosis = &d->diagnosis,
                                  .chain = chain,
                                  .data = &s->data,
                                  .test = d->options.test,
                                  .next = &d->next,
                                  .saved = c->output != NULL};
    const mukca_status status = cli_check_moving(call, &s->data, false);
    if (status == MUKCA_UNIDENTIFIABLE)
        cli_note(call, "%s", error->text); /* why it is untestable */
    if (status == MUKCA_MEMORY) return status;
    *error = (mukca_error){.status = MUKCA_OK};
    MUKCA_TRY(mukca_diagnose(&d->diagnosis, chain, &s->data, &d->options, error));
    MUKCA_TRY(mukca_next_poses_choose(&d->next, &d->diagnosis, chain, &s->data, cli_stop, error));
    if (d->next.left_out)
        cli_note(call,
                 "the next postures are for the first %d sockets; the samples of %d further ones "
                 "are not used",
                 MUKCA_PLAN_MAX_SOCKETS, d->next.left_out);
    return MUKCA_OK;
}

void cli_diagnosis_free(cli_diagnosis *d)
{
    mukca_plan_free(&d->next.plan);
    mukca_diagnosis_free(&d->diagnosis);
}

/* ---- label of the arm ---- */

/* Name of the arm's folder: `path` if it contains placements, else the folder that contains it. */
static bool folder_of(char name[MUKCA_NAME_SIZE], const char *path)
{
    char whole[PATH_MAX], socket[PATH_MAX + 16];
    struct stat about;
    if (!realpath(path, whole) || stat(whole, &about) != 0) return false;
    snprintf(socket, sizeof socket, "%s/hole_0.csv", whole);
    const bool placements = S_ISDIR(about.st_mode) && access(socket, F_OK) != 0;
    const char *folder = basename(placements ? whole : dirname(whole));
    if (!*folder || *folder == '/' || strlen(folder) >= MUKCA_NAME_SIZE) return false;
    memcpy(name, folder, strlen(folder) + 1);
    return true;
}

/* The label of the arm: `given`, else the name of the data's folder. */
static mukca_status find_label(char label[MUKCA_NAME_SIZE], cli_call *call, const char *given)
{
    char other[MUKCA_NAME_SIZE] = "";
    if (given) {
        if (!*given || strlen(given) >= MUKCA_NAME_SIZE || strpbrk(given, "\t\r\n"))
            return cli_fail(call, MUKCA_USAGE,
                            "--arm: the label must have 1 to 63 bytes and no tab or line feed");
        memcpy(label, given, strlen(given) + 1);
        return MUKCA_OK;
    }
    for (int i = 0; i < call->arguments.n; i++)
        if (!folder_of(i ? other : label, call->arguments.items[i]) ||
            (i && strcmp(other, label) != 0))
            return cli_fail(
                call, MUKCA_USAGE,
                "the data do not lie in one folder that could name the arm; give --arm NAME");
    return MUKCA_OK;
}

/* ---- the command ---- */

typedef struct {
    cli_diagnosis analysis;
    mukca_summary summary;
    mukca_adoption adoption;
    unsigned char disabled[MUKCA_EFFECT_COUNT];
} diagnose_work;

static void release(void *work)
{
    cli_diagnosis_free(&((diagnose_work *)work)->analysis);
}

static mukca_status write_offsets(cli_call *call, FILE *stream)
{
    const cli_diagnosis *analysis = &((const diagnose_work *)call->work)->analysis;
    const mukca_diagnosis *d = &analysis->diagnosis;
    char comments[512];
    snprintf(comments, sizeof comments,
             "diagnosis: %s; held-out mean error: %.4g m geometry, %.4g m with the effects\n"
             "sigma: standard error; identifiable: the data at least halved the prior uncertainty\n"
             "effects: the arm moves as if the joints were at the recorded angles + effects",
             mukca_verdict_name[d->verdict], d->geometry_m, d->applied_m);
    return mukca_offsets_write(stream, &analysis->offsets, &analysis->chain, analysis->result.data,
                               comments, &call->error);
}

/* Analyses that need the regression: summary and traits, with the diagnosed causes. */
static mukca_status go_on(void *context, struct mukca_regression *m, mukca_diagnosis *d,
                          mukca_error *error)
{
    cli_call *call = context;
    const diagnose_options *o = call->options;
    diagnose_work *w = call->work;
    MUKCA_TRY(o->summary ? mukca_summary_take(&w->summary, m, error) : MUKCA_OK);
    if (!o->common.traits) return MUKCA_OK;
    w->adoption = (mukca_adoption){.traits = &call->session->traits,
                                   .test = call->session->test.n_rows ? &call->session->test : NULL,
                                   .only = o->traits_only};
    return mukca_adopt(&w->adoption, m, d, error);
}

static mukca_status check(cli_call *call)
{
    const diagnose_options *o = call->options;
    diagnose_work *w = call->work;
    if (o->expect && mukca_effect_find(o->expect) < 0)
        return cli_fail_effect(&call->error, "--expect", o->expect);
    return disable(w->disabled, o->without, &call->error);
}

static mukca_status write_summary(cli_call *call, FILE *stream)
{
    diagnose_work *w = call->work;
    if (w->analysis.diagnosis.why)
        return cli_fail(call, MUKCA_UNIDENTIFIABLE, "no summary to write: %s",
                        w->analysis.diagnosis.why);
    w->summary.data = mukca_summary_hash(&call->session->data);
    return mukca_summary_write(stream, &w->summary, &call->error);
}

static mukca_status run(cli_call *call)
{
    const diagnose_options *o = call->options;
    diagnose_work *w = call->work;
    MUKCA_TRY(o->summary ? find_label(w->summary.arm, call, o->arm) : MUKCA_OK);
    w->analysis.options =
        (mukca_diagnose_options){.disabled = w->disabled, .go_on = go_on, .go_on_context = call};
    MUKCA_TRY(cli_diagnosis_run(call, &w->analysis));
    MUKCA_TRY(cli_write(call, o->summary, write_summary));
    if (!o->common.output && !w->analysis.diagnosis.applied.fitted) return MUKCA_OK;
    MUKCA_TRY(cli_diagnosis_make_offsets(call, &w->analysis));
    w->analysis.result.acceptance = &w->analysis.offsets.acceptance;
    return cli_write(call, o->common.output, write_offsets);
}

/* With the errors of the fit with traits, if it was adopted. */
static json_t *as_json(const cli_call *call)
{
    const diagnose_work *w = call->work;
    const mukca_diagnosed *r = &w->analysis.result;
    const mukca_adoption *a = &w->adoption;
    json_t *json = cli_diagnosis_json(r), *traits = a->traits ? cli_adoption_json(a, r) : NULL;
    json_object_update_new(json, cli_json(KEY("acceptance", cli_json_acceptance(r->acceptance)),
                                          KEY("traits", traits)));
    return json;
}

static mukca_status print(cli_call *call)
{
    const diagnose_options *o = call->options;
    const cli_session *s = call->session;
    const diagnose_work *w = call->work;
    const mukca_diagnosis *d = &w->analysis.diagnosis;
    const int expected = o->expect ? mukca_effect_find(o->expect) : -1;
    FILE *answer = cli_answer_stream(call);
    if (answer) cli_diagnosis_print(answer, &w->analysis.result, call->common->verbose);
    if (answer)
        cli_print_mismatch(call, &s->data, w->analysis.options.free_base,
                           w->analysis.options.free_tool);
    if (w->adoption.traits) cli_adoption_print(call, &w->adoption, &w->analysis.result);
    if (call->common->output && !w->analysis.offsets.acceptance.accepted) return MUKCA_NEGATIVE;
    for (int i = 0; i < d->n_causes; i++)
        if ((int)d->causes[i].effect.kind == expected) return MUKCA_OK;
    return expected < 0 && !d->why ? MUKCA_OK : MUKCA_NEGATIVE;
}

const cli_command cli_command_diagnose = {
    .name = "diagnose",
    .group = CLI_UNDERSTAND,
    .summary = "identify and quantify the causes of the remaining error",
    .synopsis = "DATA...",
    .description =
        "Fits the geometry. Then compares the evidence for every effect of the catalogue (mukca "
        "help effects), for recording faults, and for unknown functions of the joint angles. The "
        "verdict is one of these: none (the remaining error is noise), named (causes were "
        "identified), tied (the data cannot distinguish several causes), unknown (structure "
        "outside the catalogue), untestable.\n\n"
        "Held-out errors are those of each placement, predicted from the others; the noise floor "
        "is the error of a perfect model; intervals are 95 %.\n\n"
        "Readings of one posture share a part of the noise, which is estimated. Of more than 5000 "
        "rows, those of one still posture (0.2 mrad) are averaged; of more postures than that, "
        "blocks of successive ones are used, evenly spread.\n\n"
        "Joint compliance and backlash need link masses, from the URDF or --inertials, or measured "
        "efforts: columns JOINT.effort, N m, the torque that the joint exerts on the arm. Link "
        "bending and base compliance need link masses. joint_drift uses the column time_s, "
        "readback_lag the columns JOINT.command.\n\n"
        "Exit code 1: nothing could be tested (untestable), the effect of --expect is not among "
        "the causes, or the table of -o is not accepted (see calibrate). Exit code 5: -o was given "
        "but nothing could be fitted.",
    .example =
        "  mukca diagnose --urdf data/demo/arm.urdf data/demo/train.tsv \\\n"
        "      --test data/demo/test.tsv",
    .with = CLI_WITH_DATA | CLI_WITH_SD | CLI_WITH_TEST | CLI_WITH_JSON | CLI_WITH_FRAMES |
            CLI_WITH_TRAITS | CLI_WITH_THREADS,
    .options = options,
    .options_size = sizeof(diagnose_options),
    .targets = true,
    .check = check,
    .reads = CLI_READS_CONDENSED,
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(diagnose_work),
    .release = release,
};
