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
        const mukca_effect_info *info = &mukca_effect_table[f->kind];
        double size = 0;
        for (int t = 0; t < f->terms; t++) size = hypot(size, f->coefficient[t]);
        if (info->site == MUKCA_SITE_SOCKET)
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
    while (plan_evidence(wanted) < MUKCA_PLAN_NAME) wanted *= 1.01;
    const double needed = ceil(rows * (wanted - before) / (after - before));
    return needed > 1000 ? 0 : (int)fmax(needed, 1);
}

mukca_status mukca_plan_run(mukca_plan *plan, const mukca_chain *chain, const double *theta,
                            const mukca_dataset *data, const mukca_plan_socket *sockets,
                            int n_sockets, const mukca_plan_options *options, mukca_error *error)
{
    planner p = {.data = data, .sockets = sockets, .n_sockets = n_sockets};
    const int rows = options->rows > 0 ? options->rows : DEFAULT_ROWS;
    const int candidates = options->candidates > 0 ? options->candidates : DEFAULT_CANDIDATES;
    int recorded[MUKCA_PLAN_MAX_SOCKETS] = {0};
    memset(plan, 0, sizeof *plan);
    mukca_status status = check(chain, n_sockets, options, error);
    if (status != MUKCA_OK) return status;
    status = plan_state_create(&p.state, chain, theta, n_sockets, options, error);
    if (status != MUKCA_OK) return status;
    plan_state *s = &p.state;
    p.allow = plan_allow(options, chain, &s->geometry, data);
    p.poses = MUKCA_TAKE(&s->pool, plan_pose, n_sockets * candidates);
    double *H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    p.spare = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    int *chosen = MUKCA_TAKE(&s->pool, int, rows + n_sockets);
    plan->rows = calloc((size_t)rows, sizeof *plan->rows);
    if (s->pool.failed || !plan->rows) goto memory;
    for (int e = 0; e < s->n_effects; e++)
        p.ordered |= (mukca_effect_table[s->effect[e].kind].needs & MUKCA_NEEDS_ORDER) != 0;
    plan_look_elsewhere(s, &p.allow, options->seed);
    plan->n_recorded = plan_take_recorded(&p, H, recorded);
    plan->expected_before = plan_expected(s);
    const double weak = plan_strength(s);
    plan->evidence_before = plan_evidence(weak);
    mukca_random random;
    mukca_random_seed(&random, options->seed);
    for (int k = 0; k < n_sockets && !plan_stopped(options); k++) {
        const int found = plan_draw_candidates(&p, p.poses + p.n_poses, candidates, k, &random);
        p.n_poses += found;
        if (options->progress) options->progress(options->context, 0.3 * (k + 1) / n_sockets);
        if (found == 0 && recorded[k] == 0) {
            const double *c = sockets[k].centre;
            status = mukca_fail(error, MUKCA_INPUT,
                                "placement %s: no pose was found that reaches socket %s at "
                                "%.3f %.3f %.3f m; move it, or allow more --tilt",
                                sockets[k].placement, sockets[k].label, c[0], c[1], c[2]);
            goto out;
        }
    }
    if (s->pool.failed) goto memory;
    plan->tried = p.tried;
    plan->reached = p.n_poses;
    plan->n_rows = plan_choose(&p, chosen, rows, recorded);
    plan_exchange(&p, chosen, plan->n_rows, &random);
    if (plan_stopped(options)) {
        status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        goto out;
    }
    for (int i = 0; i < plan->n_rows; i++) {
        plan->rows[i].socket = p.poses[chosen[i]].socket;
        memcpy(plan->rows[i].q, p.poses[chosen[i]].q, sizeof plan->rows[i].q);
    }
    if (!p.ordered) put_in_order(plan->rows, plan->n_rows, chain->n_joints);
    plan->expected_after = plan_expected(s);
    plan->evidence_after = plan_evidence(plan_strength(s));
    plan->rows_to_name = rows_to_name(weak, plan_strength(s), plan->n_rows);
    goto out;
memory:
    status = mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
out:
    plan_state_free(s);
    if (status != MUKCA_OK) mukca_plan_free(plan);
    return status;
}

void mukca_plan_free(mukca_plan *plan)
{
    free(plan->rows);
    memset(plan, 0, sizeof *plan);
}

int mukca_plan_sockets(mukca_plan_socket *sockets, int room, const mukca_geometry *geometry,
                       const mukca_dataset *data)
{
    int n = 0;
    for (int k = 0; k < data->n_sockets && n < room; k++) {
        double sum[3] = {0}, position[3];
        int rows = 0;
        for (int r = 0; r < data->n_rows; r++) {
            if (data->socket[r] != k) continue;
            mukca_fk_position(position, geometry, data->q + r * data->n_joints, NULL);
            for (int i = 0; i < 3; i++) sum[i] += position[i];
            rows++;
        }
        if (rows == 0) continue;
        mukca_plan_socket *s = &sockets[n++];
        s->place = data->sockets[k].placement;
        memcpy(s->label, data->sockets[k].label, sizeof s->label);
        memcpy(s->placement, data->placements[s->place].name, sizeof s->placement);
        for (int i = 0; i < 3; i++) s->centre[i] = sum[i] / rows;
    }
    return n;
}
