/* Loading of the arm and the data given by the common options. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/text.h"
#include "cli/cli.h"
#include "cli/scores.h"
#include "fit/align.h"
#include "io/dataset.h"
#include "io/urdf.h"
#include "model/dataset_subset.h"
#include "mukca/gravity.h"

/* Relative, of gravity: other values are in other units.  Coefficients of springs are inversely
 * proportional. */
static const double rounding = 0.03;

mukca_status cli_read_offsets(cli_call *call, mukca_offsets *offsets, mukca_chain *embedded,
                              const mukca_chain *chain, const char *path)
{
    const cli_common *c = call->common;
    const bool any = call->command->any_table;
    const mukca_offsets_options options = {
        .accept = (any || c->accept_failed ? MUKCA_ACCEPT_FAILED : 0) |
                  (any || c->accept_edited ? MUKCA_ACCEPT_EDITED : 0) |
                  (c->accept_other_arm ? MUKCA_ACCEPT_OTHER : 0),
        .embedded = embedded,
        .notes = cli_notes(call)};
    const mukca_status status = mukca_offsets_read(offsets, chain, path, &options, &call->error);
    for (int e = 0; e < offsets->n_effects && status == MUKCA_OK; e++) {
        const mukca_effect_info *info = mukca_effect_table[offsets->effects[e].kind];
        if ((info->needs & MUKCA_NEEDS_MASSES) && (chain ? chain : embedded)->n_masses == 0)
            return cli_fail(call, MUKCA_INPUT,
                            "%s: %s needs the masses of the links: give --inertials FILE",
                            mukca_file_shown(path), info->name);
    }
    return status;
}

static mukca_status read_kinematics(cli_call *call, cli_model *model, const char *path)
{
    mukca_kinematics *k = &model->kinematics;
    if (!path) return MUKCA_OK;
    MUKCA_TRY(mukca_kinematics_read(k, path, &call->error));
    return mukca_kinematics_apply(&model->chain, k, path, cli_notes(call), &call->error);
}

mukca_status cli_load_model(cli_call *call, cli_model *model, const cli_arm *arm)
{
    const cli_common *c = call->common;
    memset(model, 0, sizeof *model);
    if (!arm->urdf)
        return cli_fail(call, MUKCA_USAGE, "--urdf FILE is needed: the nominal model of the arm");
    mukca_urdf_options options = {
        .base = arm->base, .tip = arm->tip, .inertials = arm->inertials, .notes = cli_notes(call)};
    const double g = mukca_norm3(arm->gravity);
    if (g > 0 && !(fabs(g / MUKCA_GRAVITY - 1) < rounding))
        return cli_fail(call, MUKCA_USAGE,
                        "--gravity: %g m/s^2 is not that of the earth; give m/s^2", g);
    memcpy(options.gravity, arm->gravity, sizeof options.gravity);
    MUKCA_TRY(mukca_urdf_load(&model->chain, arm->urdf, &options, &call->error));
    if (c->verbose)
        cli_log(call, "%s: robot %s, %s to %s, %d joints, %d masses, SHA-256 %.12s...\n", arm->urdf,
                model->chain.robot, model->chain.base, model->chain.tip, model->chain.n_joints,
                model->chain.n_masses, model->chain.urdf_sha256);
    model->urdf = model->chain;
    MUKCA_TRY(read_kinematics(call, model, arm->kinematics));
    mukca_offsets_init(&model->offsets, &model->chain);
    if (arm->offsets) {
        MUKCA_TRY(cli_read_offsets(call, &model->offsets, NULL, &model->chain, arm->offsets));
    }
    mukca_geometry_set(&model->geometry, &model->chain, model->offsets.theta);
    if (!c->traits) return MUKCA_OK;
    return mukca_traits_read(&call->session->traits, c->traits, &model->chain, &call->error);
}

/* Masses of --payload: of DATA, or of --test, which follow. */
static mukca_status read_payload(const double **masses, cli_call *call, bool test)
{
    const char *text = call->common->payload;
    const int all = call->arguments.n + call->common->test.n;
    if (!text) return MUKCA_OK;
    double *payload = MUKCA_TAKE(&call->pool, double, all + 1);
    if (!payload) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    *masses = test ? payload + call->arguments.n : payload;
    const int n = cli_read_list(payload, all, text);
    for (int i = 0; i < n; i++)
        if (!(payload[i] >= 0 && payload[i] <= MUKCA_ROWS_MOST_PAYLOAD))
            return cli_fail(call, MUKCA_USAGE, "--payload: '%g' is no mass in kg", payload[i]);
    for (int i = 1; n == 1 && i < all; i++) payload[i] = payload[0];
    if (n == 1 || n == all) return MUKCA_OK;
    return cli_fail(call, MUKCA_USAGE,
                    "--payload %.60s: give one mass in kg for all %d recordings, or one of each%s",
                    text, all, call->common->test.n ? ", those of --test last" : "");
}

mukca_status cli_read_format(cli_call *call, mukca_rows_format *format)
{
    static const struct {
        const char *name;
        double angle, length;
    } units[] = {{"rad", 1, 0}, {"deg", M_PI / 180, 0}, {"m", 0, 1}, {"mm", 0, 1e-3}};
    const cli_common *c = call->common;
    *format = (mukca_rows_format){.units = c->units,
                                  .columns = c->columns,
                                  .by_order = c->map != CLI_BY_NAME,
                                  .inverse = c->inverse_poses};
    const char *rotation = c->rotation                     ? c->rotation
                           : c->map == CLI_BY_ORDER_W_LAST ? "xyzw"
                                                           : NULL;
    if (rotation && !mukca_rotation_form_read(&format->rotation, rotation))
        return cli_fail(call, MUKCA_USAGE,
                        "--rotation %.40s: give angles as XYZ (intrinsic) or xyz (extrinsic), "
                        "vector, wxyz, xyzw, inverse or none",
                        rotation);
    const char *list = c->units;
    char name[8];
    while (mukca_text_item(name, sizeof name, &list)) {
        size_t k = 0;
        while (k < 4 && strcmp(units[k].name, name) != 0) k++;
        double *unit = k < 2 ? &format->angle : &format->length;
        if (k == 4 || *unit > 0)
            return cli_fail(call, MUKCA_USAGE,
                            "--units %.40s: give rad or deg, and m or mm, as in deg,mm", c->units);
        *unit = k < 2 ? units[k].angle : units[k].length;
    }
    return MUKCA_OK;
}

/* Refuse loads in grams: no arm carries twice its own masses. */
static mukca_status check_payload(cli_call *call, const mukca_dataset *data,
                                  const mukca_chain *chain)
{
    double arm_kg = 0, most = 0;
    for (int m = 0; m < chain->n_masses; m++) arm_kg += chain->mass[m].kg;
    for (int row = 0; data->payload && row < data->n_rows; row++)
        most = fmax(most, data->payload[row]);
    if (!(arm_kg > 0) || most <= 2 * arm_kg) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT,
                    "a payload of %g kg on an arm of %g kg; payload_kg and --payload are in kg",
                    most, arm_kg);
}

/* Refuse options of pose logs for samples of sockets alone. */
static mukca_status check_pose_options(cli_call *call, const mukca_dataset *data)
{
    const cli_common *c = call->common;
    const char *option = c->free_base       ? "--free-base"
                         : c->free_tool     ? "--free-tool"
                         : c->inverse_poses ? "--inverse-poses"
                         : c->rotation      ? "--rotation"
                                            : NULL;
    bool poses = data->n_rows == 0;
    for (int row = 0; row < data->n_rows; row++) poses |= data->socket[row] < 0;
    if (!option || poses) return MUKCA_OK;
    return cli_fail(call, MUKCA_USAGE,
                    "%s is for pose logs, and these are samples of sockets: their base is the "
                    "arm's, and the position of the ball is always free; omit it",
                    option);
}

mukca_status cli_load_data(cli_call *call, mukca_dataset *data, const cli_model *model,
                           const cli_list *paths)
{
    const cli_common *c = call->common;
    memset(data, 0, sizeof *data);
    mukca_dataset_options options = {.distance = c->distance,
                                     .distances = c->distances,
                                     .distance_sigma = c->distance_sd,
                                     .threads = c->threads,
                                     .notes = cli_notes(call)};
    const bool test = paths == &c->test;
    if (!paths->n) return MUKCA_OK;
    MUKCA_TRY(cli_read_format(call, &options.format));
    MUKCA_TRY(read_payload(&options.payload, call, test));
    MUKCA_TRY(
        mukca_dataset_load(data, &model->chain, paths->items, paths->n, &options, &call->error));
    MUKCA_TRY(test ? MUKCA_OK : check_pose_options(call, data));
    MUKCA_TRY(check_payload(call, data, &model->chain));
    if (data->n_targets > 1 && !call->command->targets) {
        cli_print_mismatch(call, data, c->free_base, true);
        return cli_fail(call, MUKCA_INPUT,
                        "the pose logs have %d targets; mukca diagnose -o fits the position of "
                        "each",
                        data->n_targets);
    }
    return c->angles == CLI_ANGLES_COMMANDED ? mukca_dataset_take_commands(data, &call->error)
                                             : MUKCA_OK;
}

/* Remove the distances of coincident sockets; without any other, the scale is undetermined. */
static mukca_status drop_coincident(cli_call *call, mukca_dataset *data, const cli_model *model)
{
    double *apart = MUKCA_TAKE(&call->pool, double, data->n_distances + 1);
    const int found =
        apart ? mukca_coincide_drop(apart, data, &model->chain, model->offsets.theta, 1) : -1;
    char text[400] = "";
    for (int k = 0; k < found; k++) {
        const mukca_distance *d = &data->distances[data->n_distances + k];
        snprintf(text, sizeof text,
                 "placement '%s': sockets '%s' and '%s' coincide within %.2f mm; both labels may "
                 "have been recorded in one socket",
                 data->placements[data->sockets[d->a].placement].name, data->sockets[d->a].label,
                 data->sockets[d->b].label, 1e3 * apart[k]);
        cli_note(call, "%s; their distance is not used", text);
    }
    if (found < 0) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    if (!found || data->n_distances) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT, "%s; record them again in two sockets", text);
}

static mukca_status drop_training(cli_call *call, mukca_dataset *test, const mukca_dataset *data)
{
    if (test->n_rows == 0) return MUKCA_OK;
    MUKCA_TRY(mukca_dataset_drop_copies(test, data, cli_notes(call), &call->error));
    if (test->n_rows) return MUKCA_OK;
    return cli_fail(call, MUKCA_INPUT,
                    "--test: every row is also training data; test on other recordings");
}

/* Note a time that falls: a clock that was set, or several sessions in one file, would be mistaken
 * for drift. */
static void note_falling_time(cli_call *call, const mukca_dataset *data)
{
    double latest = 0, least = 60; /* s; drift takes minutes */
    for (int row = 0; data->time && row < data->n_rows; row++) {
        const bool first = row == 0 || data->file[row] != data->file[row - 1];
        latest = first ? data->time[row] : fmax(latest, data->time[row]);
        if (!(latest - data->time[row] > least)) continue;
        cli_note(call,
                 "row %d of %s: time_s falls by %.0f s, and joint_drift is tested with "
                 "it; correct it, or write each session to a file of its own",
                 data->row[row], mukca_file_shown(data->files[data->file[row]]),
                 latest - data->time[row]);
        return;
    }
}

/* Note a socket with at most half of the samples of its partner: a file may have been cut. */
static void note_unequal_sockets(cli_call *call, const mukca_dataset *data)
{
    for (int p = 0; p < data->n_distances; p++) {
        const mukca_distance *pair = &data->distances[p];
        int a = 0, b = 0;
        for (int row = 0; row < data->n_rows; row++)
            a += data->socket[row] == pair->a, b += data->socket[row] == pair->b;
        if (a < 2 * b && b < 2 * a) continue;
        const mukca_socket *sockets = data->sockets;
        cli_note(call, "placement %s: %d samples of socket %s, %d of socket %s; was a file cut?",
                 data->placements[sockets[pair->a].placement].name, a, sockets[pair->a].label, b,
                 sockets[pair->b].label);
        return;
    }
}

/* Note what a pose log leaves open of its frames. */
static mukca_status note_open_frames(cli_call *call, const mukca_dataset *data,
                                     const cli_model *model)
{
    const mukca_align_options options = {.tracker = call->common->free_base,
                                         .target = call->common->free_tool};
    mukca_alignment found;
    if (data->n_files != 1 || data->n_targets > 1 || data->n_sockets) return MUKCA_OK;
    if (!mukca_align(&found, &model->geometry, data, &options))
        return cli_fail(call, MUKCA_MEMORY, "out of memory");
    const char *open = mukca_alignment_open(&found);
    if (open) cli_note(call, "%s", open);
    return MUKCA_OK;
}

/* The model, DATA if there are arguments, --test if given. */
static mukca_status load(cli_call *call)
{
    cli_session *s = call->session;
    MUKCA_TRY(cli_load_model(call, &s->model, &call->common->arm));
    MUKCA_TRY(cli_load_data(call, &s->data, &s->model, &call->arguments));
    MUKCA_TRY(drop_coincident(call, &s->data, &s->model));
    MUKCA_TRY(cli_load_data(call, &s->test, &s->model, &call->common->test));
    MUKCA_TRY(drop_training(call, &s->test, &s->data));
    note_unequal_sockets(call, &s->data);
    MUKCA_TRY(note_open_frames(call, &s->data, &s->model));
    if (call->command->group != CLI_UNDERSTAND) return MUKCA_OK;
    if (s->model.chain.n_masses == 0)
        cli_note(call,
                 "the URDF has no link masses; data/inertials (installed: share/mukca/inertials) "
                 "has those of common arms for --inertials");
    note_falling_time(call, &s->data);
    return MUKCA_OK;
}

mukca_status cli_check_moving(cli_call *call, const mukca_dataset *d, bool postures)
{
    const size_t n = (size_t)d->n_joints;
    int *posture = postures ? MUKCA_TAKE(&call->pool, int, d->n_rows + 1) : NULL;
    if (posture) mukca_postures_find(posture, &call->pool, d);
    if (call->pool.failed) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    for (int s = -1; s < d->n_sockets; s++) { /* -1: measured poses */
        char where[2 * MUKCA_NAME_SIZE + 32] = "measured poses";
        int rows = 0, first = -1;
        bool same = true;
        for (int i = 0; i < d->n_rows; i++) {
            if (d->socket[i] != s) continue;
            if (rows++ == 0) first = i;
            const double *q = d->q + (size_t)i * n, *p = d->q + (size_t)first * n;
            same &= postures && posture ? posture[i] == posture[first]
                                        : memcmp(q, p, n * sizeof *q) == 0;
        }
        if (!same || rows < 3) continue;
        if (s >= 0)
            snprintf(where, sizeof where, "placement '%s', socket '%s'",
                     d->placements[d->sockets[s].placement].name, d->sockets[s].label);
        return cli_fail(
            call, MUKCA_UNIDENTIFIABLE, "%s: all %d samples have the same joint angles; %s", where,
            rows, postures ? "record other postures" : "the stream had stopped, record them again");
    }
    return MUKCA_OK;
}

mukca_status cli_check_scatter(mukca_evaluation *e, cli_call *call, const char *path,
                               const cli_model *m, const mukca_dataset *d)
{
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    const mukca_model model = {.chain = &m->chain,
                               .theta = m->offsets.theta,
                               .effects = effects,
                               .n_effects = m->offsets.n_effects};
    double squares = 0;
    int n = 0;
    mukca_offsets_place_effects(effects, &m->offsets, d);
    if (!mukca_evaluation_make(e, &call->pool, &model, d))
        return cli_fail(call, MUKCA_MEMORY, "out of memory");
    for (int i = 0; i < d->n_rows; i++)
        if (d->socket[i] >= 0) squares += e->error[i] * e->error[i], n++;
    const double sigma = sqrt(squares / (3 * fmax(n, 1)));
    if (!(sigma > CLI_FOREIGN)) return MUKCA_OK;
    return cli_fail(call, MUKCA_NEGATIVE,
                    "%.100s: the predictions of a socket scatter by %.0f mm per axis: these data "
                    "are not of this arm; check --urdf, --tip, units, columns, and each joint's "
                    "angles",
                    path, 1e3 * sigma);
}

/* Condense the session's data to the capacity of a diagnosis, with a note. */
static mukca_status condense(cli_call *call)
{
    mukca_condensed condensed;
    MUKCA_TRY(mukca_condense(&condensed, &call->session->data, MUKCA_MOST_SAMPLES, &call->error));
    if (condensed.postures < condensed.rows)
        cli_note(call, "%d rows are %d postures; the rows of each were averaged", condensed.rows,
                 condensed.postures);
    if (condensed.samples < condensed.postures)
        cli_note(call, "%d of %d postures are used, in blocks that are evenly spread",
                 condensed.samples, condensed.postures);
    return MUKCA_OK;
}

mukca_status cli_read(cli_call *call, cli_reads what)
{
    if (what == CLI_READS_NOTHING) return MUKCA_OK;
    if (what == CLI_READS_MODEL)
        return cli_load_model(call, &call->session->model, &call->common->arm);
    MUKCA_TRY(load(call));
    return what == CLI_READS_CONDENSED ? condense(call) : MUKCA_OK;
}

cli_list cli_inputs(cli_call *call)
{
    static const char *standard[] = {"-"};
    if (call->arguments.n) return call->arguments;
    if (isatty(STDIN_FILENO)) cli_note(call, "reading rows from standard input, until Ctrl-D");
    return (cli_list){standard, 1};
}
