/* mukca simulate: simulated recordings of an arm with known errors. */
#include "cli/simulate.h"

#include <stdlib.h>
#include <string.h>

#include "base/list.h"
#include "io/dataset.h"
#include "mukca/version.h"

typedef struct {
    cli_common common;
    const char *perturb, *test, *truth, *at;
    cli_list effects, places;
    int placements, poses, held_out, seed;
    mukca_simulate_options recording;
    mukca_simulated_motion motion;
} simulate_options;

/* One simulation: the true arm and its recording. */
typedef struct {
    const cli_model *model; /* from the user */
    mukca_offsets truth;    /* the true arm */
    mukca_corrected arm;
    cli_simulated hidden; /* effects and faults */
    int n_places;         /* of the session; the held-out ones follow */
    mukca_place places[MUKCA_MAX_PLACEMENTS];
    mukca_simulate_options recording;
    mukca_simulated_motion motion;
    mukca_rows rows; /* of --at */
} simulate_work;

static const simulate_options defaults = {.recording.rows = 30,
                                          .motion = {.runs = 1, .rate = 200, .speed = 1}};

#define LOGS "poses or --at" /* options of a pose log */

static const cli_option options[] = {
    CLI_OPTION(simulate_options, perturb, "perturb", CLI_TEXT, "MM,MRAD",
               "standard deviation of the errors of the origins, mm and mrad (default: none)"),
    CLI_OPTION(
        simulate_options, effects, "effect", CLI_TEXTS, "EFFECT",
        "NAME[:WHERE][@VARIANT]=VALUE, see above; repeatable, or several with commas between"),
    CLI_OPTION(simulate_options, placements, "placements", CLI_INTEGER, "N",
               "placements of the tool, chosen at random (default: 4, or those of --place)",
               .least = 1, .most = MUKCA_MAX_PLACEMENTS - 1, .excludes = LOGS),
    CLI_OPTION(simulate_options, places, "place", CLI_TEXTS, "NAME[=X,Y,Z[,ROLL,PITCH,YAW]]",
               "name of a placement, and its pose: middle of the sockets, which lie on its x "
               "axis, m and rad",
               .excludes = LOGS),
    CLI_OPTION(simulate_options, recording.rows, "rows", CLI_INTEGER, "N",
               "samples in each of the two sockets (default: 30)", .least = 2, .most = 100000),
    CLI_OPTION(simulate_options, recording.noise, "noise", CLI_NUMBER, "M",
               "measurement noise of the ball per axis, m (default: 0)", .most = 1),
    CLI_OPTION(simulate_options, recording.effort, "effort", CLI_FLAG, NULL,
               "add measured joint efforts"),
    CLI_OPTION(simulate_options, recording.command, "command", CLI_FLAG, NULL,
               "add commanded angles; with readback_lag the readings lag behind them"),
    CLI_OPTION(simulate_options, recording.payload, "payload", CLI_NUMBER, "KG",
               "mass at the tip beyond the model (default: none)", .most = MUKCA_ROWS_MOST_PAYLOAD),
    CLI_OPTION(simulate_options, poses, "poses", CLI_INTEGER, "N",
               "a pose log of N samples instead of sockets", .least = 1, .most = 10000000),
    CLI_OPTION(simulate_options, at, "at", CLI_INPUT, "FILE",
               "a pose log at the joint angles of this table, row by row",
               .excludes = "poses held-out"),
    CLI_OPTION(simulate_options, recording.position_only, "position-only", CLI_FLAG, NULL,
               "pose log without orientations", .needs = LOGS),
    CLI_OPTION(simulate_options, recording.rotation, "rotation-noise", CLI_NUMBER, "RAD",
               "measurement noise of the orientations in a pose log, per axis, rad", .most = 1,
               .needs = LOGS),
    CLI_OPTION(simulate_options, held_out, "held-out", CLI_INTEGER, "N",
               "further placements (or poses) of the same arm, for --test", .least = 1,
               .most = 10000000, .needs = "test"),
    CLI_OPTION(simulate_options, test, "test", CLI_OUTPUT, "FILE", "write the held-out data there",
               .needs = "held-out"),
    CLI_OPTION(simulate_options, motion.seconds, "motion", CLI_NUMBER, "S",
               "instead, runs of the moving arm of so many seconds, with joint efforts", .least = 1,
               .most = 1e5,
               .excludes = "perturb placements place rows noise effort command payload "
                           "poses at position-only rotation-noise held-out test offsets"),
    CLI_OPTION(simulate_options, motion.runs, "runs", CLI_INTEGER, "N",
               "runs one after the other, 10 s apart (default: 1)", .least = 1, .most = 1000,
               .needs = "motion"),
    CLI_OPTION(simulate_options, motion.rate, "rate", CLI_NUMBER, "HZ",
               "rows per second (default: 200)", .least = 10, .most = 1e5, .needs = "motion"),
    CLI_OPTION(simulate_options, motion.speed, "speed", CLI_POSITIVE, "RAD/S",
               "largest velocity of the joints (default: 1)", .most = 100, .needs = "motion"),
    CLI_OPTION(simulate_options, motion.noise, "torque-noise", CLI_NUMBER, "SHARE",
               "measurement noise of the efforts, a share of half of each joint's range "
               "(default: 0)",
               .most = 1, .needs = "motion"),
    CLI_OPTION(simulate_options, seed, "seed", CLI_INTEGER, "N",
               "seed of all random numbers (default: 0)"),
    CLI_OPTION(simulate_options, truth, "truth", CLI_OUTPUT, "FILE",
               "write the true arm as an offsets table, of a moving arm its effects"),
    CLI_OPTION(simulate_options, common.arm.offsets, "offsets", CLI_INPUT, "FILE",
               "the true arm, effects included, before --perturb"),
    CLI_OUTPUT_OPTION("write the recording there (default: standard output)"),
    {.name = NULL}};

/* ---- true arm and recording from the options ---- */

/* True for a pose log instead of sockets. */
static bool is_log(const simulate_options *o)
{
    return o->poses || o->at;
}

/* All placements: those of the session, then the held-out ones. */
static mukca_status name_places(simulate_work *s, const simulate_options *o, mukca_error *error)
{
    const int held_out = is_log(o) ? 0 : o->held_out;
    const int n = is_log(o) ? 0 : o->placements ? o->placements : o->places.n ? o->places.n : 4;
    if (n < o->places.n || n >= MUKCA_MAX_PLACEMENTS || held_out > MUKCA_MAX_PLACEMENTS - n)
        return mukca_fail(error, MUKCA_USAGE,
                          "--placements %d: must be at most %d with --held-out, and not below the "
                          "number of --place",
                          n, MUKCA_MAX_PLACEMENTS);
    s->n_places = n;
    for (int i = 0; i < n + held_out; i++) {
        mukca_place *p = &s->places[i];
        if (i < o->places.n) {
            MUKCA_TRY(cli_read_place(p, o->places.items[i], error));
        } else {
            snprintf(p->name, sizeof p->name, i < n ? "p%d" : "held_out_%d",
                     i < n ? i + 1 : i - n + 1);
        }
        for (int k = 0; k < i; k++)
            if (strcmp(s->places[k].name, p->name) == 0)
                return mukca_fail(error, MUKCA_USAGE, "two placements have the name '%s'", p->name);
    }
    return mukca_simulate_places(s->places, n + held_out, &s->model->chain, s->recording.distance,
                                 s->recording.seed, error);
}

/* Gather the effects of --offsets, then those of --effect. */
static mukca_status gather_effects(simulate_work *s, const simulate_options *o, mukca_error *error)
{
    cli_simulated *hidden = &s->hidden;
    const mukca_offsets *given = &s->model->offsets;
    hidden->chain = &s->model->chain;
    hidden->places = s->places;
    hidden->n_places = s->n_places;
    hidden->rows = o->recording.rows;
    mukca_simulate_seed(&hidden->random, s->recording.seed, MUKCA_DRAW_EFFECTS);
    for (int e = 0; e < given->n_effects; e++) {
        mukca_effect effect = given->effects[e];
        const char *name = effect.placement >= 0 ? given->placements[effect.placement] : NULL;
        effect.placement = -1;
        for (int p = 0; p < s->n_places && name; p++)
            if (strcmp(s->places[p].name, name) == 0) effect.placement = p;
        if (!name || effect.placement >= 0) hidden->effects[hidden->n_effects++] = effect;
    }
    for (int i = 0; i < o->effects.n; i++)
        MUKCA_TRY(cli_simulated_parse(hidden, o->effects.items[i], error));
    memcpy(s->arm.effects, hidden->effects, sizeof hidden->effects);
    s->arm.n_effects = hidden->n_effects;
    return MUKCA_OK;
}

/* The true arm as an offsets table, without recording faults. */
static void set_truth(simulate_work *s)
{
    for (int p = 0; p < s->n_places; p++)
        memcpy(s->truth.placements[p], s->places[p].name, MUKCA_NAME_SIZE);
    s->truth.n_placements = s->n_places;
    s->truth.n_effects = 0;
    for (int e = 0; e < s->arm.n_effects; e++)
        if (!mukca_effect_has((int)s->arm.effects[e].kind, MUKCA_TRAIT_RECORDING_FAULT))
            s->truth.effects[s->truth.n_effects++] = s->arm.effects[e];
}

/* The same of a moving arm. */
static mukca_status prepare_motion(cli_call *call)
{
    const simulate_options *o = call->options;
    simulate_work *s = call->work;
    s->model = &call->session->model;
    s->motion = o->motion;
    s->motion.seed = (uint64_t)o->seed;
    s->motion.effects = s->hidden.torques;
    s->motion.interrupted = cli_interrupted;
    s->motion.chain = s->hidden.chain = &s->model->chain;
    s->hidden.moves = true;
    if (!s->model->chain.n_masses)
        return cli_fail(call, MUKCA_USAGE, "--motion needs link masses; give --inertials FILE");
    for (int i = 0; i < o->effects.n; i++)
        MUKCA_TRY(cli_simulated_parse(&s->hidden, o->effects.items[i], &call->error));
    s->motion.n_effects = s->hidden.n_torques;
    return MUKCA_OK;
}

/* Fill the zeroed simulation from the options of the call. */
static mukca_status prepare(cli_call *call)
{
    const simulate_options *o = call->options;
    simulate_work *s = call->work;
    double perturb[2] = {0, 0};
    s->model = &call->session->model;
    if (o->perturb && cli_read_list(perturb, 2, o->perturb) != 2)
        return cli_fail(call, MUKCA_USAGE, "--perturb %.40s: must be MM,MRAD, two numbers",
                        o->perturb);
    s->recording = o->recording;
    s->recording.distance = call->common->distance;
    s->recording.seed = (uint64_t)o->seed;
    s->recording.interrupted = cli_interrupted;
    if (s->recording.effort && !s->model->chain.n_masses)
        return cli_fail(call, MUKCA_USAGE, "--effort needs link masses; give --inertials FILE");
    s->truth = s->model->offsets;
    mukca_simulate_perturb(s->truth.theta, o->perturb ? s->truth.listed : NULL, &s->model->chain,
                           1e-3 * perturb[0], 1e-3 * perturb[1], s->recording.seed);
    for (int i = 0; i < MUKCA_MAX_THETA; i++) s->truth.identifiable[i] = s->truth.listed[i];
    mukca_simulate_arm(&s->arm, &s->model->chain, s->truth.theta);
    MUKCA_TRY(name_places(s, o, &call->error));
    MUKCA_TRY(gather_effects(s, o, &call->error));
    set_truth(s);
    return MUKCA_OK;
}

/* ---- recording ---- */

static bool moves(const simulate_options *o)
{
    return o->motion.seconds > 0;
}

/* Lines of where a recording is from. */
static void write_origin(cli_call *call, FILE *stream, const char *kind)
{
    const simulate_options *o = call->options;
    const simulate_work *s = call->work;
    const mukca_chain *chain = &s->model->chain;
    fprintf(stream, "# mukca %s\n# robot: %s\n# stream: raw\n# base: %s\n# tip: %s\n", kind,
            chain->robot, chain->base, chain->tip);
    fprintf(stream, "# simulated by mukca " MUKCA_VERSION ": --seed %d", o->seed);
    if (o->perturb) fprintf(stream, " --perturb %s", o->perturb);
    for (int i = 0; i < o->effects.n; i++) fprintf(stream, " --effect %s", o->effects.items[i]);
    if (moves(o))
        fprintf(stream, " --motion %g --runs %d --rate %g --speed %g --torque-noise %g",
                o->motion.seconds, o->motion.runs, o->motion.rate, o->motion.speed,
                o->motion.noise);
    else
        fprintf(stream, " --noise %g", o->recording.noise);
    fputc('\n', stream);
}

static mukca_status write_data(cli_call *call, FILE *stream, const mukca_dataset *data,
                               const char *path)
{
    const simulate_work *s = call->work;
    write_origin(call, stream, s->n_places ? "session" : "pose log");
    mukca_dataset_write(stream, data, &s->model->chain, mukca_dataset_separator(path));
    return MUKCA_OK;
}

static mukca_status write_effects(cli_call *call, FILE *stream)
{
    const simulate_work *s = call->work;
    write_origin(call, stream, "motion: the true effects");
    cli_write_torques(stream, &s->motion);
    return MUKCA_OK;
}

static mukca_status write_truth(cli_call *call, FILE *stream)
{
    const simulate_work *s = call->work;
    return mukca_offsets_write(stream, &s->truth, &s->model->chain, NULL,
                               "the true arm of a simulation", &call->error);
}

static mukca_status write_recording(cli_call *call, FILE *stream)
{
    const simulate_options *o = call->options;
    const simulate_work *s = call->work;
    const char *path = call->common->output ? call->common->output : "-";
    if (!moves(o)) return write_data(call, stream, &call->session->data, path);
    write_origin(call, stream, "runs");
    return cli_write_motion(stream, &s->motion, mukca_dataset_separator(path));
}

static mukca_status write_test(cli_call *call, FILE *stream)
{
    const simulate_options *o = call->options;
    return write_data(call, stream, &call->session->test, o->test);
}

/* Record a pose log at the angles of the table --at. */
static mukca_status record_at(cli_call *call, mukca_dataset *data)
{
    const simulate_options *o = call->options;
    simulate_work *s = call->work;
    const size_t size = (size_t)s->model->chain.n_joints * sizeof(double);
    const mukca_rows_options header = {.kind = MUKCA_EITHER, .unchecked = true};
    double *q = NULL;
    int count = 0;
    mukca_row row;
    mukca_status status = MUKCA_OK;
    MUKCA_TRY(mukca_rows_open(&s->rows, o->at, &s->model->chain, &header, &call->error));
    while (status == MUKCA_OK && mukca_rows_next(&s->rows, &row)) {
        double *added = mukca_list_append(&q, &count, size);
        if (added)
            memcpy(added, row.q, size);
        else
            status = cli_fail(call, MUKCA_MEMORY, "out of memory");
    }
    const mukca_status read = mukca_rows_close(&s->rows);
    if (status == MUKCA_OK) status = read;
    if (status == MUKCA_OK)
        status = mukca_simulate_poses(data, &s->arm, q, count, &s->recording, &call->error);
    free(q);
    return status;
}

/* Record the session or, at last and with `held_out`, the held-out data. */
static mukca_status record(cli_call *call, mukca_dataset *data, bool held_out)
{
    const simulate_options *o = call->options;
    simulate_work *s = call->work;
    if (o->at) return record_at(call, data);
    if (held_out) s->recording.seed ^= 0x686f6c646f757421u; /* different postures and noise */
    if (o->poses)
        return mukca_simulate_poses(data, &s->arm, NULL, held_out ? o->held_out : o->poses,
                                    &s->recording, &call->error);
    for (int e = 0; e < s->arm.n_effects && held_out; e++)
        s->arm.effects[e].placement = -1; /* no effect of these placements here */
    const mukca_simulated_session session = {.arm = &s->arm,
                                             .places = s->places + (held_out ? s->n_places : 0),
                                             .n_places = held_out ? o->held_out : s->n_places,
                                             .faults = s->hidden.faults,
                                             .n_faults = held_out ? 0 : s->hidden.n_faults,
                                             .options = &s->recording};
    return mukca_simulate_sockets(data, &session, &call->error);
}

static mukca_status run(cli_call *call)
{
    const simulate_options *o = call->options;
    simulate_work *s = call->work;
    MUKCA_TRY(moves(o) ? prepare_motion(call) : prepare(call));
    if (moves(o)) return cli_write(call, o->truth, write_effects);
    s->truth.acceptance.given = s->truth.acceptance.accepted = s->truth.acceptance.converged = true;
    MUKCA_TRY(record(call, &call->session->data, false));
    MUKCA_TRY(o->test ? record(call, &call->session->test, true) : MUKCA_OK);
    MUKCA_TRY(cli_write(call, o->test, write_test));
    return cli_write(call, o->truth, write_truth);
}

const cli_command cli_command_simulate = {
    .name = "simulate",
    .group = CLI_MEASURE,
    .summary = "make a recording with chosen errors, effects and noise",
    .synopsis = "",
    .description =
        "Simulates the arm of --urdf with other origins (--perturb, or --offsets as the truth), "
        "effects of the catalogue, recording faults and noise. Its ball sits in two sockets at "
        "several placements, or (--poses, --at) a tracker or a controller measures the poses of "
        "its tip. The same seed gives the same bytes.\n\n"
        "An EFFECT is NAME[:WHERE][@VARIANT]=VALUE in the unit of `mukca help effects`:\n"
        "  joint_compliance:JOINT=1e-5         link_bending, joint_scale ... alike\n"
        "  base_compliance=1e-5                readback_lag=1e-3, or @command\n"
        "  backlash:JOINT@300mNm=1e-3          torque scale, default 1000mNm\n"
        "  joint_coupling:JOINT@+1=1e-3        from the next joint; -1: the one before\n"
        "  gear_harmonic:JOINT@ORDER=5e-4      =A,B for A sin + B cos\n"
        "  axis_wobble:JOINT@fixed1=1e-3       fixed2, turning1, turning2, cone-2,\n"
        "                                      cone-1, cone+2, cone+3\n"
        "  joint_drift:JOINT@300s=1e-3         time constant; 0: rad per 1000 s\n"
        "  zero_jump:JOINT/PLACE=1e-3          ball_shift:PLACE=1e-3, or =X,Y,Z\n"
        "  tool_motion:PLACE/SOCKET@12=1e-3    from its sample 12 on, or @creep\n"
        "  wrong_socket:PLACE/SOCKET@5         duplicate alike; outlier with a size\n"
        "  socket_distance=1e-3                the sockets are farther apart than stated\n\n"
        "With --motion, a table of runs (time, joint angles, efforts) instead: the joints follow "
        "sums of sines within their limits; self-collisions are ignored. Its effects:\n"
        "  payload=KG[,X,Y,Z]                  a point mass at the tip, m from it\n"
        "  link_mass:JOINT=KG                  of the link after JOINT, beyond the model\n"
        "  link_centre:JOINT=X,Y,Z             its centre is moved by so many m\n"
        "  armature:JOINT=KGM2                 coulomb, viscous, offset alike; asymmetry\n"
        "                                      (times the speed), load_friction (a share\n"
        "                                      of the load's torque)\n"
        "  stribeck:JOINT@0.1=NM               velocity, rad/s\n"
        "  spring:JOINT=NM/RAD[,ZERO]          cogging:JOINT@ORDER=A[,B]: A sin + B cos\n"
        "  thermal_friction:JOINT@60=NM        time constant, s\n"
        "  torque_gain[:JOINT]=SHARE           delay[:JOINT]=S: the efforts are late",
    .example =
        "  mukca simulate --urdf data/demo/arm.urdf --placements 2 --rows 5 \\\n"
        "      --seed 1 --perturb 1,2 --noise 1e-4 \\\n"
        "      --effect gear_harmonic:joint_4@160=5e-4\n"
        "  mukca simulate --urdf data/demo/arm.urdf --motion 10 --rate 50 \\\n"
        "      --seed 1 --torque-noise 0.01 --effect payload=0.5,viscous:joint_3=2",
    .with = CLI_WITH_MODEL | CLI_WITH_DISTANCE,
    .options = options,
    .options_size = sizeof(simulate_options),
    .defaults = &defaults,
    .any_table = true,
    .reads = CLI_READS_MODEL,
    .run = run,
    .table = write_recording,
    .work_size = sizeof(simulate_work),
};
