/* Outputs of commands: checks before long work, opening, files written by several commands. */
#include <fnmatch.h>

#include "base/file.h"
#include "cli/cli.h"

/* Is `path` the input or, if the input is a placement's folder, one of the files read in it? */
static bool is_input(const char *path, const char *input)
{
    char file[1300];
    if (!path || !input) return false;
    const char *name = mukca_file_name(path);
    if (fnmatch("hole_*.csv", name, 0) != 0) return mukca_output_same(path, input);
    snprintf(file, sizeof file, "%.1000s/%.255s", input, name);
    return mukca_output_same(path, input) || mukca_output_same(path, file);
}

mukca_status cli_keep_inputs(cli_call *call, const char *path)
{
    const cli_common *c = call->common;
    const char *const inputs[] = {c->urdf, c->inertials, c->offsets, c->distances, c->kinematics};
    bool same = false;
    for (int i = 0; i < 5; i++) same |= is_input(path, inputs[i]);
    for (int i = 0; i < call->arguments.n; i++) same |= is_input(path, call->arguments.items[i]);
    for (const cli_option *o = call->command->options; o->name; o++) {
        if (o->kind != CLI_REST) continue;
        const cli_list *rest = (const cli_list *)(void *)((char *)call->options + o->offset);
        for (int i = 0; i < rest->n; i++) same |= is_input(path, rest->items[i]);
    }
    if (!same) return MUKCA_OK;
    return mukca_fail(&call->error, MUKCA_USAGE,
                      "%.120s is an input of this command; refusing to overwrite it", path);
}

mukca_status cli_check_output(cli_call *call, const char *option, const char *path)
{
    const cli_common *c = call->common;
    if (!path) return MUKCA_OK;
    if (mukca_output_same(path, c->json) || mukca_output_same(path, c->output))
        return mukca_fail(&call->error, MUKCA_USAGE, "%s and another output cannot both go to %s",
                          option, path);
    mukca_status status = cli_keep_inputs(call, path);
    if (status != MUKCA_OK) return status;
    return mukca_output_check(path, c->force, &call->error);
}

mukca_status cli_check_outputs(cli_call *call)
{
    const char *const paths[] = {call->common->json, call->common->output};
    if (mukca_output_same(paths[0], paths[1]))
        return mukca_fail(&call->error, MUKCA_USAGE, "--json and -o cannot both go to %s",
                          paths[0]);
    for (int i = 0; i < 2; i++) {
        if (!paths[i]) continue;
        mukca_status status = mukca_output_check(paths[i], call->common->force, &call->error);
        if (status != MUKCA_OK) return status;
    }
    return MUKCA_OK;
}

void cli_print_verdict(const cli_call *call, FILE *stream)
{
    const mukca_acceptance *a = &call->session->model.offsets.acceptance;
    if (a->given && !a->accepted)
        fprintf(stream, "# the offsets table was not accepted: %s\n", a->reason);
}

mukca_status cli_output_open(cli_call *call, mukca_output *output)
{
    const cli_common *c = call->common;
    call->printed = !c->output;
    return mukca_output_open(output, c->output ? c->output : "-", c->force, &call->error);
}

mukca_status cli_write_offsets(cli_call *call, const char *path, const mukca_offsets *offsets,
                               const mukca_chain *chain, const mukca_dataset *data,
                               const char *comments)
{
    mukca_output output = {0};
    if (!path) return MUKCA_OK;
    mukca_status status = mukca_output_open(&output, path, call->common->force, &call->error);
    if (status == MUKCA_OK)
        status = mukca_offsets_write(output.stream, offsets, chain, data, comments, &call->error);
    return mukca_output_finish(&output, status, &call->error);
}

mukca_status cli_write_json(cli_call *call, json_t *root)
{
    mukca_output output = {0};
    mukca_status status = MUKCA_OK;
    if (!call->common->json) {
        json_decref(root);
        return MUKCA_OK;
    }
    if (!root || cli_json_incomplete())
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    else
        status = mukca_output_open(&output, call->common->json, call->common->force, &call->error);
    if (status == MUKCA_OK &&
        (json_dumpf(root, output.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0 ||
         fputc('\n', output.stream) == EOF) &&
        !ferror(output.stream)) /* mukca_output_close reports the reason */
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    json_decref(root);
    return mukca_output_finish(&output, status, &call->error);
}
