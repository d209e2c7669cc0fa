/* mukca motion: what separates the torques of a moving arm from its model. */
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "cli/motion.h"
#include "record/joint_lines.h"

#define put mukca_wording_put /* short for this file */

typedef struct {
    cli_common common;
    const char *mjcf, *gain, *stiffness, *without, *report;
    cli_list reference;
    int effort;
} motion_options;

static const char *const efforts[] = {"torque", "current", NULL};

static const cli_option options[] = {
    CLI_OPTION(
        motion_options, reference, "reference", CLI_REST, "RUN...",
        "earlier runs: report what has changed since, not what separates them from the model"),
    CLI_OPTION(motion_options, mjcf, "mjcf", CLI_INPUT, "FILE",
               "MuJoCo model with frictionloss, damping and armature of the joints (default: "
               "<dynamics> of the URDF)"),
    CLI_CHOICE_OPTION(motion_options, effort, "effort", "WHAT", efforts,
                      "what JOINT.effort contains (default: torque, N m)"),
    CLI_OPTION(motion_options, gain, "current-gain", CLI_TEXT, "GAINS",
               "torque constants N m/A for currents, as in joint_1=14.9,joint_2=13.3"),
    CLI_OPTION(motion_options, stiffness, "kp", CLI_TEXT, "GAINS",
               "position gains, N m/rad, likewise: the efforts of runs with commands only"),
    CLI_OPTION(motion_options, without, "without", CLI_TEXT, "EFFECTS",
               "exclude these effects from the catalogue (comma-separated)"),
    CLI_OPTION(motion_options, report, "report", CLI_OUTPUT, "FILE",
               "write a page (HTML): findings, torques over time, errors over angle and velocity"),
    CLI_OUTPUT_OPTION("write the effects as a table"),
    {.name = NULL}};

/* ---- inputs ---- */

/* Numbers by joint: J1=14.87,J2=...; NaN: not given. */
static mukca_status read_by_joint(double *values, cli_call *call, const char *option,
                                  const char *list)
{
    const mukca_chain *chain = &call->session->model.chain;
    for (int j = 0; j < MUKCA_MAX_JOINTS; j++) values[j] = (double)NAN;
    char name[MUKCA_NAME_SIZE + 40];
    while (mukca_text_item(name, sizeof name, &list)) {
        char *equals = strchr(name, '=');
        if (equals) *equals = '\0';
        const int joint = mukca_chain_find_joint(chain, name);
        if (!equals || joint < 0 || !mukca_number_parse(&values[joint], equals + 1))
            return cli_fail(call, MUKCA_USAGE,
                            "--%s: '%.60s' is not JOINT=NUMBER with a joint of the chain", option,
                            name);
    }
    return MUKCA_OK;
}

static mukca_status disable(bool *disabled, cli_call *call, const char *list)
{
    char name[64];
    while (mukca_text_item(name, sizeof name, &list)) {
        const int effect = mukca_torque_effect_find(name);
        if (effect < 0)
            return cli_fail(call, MUKCA_USAGE, "--without: there is no effect '%s' of a motion",
                            name);
        disabled[effect] = true;
    }
    return MUKCA_OK;
}

static mukca_status read_runs(cli_call *call, mukca_run *run, mukca_run_options *o)
{
    const cli_list *lists[] = {&((const motion_options *)call->options)->reference,
                               &call->arguments, &call->common->test};
    static const mukca_run_role roles[] = {MUKCA_RUN_REFERENCE, MUKCA_RUN_NEW, MUKCA_RUN_TEST};
    cli_motion *w = call->work;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < lists[k]->n; i++) {
            mukca_run *next = &run[w->input.n_runs++];
            next->role = roles[k];
            const char *path = lists[k]->items[i];
            const mukca_chain *chain = &call->session->model.chain;
            bool states;
            mukca_status status =
                mukca_run_states_read(&states, next, &call->pool, path, chain, o, &call->error);
            if (!states) status = mukca_run_read(next, &call->pool, path, chain, o, &call->error);
            if (status != MUKCA_OK) return status;
        }
    return MUKCA_OK;
}

/* ---- report ---- */

static bool view(void *context, const struct mukca_torques *torques,
                 const struct mukca_torque_columns *fitted)
{
    cli_call *call = context;
    cli_motion *w = call->work;
    return mukca_motion_trace_make(&w->trace, &call->pool, torques, fitted);
}

static mukca_status write_page(cli_call *call, FILE *stream)
{
    cli_motion *w = call->work;
    const mukca_motion_report r = {
        .chain = &call->session->model.chain,
        .motion = &w->motion,
        .trace = &w->trace,
        .points = MUKCA_TAKE(&call->pool, mukca_plot_point, MUKCA_TRACES * w->trace.n + 1)};
    if (!r.points) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    return cli_write_page(call, stream, mukca_motion_page(&r));
}

static mukca_status run(cli_call *call)
{
    const motion_options *o = call->options;
    const cli_model *model = &call->session->model;
    cli_motion *w = call->work;
    mukca_run_options how = {.current = o->effort == 1, .notes = cli_notes(call)};
    const int n = call->arguments.n + o->reference.n + call->common->test.n;
    mukca_run *runs = MUKCA_TAKE(&call->pool, mukca_run, n + 1);
    if (!runs) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    w->input.chain = &model->chain;
    w->input.run = runs;
    w->input.notes = cli_notes(call);
    mukca_status status = read_by_joint(how.gain, call, "current-gain", o->gain);
    if (status == MUKCA_OK) status = read_by_joint(how.stiffness, call, "kp", o->stiffness);
    if (status == MUKCA_OK) status = disable(w->input.disabled, call, o->without);
    if (status == MUKCA_OK) status = cli_read_format(call, &how.format);
    if (status == MUKCA_OK)
        status = mukca_drives_read(&w->input.drives, o->mjcf ? o->mjcf : call->common->arm.urdf,
                                   &model->chain, &call->error);
    if (status == MUKCA_OK) status = read_runs(call, runs, &how);
    if (status != MUKCA_OK) return status;
    w->input.current = how.current;
    if (o->report) w->input.view = view;
    status = mukca_motion_analyse(&w->motion, &w->input, &call->error);
    return status == MUKCA_OK && o->report ? cli_write(call, o->report, write_page) : status;
}

/* ---- screen ---- */

enum { MOST_FOUND = 4, SIZE_COLUMN = 58 }; /* a screen of 20 lines */

static void print_finding(FILE *stream, const mukca_chain *chain, const mukca_motion_finding *f,
                          const char *key, bool sure)
{
    char text[MUKCA_WORDING] = "";
    mukca_wording_torque(text, &f->group, chain);
    if (!sure) put(text, ", %.0f %%", 100 * f->group.probability);
    fprintf(stream, "%s%-8s%s%-*s  %.2g N·m, %.1f %%\n", cli_bold(stream), key, cli_plain(stream),
            SIZE_COLUMN - 8, text, f->size_nm.value, f->size_percent);
    if (!sure) return;
    cli_print_keyed(stream, "", mukca_wording_torque_certainty(MUKCA_WORDS, f));
    cli_print_keyed(stream, "", mukca_wording_torque_alternatives(MUKCA_WORDS, f, chain));
}

/* Mean over the joints of an error in % of their ranges, rms. */
static double percent(const mukca_motion *m, size_t offset)
{
    double sum = 0;
    for (int j = 0; j < m->n_joints; j++) {
        double error;
        memcpy(&error, (const char *)&m->joint[j] + offset, sizeof error);
        sum += pow(error / m->joint[j].range_nm, 2) / m->n_joints;
    }
    return 100 * sqrt(sum);
}
#define PERCENT(m, member) percent(m, offsetof(mukca_motion_joint, member))

static mukca_status print(cli_call *call)
{
    const cli_motion *w = call->work;
    const mukca_motion *m = &w->motion;
    const mukca_chain *chain = &call->session->model.chain;
    FILE *stream = cli_answer_stream(call);
    if (!stream) return MUKCA_OK;
    const bool all = call->common->verbose;
    fprintf(stream, "%s: %d run%s, %.0f s of motion", chain->robot, m->n_runs,
            m->n_runs == 1 ? "" : "s", m->seconds);
    if (m->n_reference) fprintf(stream, "; reference: %d", m->n_reference);
    if (m->n_test) fprintf(stream, "; test: %d", m->n_test);
    fputs("\n\n", stream);
    for (int i = 0; i < m->n_findings && (all || i < MOST_FOUND); i++)
        print_finding(stream, chain, &m->finding[i], i ? "" : "Found", true);
    if (!all && m->n_findings > MOST_FOUND)
        cli_print_keyed(stream, "",
                        put(MUKCA_WORDS, "and %d more; -v and --json list them all",
                            m->n_findings - MOST_FOUND));
    if (!m->n_findings)
        cli_print_keyed(stream, "Found",
                        m->n_reference
                            ? "nothing: these runs agree with the reference"
                            : "nothing beyond the uncertainty of the model's parameters");
    for (int i = 0; i < m->n_maybe && (all || i < 1); i++)
        print_finding(stream, chain, &m->maybe[i], i ? "" : "Maybe", false);
    cli_print_keyed(stream, "Rest",
                    put(MUKCA_WORDS,
                        "%.1f %% of the range held out (model %.1f, with fitted parameters %.1f), "
                        "noise %.1f %%",
                        PERCENT(m, explained_nm), PERCENT(m, nominal_nm), PERCENT(m, baseline_nm),
                        PERCENT(m, floor_nm)));
    return MUKCA_OK;
}

const cli_command cli_command_motion = {
    .name = "motion",
    .group = CLI_UNDERSTAND,
    .summary = "friction, payload, delay and others of a moving arm",
    .synopsis = "RUN...",
    .description =
        "Identifies the effects that separate the measured joint torques of a moving arm from its "
        "model: payload, masses, friction, armature, gain, delay and others, each with its size, "
        "probability and alternatives. With --reference: what has changed since those runs; "
        "errors of the model that both share cancel.\n\n"
        "A RUN is a table with time_s, the joint angles, and JOINT.effort (torque, N m) or "
        "JOINT.current (A, with --current-gain) for each joint, 20 rows per second or more; or a "
        "log of lcm-logger, or the output of ros2 topic echo --csv, with joint states that have "
        "efforts. Motions to and fro over the arm's range, 20 s or more, fast enough for its task, "
        "show most.",
    .example =
        "  mukca simulate --urdf data/demo/arm.urdf --motion 30 --seed 1 \\\n"
        "      --effect payload=0.5,viscous:joint_3=2 -o build/run.tsv\n"
        "  mukca motion --urdf data/demo/arm.urdf build/run.tsv",
    .with = CLI_WITH_MODEL | CLI_WITH_TEST | CLI_WITH_JSON | CLI_WITH_COLUMNS,
    .options = options,
    .options_size = sizeof(motion_options),
    .reads = CLI_READS_MODEL,
    .run = run,
    .table = cli_motion_table,
    .json = cli_motion_json,
    .print = print,
    .work_size = sizeof(cli_motion),
};
