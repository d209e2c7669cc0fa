/* Choose poses: many candidates per socket, greedily the one that tells most, then exchanges. */
#include "study/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "study/plan_poses.h"
#include "study/plan_state.h"

enum {
    DEFAULT_ROWS = 20,
    DEFAULT_CANDIDATES = 150,
    DRAWS = 40,
    EXCHANGES = 2,
    SHIFTS = 40,
    ELSEWHERE = 12
};

typedef struct {
    plan_state state;
    plan_allowance allow;
    const mukca_dataset *data;
    const mukca_plan_socket *sockets;
    int n_sockets, n_poses;
    plan_pose *poses; /* [n_poses] candidates, by socket */
    int tried;
    double *spare; /* an H */
    bool ordered;  /* a cause depends on where the arm comes from */
} planner;

/* ---- where the ball might be: a grid around the arm ---- */

enum { AZIMUTHS = 8, CELLS = 3 * 3 * AZIMUTHS };

/* Cell i of the grid: its middle, and a yaw that turns from cell to cell. */
static void grid_place(double centre[3], double *yaw, int i, const plan_state *s)
{
    static const double radius[3] = {0.4, 0.55, 0.7}, height[3] = {0.0, 0.2, 0.4};
    double reach = 0;
    for (int k = 0; k < s->chain->n_elements; k++)
        reach += sqrt(mukca_dot3(s->geometry.origin[k].p, s->geometry.origin[k].p));
    const double azimuth = 2 * M_PI * (i % AZIMUTHS) / AZIMUTHS;
    const double r = 0.75 * reach * radius[i / AZIMUTHS % 3];
    centre[0] = r * cos(azimuth);
    centre[1] = r * sin(azimuth);
    centre[2] = 0.75 * reach * height[i / (3 * AZIMUTHS)];
    *yaw = azimuth + M_PI / 4 * (i % 4);
}

/* Poses at the places of the grid that the arm reaches: what the error is expected for. */
static void look_elsewhere(plan_state *s, const plan_allowance *allow, uint64_t seed)
{
    const int p = s->n_geometry, k = s->n_known;
    double *H = MUKCA_TAKE(&s->pool, double, ELSEWHERE * 3 * k);
    s->elsewhere = MUKCA_TAKE(&s->pool, double, CELLS *ELSEWHERE * 3 * p);
    double centre[3], yaw;
    mukca_random random;
    mukca_random_seed(&random, seed + 1);
    if (s->pool.failed) return;
    for (int cell = 0; cell < CELLS; cell++) {
        int found = 0;
        grid_place(centre, &yaw, cell, s);
        for (int t = 0; t < 2 * ELSEWHERE && found < ELSEWHERE; t++) {
            double q[MUKCA_MAX_JOINTS];
            if (plan_draw_pose(q, s->chain, &s->geometry, centre, allow, &random))
                plan_design(H + 3 * k * found++, s, q, 0, NULL);
        }
        if (found < ELSEWHERE / 3) continue;
        for (int d = 0; d < 3; d++)
            for (int c = 0; c < p; c++) {
                double mean = 0;
                for (int f = 0; f < found; f++) mean += H[(3 * f + d) * k + c] / found;
                for (int f = 0; f < found; f++)
                    s->elsewhere[(3 * (s->n_elsewhere + f) + d) * p + c] =
                        H[(3 * f + d) * k + c] - mean;
            }
        s->n_elsewhere += found;
    }
}

/* ---- candidates ---- */

static bool stopped(const mukca_plan_options *o)
{
    return o->stop && o->stop(o->context);
}

/* Whether no recorded row is nearly this pose. */
static bool is_new(const planner *p, const double *q)
{
    const int n = p->state.chain->n_joints;
    for (int r = 0; p->data && r < p->data->n_rows; r++)
        if (!plan_differs(q, p->data->q + r * n, n, p->allow.separation)) return false;
    return true;
}

/* Fill candidates for socket `k` from pose index `from`; returns their number. */
static int draw_candidates(planner *p, plan_pose *poses, int room, int k, mukca_random *random)
{
    plan_state *s = &p->state;
    const int n = s->chain->n_joints;
    int found = 0, draws = 0;
    while (found < room && draws < DRAWS * room && (found > 0 || draws < 10 * DRAWS)) {
        plan_pose *pose = &poses[found];
        bool fresh;
        draws++;
        if (!plan_draw_pose(pose->q, s->chain, &s->geometry, p->sockets[k].centre, &p->allow,
                            random))
            continue;
        fresh = is_new(p, pose->q);
        for (int i = 0; i < found && fresh; i++)
            fresh = plan_differs(pose->q, poses[i].q, n, p->allow.separation);
        if (!fresh) continue;
        pose->H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
        if (!pose->H) break;
        pose->socket = k;
        pose->used = false;
        pose->bound = HUGE_VAL;
        plan_design(pose->H, s, pose->q, p->sockets[k].place, NULL);
        found++;
    }
    p->tried += draws;
    return found;
}

/* ---- what is there already ---- */

/* The socket of the plan that a row of the dataset belongs to, -1 where none. */
static int socket_of_row(const planner *p, int row)
{
    const int k = p->data->socket[row];
    if (k < 0) return -1;
    const mukca_socket *is = &p->data->sockets[k];
    for (int i = 0; i < p->n_sockets; i++)
        if (strcmp(p->sockets[i].label, is->label) == 0 &&
            strcmp(p->sockets[i].placement, p->data->placements[is->placement].name) == 0)
            return i;
    return -1;
}

/* Rows of sockets that are not in the plan still tell about the geometry: they come first, each
 * such socket in a scratch slot of its own would do, but sockets of `data` are always in the plan.
 */
static int take_recorded(planner *p, double *H, int *count)
{
    int rows = 0;
    const double *before = NULL;
    for (int r = 0; p->data && r < p->data->n_rows; r++) {
        const double *q = p->data->q + r * p->state.chain->n_joints;
        const int k = socket_of_row(p, r);
        if (k < 0) continue;
        plan_design(H, &p->state, q, p->sockets[k].place, before);
        plan_state_row(&p->state, H, k, 1);
        before = q;
        count[k]++;
        rows++;
    }
    for (int a = 0; a < p->n_sockets; a++)
        for (int b = a + 1; b < p->n_sockets; b++)
            if (p->sockets[a].place == p->sockets[b].place)
                plan_state_distance(&p->state, a, b, p->sockets[a].centre, p->sockets[b].centre);
    return rows;
}

/* ---- choosing ---- */

/* Whether a pose repeats one of those chosen, number `except` apart. */
static bool too_near(const planner *p, const plan_pose *pose, const int *chosen, int n_chosen,
                     int except)
{
    const int n = p->state.chain->n_joints;
    for (int i = 0; i < n_chosen; i++)
        if (i != except && p->poses[chosen[i]].socket == pose->socket &&
            !plan_differs(p->poses[chosen[i]].q, pose->q, n, p->allow.separation))
            return true;
    return false;
}

static double renew(planner *p, plan_pose *pose, const double *before)
{
    if (p->ordered)
        plan_design(pose->H, &p->state, pose->q, p->sockets[pose->socket].place, before);
    return plan_gain(&p->state, pose->H, pose->socket);
}

/* The most telling candidate that is free, of one socket or (-1) of all that have room; -1: none.
 * Gains only fall as rows are added, so that a stale one is a bound (not so for causes). */
static int best_pose(planner *p, int socket, const int *count, int room, const double *before)
{
    const bool bounds = p->state.n_effects == 0 && socket < 0;
    int best = -1;
    double most = -HUGE_VAL;
    plan_state_refresh(&p->state);
    for (;;) {
        int next = -1;
        for (int i = 0; i < p->n_poses; i++) {
            plan_pose *pose = &p->poses[i];
            if (pose->used || (socket >= 0 ? pose->socket != socket : count[pose->socket] >= room))
                continue;
            if (!bounds) {
                const double gain = renew(p, pose, before);
                if (gain > most) {
                    most = gain;
                    best = i;
                }
            } else if (pose->bound > most && (next < 0 || pose->bound > p->poses[next].bound)) {
                next = i;
            }
        }
        if (!bounds || next < 0) return best;
        p->poses[next].bound = renew(p, &p->poses[next], before);
        if (p->poses[next].bound > most) {
            most = p->poses[next].bound;
            best = next;
        } else if (next == best) {
            return best;
        }
    }
}

/* The pose of a socket nearest to the mean of its candidates: a first row tells nothing by itself.
 */
static int middle_pose(const planner *p, int socket)
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

static void take(planner *p, int pose, int *chosen, int *n_chosen, int *count)
{
    plan_state_row(&p->state, p->poses[pose].H, p->poses[pose].socket, 1);
    p->poses[pose].used = true;
    if (count) count[p->poses[pose].socket]++;
    chosen[(*n_chosen)++] = pose;
}

/* Try a pose near chosen[i], whose row is forgotten at the moment, and keep it if it tells more. */
static void shift(planner *p, const int *chosen, int n_chosen, int i, double spread,
                  mukca_random *random)
{
    plan_state *s = &p->state;
    plan_pose *pose = &p->poses[chosen[i]], trial = *pose;
    trial.H = p->spare;
    if (!plan_draw_near(trial.q, spread, s->chain, &s->geometry, p->sockets[pose->socket].centre,
                        &p->allow, random) ||
        too_near(p, &trial, chosen, n_chosen, i) || !is_new(p, trial.q))
        return;
    plan_design(trial.H, s, trial.q, p->sockets[pose->socket].place, NULL);
    if (plan_gain(s, trial.H, trial.socket) > plan_gain(s, pose->H, pose->socket)) {
        p->spare = pose->H;
        *pose = trial;
    }
}

/* Choose `rows` candidates; returns how many were found. */
static int choose(planner *p, int *chosen, int rows, const int *recorded, mukca_random *random)
{
    static const double spread = 0.4; /* rad */
    int count[MUKCA_PLAN_MAX_SOCKETS] = {0}, n = 0, fresh = 0;
    const mukca_plan_options *o = p->state.options;
    for (int k = 0; k < p->n_sockets; k++) fresh += recorded[k] == 0;
    /* A session from nothing fills its sockets evenly; more rows go where they tell most. */
    const int room = fresh == p->n_sockets ? (rows + fresh - 1) / fresh : rows;
    for (int k = 0; k < p->n_sockets && n < rows; k++) {
        const int first = recorded[k] == 0 ? middle_pose(p, k) : -1;
        if (first >= 0) take(p, first, chosen, &n, count);
    }
    while (n < rows && !stopped(o)) {
        const double *before = n > 0 ? p->poses[chosen[n - 1]].q : NULL;
        const int best = best_pose(p, -1, count, room, before);
        if (best < 0) break;
        if (too_near(p, &p->poses[best], chosen, n, -1)) {
            p->poses[best].used = true; /* as good as taken */
            continue;
        }
        renew(p, &p->poses[best], before);
        take(p, best, chosen, &n, count);
        if (o->progress) o->progress(o->context, 0.3 + 0.5 * n / rows);
    }
    for (int pass = 0; pass < EXCHANGES && !p->ordered; pass++) {
        if (p->state.n_effects == 0) plan_state_weigh(&p->state);
        for (int i = 0; i < n && !stopped(o); i++) {
            plan_pose *pose = &p->poses[chosen[i]];
            plan_state_row(&p->state, pose->H, pose->socket, -1);
            pose->used = false;
            const int best = best_pose(p, pose->socket, count, rows, NULL);
            if (best >= 0 && !too_near(p, &p->poses[best], chosen, n, i)) chosen[i] = best;
            pose = &p->poses[chosen[i]];
            pose->used = true;
            for (int t = 0; t < SHIFTS; t++) shift(p, chosen, n, i, spread / (1 + pass), random);
            plan_state_row(&p->state, pose->H, pose->socket, 1);
        }
    }
    return n;
}

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
    p.allow = plan_allow(options);
    p.poses = MUKCA_TAKE(&s->pool, plan_pose, n_sockets * candidates);
    double *H = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    p.spare = MUKCA_TAKE(&s->pool, double, 3 * s->n_known);
    int *chosen = MUKCA_TAKE(&s->pool, int, rows + n_sockets);
    plan->rows = calloc((size_t)rows, sizeof *plan->rows);
    if (s->pool.failed || !plan->rows) goto memory;
    for (int e = 0; e < s->n_effects; e++)
        p.ordered |= (mukca_effect_table[s->effect[e].kind].needs & MUKCA_NEEDS_ORDER) != 0;
    look_elsewhere(s, &p.allow, options->seed);
    plan->n_recorded = take_recorded(&p, H, recorded);
    plan->expected_before = plan_expected(s);
    plan->evidence_before = plan_evidence(s);
    mukca_random random;
    mukca_random_seed(&random, options->seed);
    for (int k = 0; k < n_sockets && !stopped(options); k++) {
        const int found = draw_candidates(&p, p.poses + p.n_poses, candidates, k, &random);
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
    plan->n_rows = choose(&p, chosen, rows, recorded, &random);
    if (stopped(options)) {
        status = mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        goto out;
    }
    for (int i = 0; i < plan->n_rows; i++) {
        plan->rows[i].socket = p.poses[chosen[i]].socket;
        memcpy(plan->rows[i].q, p.poses[chosen[i]].q, sizeof plan->rows[i].q);
    }
    if (!p.ordered) put_in_order(plan->rows, plan->n_rows, chain->n_joints);
    plan->expected_after = plan_expected(s);
    plan->evidence_after = plan_evidence(s);
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
