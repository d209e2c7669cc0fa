/* mukca plan: the next postures to record, for accuracy or to distinguish two causes. */
#include <math.h>
#include <string.h>

#include "cli/simulate.h"
#include "diagnose/next_poses.h"
#include "report/wording.h"

typedef struct {
    cli_common common;
    cli_list places;
    int split; /* --for, from 1; 0: for accuracy */
    int rows, seed;
    double noise, tilt;
} plan_options;

typedef struct {
    cli_call *call;
    cli_model *model;          /* of the call's session */
    const mukca_dataset *data; /* likewise */
    int n_sockets;
    mukca_plan_socket sockets[MUKCA_PLAN_MAX_SOCKETS];
    mukca_effect tied[2]; /* of --for */
    mukca_diagnosis diagnosis;
    double theta[MUKCA_MAX_THETA]; /* of the model; with --for, of the diagnosis */
    mukca_plan_options options;
    mukca_plan plan;
    double payload;  /* kg, for the proposed postures; 0: none */
    double unloaded; /* evidence from equally many postures without payload */
} plan_work;

static const plan_options defaults = {.rows = 20, .noise = 1e-4};

static const cli_option options[] = {
    CLI_OPTION(plan_options, rows, "rows", CLI_INTEGER, "N",
               "postures to propose, all sockets together (default: 20)", .least = 1, .most = 1000),
    CLI_OPTION(plan_options, places, "place", CLI_TEXTS, "NAME=X,Y,Z[,ROLL,PITCH,YAW]",
               "a placement of the tool: middle of the sockets, which lie on its x axis, m and "
               "rad; 1 cm is accurate enough"),
    CLI_OPTION(plan_options, split, "for", CLI_INTEGER, "N",
               "diagnose DATA and split finding N of it: tell its two most probable "
               "alternatives apart",
               .least = 1, .most = MUKCA_MOST_FINDINGS),
    CLI_OPTION(plan_options, noise, "noise", CLI_POSITIVE, "M",
               "measurement noise of the ball per axis, m (default: 1e-4)", .most = 0.1),
    CLI_OPTION(
        plan_options, tilt, "tilt", CLI_POSITIVE, "DEG",
        "largest tilt of the tool from straight down (default: 60, or that of DATA; 180: any)",
        .most = 180),
    CLI_OPTION(plan_options, seed, "seed", CLI_INTEGER, "N",
               "seed of the random candidates (default: 0)"),
    CLI_OUTPUT_OPTION("write the postures there, a session file (default: standard output)"),
    {.name = NULL}};

static void progress(void *context, double fraction)
{
    cli_show_progress(context, fraction, "trying postures");
}

static mukca_status check(cli_call *call)
{
    const plan_options *o = call->options;
    if (o->split && call->arguments.n == 0)
        return cli_fail(call, MUKCA_USAGE, "--for needs the DATA of the finding");
    if (call->arguments.n == 0 && o->places.n == 0)
        return cli_fail(call, MUKCA_USAGE,
                        "where is the tool? give recorded DATA, or --place NAME=X,Y,Z");
    return MUKCA_OK;
}

static mukca_status add_place(plan_work *r, const char *text, int number)
{
    mukca_error *error = &r->call->error;
    const double distance = r->call->common->distance;
    mukca_place at = {.placed = false};
    MUKCA_TRY(cli_read_place(&at, text, error));
    if (!at.placed) return mukca_fail(error, MUKCA_USAGE, "--place %s: needs NAME=X,Y,Z", at.name);
    for (int k = 0; k < r->n_sockets; k++)
        if (strcmp(r->sockets[k].placement, at.name) == 0)
            return mukca_fail(error, MUKCA_USAGE,
                              "--place %s: there is such a placement already; choose another name",
                              at.name);
    if (r->n_sockets + 2 > MUKCA_PLAN_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_USAGE, "more than %d sockets", MUKCA_PLAN_MAX_SOCKETS);
    for (int side = 0; side < 2; side++) {
        mukca_plan_socket *s = &r->sockets[r->n_sockets++];
        s->place = number;
        snprintf(s->label, sizeof s->label, "%d", side);
        snprintf(s->placement, sizeof s->placement, "%s", at.name);
        for (int a = 0; a < 3; a++)
            s->centre[a] = at.pose.p[a] + (side - 0.5) * distance * at.pose.R[3 * a];
    }
    return MUKCA_OK;
}

/* Sockets of the data, then two for each --place. */
static mukca_status gather_sockets(plan_work *r)
{
    const plan_options *o = r->call->options;
    if (r->data->n_rows > 0) {
        int left_out;
        r->n_sockets = mukca_plan_sockets(r->sockets, MUKCA_PLAN_MAX_SOCKETS, &left_out,
                                          &r->model->geometry, r->data);
        if (left_out)
            cli_note(
                r->call,
                "the plan covers the first %d sockets; the samples of %d further ones are not used",
                r->n_sockets, left_out);
        if (r->n_sockets == 0)
            return cli_fail(r->call, MUKCA_INPUT,
                            "these DATA have no sockets; plan is for socket data");
    }
    for (int i = 0; i < o->places.n; i++)
        MUKCA_TRY(add_place(r, o->places.items[i], r->data->n_placements + i));
    return MUKCA_OK;
}

/* The alternatives of a finding, and the diagnosed geometry for the plan. */
static mukca_status find_pair(plan_work *r)
{
    const mukca_chain *chain = &r->model->chain;
    const mukca_diagnose_options diagnose = {.threads = r->call->common->threads,
                                             .progress = cli_show_progress,
                                             .progress_context = r->call};
    const int finding = ((const plan_options *)r->call->options)->split - 1;
    mukca_next_poses next;
    MUKCA_TRY(mukca_diagnose(&r->diagnosis, chain, r->data, &diagnose, &r->call->error));
    if (!mukca_next_poses_pair(&next, &r->options, r->tied, &r->diagnosis, finding))
        return cli_fail(r->call, MUKCA_NEGATIVE,
                        "%s (%d finding%s in all); without --for, postures are chosen for accuracy",
                        finding < r->diagnosis.n_findings
                            ? "that finding has no two alternatives that postures could separate"
                            : "there is no such finding",
                        r->diagnosis.n_findings, r->diagnosis.n_findings == 1 ? "" : "s");
    mukca_geometry_theta(r->theta, chain, &r->diagnosis.geometry);
    mukca_geometry_set(&r->model->geometry, chain, r->theta);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    const plan_options *o = call->options;
    plan_work *r = call->work;
    r->call = call;
    r->model = &call->session->model;
    r->data = &call->session->data;
    memcpy(r->theta, r->model->offsets.theta, sizeof r->theta);
    r->options = (mukca_plan_options){.rows = o->rows,
                                      .seed = (uint64_t)o->seed,
                                      .noise = o->noise,
                                      .distance_sigma = r->call->common->distance_sd,
                                      .tilt = o->tilt >= 180 ? 4 : o->tilt * M_PI / 180,
                                      .stop = cli_stop,
                                      .progress = progress,
                                      .context = r->call};
    mukca_evaluation evaluation;
    mukca_status status = cli_check_moving(call, r->data, false);
    if (status == MUKCA_OK && r->data->n_sockets > 0)
        status = cli_check_scatter(&evaluation, call, call->arguments.items[0], r->model, r->data);
    if (status == MUKCA_OK && o->split) status = find_pair(r);
    if (status == MUKCA_OK) status = gather_sockets(r);
    if (status != MUKCA_OK) return status;
    const mukca_plan_task task = {.chain = &r->model->chain,
                                  .theta = r->theta,
                                  .data = r->data->n_rows > 0 ? r->data : NULL,
                                  .sockets = r->sockets,
                                  .n_sockets = r->n_sockets};
    status = mukca_plan_run(&r->plan, &task, &r->options, &r->call->error);
    r->unloaded = r->plan.evidence_after;
    if (status == MUKCA_OK && r->options.n_effects > 0)
        status = mukca_plan_payload(&r->payload, &r->plan, &task, &r->options, &r->call->error);
    return status;
}

/* ---- output ---- */

/* The postures as rows of a session file, to be recorded. */
static mukca_status write_rows(cli_call *call, FILE *out)
{
    const plan_work *r = call->work;
    const mukca_chain *chain = &r->model->chain;
    fprintf(out,
            "# postures proposed by mukca plan for %s, joints in rad; guide the arm there and\n"
            "# record the angles with the ball seated in its socket\n",
            chain->robot);
    fputs("placement\tsocket", out);
    for (int j = 0; j < chain->n_joints; j++)
        fprintf(out, "\t%s", mukca_chain_joint_name(chain, j));
    fputs(r->payload > 0 ? "\tpayload_kg\n" : "\n", out);
    for (int i = 0; i < r->plan.n_rows; i++) {
        const mukca_plan_row *row = &r->plan.rows[i];
        fprintf(out, "%s\t%s", r->sockets[row->socket].placement, r->sockets[row->socket].label);
        for (int j = 0; j < chain->n_joints; j++) fprintf(out, "\t%.6f", row->q[j]);
        if (r->payload > 0) fprintf(out, "\t%g", r->payload);
        fputc('\n', out);
    }
    return MUKCA_OK;
}

static json_t *as_json(const cli_call *call)
{
    const plan_work *r = call->work;
    const mukca_chain *chain = &r->model->chain;
    json_t *rows = json_array();
    for (int i = 0; i < r->plan.n_rows; i++) {
        const mukca_plan_row *row = &r->plan.rows[i];
        json_t *joints = json_object();
        for (int j = 0; j < chain->n_joints; j++)
            json_object_set_new(joints, mukca_chain_joint_name(chain, j), json_real(row->q[j]));
        cli_json_append(rows, KEY("placement", r->sockets[row->socket].placement),
                        KEY("socket", r->sockets[row->socket].label), KEY("joints", joints));
    }
    const mukca_plan *p = &r->plan;
    return cli_json(
        KEY("recorded_rows", p->n_recorded), KEY("poses", rows),
        KEY("expected_error_m",
            cli_json(KEY("before", p->expected_before), KEY("after", p->expected_after))),
        KEY("log_bayes_factor",
            cli_json(KEY("before", p->evidence_before), KEY("after", p->evidence_after))),
        FIELD(p, rows_to_name), KEY("payload_kg", r->payload), KEY("elapsed_s", cli_elapsed(call)));
}

static mukca_status print(cli_call *call)
{
    const plan_work *r = call->work;
    const plan_options *o = call->options;
    const mukca_plan *p = &r->plan;
    cli_answer(call, "%d postures in %d sockets; %d samples recorded\n", p->n_rows, r->n_sockets,
               p->n_recorded);
    if (o->split) {
        const mukca_chain *chain = &r->model->chain;
        const mukca_effect *e = r->tied;
        cli_say(
            call, NULL,
            "Separating %s from %s: log Bayes factor %.1f now, %.1f with the plan (%g decides)",
            mukca_wording_effect(MUKCA_WORDS, e->kind, mukca_chain_joint_name(chain, e->joint)),
            mukca_wording_effect(MUKCA_WORDS, e[1].kind, mukca_chain_joint_name(chain, e[1].joint)),
            p->evidence_before, p->evidence_after, MUKCA_PLAN_NAME);
        if (r->payload > 0)
            cli_say(call, NULL,
                    "These postures are for a payload of %g kg at the tip; as many without it "
                    "reach %.1f",
                    r->payload, r->unloaded);
        if (p->evidence_after < MUKCA_PLAN_NAME)
            cli_say(call, NULL, "Not enough: try another placement (--place)%s",
                    p->rows_to_name > 0 ? ", or more --rows" : "");
    } else {
        cli_say(call, NULL,
                "Expected consistency error at new placements, without noise: %.3f mm before, "
                "%.3f mm after",
                p->expected_before * 1e3, p->expected_after * 1e3);
    }
    if (p->n_rows < o->rows)
        cli_say(call, NULL,
                "Fewer than the requested %d: the sockets allow no more different postures",
                o->rows);
    cli_say(call, "Next",
            "check each posture for collisions (only joint limits, tilt and height are checked "
            "here), guide the arm there, and record it with the ball seated");
    return MUKCA_OK;
}

static void release(void *work)
{
    plan_work *r = work;
    mukca_plan_free(&r->plan);
    mukca_diagnosis_free(&r->diagnosis);
}

const cli_command cli_command_plan = {
    .name = "plan",
    .group = CLI_MEASURE,
    .summary = "plan the next postures to record",
    .synopsis = "[DATA...]",
    .description =
        "Finds postures with the ball in the sockets of DATA (located by --offsets or the nominal "
        "model) and of each --place, within the joint limits and with the tool pointing down, and "
        "selects those that add most information to DATA: about the geometry (D-optimality), or, "
        "with --for, about which of two causes is present (T-optimality). If "
        "postures alone cannot separate elastic causes, the plan is for the smallest payload with "
        "which they do. Writes a session file in the order to visit. Guide the arm to these angles "
        "and record the angles at which the ball is seated.",
    .example =
        "  mukca plan --urdf data/demo/arm.urdf \\\n"
        "      --place front=0.45,0,0.05,0,0,1.57 --rows 40 \\\n"
        "      -o build/demo/plan.tsv --force",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_DISTANCE |
            CLI_WITH_DISTANCES | CLI_WITH_SD | CLI_WITH_JSON | CLI_WITH_PAYLOAD | CLI_WITH_TABLES |
            CLI_WITH_THREADS,
    .options = options,
    .options_size = sizeof(plan_options),
    .defaults = &defaults,
    .check = check,
    .reads = CLI_READS_CONDENSED,
    .run = run,
    .table = write_rows,
    .json = as_json,
    .print = print,
    .work_size = sizeof(plan_work),
    .release = release,
};
