/* Planned postures as a table, as JSON and on the screen. */
#include <math.h>

#include "cli/plan.h"
#include "io/output.h"

/* The postures as rows of a session file, to be recorded. */
mukca_status cli_plan_write(cli_plan *r)
{
    const cli_common *c = r->call->common;
    const mukca_chain *chain = &r->model->chain;
    mukca_output output = {0};
    if (c->json && !c->output) return MUKCA_OK;
    mukca_status status = cli_output_open(r->call, &output);
    if (status != MUKCA_OK) return status;
    FILE *out = output.stream;
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
    return mukca_output_close(&output, &r->call->error);
}

json_t *cli_plan_json(const cli_plan *r)
{
    const mukca_chain *chain = &r->model->chain;
    json_t *rows = json_array();
    for (int i = 0; i < r->plan.n_rows; i++) {
        const mukca_plan_row *row = &r->plan.rows[i];
        json_t *joints = json_object();
        for (int j = 0; j < chain->n_joints; j++)
            json_object_set_new(joints, mukca_chain_joint_name(chain, j), json_real(row->q[j]));
        json_array_append_new(
            rows, json_pack("{s:s, s:s, s:o}", "placement", r->sockets[row->socket].placement,
                            "socket", r->sockets[row->socket].label, "joints", joints));
    }
    const mukca_plan *p = &r->plan;
    return json_pack("{s:s, s:i, s:o, s:o, s:o, s:i, s:f, s:f}", "schema", "mukca.plan/1",
                     "recorded_rows", p->n_recorded, "poses", rows, "expected_error_m",
                     cli_json_numbers("before", p->expected_before, "after", p->expected_after),
                     "log_bayes_factor",
                     cli_json_numbers("before", p->evidence_before, "after", p->evidence_after),
                     "rows_to_name", p->rows_to_name, "payload_kg", r->payload, "elapsed_s",
                     cli_elapsed(r->call));
}

static void name_cause(char name[96], const mukca_effect *effect, const mukca_chain *chain)
{
    snprintf(name, 96, "%s%s%s", mukca_effect_table[effect->kind]->name,
             effect->joint < 0 ? "" : " of ",
             effect->joint < 0 ? "" : mukca_chain_joint_name(chain, effect->joint));
}

void cli_plan_print(cli_plan *r)
{
    const cli_plan_options *o = r->call->options;
    const mukca_plan *p = &r->plan;
    cli_answer(r->call, "%d postures in %d sockets; %d samples recorded\n", p->n_rows, r->n_sockets,
               p->n_recorded);
    if (r->causes.n_effects > 0) {
        char a[96], b[96];
        name_cause(a, &r->causes.effects[0], &r->model->chain);
        name_cause(b, &r->causes.effects[1], &r->model->chain);
        cli_answer_wrapped(r->call,
                           "Separating %s from %s: expected log Bayes factor %.1f before, %.1f "
                           "after (%g decides)",
                           a, b, p->evidence_before, p->evidence_after, MUKCA_PLAN_NAME);
        if (r->payload > 0)
            cli_answer_wrapped(r->call,
                               "These postures are for a payload of %g kg at the tip; as many "
                               "without it reach %.1f",
                               r->payload, r->unloaded);
        if (p->evidence_after < MUKCA_PLAN_NAME && p->rows_to_name > 0)
            cli_answer_wrapped(r->call,
                               "Not enough: some --rows %d are needed, or another placement "
                               "(--place)",
                               p->rows_to_name);
        else if (p->evidence_after < MUKCA_PLAN_NAME)
            cli_answer_wrapped(r->call,
                               "Not enough, and more samples here do not decide: try another "
                               "placement (--place)");
    } else {
        cli_answer(r->call, "Expected error of the ball elsewhere: %.3f mm before, %.3f mm after\n",
                   p->expected_before * 1e3, p->expected_after * 1e3);
    }
    if (p->n_rows < o->rows)
        cli_answer_wrapped(r->call,
                           "Fewer than the requested %d: the sockets allow no more different "
                           "postures",
                           o->rows);
    cli_answer_keyed(r->call, "Next",
                     "check each posture for collisions (only joint limits, tilt and height are "
                     "checked here), guide the arm there, and record it with the ball seated");
}
