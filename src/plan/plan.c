/* The next postures: candidates in each socket, the choice, and its expected effect. */
#include "plan/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/choose.h"

enum { DEFAULT_ROWS = 20, CANDIDATES = 150, CANDIDATES_OF_CAUSES = 40 }; /* of each socket */

/* Visit each placement once, beginning where the plate stands (that of the last sample), and each
 * socket once; within a socket, order by distance from the preceding posture. */
static void put_in_order(mukca_plan_row *rows, int n, const mukca_plan_task *task)
{
    const mukca_dataset *data = task->data;
    const int last = data ? data->socket[data->n_rows - 1] : -1;
    int place = last < 0 ? 0 : data->sockets[last].placement;
    for (int i = 0; i < n; i++) {
        double least = HUGE_VAL;
        int next = i;
        for (int k = i; k < n; k++) {
            double far = task->sockets[rows[k].socket].place == place ? 0 : 1e6;
            far += i && rows[k].socket == rows[i - 1].socket ? 0 : 1e3 * (1 + rows[k].socket);
            if (i) far += mukca_largest_difference(rows[k].q, rows[i - 1].q, task->chain->n_joints);
            if (far < least) least = far, next = k;
        }
        const mukca_plan_row swap = rows[i];
        rows[i] = rows[next];
        rows[next] = swap;
        place = task->sockets[rows[i].socket].place;
    }
}

static mukca_status check(const mukca_chain *chain, const mukca_plan_options *o, mukca_error *error)
{
    for (int e = 0; e < o->n_effects; e++) {
        const mukca_effect_info *info = mukca_effect_table[o->effects[e].kind];
        if ((info->needs & MUKCA_NEEDS_MASSES) && chain->n_masses == 0)
            return mukca_fail(error, MUKCA_INPUT,
                              "%s needs the masses of the links: give --inertials FILE",
                              info->name);
    }
    return MUKCA_OK;
}

/* Expected log Bayes factor of a cause of this strength. */
static double evidence_of(double strength)
{
    /* Gain in log likelihood, less the Occam penalty of a coefficient whose prior standard
     * deviation equals its size. */
    return 0.5 * (strength - log1p(strength));
}

/* Evidence before and after the plan, and the samples until it reaches MUKCA_PLAN_NAME: the
 * strength grows linearly with their number.  A measured log Bayes factor m favours the cause that
 * is present with probability 1 / (1 + exp(-|m|)): its expectation is m tanh(m / 2). */
static void set_evidence(mukca_plan *plan, double before, double after, double measured)
{
    const double expected = evidence_of(before),
                 less = measured ? expected - measured * tanh(measured / 2) : 0;
    double wanted = 1;
    plan->evidence_before = measured ? fabs(measured) : expected;
    plan->evidence_after = evidence_of(after) - less;
    if (!(after > before) || plan->n_rows < 1) return;
    while (evidence_of(wanted) < MUKCA_PLAN_NAME + less) wanted *= 1.01;
    const double needed = ceil(plan->n_rows * (wanted - before) / (after - before));
    plan->rows_to_name = needed > 1000 ? 0 : (int)fmax(needed, 1);
}

static mukca_status find_candidates(mukca_planner *p, int per_socket, mukca_error *error)
{
    const mukca_plan_options *o = p->state.options;
    for (int k = 0; k < p->task->n_sockets && !mukca_plan_stopped(p); k++) {
        const int found = mukca_plan_draw_candidates(p, per_socket, k);
        if (o->progress) o->progress(o->context, 0.3 * (k + 1) / p->task->n_sockets);
        if (found > 0 || p->recorded[k] > 0) continue;
        const mukca_plan_socket *socket = &p->task->sockets[k];
        return mukca_fail(error, MUKCA_INPUT,
                          "placement %s: no pose was found that reaches socket %s at "
                          "%.3f %.3f %.3f m; move it, or allow more --tilt",
                          socket->placement, socket->label, socket->centre[0], socket->centre[1],
                          socket->centre[2]);
    }
    if (p->state.pool.failed)
        return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    return MUKCA_OK;
}

static mukca_status run(mukca_plan *plan, mukca_planner *p, const mukca_plan_task *task,
                        const mukca_plan_options *options, mukca_error *error)
{
    mukca_plan_state *s = &p->state;
    const int rows = options->rows > 0 ? options->rows : DEFAULT_ROWS;
    const int candidates = options->n_effects > 0 ? CANDIDATES_OF_CAUSES : CANDIDATES;
    MUKCA_TRY(mukca_planner_create(p, task->n_sockets * candidates, rows, task, options, error));
    const double weak = mukca_plan_strength(s);
    *plan = (mukca_plan){.n_recorded = p->n_recorded,
                         .rows = calloc((size_t)rows, sizeof *plan->rows),
                         .expected_before = mukca_plan_expected(s)};
    if (!plan->rows) return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    MUKCA_TRY(find_candidates(p, candidates, error));
    mukca_plan_choose(p, rows);
    if (mukca_plan_stopped(p)) return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
    plan->n_rows = p->n_chosen;
    for (int i = 0; i < plan->n_rows; i++) {
        const mukca_plan_pose *pose = &p->poses[p->chosen[i]];
        plan->rows[i].socket = pose->socket;
        memcpy(plan->rows[i].q, pose->q, sizeof pose->q);
    }
    if (!p->ordered) put_in_order(plan->rows, plan->n_rows, task);
    plan->expected_after = mukca_plan_expected(s);
    set_evidence(plan, weak, mukca_plan_strength(s), options->measured);
    return MUKCA_OK;
}

mukca_status mukca_plan_run(mukca_plan *plan, const mukca_plan_task *task,
                            const mukca_plan_options *options, mukca_error *error)
{
    memset(plan, 0, sizeof *plan);
    MUKCA_TRY(check(task->chain, options, error));
    mukca_planner *p = calloc(1, sizeof *p);
    if (!p) return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    const mukca_status status = run(plan, p, task, options, error);
    mukca_pool_free(&p->state.pool);
    free(p);
    if (status != MUKCA_OK) mukca_plan_free(plan);
    return status;
}

mukca_status mukca_plan_payload(double *payload, mukca_plan *plan, const mukca_plan_task *task,
                                const mukca_plan_options *options, mukca_error *error)
{
    static const double masses[] = {0.5, 1, 2, 5, 10, 20, 50, 100};
    mukca_plan_options loaded = *options;
    double arm_kg = 0;
    bool elastic = false;
    *payload = 0;
    for (int i = 0; i < task->chain->n_masses; i++) arm_kg += task->chain->mass[i].kg;
    for (int e = 0; e < options->n_effects; e++)
        elastic |= mukca_effect_has((int)options->effects[e].kind, MUKCA_TRAIT_ELASTIC);
    if (!elastic || plan->evidence_after >= MUKCA_PLAN_NAME) return MUKCA_OK;
    for (size_t i = 0; i < sizeof masses / sizeof *masses && masses[i] <= arm_kg / 3; i++) {
        mukca_plan tried;
        loaded.payload = masses[i];
        MUKCA_TRY(mukca_plan_run(&tried, task, &loaded, error));
        if (tried.evidence_after >= MUKCA_PLAN_NAME) {
            mukca_plan_free(plan);
            *plan = tried;
            *payload = masses[i];
            return MUKCA_OK;
        }
        mukca_plan_free(&tried);
    }
    return MUKCA_OK;
}

void mukca_plan_free(mukca_plan *plan)
{
    free(plan->rows);
    memset(plan, 0, sizeof *plan);
}

int mukca_plan_sockets(mukca_plan_socket *sockets, int room, int *left_out,
                       const mukca_geometry *geometry, const mukca_dataset *data)
{
    int n = 0;
    *left_out = 0;
    for (int k = 0; k < data->n_sockets; k++) {
        mukca_plan_socket s = {.place = data->sockets[k].placement};
        if (!mukca_socket_mean(s.centre, geometry, data, k, -1)) continue;
        memcpy(s.label, data->sockets[k].label, sizeof s.label);
        memcpy(s.placement, data->placements[s.place].name, sizeof s.placement);
        if (n < room)
            sockets[n++] = s;
        else
            ++*left_out;
    }
    return n;
}
