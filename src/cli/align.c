/* mukca align: pose of one arm's base in that of another, from sessions at the same sockets. */
#include <string.h>

#include "cli/cli.h"
#include "fit/align.h"

typedef struct {
    cli_common common;
    cli_arm right; /* as far as it differs */
} align_options;

static const cli_option options[] = {
    CLI_OPTION(align_options, right.urdf, "right-urdf", CLI_INPUT, "FILE",
               "nominal model of the right arm (default: that of --urdf)"),
    CLI_OPTION(align_options, right.base, "right-base", CLI_TEXT, "LINK",
               "first link of the right arm (default: --base)"),
    CLI_OPTION(align_options, right.tip, "right-tip", CLI_TEXT, "LINK",
               "last link of the right arm (default: --tip)"),
    CLI_OPTION(align_options, right.offsets, "right-offsets", CLI_INPUT, "FILE",
               "offsets table of the right arm (default: none)"),
    {.name = NULL}};

/* One arm and its session. */
typedef struct {
    cli_model model;
    mukca_dataset data;
    mukca_evaluation evaluation;
    double variance; /* of a coordinate of one sample, m^2 */
} side;

typedef struct {
    side side[2];
    mukca_shared_socket *shared;
    int n;
    mukca_two_arms result;
} align_work;

static void release(void *work)
{
    align_work *w = work;
    for (int i = 0; i < 2; i++) mukca_dataset_free(&w->side[i].data);
}

/* Variance of the predicted ball positions about their means. */
static double find_variance(const side *s)
{
    const mukca_dataset *d = &s->data;
    double squares = 0;
    int freedom = 0;
    for (int k = 0; k < d->n_sockets; k++)
        freedom += s->evaluation.count[k] > 1 ? s->evaluation.count[k] - 1 : 0;
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) squares += s->evaluation.error[i] * s->evaluation.error[i];
    return freedom > 0 ? squares / (3 * freedom) : 0;
}

static mukca_status load_side(cli_call *call, int i)
{
    const align_options *o = call->options;
    align_work *w = call->work;
    const cli_arm *right = &o->right;
    cli_arm arm = call->common->arm;
    side *s = &w->side[i];
    const cli_list path = {call->arguments.items + i, 1};
    if (i == 1) arm.offsets = right->offsets;
    if (i == 1 && right->urdf) arm.urdf = right->urdf;
    if (i == 1 && right->base) arm.base = right->base;
    if (i == 1 && right->tip) arm.tip = right->tip;
    MUKCA_TRY(cli_load_model(call, &s->model, &arm));
    MUKCA_TRY(cli_load_data(call, &s->data, &s->model, &path));
    if (s->data.n_sockets == 0)
        return cli_fail(call, MUKCA_INPUT, "%.100s: no sockets; give a session", path.items[0]);
    MUKCA_TRY(cli_check_moving(call, &s->data, false));
    MUKCA_TRY(cli_check_scatter(&s->evaluation, call, path.items[0], &s->model, &s->data));
    s->variance = find_variance(s);
    return MUKCA_OK;
}

static const char *placement_of(const side *s, int socket)
{
    return s->data.placements[s->data.sockets[socket].placement].name;
}

/* Sockets with the same placement and label in both sessions. */
static mukca_status find_shared(cli_call *call)
{
    align_work *w = call->work;
    const side *l = &w->side[0], *r = &w->side[1];
    w->shared = MUKCA_TAKE(&call->pool, mukca_shared_socket, l->data.n_sockets);
    if (!w->shared) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    for (int i = 0; i < l->data.n_sockets; i++)
        for (int k = 0; k < r->data.n_sockets; k++) {
            if (!l->evaluation.count[i] || !r->evaluation.count[k] ||
                strcmp(placement_of(l, i), placement_of(r, k)) != 0 ||
                strcmp(l->data.sockets[i].label, r->data.sockets[k].label) != 0)
                continue;
            mukca_shared_socket *s = &w->shared[w->n++];
            memcpy(s->at[0], l->evaluation.mean[i], sizeof s->at[0]);
            memcpy(s->at[1], r->evaluation.mean[k], sizeof s->at[1]);
            s->variance[0] = l->variance / l->evaluation.count[i];
            s->variance[1] = r->variance / r->evaluation.count[k];
            break;
        }
    if (w->n > 0) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT,
                    "the sessions share no socket: none has the same placement and label in both "
                    "('%.40s' in %.60s, '%.40s' in %.60s)",
                    placement_of(l, 0), call->arguments.items[0], placement_of(r, 0),
                    call->arguments.items[1]);
}

static mukca_status print(cli_call *call)
{
    static const char *const names[6] = {"x", "y", "z", "about x", "about y", "about z"};
    const align_work *w = call->work;
    const mukca_two_arms *t = &w->result;
    double rpy[3];
    mukca_rotation_to_rpy(rpy, t->pose.R, NULL);
    cli_answer(call, "%d shared sockets; right base '%s' in left base '%s'\n", w->n,
               w->side[1].model.chain.base, w->side[0].model.chain.base);
    for (int a = 0; a < 3; a++)
        cli_answer(call, "  %-8s %12.3f mm    [%.3f, %.3f]\n", names[a], 1e3 * t->pose.p[a],
                   1e3 * (t->pose.p[a] - t->width95[a]), 1e3 * (t->pose.p[a] + t->width95[a]));
    cli_answer(call, "  roll %.6f pitch %.6f yaw %.6f rad\n", rpy[0], rpy[1], rpy[2]);
    for (int a = 3; a < 6; a++)
        cli_answer(call, "  %-8s within %.3f mrad\n", names[a], 1e3 * t->width95[a]);
    cli_say(call, NULL,
            "Distance of the sockets after the alignment: %.3f mm rms; noise alone: %.3f mm%s",
            1e3 * t->residual_m, 1e3 * t->expected_m,
            t->scale > 2 ? " (calibrate both arms first: --offsets, --right-offsets)" : "");
    return MUKCA_OK;
}

static json_t *as_json(const cli_call *call)
{
    const align_work *w = call->work;
    const mukca_two_arms *t = &w->result;
    double rpy[3];
    mukca_rotation_to_rpy(rpy, t->pose.R, NULL);
    return cli_json(
        KEY("pose", cli_json_frame(&t->pose)), KEY("rpy_rad", cli_json_reals(rpy, 3)),
        KEY("sigma", cli_json(KEY("position_m", cli_json_reals(t->sigma, 3)),
                              KEY("rotation_rad", cli_json_reals(t->sigma + 3, 3)))),
        KEY("width95", cli_json(KEY("position_m", cli_json_reals(t->width95, 3)),
                                KEY("rotation_rad", cli_json_reals(t->width95 + 3, 3)))),
        KEY("shared_sockets", w->n), FIELD(t, freedom), FIELD(t, residual_m), FIELD(t, expected_m),
        KEY("elapsed_s", cli_elapsed(call)));
}

static mukca_status run(cli_call *call)
{
    align_work *w = call->work;
    MUKCA_TRY(load_side(call, 0));
    MUKCA_TRY(load_side(call, 1));
    MUKCA_TRY(find_shared(call));
    return mukca_two_arms_align(&w->result, w->shared, w->n, &call->error);
}

const cli_command cli_command_align = {
    .name = "align",
    .group = CLI_USE,
    .summary = "base-to-base pose of two arms from the same sockets",
    .synopsis = "LEFT RIGHT",
    .description =
        "LEFT and RIGHT are sessions of two arms with the same artefact in the same placements: "
        "sockets with the same placement and label are one point. Prints the pose of the right "
        "arm's base in the left arm's base with 95 % intervals. The intervals are computed from "
        "the measurement noise, or from the larger disagreement of the sockets (errors of the "
        "arms' geometry). Calibrate both arms first and give their tables: the pose is that of the "
        "bases of these tables.",
    .example =
        "  mukca simulate --urdf data/demo/arm.urdf --place a=0.4,0.2,0.1 \\\n"
        "      --place b=0.4,-0.2,0.3 --noise 1e-4 -o build/demo/left.tsv \\\n"
        "      --force\n"
        "  mukca align \\\n"
        "      --urdf data/demo/arm.urdf build/demo/left.tsv build/demo/left.tsv",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_JSON,
    .options = options,
    .options_size = sizeof(align_options),
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(align_work),
    .release = release,
};
