/* mukca simulate: recordings of a made-up arm whose truth is known. */
#include "cli/simulate.h"

#include <stdlib.h>
#include <string.h>

#include "base/number.h"
#include "io/dataset_write.h"
#include "io/output.h"
#include "mukca/version.h"

static const cli_simulate_options defaults = {.placements = -1, .rows = 30};

#define OPTION(name, kind, argument, help, member)                                  \
    {                                                                               \
        name, 0, kind, argument, help, NULL, offsetof(cli_simulate_options, member) \
    }

static const cli_option options[] = {
    OPTION("perturb", CLI_TEXT, "MM,MRAD",
           "normal errors of the true origins, positions and angles (default: none)", perturb),
    OPTION("effect", CLI_TEXTS, "EFFECT",
           "NAME[:WHERE][@VARIANT]=VALUE, see below; repeatable, or several with commas between",
           effects),
    OPTION("mass-error", CLI_NUMBER, "PERCENT", "normal errors of the true masses", mass_error),
    OPTION("placements", CLI_INTEGER, "N",
           "places of the tool, found by the seed (default: 4, or those of --place)", placements),
    OPTION("place", CLI_TEXTS, "NAME[=X,Y,Z[,ROLL,PITCH,YAW]]",
           "name a place, or give it: middle of the sockets, which lie on its x axis, m and rad",
           places),
    OPTION("rows", CLI_INTEGER, "N", "rows of each of the two sockets (default: 30)", rows),
    OPTION("sweep", CLI_FLAG, NULL, "postures follow each other smoothly, not at random", sweep),
    OPTION("noise", CLI_NUMBER, "M", "standard deviation at the ball, per axis, m (default: 0)",
           noise),
    OPTION("correlation", CLI_NUMBER, "RHO",
           "of the noise in a row with that in the row before, 0 to below 1", correlation),
    OPTION("effort", CLI_FLAG, NULL, "add measured joint efforts", effort),
    OPTION("effort-noise", CLI_NUMBER, "NM", "their standard deviation, N m; implies --effort",
           effort_noise),
    OPTION("command", CLI_FLAG, NULL, "add commanded angles, which a stale reading lags", command),
    OPTION("interval", CLI_POSITIVE, "S", "mean time between rows, s (default: 5)", interval),
    OPTION("poses", CLI_INTEGER, "N", "a pose log of N rows instead of sockets", poses),
    OPTION("position-only", CLI_FLAG, NULL, "pose log without orientations", position_only),
    OPTION("rotation-noise", CLI_NUMBER, "RAD", "of the orientations in a pose log, per axis, rad",
           rotation),
    OPTION("held-out", CLI_INTEGER, "N", "more places of the same arm, or poses, for --test",
           held_out),
    OPTION("test", CLI_TEXT, "FILE", "where to write them", test),
    OPTION("seed", CLI_INTEGER, "N", "of all random numbers (default: 0)", seed),
    OPTION("truth", CLI_TEXT, "FILE", "write the true arm as an offsets table", truth),
    OPTION("labels", CLI_TEXT, "FILE",
           "write all that is hidden as JSON, and nothing of it into the recording", labels),
    CLI_DISTANCE_OPTION,
    CLI_COMMON(offsets, 0, CLI_TEXT, "FILE", "the true arm, effects included, before --perturb"),
    CLI_MODEL_OPTIONS,
    CLI_OUTPUT_OPTION("where to write the recording (default: standard output)"),
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

static bool is_csv(const char *path)
{
    const size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".csv") == 0;
}

/* How the recording came about; without the secrets where there are labels. */
static void describe(FILE *stream, const cli_simulation *s, const cli_simulate_options *o)
{
    fprintf(stream, "mukca session\nrobot: %s\nstream: raw\nbase: %s\ntip: %s\n",
            s->model.chain.robot, s->model.chain.base, s->model.chain.tip);
    if (o->labels) return;
    fprintf(stream, "simulated by mukca " MUKCA_VERSION ": --seed %d", o->seed);
    if (o->perturb) fprintf(stream, " --perturb %s", o->perturb);
    for (int i = 0; i < o->effects.n; i++) fprintf(stream, " --effect %s", o->effects.items[i]);
    fprintf(stream, " --noise %g", o->noise);
    if (o->correlation > 0) fprintf(stream, " --correlation %g", o->correlation);
    if (o->mass_error > 0) fprintf(stream, " --mass-error %g", o->mass_error);
    fputc('\n', stream);
}

/* Write one recording. */
static mukca_status write_data(cli_call *call, const char *path, const mukca_dataset *data,
                               const cli_simulation *s)
{
    mukca_output output = {0};
    char *comments = NULL;
    size_t size = 0;
    FILE *text = open_memstream(&comments, &size);
    if (!text) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    describe(text, s, call->options);
    const bool complete = fclose(text) == 0;
    mukca_status status = complete
                              ? mukca_output_open(&output, path, call->common->force, &call->error)
                              : mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    if (status == MUKCA_OK) {
        mukca_dataset_write(output.stream, data, &s->model.chain, is_csv(path) ? ',' : '\t',
                            comments);
        status = mukca_output_close(&output, &call->error);
    }
    mukca_output_abort(&output);
    free(comments);
    return status;
}

static mukca_status write_truth(cli_call *call, const cli_simulation *s, const char *path)
{
    mukca_output output = {0};
    mukca_status status = mukca_output_open(&output, path, call->common->force, &call->error);
    if (status == MUKCA_OK)
        status = mukca_offsets_write(output.stream, &s->truth, &s->model.chain, NULL,
                                     "the true arm of a simulation", &call->error);
    if (status == MUKCA_OK) status = mukca_output_close(&output, &call->error);
    mukca_output_abort(&output);
    return status;
}

/* ---- what the options say ---- */

static mukca_status check_numbers(const cli_simulate_options *o, mukca_error *error)
{
    if (o->rows < 2) return mukca_fail(error, MUKCA_USAGE, "--rows %d: must be 2 or more", o->rows);
    if (o->noise < 0 || o->noise > 1)
        return mukca_fail(error, MUKCA_USAGE, "--noise %g: must be m, from 0 to 1", o->noise);
    if (o->correlation < 0 || o->correlation >= 1)
        return mukca_fail(error, MUKCA_USAGE, "--correlation %g: must be from 0 to below 1",
                          o->correlation);
    if (o->mass_error < 0 || o->effort_noise < 0 || o->rotation < 0)
        return mukca_fail(error, MUKCA_USAGE,
                          "--mass-error, --effort-noise and --rotation-noise cannot be negative");
    if (o->poses < 0 || o->poses > 10000000 || o->rows > 100000)
        return mukca_fail(error, MUKCA_USAGE, "--poses and --rows: not that many");
    if (o->held_out < 0 || (o->held_out > 0) != (o->test != NULL))
        return mukca_fail(error, MUKCA_USAGE, "--held-out N and --test FILE go together");
    if (o->poses && (o->places.n || o->placements >= 0))
        return mukca_fail(error, MUKCA_USAGE, "a pose log (--poses) has no placements");
    if (!o->poses && (o->position_only || o->rotation > 0))
        return mukca_fail(error, MUKCA_USAGE,
                          "--position-only and --rotation-noise are for pose logs (--poses N)");
    if (o->common.distance > 1)
        return mukca_fail(error, MUKCA_USAGE, "--distance %g looks like millimetres; give m",
                          o->common.distance);
    return MUKCA_OK;
}

/* Numbers with commas between; how many, -1 where one is none or there are more than `most`. */
static int read_list(double *values, int most, const char *text)
{
    char number[64];
    int n = 0;
    for (;; text++) {
        const size_t length = strcspn(text, ",");
        if (n == most || length >= sizeof number) return -1;
        memcpy(number, text, length);
        number[length] = '\0';
        if (!mukca_number_parse(&values[n++], number)) return -1;
        text += length;
        if (!*text) return n;
    }
}

/* One --place. */
static mukca_status read_place(mukca_place *place, const char *text, mukca_error *error)
{
    double v[6] = {0};
    const size_t length = strcspn(text, "=");
    if (length == 0 || length >= sizeof place->name || strcspn(text, "\t,#/ ") < length)
        return mukca_fail(error, MUKCA_USAGE, "--place %.80s: begins with no usable name", text);
    memcpy(place->name, text, length);
    if (!text[length]) return MUKCA_OK;
    const int n = read_list(v, 6, text + length + 1);
    if (n != 3 && n != 6)
        return mukca_fail(error, MUKCA_USAGE,
                          "--place %.80s: needs NAME=X,Y,Z or NAME=X,Y,Z,ROLL,PITCH,YAW", text);
    memcpy(place->pose.p, v, sizeof place->pose.p);
    mukca_rotation_from_rpy(place->pose.R, v + 3);
    place->placed = true;
    return MUKCA_OK;
}

/* All places: those of the session, then the held-out ones. */
static mukca_status name_places(cli_simulation *s, const cli_simulate_options *o,
                                mukca_error *error)
{
    int n = o->placements >= 0 ? o->placements : o->places.n ? o->places.n : 4;
    const int held_out = o->poses ? 0 : o->held_out;
    if (o->poses) n = 0;
    if (n < o->places.n || (n < 1 && !o->poses) || n > CLI_MAX_PLACES - 1 ||
        held_out > CLI_MAX_PLACES - n)
        return mukca_fail(error, MUKCA_USAGE,
                          "--placements %d: must be 1 to %d with --held-out, and no less than the "
                          "places given",
                          n, CLI_MAX_PLACES);
    s->n_places = n;
    for (int i = 0; i < n + held_out; i++) {
        mukca_place *p = &s->places[i];
        mukca_status status = MUKCA_OK;
        if (i < o->places.n)
            status = read_place(p, o->places.items[i], error);
        else
            snprintf(p->name, sizeof p->name, i < n ? "p%d" : "held_out_%d",
                     i < n ? i + 1 : i - n + 1);
        for (int k = 0; k < i && status == MUKCA_OK; k++)
            if (strcmp(s->places[k].name, p->name) == 0)
                status = mukca_fail(error, MUKCA_USAGE, "two places are called '%s'", p->name);
        if (status) return status;
    }
    return mukca_simulate_places(s->places, n + held_out, &s->model.chain, s->how.distance,
                                 s->how.seed, error);
}

/* Take over the effects of --offsets, then those of --effect. */
static mukca_status gather_effects(cli_simulation *s, const cli_simulate_options *o,
                                   mukca_error *error)
{
    cli_simulated *hidden = &s->hidden;
    const mukca_offsets *given = &s->model.offsets;
    hidden->chain = &s->model.chain;
    hidden->places = s->places;
    hidden->n_places = s->n_places;
    hidden->rows = o->rows;
    mukca_simulate_seed(&hidden->random, s->how.seed, MUKCA_DRAW_EFFECTS);
    for (int e = 0; e < given->n_effects; e++) {
        mukca_effect effect = given->effects[e];
        const char *name = effect.placement >= 0 ? given->placements[effect.placement] : NULL;
        effect.placement = -1;
        for (int p = 0; p < s->n_places && name; p++)
            if (strcmp(s->places[p].name, name) == 0) effect.placement = p;
        if (!name || effect.placement >= 0) hidden->effects[hidden->n_effects++] = effect;
    }
    for (int i = 0; i < o->effects.n; i++) {
        mukca_status status = cli_simulated_parse(hidden, o->effects.items[i], error);
        if (status) return status;
    }
    memcpy(s->arm.effects, hidden->effects, sizeof hidden->effects);
    s->arm.n_effects = hidden->n_effects;
    return MUKCA_OK;
}

/* The true arm as a table: what faults of the recording did is no part of it. */
static void tell_truth(cli_simulation *s)
{
    for (int p = 0; p < s->n_places; p++)
        memcpy(s->truth.placements[p], s->places[p].name, MUKCA_NAME_SIZE);
    s->truth.n_placements = s->n_places;
    s->truth.n_effects = 0;
    for (int e = 0; e < s->arm.n_effects; e++)
        if (mukca_effect_table[s->arm.effects[e].kind].site != MUKCA_SITE_SOCKET)
            s->truth.effects[s->truth.n_effects++] = s->arm.effects[e];
}

static mukca_status prepare(cli_call *call, cli_simulation *s)
{
    const cli_simulate_options *o = call->options;
    double perturb[2] = {0, 0};
    mukca_status status = check_numbers(o, &call->error);
    if (status == MUKCA_OK && o->perturb && read_list(perturb, 2, o->perturb) != 2)
        status = mukca_fail(&call->error, MUKCA_USAGE,
                            "--perturb %.40s: must be MM,MRAD, two numbers", o->perturb);
    const char *const files[] = {call->common->output, o->test, o->truth, o->labels};
    for (int i = 0; i < 4 && status == MUKCA_OK; i++) {
        if (!files[i]) continue;
        for (int k = 0; k < i && status == MUKCA_OK; k++)
            if (files[k] && strcmp(files[i], files[k]) == 0)
                status = mukca_fail(&call->error, MUKCA_USAGE, "two outputs cannot both go to %s",
                                    files[i]);
        if (status == MUKCA_OK)
            status = mukca_output_check(files[i], call->common->force, &call->error);
    }
    if (status == MUKCA_OK) status = cli_load_model(call, &s->model);
    if (status) return status;
    s->how = (mukca_simulate_options){
        .rows = o->rows,
        .distance = call->common->distance > 0 ? call->common->distance : 0.05,
        .noise = o->noise,
        .rotation = o->rotation,
        .correlation = o->correlation,
        .interval = o->interval,
        .sweep = o->sweep,
        .effort = o->effort || o->effort_noise > 0,
        .command = o->command,
        .effort_noise = o->effort_noise,
        .position_only = o->position_only,
        .seed = (uint64_t)o->seed};
    if (s->how.effort && !s->model.chain.n_masses)
        return mukca_fail(&call->error, MUKCA_USAGE,
                          "--effort needs link masses; give --inertials FILE");
    s->truth = s->model.offsets;
    mukca_simulate_perturb(s->truth.theta, o->perturb ? s->truth.listed : NULL, &s->model.chain,
                           1e-3 * perturb[0], 1e-3 * perturb[1], s->how.seed);
    for (int i = 0; i < MUKCA_MAX_THETA; i++) s->truth.identifiable[i] = s->truth.listed[i];
    mukca_simulate_arm(&s->arm, &s->model.chain, s->truth.theta, 1e-2 * o->mass_error, s->how.seed);
    status = name_places(s, o, &call->error);
    if (status == MUKCA_OK) status = gather_effects(s, o, &call->error);
    if (status == MUKCA_OK) tell_truth(s);
    return status;
}

/* ---- the work ---- */

/* Record the session, or with `held_out` what is held out. */
static mukca_status record(cli_call *call, mukca_dataset *data, const cli_simulation *s,
                           bool held_out)
{
    const cli_simulate_options *o = call->options;
    mukca_simulate_options how = s->how;
    if (held_out) how.seed ^= 0x686f6c646f757421u; /* other postures and noise */
    if (o->poses)
        return mukca_simulate_poses(data, &s->arm, NULL, held_out ? o->held_out : o->poses, &how,
                                    &call->error);
    mukca_true_arm *arm = malloc(sizeof *arm);
    if (!arm) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    *arm = s->arm;
    for (int e = 0; e < arm->n_effects && held_out; e++)
        arm->effects[e].placement = -1; /* none of these is here */
    mukca_status status = mukca_simulate_sockets(
        data, arm, s->places + (held_out ? s->n_places : 0), held_out ? o->held_out : s->n_places,
        s->hidden.faults, held_out ? 0 : s->hidden.n_faults, &how, &call->error);
    free(arm);
    return status;
}

static mukca_status run(cli_call *call)
{
    const cli_simulate_options *o = call->options;
    mukca_dataset data = {0}, test = {0};
    cli_simulation *s = calloc(1, sizeof *s);
    if (!s) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    mukca_status status = prepare(call, s);
    if (status == MUKCA_OK) status = record(call, &data, s, false);
    if (status == MUKCA_OK && o->test) status = record(call, &test, s, true);
    if (status == MUKCA_OK && cli_interrupted()) status = MUKCA_INTERRUPTED;
    if (status == MUKCA_OK)
        status = write_data(call, call->common->output ? call->common->output : "-", &data, s);
    if (status == MUKCA_OK && o->test) status = write_data(call, o->test, &test, s);
    if (status == MUKCA_OK && o->truth) status = write_truth(call, s, o->truth);
    if (status == MUKCA_OK && o->labels) status = cli_write_labels(call, s, &data);
    mukca_dataset_free(&data);
    mukca_dataset_free(&test);
    free(s);
    return status;
}

const cli_command cli_command_simulate = {
    .name = "simulate",
    .group = CLI_MEASURE,
    .summary = "make a recording of a given arm with chosen errors, effects and noise",
    .synopsis = "",
    .description =
        "Records an arm that does not exist: the one of --urdf with other origins (--perturb, or "
        "--offsets as the truth), with effects of the catalogue, faults of the recording and "
        "noise. Its ball sits in two sockets at some places of the workspace, or (--poses) a "
        "tracker watches its tip. The same seed gives the same bytes.\n\n"
        "An EFFECT is NAME[:WHERE][@VARIANT]=VALUE in the unit of `mukca help effects`:\n"
        "  joint_compliance:JOINT=1e-5         link_bending, joint_scale ... alike\n"
        "  base_compliance=1e-5                readback_lag alike\n"
        "  backlash:JOINT@TORQUE=1e-3          torque scale in mN m, default 1000\n"
        "  joint_coupling:JOINT@+1=1e-3        from the next joint, -1 from the one before\n"
        "  gear_harmonic:JOINT@ORDER=5e-4      =A,B for A sin + B cos\n"
        "  axis_wobble:JOINT@1=1e-3            1, 2; 11, 12 after the turn; 98, 99, 102, 103\n"
        "  joint_drift:JOINT@300=1e-3          time constant in s; 0: rad per 1000 s\n"
        "  zero_jump:JOINT/PLACE=1e-3          ball_shift:PLACE=1e-3, or =X,Y,Z\n"
        "  tool_motion:PLACE/SOCKET@12=1e-3    from row 12 of the socket on, or @creep\n"
        "  wrong_socket:PLACE/SOCKET@5         duplicate alike; outlier with a size\n"
        "  socket_distance=1e-3                the sockets are farther apart than --distance",
    .example =
        "mukca simulate --urdf data/demo/arm.urdf --placements 2 --rows 5 --seed 1 "
        "--perturb 1,2 --noise 1e-4 --effect gear_harmonic:joint_4@160=5e-4",
    .options = options,
    .options_size = sizeof(cli_simulate_options),
    .defaults = &defaults,
    .run = run,
};
