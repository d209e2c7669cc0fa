/* The arm and the data that the common options name. */
#include <fnmatch.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"
#include "io/dataset_load.h"
#include "io/output.h"
#include "io/urdf.h"

static const double most_gravity = 1e3; /* m/s^2 */

/* Is `path` the input or, where that is a placement's folder, a file that is read there? */
static bool is_input(const char *path, const char *input)
{
    char file[1300];
    if (!path || !input) return false;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (fnmatch("hole_*.csv", name, 0) != 0) return mukca_output_same(path, input);
    snprintf(file, sizeof file, "%.1000s/%.255s", input, name);
    return mukca_output_same(path, input) || mukca_output_same(path, file);
}

mukca_status cli_keep_inputs(cli_call *call, const char *path)
{
    const cli_common *c = call->common;
    const char *const inputs[] = {c->urdf, c->inertials, c->offsets, c->distances};
    bool same = false;
    for (int i = 0; i < 4; i++) same |= is_input(path, inputs[i]);
    for (int i = 0; i < call->arguments.n; i++) same |= is_input(path, call->arguments.items[i]);
    for (const cli_option *o = call->command->options; o->name; o++) {
        if (o->kind != CLI_REST) continue;
        const cli_list *rest = (const cli_list *)(void *)((char *)call->options + o->offset);
        for (int i = 0; i < rest->n; i++) same |= is_input(path, rest->items[i]);
    }
    if (!same) return MUKCA_OK;
    return mukca_fail(&call->error, MUKCA_USAGE,
                      "%.120s is read here, and so cannot be written; name another file", path);
}

mukca_status cli_load_model(cli_call *call, cli_model *model)
{
    const cli_common *c = call->common;
    memset(model, 0, sizeof *model);
    mukca_status status = cli_keep_inputs(call, c->output);
    if (status == MUKCA_OK) status = cli_keep_inputs(call, c->json);
    if (status) return status;
    if (!c->urdf)
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--urdf FILE is needed: the arm's nominal model");
    mukca_urdf_options options = {.base = c->base, .tip = c->tip, .inertials = c->inertials};
    for (int i = 0; i < 3; i++)
        if (fabs(c->gravity[i]) > most_gravity)
            return mukca_fail(&call->error, MUKCA_USAGE, "--gravity: %g is none; give m/s^2",
                              c->gravity[i]);
    memcpy(options.gravity, c->gravity, sizeof options.gravity);
    status = mukca_urdf_load(&model->chain, c->urdf, &options, cli_note, call, &call->error);
    if (status) return status;
    if (c->verbose)
        cli_tell(call, "%s: robot %s, %s to %s, %d joints, %d masses, SHA-256 %.12s...", c->urdf,
                 model->chain.robot, model->chain.base, model->chain.tip, model->chain.n_joints,
                 model->chain.n_masses, model->chain.urdf_sha256);
    if (c->offsets)
        status = mukca_offsets_read(&model->offsets, &model->chain, c->offsets, c->force, cli_note,
                                    call, &call->error);
    else
        mukca_offsets_init(&model->offsets, &model->chain);
    mukca_geometry_set(&model->geometry, &model->chain, model->offsets.theta);
    return status;
}

mukca_status cli_load_data(cli_call *call, mukca_dataset *data, const cli_model *model,
                           const cli_list *paths)
{
    const cli_common *c = call->common;
    memset(data, 0, sizeof *data);
    if (c->distance >= 2)
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--distance %g looks like %s; give m, as in 0.05", c->distance,
                          c->distance > 10 ? "millimetres" : "centimetres");
    const mukca_dataset_options options = {
        .distance = c->distance, .distances = c->distances, .note = cli_note, .context = call};
    const mukca_status status =
        mukca_dataset_load(data, &model->chain, paths->items, paths->n, &options, &call->error);
    for (int f = 0; f < data->n_files && c->verbose && status == MUKCA_OK; f++) {
        int rows = 0;
        for (int i = 0; i < data->n_rows; i++) rows += data->file[i] == f;
        cli_tell(call, "%s: %d rows", data->files[f], rows);
    }
    return status;
}

mukca_status cli_load_test(cli_call *call, mukca_dataset *test, const cli_model *model,
                           const cli_list *paths, const mukca_dataset *train)
{
    if (paths->n == 0) return MUKCA_OK;
    const mukca_status status = cli_load_data(call, test, model, paths);
    for (int t = 0; t < test->n_files && status == MUKCA_OK; t++)
        for (int k = 0; k < train->n_files; k++) {
            char text[640];
            if (!mukca_output_same(test->files[t], train->files[k])) continue;
            snprintf(text, sizeof text, "%s is trained on and tested on: that test proves nothing",
                     test->files[t]);
            cli_note(call, text);
        }
    return status;
}

cli_list cli_inputs(cli_call *call)
{
    static const char *standard[] = {"-"};
    if (call->arguments.n) return call->arguments;
    if (isatty(STDIN_FILENO))
        cli_note(call, "rows are read from standard input, to its end (Ctrl-D)");
    return (cli_list){standard, 1};
}

mukca_status cli_check_effects(cli_call *call, const cli_model *model)
{
    for (int e = 0; e < model->offsets.n_effects; e++) {
        const mukca_effect_info *info = &mukca_effect_table[model->offsets.effects[e].kind];
        if ((info->needs & MUKCA_NEEDS_MASSES) && model->chain.n_masses == 0)
            return mukca_fail(&call->error, MUKCA_INPUT,
                              "%s: %s needs the masses of the links: give --inertials FILE",
                              call->common->offsets, info->name);
    }
    return MUKCA_OK;
}
