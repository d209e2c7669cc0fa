/* The next poses: candidates in each socket, the choice, and what it brings. */
#include "plan/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/choose.h"

enum { DEFAULT_ROWS = 20, DEFAULT_CANDIDATES = 150 };

/* Socket by socket, each time on to the nearest pose. */
static void put_in_order(mukca_plan_row *rows, int n, int n_joints)
{
    for (int i = 1; i < n; i++) {
        double least = HUGE_VAL;
        int next = i;
        for (int k = i; k < n; k++) {
            double far = rows[k].socket == rows[i - 1].socket ? 0 : 1e3 * (1 + rows[k].socket);
            for (int j = 0; j < n_joints; j++)
                far = fmax(far, fabs(rows[k].q[j] - rows[i - 1].q[j]));
            if (far < least) {
                least = far;
                next = k;
            }
        }
        const mukca_plan_row swap = rows[i];
        rows[i] = rows[next];
        rows[next] = swap;
    }
}

static mukca_status check(const mukca_chain *chain, int n_sockets, const mukca_plan_options *o,
                          mukca_error *error)
{
    if (n_sockets < 1 || n_sockets > MUKCA_PLAN_MAX_SOCKETS)
        return mukca_fail(error, MUKCA_USAGE, "a plan needs 1 to %d sockets, not %d",
                          MUKCA_PLAN_MAX_SOCKETS, n_sockets);
    if (o->n_effects == 1 || o->n_effects > MUKCA_PLAN_MAX_EFFECTS)
        return mukca_fail(error, MUKCA_USAGE, "a plan separates 2 to %d causes, not %d",
                          MUKCA_PLAN_MAX_EFFECTS, o->n_effects);
    for (int e = 0; e < o->n_effects; e++) {
        const mukca_effect *f = &o->effects[e];
        const mukca_effect_info *info = mukca_effect_table[f->kind];
        double size = 0;
        for (int t = 0; t < f->terms; t++) size = hypot(size, f->coefficient[t]);
        if (info->traits & MUKCA_TRAIT_RECORDING_FAULT)
            return mukca_fail(error, MUKCA_USAGE,
                              "%s is a fault of the recording; no pose settles it: record again",
                              info->name);
        if (!(size > 0))
            return mukca_fail(error, MUKCA_USAGE, "%s needs a size, as in %s:joint=value",
                              info->name, info->name);
        if ((info->needs & MUKCA_NEEDS_MASSES) && chain->n_masses == 0)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s needs the masses of the links: give --inertials FILE",
                              info->name);
    }
    return MUKCA_OK;
}

/* The strength grows by about the same with each row. */
static int rows_to_name(double before, double after, int rows)
{
    double wanted = 1;
    if (!(after > before) || rows < 1) return 0;
    while (mukca_plan_evidence(wanted) < MUKCA_PLAN_NAME) wanted *= 1.01;
    const double needed = ceil(rows * (wanted - before) / (after - before));
    return needed > 1000 ? 0 : (int)fmax(needed, 1);
}

mukca_status mukca_plan_run(mukca_plan *plan, const mukca_plan_task *task,
                            const mukca_plan_options *options, mukca_error *error)
{
    const mukca_chain *chain = task->chain;
    const int n_sockets = task->n_sockets;
    mukca_planner p = {.data = task->data, .sockets = task->sockets, .n_sockets = n_sockets};
    const int rows = options->rows > 0 ? options->rows : DEFAULT_ROWS;
    const int candidates = options->candidates > 0 ? options->candidates : DEFAULT_CANDIDATES;
    int recorded[MUKCA_PLAN_MAX_SOCKETS] = {0};
    memset(plan, 0, sizeof *plan);
    mukca_status status = check(chain, n_sockets, options, error);
    if (status != MUKCA_OK) return status;
    status = mukca_plan_state_create(&p.state, task, n_sockets, options, error);
    if (status != MUKCA_OK) return status;
    mukca_plan_state *s = &p.state;
    mukca_plan_rules_set(&p.rules, chain, &s->at.geometry, options, task->data);
    p.poses = MUKCA_TAKE(&s->pool, mukca_plan_pose, n_sockets * candidates);
    double *H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    p.spare = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    int *chosen = MUKCA_TAKE(&s->pool, int, rows + n_sockets);
    plan->rows = calloc((size_t)rows, sizeof *plan->rows);
    if (s->pool.failed || !plan->rows) goto memory;
    for (int e = 0; e < s->n_effects; e++)
        p.ordered |= (mukca_effect_table[s->effect[e].kind]->needs & MUKCA_NEEDS_ORDER) != 0;
    mukca_plan_look_elsewhere(s, &p.rules, options->seed);
    plan->n_recorded = mukca_plan_take_recorded(&p, H, recorded);
    plan->expected_before = mukca_plan_expected(s);
    const double weak = mukca_plan_strength(s);
    plan->evidence_before = mukca_plan_evidence(weak);
    mukca_random random;
    mukca_random_seed(&random, options->seed);
    for (int k = 0; k < n_sockets && !mukca_plan_stopped(options); k++) {
        const int found =
            mukca_plan_draw_candidates(&p, p.poses + p.n_poses, candidates, k, &random);
        p.n_poses += found;
        if (options->progress) options->progress(options->context, 0.3 * (k + 1) / n_sockets);
        if (found == 0 && recorded[k] == 0) {
            const mukca_plan_socket *socket = &task->sockets[k];
            const double *c = socket->centre;
            status = mukca_fail(error, MUKCA_INPUT,
                                "placement %s: no pose was found that reaches socket %s at "
                                "%.3f %.3f %.3f m; move it, or allow more --tilt",
                                socket->placement, socket->label, c[0], c[1], c[2]);
            goto out;
        }
    }
    if (s->pool.failed) goto memory;
    plan->tried = p.tried;
    plan->reached = p.n_poses;
    plan->n_rows = mukca_plan_choose(&p, chosen, rows, recorded);
    mukca_plan_exchange(&p, chosen, plan->n_rows, &random);
    if (mukca_plan_stopped(options)) {
        status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        goto out;
    }
    for (int i = 0; i < plan->n_rows; i++) {
        plan->rows[i].socket = p.poses[chosen[i]].socket;
        memcpy(plan->rows[i].q, p.poses[chosen[i]].q, sizeof plan->rows[i].q);
    }
    if (!p.ordered) put_in_order(plan->rows, plan->n_rows, chain->n_joints);
    plan->expected_after = mukca_plan_expected(s);
    plan->evidence_after = mukca_plan_evidence(mukca_plan_strength(s));
    plan->rows_to_name = rows_to_name(weak, mukca_plan_strength(s), plan->n_rows);
    goto out;
memory:
    status = mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
out:
    mukca_plan_state_free(s);
    if (status != MUKCA_OK) mukca_plan_free(plan);
    return status;
}

void mukca_plan_free(mukca_plan *plan)
{
    free(plan->rows);
    memset(plan, 0, sizeof *plan);
}
