/* mukca motion: what separates the torques of a moving arm from its model. */
#include <math.h>
#include <string.h>

#include "base/number.h"
#include "cli/cli.h"
#include "io/drives.h"
#include "io/export.h"
#include "math/stats.h"
#include "motion/raw.h"
#include "mukca/version.h"
#include "record/joint_lines.h"
#include "report/motion_page.h"
#include "report/wording_motion.h"

#define put mukca_wording_put /* short for this file */

typedef struct {
    cli_common common;
    const char *mjcf, *gain, *stiffness, *without, *report;
    cli_list reference;
    int effort;
} motion_options;

enum { TORQUE, CURRENT }; /* what --effort can be */
static const char *const efforts[] = {[TORQUE] = "torque", [CURRENT] = "current", NULL};

static const cli_option options[] = {
    CLI_OPTION(
        motion_options, reference, "reference", CLI_REST, "RUN...",
        "earlier runs: report what has changed since, not what separates them from the model"),
    CLI_OPTION(motion_options, mjcf, "mjcf", CLI_INPUT, "FILE",
               "MuJoCo model with frictionloss, damping and armature of the joints (default: "
               "<dynamics> of the URDF)"),
    CLI_OPTION(motion_options, effort, "effort", CLI_CHOICE, "WHAT",
               "what JOINT.effort contains (default: torque, N m)", .choices = efforts),
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

typedef struct {
    mukca_motion_input input;
    mukca_motion motion;
    mukca_motion_trace trace; /* for the page */
} motion_work;

/* ---- inputs ---- */

/* Numbers by joint: J1=14.87,J2=...; NaN: not given. */
static mukca_status read_by_joint(double *values, cli_call *call, const char *option,
                                  const char *list)
{
    const mukca_chain *chain = &call->session->model.chain;
    const bool given = list != NULL;
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
    for (int j = 0; j < chain->n_joints && given; j++)
        if (!isfinite(values[j]))
            return cli_fail(call, MUKCA_USAGE, "--%s: no value for %s; give one for each joint",
                            option, mukca_chain_joint_name(chain, j));
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

static mukca_status read_runs(cli_call *call, mukca_run *run, const mukca_run_options *o)
{
    const cli_list *lists[] = {&((const motion_options *)call->options)->reference,
                               &call->arguments, &call->common->test};
    static const mukca_run_role roles[] = {MUKCA_RUN_REFERENCE, MUKCA_RUN_NEW, MUKCA_RUN_TEST};
    motion_work *w = call->work;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < lists[k]->n; i++) {
            mukca_run *next = &run[w->input.n_runs++];
            next->role = roles[k];
            const char *path = lists[k]->items[i];
            const mukca_chain *chain = &call->session->model.chain;
            MUKCA_TRY(mukca_run_load(next, &call->pool, path, chain, o, &call->error));
            if (next->current != run[0].current)
                return cli_fail(
                    call, MUKCA_INPUT, "%s has motor currents, %s torques; give runs of one kind",
                    (next->current ? next : run)->name, (next->current ? run : next)->name);
        }
    return MUKCA_OK;
}

/* ---- table ---- */

/* A row of the table. */
typedef struct {
    const char *name, *unit;
    mukca_estimate value;
    int finding;
    double nominal, fitted; /* in the model, without the effect */
} table_parameter;

static void write_parameter(cli_call *call, FILE *stream, const mukca_motion_alternative *a,
                            int joint, const table_parameter *p)
{
    fprintf(stream, "%s\t%s\t%s\t%s\t%.17g\t%.17g\t%.4f\t%d\t%.17g\t%.17g\n",
            mukca_torque_table[a->effect].name,
            mukca_chain_joint_name(&call->session->model.chain, joint), p->name, p->unit,
            p->value.value, (p->value.high - p->value.low) / (2 * MUKCA_SIGMAS_95), a->probability,
            p->finding, p->nominal, p->fitted);
}

static void write_alternative(cli_call *call, FILE *stream, const mukca_motion_alternative *a,
                              int finding)
{
    const mukca_motion *m = &((const motion_work *)call->work)->motion;
    const mukca_torque_effect *row = &mukca_torque_table[a->effect];
    const double *nominal = mukca_drives_of(&m->drives, a->effect),
                 *fitted = mukca_drives_of(&m->fitted, a->effect);
    for (int j = a->all ? 0 : a->from; j <= (a->all ? m->n_joints - 1 : a->to); j++) {
        table_parameter p = {row->coefficient, row->unit, a->amplitude, .finding = finding};
        if (nominal) p.nominal = nominal[j], p.fitted = fitted[j];
        if (!row->links) write_parameter(call, stream, a, j, &p);
        for (int i = 0; i < MUKCA_INERTIAL && row->links; i++) {
            const char *unit = i == 0 ? "kg" : i < 4 ? "kg*m" : "kg*m^2";
            p = (table_parameter){mukca_export_inertial[i], unit,
                                  a->inertial[i],           finding,
                                  m->inertial[j][i],        m->fitted_inertial[j][i]};
            if (p.value.high > p.value.low) write_parameter(call, stream, a, j, &p);
        }
        p = (table_parameter){"order", "1", {a->detail, a->detail, a->detail}, finding, 0, 0};
        if (row->orders) write_parameter(call, stream, a, j, &p);
    }
}

static mukca_status write_table(cli_call *call, FILE *stream)
{
    const motion_work *w = call->work;
    const mukca_chain *chain = &call->session->model.chain;
    fprintf(stream, "# mukca %s\n# robot: %s\n# urdf_sha256: %s\n", MUKCA_VERSION, chain->robot,
            chain->urdf_sha256);
    fputs(
        "# torque of the arm = torque of the model + effects\n"
        "# parameter of the arm = fitted + value; nominal: in the model, fitted: within the "
        "model's uncertainty\n"
        "effect\tjoint\tparameter\tunit\tvalue\tsigma\tprobability\tfinding\tnominal\tfitted\n",
        stream);
    for (int i = 0; i < w->motion.n_findings; i++) {
        const mukca_motion_finding *f = &w->motion.finding[i];
        for (int k = 0; k < f->n_alternatives; k++)
            if (f->alternative[k].effect >= 0)
                write_alternative(call, stream, &f->alternative[k], i + 1);
    }
    return MUKCA_OK;
}

/* ---- report ---- */

static bool view(void *context, const struct mukca_torques *torques,
                 const struct mukca_torque_columns *fitted)
{
    cli_call *call = context;
    motion_work *w = call->work;
    return mukca_motion_trace_make(&w->trace, &call->pool, torques, fitted);
}

static mukca_status write_page(cli_call *call, FILE *stream)
{
    motion_work *w = call->work;
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
    motion_work *w = call->work;
    mukca_run_options form = {.current = o->effort == CURRENT, .notes = cli_notes(call)};
    const int n = call->arguments.n + o->reference.n + call->common->test.n;
    mukca_run *runs = MUKCA_TAKE(&call->pool, mukca_run, n + 1);
    if (!runs) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    w->input.chain = &model->chain;
    w->input.run = runs;
    w->input.notes = cli_notes(call);
    MUKCA_TRY(read_by_joint(form.gain, call, "current-gain", o->gain));
    MUKCA_TRY(read_by_joint(form.stiffness, call, "kp", o->stiffness));
    MUKCA_TRY(disable(w->input.disabled, call, o->without));
    MUKCA_TRY(cli_read_format(call, &form.format));
    MUKCA_TRY(mukca_drives_read(&w->input.drives, o->mjcf ? o->mjcf : call->common->arm.urdf,
                                &model->chain, &call->error));
    MUKCA_TRY(read_runs(call, runs, &form));
    w->input.progress = cli_show_progress;
    w->input.progress_context = call;
    if (o->report) w->input.view = view;
    MUKCA_TRY(mukca_motion_analyse(&w->motion, &w->input, &call->error));
    MUKCA_TRY(cli_write(call, call->common->output, write_table));
    return cli_write(call, o->report, write_page);
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
        const void *error = (const char *)&m->joint[j] + offset;
        sum += pow(*(const double *)error / m->joint[j].range_nm, 2) / m->n_joints;
    }
    return 100 * sqrt(sum);
}
#define PERCENT(m, member) percent(m, offsetof(mukca_motion_joint, member))

static mukca_status print(cli_call *call)
{
    const mukca_motion *m = &((const motion_work *)call->work)->motion;
    const mukca_chain *chain = &call->session->model.chain;
    FILE *stream = cli_answer_stream(call);
    if (!stream) return MUKCA_OK;
    const bool all = call->common->verbose;
    fprintf(stream, "%s: %s\n\n", chain->robot, mukca_wording_runs(MUKCA_WORDS, m));
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

/* ---- JSON ---- */

static json_t *alternatives_json(const mukca_motion_finding *f, const mukca_chain *chain)
{
    json_t *array = json_array();
    const int last = chain->n_joints - 1;
    for (int i = 0; i < f->n_alternatives; i++) {
        const mukca_motion_alternative *a = &f->alternative[i];
        const mukca_torque_effect *row = a->effect < 0 ? NULL : &mukca_torque_table[a->effect];
        const bool links = row ? row->links : mukca_wording_torque_on_links(&f->group);
        cli_json_append(
            array, KEY("effect", row ? row->name : NULL), KEY("on", links ? "links" : "joints"),
            KEY("from", mukca_wording_torque_position(chain, links, a->all ? 0 : a->from)),
            KEY("to", mukca_wording_torque_position(chain, links, a->all ? last : a->to)),
            KEY("joint", a->all || a->from < a->to ? NULL : mukca_chain_joint_name(chain, a->to)),
            KEY("order", cli_json_positive(a->detail)), FIELD(a, probability),
            KEY("amplitude", row ? a->amplitude.value : (double)NAN),
            KEY("unit", row ? row->unit : NULL),
            KEY("ci95", row ? cli_json_estimate(&a->amplitude) : NULL));
    }
    return array;
}

static json_t *finding_json(const mukca_motion_finding *f, const mukca_chain *chain)
{
    static const char *const kinds[] = {"effect", "effect", "family", "tie", "place"};
    const mukca_finding_group *g = &f->group;
    const bool links = mukca_wording_torque_on_links(g), sized = isfinite(f->coefficient.value);
    const double shrink = 100 * (1 - f->after_nm / f->before_nm);
    const int last = chain->n_joints - 1;
    return cli_json(
        KEY("kind", kinds[g->kind]),
        KEY("effect", g->effect < 0 ? NULL : mukca_torque_table[g->effect].name),
        KEY("varies_with", g->family < 0 ? NULL : mukca_torque_family_name[g->family]),
        KEY("on", links ? "links" : "joints"),
        KEY("from", mukca_wording_torque_position(chain, links, g->apart ? 0 : g->from)),
        KEY("to", mukca_wording_torque_position(chain, links, g->apart ? last : g->to)),
        KEY("order", cli_json_positive(f->order[0] ? f->alternative[0].detail : 0)),
        KEY("order_ci95", f->order[0] > 0 ? json_pack("[i, i]", f->order[0], f->order[1]) : NULL),
        KEY("probability", g->probability), KEY("halves", g->halves),
        KEY("halves_against", g->against), KEY("beside_finer", g->n_finer > 0),
        KEY("size_nm", f->size_nm.value), KEY("size_ci95_nm", cli_json_estimate(&f->size_nm)),
        FIELD(f, size_percent), KEY("worst", mukca_chain_joint_name(chain, f->worst)),
        FIELD(f, share),
        KEY("held_out", f->before_nm > 0 ? cli_json(FIELD(f, before_nm), FIELD(f, after_nm),
                                                    KEY("shrink_percent", shrink))
                                         : NULL),
        KEY("coefficient", sized ? cli_json(KEY("value", f->coefficient.value),
                                            KEY("unit", mukca_torque_table[g->effect].unit),
                                            KEY("ci95", cli_json_estimate(&f->coefficient)))
                                 : NULL),
        KEY("alternatives", alternatives_json(f, chain)),
        KEY("sentence", mukca_wording_torque(MUKCA_WORDS, g, chain)));
}

static json_t *as_json(const cli_call *call)
{
    const mukca_motion *m = &((const motion_work *)call->work)->motion;
    const mukca_chain *chain = &call->session->model.chain;
    json_t *findings = json_array(), *maybe = json_array(), *joints = json_array();
    for (int i = 0; i < m->n_findings; i++)
        json_array_append_new(findings, finding_json(&m->finding[i], chain));
    for (int i = 0; i < m->n_maybe; i++)
        json_array_append_new(maybe, finding_json(&m->maybe[i], chain));
    for (int j = 0; j < m->n_joints; j++) {
        const mukca_motion_joint *of = &m->joint[j];
        cli_json_append(joints, KEY("joint", mukca_chain_joint_name(chain, j)),
                        FIELD(of, nominal_nm), FIELD(of, baseline_nm), FIELD(of, explained_nm),
                        FIELD(of, floor_nm), FIELD(of, range_nm), FIELD(of, moves),
                        FIELD(of, reverses));
    }
    return cli_json(KEY("verdict", mukca_motion_verdict_name[m->verdict]),
                    KEY("findings", findings), KEY("maybe", maybe), KEY("joints", joints),
                    KEY("runs", m->n_runs), KEY("reference", m->n_reference),
                    KEY("test", m->n_test), KEY("seconds", m->seconds), KEY("shift_s", m->shift_s),
                    KEY("elapsed_s", cli_elapsed(call)));
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
    .json = as_json,
    .print = print,
    .work_size = sizeof(motion_work),
};
