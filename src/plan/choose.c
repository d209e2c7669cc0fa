/* Choice among candidates: greedy by information gain, then by exchanges. */
#include "plan/choose.h"

#include <math.h>
#include <string.h>

enum { DRAWS = 40, EXCHANGES = 2, SHIFTS = 40 };

bool mukca_plan_stopped(const mukca_planner *p)
{
    const mukca_plan_options *options = p->state.options;
    return options->stop && options->stop(options->context);
}

/* ---- candidates ---- */

/* Whether posture q differs enough from every recorded sample. */
static bool is_new(const mukca_planner *p, const double *q)
{
    const int n = p->state.chain->n_joints;
    const mukca_dataset *data = p->task->data;
    for (int r = 0; data && r < data->n_rows; r++)
        if (!mukca_plan_differs(q, data->q + r * n, n)) return false;
    return true;
}

int mukca_plan_draw_candidates(mukca_planner *p, int room, int k)
{
    mukca_plan_state *s = &p->state;
    mukca_plan_pose *poses = p->poses + p->n_poses;
    const int n = s->chain->n_joints;
    int found = 0, draws = 0;
    while (found < room && draws < DRAWS * room && (found > 0 || draws < 10 * DRAWS)) {
        mukca_plan_pose *pose = &poses[found];
        draws++;
        if (!mukca_plan_draw_pose(pose->q, p->task->sockets[k].centre, &p->rules, &p->random))
            continue;
        bool fresh = is_new(p, pose->q);
        for (int i = 0; i < found && fresh; i++) fresh = mukca_plan_differs(pose->q, poses[i].q, n);
        if (!fresh) continue;
        if (!pose->H) pose->H = MUKCA_TAKE(&s->pool, double, 3 * s->groups.size);
        if (!pose->H) break;
        pose->socket = k;
        pose->used = false;
        mukca_plan_design(pose->H, s, pose->q, p->task->sockets[k].place, NULL);
        found++;
    }
    p->n_poses += found;
    return found;
}

/* ---- recorded samples ---- */

static void add_recorded(mukca_planner *p)
{
    const mukca_dataset *data = p->task->data;
    const mukca_plan_socket *sockets = p->task->sockets;
    const double *before = NULL;
    int socket[MUKCA_PLAN_MAX_SOCKETS] = {0}; /* sockets of the data */
    for (int k = 0; data && k < p->task->n_sockets; k++)
        socket[k] = mukca_dataset_find_socket(data, sockets[k].placement, sockets[k].label);
    for (int r = 0; data && r < data->n_rows; r++) {
        const double *q = data->q + r * data->n_joints;
        int k = 0;
        while (k < p->task->n_sockets && (socket[k] < 0 || socket[k] != data->socket[r])) k++;
        if (k == p->task->n_sockets) continue;
        const double kg = data->payload ? data->payload[r] : 0;
        p->state.payload = isfinite(kg) ? kg : 0;
        mukca_plan_design(p->spare, &p->state, q, sockets[k].place, before);
        mukca_plan_state_row(&p->state, p->spare, k, 1);
        before = q;
        p->recorded[k]++;
        p->n_recorded++;
    }
    p->state.payload = p->state.options->payload;
    mukca_plan_state_refresh(&p->state);
}

mukca_status mukca_planner_create(mukca_planner *p, int candidates, int rows,
                                  const mukca_plan_task *task, const mukca_plan_options *options,
                                  mukca_error *error)
{
    mukca_plan_state *s = &p->state;
    memset(p, 0, sizeof *p);
    MUKCA_TRY(mukca_plan_state_create(s, task, options, error));
    p->task = task;
    p->poses = MUKCA_TAKE(&s->pool, mukca_plan_pose, candidates);
    p->spare = MUKCA_TAKE(&s->pool, double, 3 * s->groups.size);
    p->chosen = MUKCA_TAKE(&s->pool, int, rows + task->n_sockets);
    mukca_plan_rules_set(&p->rules, s->chain, &s->geometry, options, task->data);
    if (!options->poses_only || s->n_effects == 0)
        mukca_plan_look_elsewhere(s, &p->rules, options->seed);
    if (s->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory while planning");
    for (int e = 0; e < s->n_effects; e++)
        p->ordered |= (mukca_effect_table[s->effects[e].kind]->needs & MUKCA_NEEDS_ORDER) != 0;
    add_recorded(p);
    p->random = mukca_random_seeded(options->seed);
    return MUKCA_OK;
}

/* ---- choice ---- */

/* Whether a pose repeats a chosen one; choice `except` is not compared. */
static bool too_near(const mukca_planner *p, const mukca_plan_pose *pose, int except)
{
    const int n = p->state.chain->n_joints;
    for (int i = 0; i < p->n_chosen; i++) {
        const mukca_plan_pose *other = &p->poses[p->chosen[i]];
        if (i != except && other->socket == pose->socket &&
            !mukca_plan_differs(other->q, pose->q, n))
            return true;
    }
    return false;
}

static double renew(mukca_planner *p, mukca_plan_pose *pose, const double *before)
{
    if (p->ordered)
        mukca_plan_design(pose->H, &p->state, pose->q, p->task->sockets[pose->socket].place,
                          before);
    return mukca_plan_gain(&p->state, pose->H, pose->socket);
}

/* The unused candidate with the largest gain, of one socket, or (socket -1) of all with fewer than
 * `room` choices; -1: none. */
static int best_pose(mukca_planner *p, int socket, const int *count, int room, const double *before)
{
    int best = -1;
    double most = -HUGE_VAL;
    mukca_plan_state_refresh(&p->state);
    for (int i = 0; i < p->n_poses; i++) {
        mukca_plan_pose *pose = &p->poses[i];
        if (pose->used || (socket >= 0 && pose->socket != socket)) continue;
        if (count && count[pose->socket] >= room) continue;
        const double gain = renew(p, pose, before);
        if (gain > most) most = gain, best = i;
    }
    return best;
}

/* The candidate of a socket closest to their mean: the first sample of a socket only determines its
 * position and has no gain. */
static int middle_pose(const mukca_planner *p, int socket)
{
    const int n = p->state.chain->n_joints;
    double mean[MUKCA_MAX_JOINTS] = {0}, least = HUGE_VAL;
    int count = 0, best = -1;
    for (int i = 0; i < p->n_poses; i++) {
        if (p->poses[i].socket != socket) continue;
        count++;
        for (int j = 0; j < n; j++) mean[j] += p->poses[i].q[j];
    }
    for (int i = 0; i < p->n_poses; i++) {
        double sum = 0;
        if (p->poses[i].socket != socket) continue;
        for (int j = 0; j < n; j++) sum += pow(p->poses[i].q[j] - mean[j] / count, 2);
        if (sum < least) {
            least = sum;
            best = i;
        }
    }
    return best;
}

static void add_choice(mukca_planner *p, int pose, int *count)
{
    mukca_plan_state_row(&p->state, p->poses[pose].H, p->poses[pose].socket, 1);
    p->poses[pose].used = true;
    count[p->poses[pose].socket]++;
    p->chosen[p->n_chosen++] = pose;
}

/* Draw a pose near choice i, whose sample is removed from the state by the caller.  Keep it if its
 * gain exceeds *most, the gain of the present one. */
static void shift(mukca_planner *p, int i, double spread, double *most)
{
    mukca_plan_state *s = &p->state;
    mukca_plan_pose *pose = &p->poses[p->chosen[i]], trial = *pose;
    const mukca_plan_socket *socket = &p->task->sockets[pose->socket];
    trial.H = p->spare;
    if (!mukca_plan_draw_near(trial.q, spread, socket->centre, &p->rules, &p->random) ||
        too_near(p, &trial, i) || !is_new(p, trial.q))
        return;
    mukca_plan_design(trial.H, s, trial.q, socket->place, NULL);
    const double gain = mukca_plan_gain(s, trial.H, trial.socket);
    if (gain > *most) {
        p->spare = pose->H;
        *pose = trial;
        *most = gain;
    }
}

/* Exchange chosen poses for poses of larger gain. */
static void exchange(mukca_planner *p)
{
    static const double spread = 0.4; /* rad */
    for (int pass = 0; pass < EXCHANGES; pass++) {
        if (p->state.n_effects == 0) mukca_plan_state_weigh(&p->state);
        for (int i = 0; i < p->n_chosen && !mukca_plan_stopped(p); i++) {
            mukca_plan_pose *pose = &p->poses[p->chosen[i]];
            mukca_plan_state_row(&p->state, pose->H, pose->socket, -1);
            pose->used = false;
            const int best = best_pose(p, pose->socket, NULL, 0, NULL);
            if (best >= 0 && !too_near(p, &p->poses[best], i)) p->chosen[i] = best;
            pose = &p->poses[p->chosen[i]];
            pose->used = true;
            double most = mukca_plan_gain(&p->state, pose->H, pose->socket);
            for (int t = 0; t < SHIFTS; t++) shift(p, i, spread / (1 + pass), &most);
            mukca_plan_state_row(&p->state, pose->H, pose->socket, 1);
        }
    }
}

void mukca_plan_choose(mukca_planner *p, int rows)
{
    int count[MUKCA_PLAN_MAX_SOCKETS] = {0}, fresh = 0;
    const mukca_plan_options *o = p->state.options;
    p->n_chosen = 0;
    for (int k = 0; k < p->task->n_sockets; k++) fresh += p->recorded[k] == 0;
    /* A new session distributes its samples evenly over the sockets; a continued one adds samples
     * where the gain is largest. */
    const int room = fresh > 0 && fresh == p->task->n_sockets ? (rows + fresh - 1) / fresh : rows;
    for (int k = 0; k < p->task->n_sockets && p->n_chosen < rows; k++) {
        const int first = p->recorded[k] == 0 ? middle_pose(p, k) : -1;
        if (first >= 0) add_choice(p, first, count);
    }
    while (p->n_chosen < rows && !mukca_plan_stopped(p)) {
        const double *before = p->n_chosen > 0 ? p->poses[p->chosen[p->n_chosen - 1]].q : NULL;
        const int best = best_pose(p, -1, count, room, before);
        if (best < 0) break;
        if (too_near(p, &p->poses[best], -1)) {
            p->poses[best].used = true; /* excluded from here on */
            continue;
        }
        renew(p, &p->poses[best], before);
        add_choice(p, best, count);
        if (o->progress) o->progress(o->context, 0.3 + 0.5 * p->n_chosen / rows);
    }
    if (!p->ordered) exchange(p);
    mukca_plan_state_refresh(&p->state);
}
