/* mukca diagnose: where the gap lies, which effect causes it, how far it shrinks. */
#include "cli/diagnose.h"

#include <math.h>
#include <string.h>

#include "base/suggest.h"
#include "io/output.h"

enum { MANY_ROWS = 20000 };

typedef struct {
    cli_common common;
    cli_list test;
    const char *without, *expect;
    bool free_base, free_tool;
} diagnose_options;

static const cli_option options[] = {
    {"test", 0, CLI_REST, "DATA...", "held-out data: never fitted, always reported", NULL,
     offsetof(diagnose_options, test)},
    {"without", 0, CLI_TEXT, "EFFECTS",
     "leave these effects out of the catalogue (comma-separated)", NULL,
     offsetof(diagnose_options, without)},
    {"expect", 0, CLI_TEXT, "EFFECT", "exit 1 unless this effect is among the causes", NULL,
     offsetof(diagnose_options, expect)},
    {"free-base", 0, CLI_FLAG, NULL, "pose logs: fit the tracker's frame", NULL,
     offsetof(diagnose_options, free_base)},
    {"free-tool", 0, CLI_FLAG, NULL, "pose logs: fit the target's place on the tool", NULL,
     offsetof(diagnose_options, free_tool)},
    CLI_MODEL_OPTIONS,
    CLI_DISTANCE_OPTIONS,
    CLI_OUTPUT_OPTION("write the offsets table there: geometry and accepted causes"),
    CLI_JSON_OPTION,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

static mukca_status no_effect(mukca_error *error, const char *option, const char *name)
{
    const char *meant = NULL;
    int best = 99;
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++)
        if (mukca_suggest_better(&best, name, mukca_effect_table[kind].name))
            meant = mukca_effect_table[kind].name;
    return mukca_fail(error, MUKCA_USAGE, "%s: no effect is called '%.60s'; %s%s%s", option, name,
                      meant ? "did you mean " : "`mukca help effects` lists them",
                      meant ? meant : "", meant ? "?" : "");
}

static mukca_status disable(unsigned char *disabled, const char *list, mukca_error *error)
{
    char name[64];
    while (list && *list) {
        const size_t length = strcspn(list, ",");
        snprintf(name, sizeof name, "%.*s", (int)(length < 60 ? length : 60), list);
        const int kind = mukca_effect_find(name);
        if (kind < 0) return no_effect(error, "--without", name);
        disabled[kind] = 1;
        list += length + (list[length] == ',');
    }
    return MUKCA_OK;
}

static mukca_status write_offsets(cli_call *call, const mukca_diagnosed *r, bool free_base)
{
    const mukca_diagnosis *d = r->diagnosis;
    mukca_pool pool = {0};
    mukca_output output = {0};
    char comments[512];
    int left_out = 0;
    if (!call->common->output) return MUKCA_OK;
    mukca_offsets *offsets = MUKCA_TAKE(&pool, mukca_offsets, 1);
    mukca_chain *chain = MUKCA_TAKE(&pool, mukca_chain, 1);
    mukca_status status =
        offsets && chain
            ? cli_diagnosis_offsets(offsets, chain, &left_out, r, free_base, &call->error)
            : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    if (status != MUKCA_OK) goto out;
    if (left_out)
        cli_note(call, "the table lacks the causes that need link masses: give --inertials FILE");
    snprintf(
        comments, sizeof comments,
        "diagnosis: %s; mean error on rows left out: %.4g m geometry, %.4g m with the effects\n"
        "sigma: standard error; identifiable: the rows at least halved what was uncertain\n"
        "effects: the arm moves as if the joints stood at the recorded angles + effects",
        mukca_verdict_name[d->verdict], d->geometry_m, d->explained_m);
    status = mukca_output_open(&output, call->common->output, call->common->force, &call->error);
    if (status == MUKCA_OK)
        status =
            mukca_offsets_write(output.stream, offsets, chain, r->data, comments, &call->error);
    if (status == MUKCA_OK) status = mukca_output_close(&output, &call->error);
    mukca_output_abort(&output);
out:
    mukca_pool_free(&pool);
    return status;
}

static mukca_status run(cli_call *call)
{
    const diagnose_options *o = call->options;
    unsigned char disabled[MUKCA_EFFECT_COUNT] = {0};
    cli_model model;
    mukca_dataset data = {0}, test = {0};
    mukca_diagnosis *d = NULL;
    mukca_next_poses *next = NULL;
    mukca_pool pool = {0};
    mukca_status status = disable(disabled, o->without, &call->error);
    int expected = -1;
    if (status == MUKCA_OK && o->expect && (expected = mukca_effect_find(o->expect)) < 0)
        status = no_effect(&call->error, "--expect", o->expect);
    if (status == MUKCA_OK) status = cli_check_outputs(call);
    if (status == MUKCA_OK) status = cli_load_model(call, &model);
    if (status == MUKCA_OK) status = cli_load_data(call, &data, &model, &call->arguments);
    if (status == MUKCA_OK) status = cli_load_test(call, &test, &model, &o->test, &data);
    if (status != MUKCA_OK) goto out;
    d = MUKCA_TAKE(&pool, mukca_diagnosis, 1);
    next = MUKCA_TAKE(&pool, mukca_next_poses, 1);
    if (pool.failed) {
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    if (data.n_rows > MANY_ROWS)
        cli_note(call,
                 "more than 20000 rows take minutes and gigabytes; a tenth of them tells as much");
    const mukca_diagnose_options how = {.test = o->test.n ? &test : NULL,
                                        .disabled = disabled,
                                        .free_base = o->free_base,
                                        .free_tool = o->free_tool,
                                        .applied = call->common->output != NULL,
                                        .progress = cli_show_progress,
                                        .progress_context = call};
    status = mukca_diagnose(d, &model.chain, &data, &how, &call->error);
    if (status != MUKCA_OK) goto out;
    const mukca_diagnosed result = {.diagnosis = d,
                                    .chain = &model.chain,
                                    .data = &data,
                                    .test = o->test.n ? &test : NULL,
                                    .next = next,
                                    .saved = call->common->output != NULL};
    status = mukca_next_poses_choose(next, d, &model.chain, &data, cli_stop, &call->error);
    if (status == MUKCA_OK) status = write_offsets(call, &result, o->free_base && data.position);
    if (status == MUKCA_OK && call->common->json)
        status = cli_write_json(call, cli_diagnosis_json(&result));
    FILE *answer = cli_answer_stream(call);
    if (status == MUKCA_OK && answer) cli_diagnosis_print(answer, &result);
    if (status == MUKCA_OK && expected >= 0) {
        status = MUKCA_NEGATIVE;
        for (int i = 0; i < d->n_causes; i++)
            if ((int)d->causes[i].effect.kind == expected) status = MUKCA_OK;
    }
out:
    if (next) mukca_next_poses_free(next);
    if (d) mukca_diagnosis_free(d);
    mukca_pool_free(&pool);
    mukca_dataset_free(&data);
    mukca_dataset_free(&test);
    return status;
}

const cli_command cli_command_diagnose = {
    .name = "diagnose",
    .group = CLI_UNDERSTAND,
    .summary = "which effect causes the gap that is left, where, how much",
    .synopsis = "DATA...",
    .min_arguments = 1,
    .max_arguments = -1,
    .description =
        "Fits the geometry, looks at what is left, and lets every effect of the catalogue (`mukca "
        "help effects`) compete by evidence with faults of the recording and with unknown "
        "functions "
        "of the joints' angles. The verdict is none (noise), named, tied (several causes that "
        "these "
        "rows cannot tell apart), unknown (something that is not in the catalogue) or untestable.\n"
        "\n"
        "Errors are measured on rows that took no part in the fit, one placement left out at a "
        "time: of the nominal model, with the geometry fitted, with faulty rows excused, with the "
        "causes modelled, and what the noise alone would leave. Intervals are 95 %. Where causes "
        "tie, the poses that would settle it are proposed.\n"
        "\n"
        "Flexibility and backlash need link masses, from the URDF or --inertials, or efforts: "
        "JOINT.effort columns, N m, the torque that the joint exerts on the arm. Drift uses the "
        "time_s column, a stale reading JOINT.command.\n"
        "\n"
        "With -o the geometry and the causes that act on the arm become an offsets table, which "
        "evaluate, fk, compensate and export apply. sigma there is the standard error, and "
        "identifiable tells that the rows at least halved what was uncertain before.\n"
        "\n"
        "Exit code 1: the cause that --expect names was not found; 5: -o, and nothing could be "
        "fitted.",
    .example =
        "mukca diagnose --urdf data/demo/arm.urdf data/demo/train.tsv --test data/demo/test.tsv",
    .options = options,
    .options_size = sizeof(diagnose_options),
    .run = run,
};
