/* mukca fleet: pool the summaries of many arms of one model. */
#include "cli/diagnose.h"

#include "report/report.h"

typedef struct {
    cli_common common;
    bool partial;
} fleet_options;

static const cli_option options[] = {
    CLI_OUTPUT_OPTION("write the traits table; with --partial, the summary of summaries"),
    CLI_OPTION(fleet_options, partial, "partial", CLI_FLAG, NULL,
               "join the summaries into one file (-o) for a later mukca fleet; pool nothing",
               .needs = "output", .excludes = "json"),
    {.name = NULL}};

static void release(void *fleet)
{
    mukca_fleet_free(fleet);
}

mukca_status cli_fleet_read(cli_call *call, mukca_fleet *f)
{
    for (int i = 0; i < call->arguments.n; i++) {
        if (!cli_show_progress(call, (double)i / call->arguments.n, "reading summaries"))
            return cli_fail(call, MUKCA_INTERRUPTED, "interrupted");
        MUKCA_TRY(mukca_summary_read(f, call->arguments.items[i], &call->error));
    }
    return mukca_fleet_gather(f, &call->error);
}

static mukca_status write_traits(cli_call *call, FILE *stream)
{
    const fleet_options *o = call->options;
    const mukca_fleet *f = call->work;
    /* the bytes of a partial file do not depend on previous merges: its lines are sorted */
    for (int s = 0; o->partial && s < f->n_sessions; s++)
        MUKCA_TRY(mukca_summary_write(stream, f->session[s], &call->error));
    if (!o->partial) mukca_traits_write(stream, &f->traits);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    const fleet_options *o = call->options;
    mukca_fleet *f = call->work;
    MUKCA_TRY(cli_fleet_read(call, f));
    MUKCA_TRY(o->partial ? MUKCA_OK : mukca_fleet_pool(f, &call->error));
    return cli_write(call, call->common->output, write_traits);
}

/* ---- JSON ---- */

static const char *joint_name(const mukca_fleet *f, int joint)
{
    return joint < 0 ? NULL : f->model.joint[joint];
}

static json_t *trait_json(const mukca_trait *t, const mukca_fleet *f)
{
    const mukca_effect_info *info = mukca_effect_table[t->effect.kind];
    return cli_json(FIELD(t, mean), FIELD(t, spread), FIELD(t, error), FIELD(t, value),
                    FIELD(t, log_bayes_factor), FIELD(t, probability), KEY("effect", info->name),
                    KEY("joint", joint_name(f, t->effect.joint)),
                    KEY("order", cli_json_positive(t->effect.variant.order)), FIELD(info, unit),
                    FIELD(t, arms), KEY("ci95", cli_json_interval(t->low, t->high)));
}

static json_t *departure_json(const mukca_departure *d, const mukca_fleet *f)
{
    return cli_json(KEY("arm", f->arm[d->arm].name),
                    KEY("effect", mukca_effect_table[d->effect.kind]->name),
                    KEY("joint", joint_name(f, d->effect.joint)), FIELD(d, ratio),
                    FIELD(d, probability), FIELD(d, log_bayes_factor), FIELD(d, value),
                    KEY("ci95", cli_json_interval(d->low, d->high)), FIELD(d, mean));
}

static json_t *arm_json(const mukca_fleet *f, int arm)
{
    json_t *effects = json_array();
    const int n = f->population.n;
    for (int k = 0; k < n && f->arm[arm].departure.k >= 0; k++)
        json_array_append_new(effects, departure_json(&f->arm[arm].estimate[k], f));
    return cli_json(KEY("arm", f->arm[arm].name),
                    KEY("sessions", f->arm[arm].end - f->arm[arm].first),
                    KEY("samples", f->arm[arm].samples), KEY("effects", effects));
}

static json_t *as_json(const cli_call *call)
{
    const mukca_fleet *f = call->work;
    json_t *effects = json_array(), *orders = json_array(), *departures = json_array(),
           *arms = json_array();
    for (int i = 0; i < f->traits.n; i++)
        json_array_append_new(effects, trait_json(&f->traits.list[i], f));
    for (int j = 0; j < f->model.n_joints; j++) {
        const mukca_trait *o = &f->order[j];
        if (o->effect.variant.order)
            cli_json_append(orders, KEY("joint", joint_name(f, j)),
                            KEY("order", o->effect.variant.order), FIELD(o, probability),
                            FIELD(o, log_bayes_factor), FIELD(o, arms));
    }
    for (int a = 0; a < f->n_arms; a++) {
        if (f->arm[a].departure.probability >= MUKCA_DEPARTS)
            json_array_append_new(departures, departure_json(&f->arm[a].departure, f));
        json_array_append_new(arms, arm_json(f, a));
    }
    return cli_json(KEY("robot", f->model.robot), FIELD(f, n_arms),
                    KEY("samples", f->traits.n_samples), KEY("effects", effects),
                    KEY("orders", orders), KEY("departures", departures), KEY("arms", arms));
}

/* ---- screen ---- */

static void print_shared(cli_call *call, const mukca_fleet *f)
{
    const mukca_traits *t = &f->traits;
    for (int ripple = 0; ripple < 2; ripple++) {
        const char *key = ripple ? "Ripple" : "Shared";
        int shown = 0;
        for (int i = 0; i < t->n; i++) {
            if (t->list[i].probability < MUKCA_SHARED ||
                (t->list[i].effect.variant.order > 0) != ripple)
                continue;
            cli_say(call, shown++ ? "" : key, "%s",
                    mukca_wording_fleet_trait(MUKCA_WORDS, &t->list[i], f));
        }
        if (!shown) cli_say(call, key, ripple ? "no shared order" : "no elastic coefficient");
    }
}

static void print_departures(cli_call *call, const mukca_fleet *f)
{
    const mukca_departure *d = f->ranked, *const end = d + f->n_arms;
    if (!(d->probability >= MUKCA_DEPARTS))
        cli_say(call, "Departs", f->n_arms < 3 ? "not testable with two arms" : "no arm");
    for (const char *key = "Departs"; d < end && d->probability >= MUKCA_DEPARTS; d++, key = "")
        cli_say(call, key, "%s", mukca_wording_fleet_departure(MUKCA_WORDS, d, f));
}

static mukca_status print(cli_call *call)
{
    const fleet_options *o = call->options;
    const mukca_fleet *f = call->work;
    cli_answer(call, "%s: %d arms, %d sessions\n\n", f->model.robot, f->n_arms, f->n_sessions);
    if (o->partial) return MUKCA_OK;
    print_shared(call, f);
    print_departures(call, f);
    return MUKCA_OK;
}

const cli_command cli_command_fleet = {
    .name = "fleet",
    .group = CLI_UNDERSTAND,
    .summary = "pool the summaries of many arms of one model",
    .synopsis = "SUMMARY...",
    .description =
        "Reads the files of diagnose --summary. Sessions with the same arm label are one arm's "
        "data. Prints which elastic coefficients the arms share (mean, 95 % interval, spread "
        "between arms), the orders of transmission ripple that they share, and which arms depart "
        "from all others. Probabilities take the number of arms and coefficients into account.\n\n"
        "-o writes the traits table: the population as prior for diagnose --traits and calibrate "
        "--traits.\n\n"
        "--partial writes the summaries into one file instead, for a tree of jobs: pooling the "
        "parts gives the same bytes as pooling all files at once. See docs/fleet.md for GNU "
        "parallel and Slurm.",
    .example =
        "  mukca diagnose --urdf data/demo/arm.urdf data/demo/train.tsv \\\n"
        "      --summary build/demo/arm_1.json --arm 1 --force\n"
        "  mukca diagnose --urdf data/demo/arm.urdf data/demo/test.tsv \\\n"
        "      --summary build/demo/arm_2.json --arm 2 --force\n"
        "  mukca fleet build/demo/arm_1.json build/demo/arm_2.json \\\n"
        "      -o build/demo/heron7.traits.tsv --force",
    .with = CLI_WITH_JSON,
    .options = options,
    .options_size = sizeof(fleet_options),
    .run = run,
    .json = as_json,
    .print = print,
    .work_size = sizeof(mukca_fleet),
    .release = release,
};
